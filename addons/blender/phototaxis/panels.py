"""Panels of the render engine, and Blender's own that go with it."""

from __future__ import annotations

import bpy

_ENGINE = "PHOTOTAXIS"
_EXCLUDED = {
    "RENDER_PT_simplify",
    "RENDER_PT_gpencil",
    "RENDER_PT_grease_pencil_viewport",
    "RENDER_PT_freestyle",
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_layer_passes",
    "DATA_PT_area",
    "DATA_PT_falloff_curve",
    "DATA_PT_light",
}
#: Panels of other engines that show what counts here as well.
_BORROWED = {
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "EEVEE_WORLD_PT_settings",
    "MATERIAL_PT_preview",
    "WORLD_PT_context_world",
}


class _Panel(bpy.types.Panel):
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {_ENGINE}

    @classmethod
    def poll(cls, context) -> bool:
        return context.engine in cls.COMPAT_ENGINES

    def columns(self):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        return layout


class PHOTOTAXIS_RENDER_PT_sampling(_Panel):
    bl_label = "Sampling"

    def draw(self, context) -> None:
        layout, settings = self.columns(), context.scene.phototaxis
        layout.prop(settings, "spp")
        row = layout.row(heading="Time Limit")
        row.prop(settings, "use_time", text="")
        part = row.row()
        part.active = settings.use_time
        part.prop(settings, "time", text="")
        layout.prop(settings, "denoise")
        layout.prop(settings, "seed")
        layout.prop(settings, "sampler")
        layout.prop(settings, "filter")


class PHOTOTAXIS_RENDER_PT_guide(_Panel):
    bl_label = "Guide"

    def draw(self, context) -> None:
        layout, settings = self.columns(), context.scene.phototaxis
        layout.prop(settings, "method")
        used = settings.guiding()
        for name in ("sampling", "resolution", "memory"):
            if name in used:
                layout.prop(settings, name)


class PHOTOTAXIS_RENDER_PT_paths(_Panel):
    bl_label = "Light Paths"

    def draw(self, context) -> None:
        layout, settings = self.columns(), context.scene.phototaxis
        for name in ("max_depth", "light_sampler", "roulette"):
            layout.prop(settings, name)


class PHOTOTAXIS_RENDER_PT_performance(_Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context) -> None:
        layout, settings = self.columns(), context.scene.phototaxis
        layout.prop(settings, "threads")
        layout.prop(settings, "every")


class PHOTOTAXIS_VIEWLAYER_PT_passes(_Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context) -> None:
        layout, view_layer = self.columns(), context.view_layer
        column = layout.column(heading="Data")
        for name in ("use_pass_z", "use_pass_position", "use_pass_normal", "use_pass_diffuse_color"):
            column.prop(view_layer, name)
        column = layout.column(heading="Light")
        column.prop(view_layer, "use_pass_emit")
        for name in ("use_pass_direct", "use_pass_indirect", "use_pass_variance", "use_pass_samples"):
            column.prop(view_layer.phototaxis, name)
        column = layout.column(heading="Cryptomatte")
        column.prop(view_layer, "use_pass_cryptomatte_object", text="Object")
        column.prop(view_layer, "use_pass_cryptomatte_material", text="Material")
        column.prop(view_layer, "pass_cryptomatte_depth", text="Levels")


class PHOTOTAXIS_DATA_PT_light(_Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context) -> bool:
        return context.light is not None and super().poll(context)

    def draw(self, context) -> None:
        layout, light = self.columns(), context.light
        layout.prop(light, "type", expand=True)
        layout.prop(light, "color")
        layout.prop(light, "energy")
        for name in _OF_LIGHTS[light.type]:
            layout.prop(light, name)
        if light.type == "AREA" and light.shape in ("RECTANGLE", "ELLIPSE"):
            layout.prop(light, "size_y")


_OF_LIGHTS = {"POINT": ("shadow_soft_size",), "SPOT": ("spot_size", "spot_blend"), "SUN": ("angle",), "AREA": ("shape", "size")}
_CLASSES = (
    PHOTOTAXIS_RENDER_PT_sampling,
    PHOTOTAXIS_RENDER_PT_guide,
    PHOTOTAXIS_RENDER_PT_paths,
    PHOTOTAXIS_RENDER_PT_performance,
    PHOTOTAXIS_VIEWLAYER_PT_passes,
    PHOTOTAXIS_DATA_PT_light,
)


def _blenders_own() -> list[type]:
    panels = [p for p in bpy.types.Panel.__subclasses__() if hasattr(p, "COMPAT_ENGINES")]
    return [p for p in panels if p.__name__ in _BORROWED or "BLENDER_RENDER" in p.COMPAT_ENGINES and p.__name__ not in _EXCLUDED]


def register() -> None:
    for each in _CLASSES:
        bpy.utils.register_class(each)
    for panel in _blenders_own():
        panel.COMPAT_ENGINES.add(_ENGINE)


def unregister() -> None:
    for panel in _blenders_own():
        panel.COMPAT_ENGINES.discard(_ENGINE)
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
