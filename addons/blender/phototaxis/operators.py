"""File > Export and File > Import."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import preferences
from .engine import Exporting, PhototaxisEngine
from .export import NoCamera, export
from .import_ import NotAScene, import_scene

_OBJECTS = [
    ("RENDER", "As Rendered", "Objects, modifiers and subdivision as in renders"),
    ("VIEWPORT", "As in the Viewport", "Objects, modifiers and subdivision as the viewport shows them"),
]


class EXPORT_SCENE_OT_phototaxis(bpy.types.Operator, ExportHelper):
    """Write the scene as a scene file of Phototaxis, with its meshes and pictures beside it"""

    bl_idname = "export_scene.phototaxis"
    bl_label = "Export Phototaxis"
    bl_options = {"PRESET"}

    filename_ext = ".toml"
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})
    objects: EnumProperty(name="Objects", items=_OBJECTS, default="RENDER")

    def execute(self, context):
        path = Path(bpy.path.abspath(self.filepath)).resolve()
        try:
            warnings = _as_rendered(context, path) if self.objects == "RENDER" else _as_shown(context, path)
        except (NoCamera, OSError, ValueError) as error:
            self.report({"ERROR"}, f"Phototaxis: {error}")
            return {"CANCELLED"}
        for line in warnings:
            self.report({"WARNING"}, line)
        self.report({"INFO"}, f"The scene is {path}")
        return {"FINISHED"}


def _as_shown(context, path: Path) -> list[str]:
    return list(export(context.evaluated_depsgraph_get(), path, renders=False).warnings)


def _as_rendered(context, path: Path) -> list[str]:
    """A graph of what renders is given to render engines alone: the engine writes the scene in the place of rendering it."""
    scene, engine = context.scene, context.scene.render.engine
    if scene.camera is None:
        raise NoCamera("the scene has no camera")
    exporting = Exporting(path)
    PhototaxisEngine.export_only = exporting
    scene.render.engine = PhototaxisEngine.bl_idname
    try:
        bpy.ops.render.render(layer=context.view_layer.name, scene=scene.name)
    finally:
        scene.render.engine = engine
        PhototaxisEngine.export_only = None
    if exporting.error is not None:
        raise exporting.error
    return exporting.warnings


class IMPORT_SCENE_OT_phototaxis(bpy.types.Operator, ImportHelper):
    """Read a scene of Phototaxis, or of another kind that it reads"""

    bl_idname = "import_scene.phototaxis"
    bl_label = "Import Phototaxis"
    bl_options = {"UNDO", "PRESET"}

    filter_glob: StringProperty(default="*.toml;*.xml;*.json;*.pbrt", options={"HIDDEN"})
    up: EnumProperty(
        name="Up",
        description="What is up in the scene",
        items=[("AUTO", "Automatic", "z for scenes that this add-on wrote, else y"), ("Y", "Y", ""), ("Z", "Z", "")],
        default="AUTO",
    )
    use_settings: BoolProperty(name="Picture and Settings", description="Take over size, samples and camera", default=True)

    def execute(self, context):
        path = Path(bpy.path.abspath(self.filepath)).resolve()
        try:
            warnings = import_scene(context, path, preferences.program(), up=self.up, use_settings=self.use_settings)
        except (NotAScene, preferences.ProgramMissing, OSError) as error:
            self.report({"ERROR"}, f"Phototaxis: {error}")
            return {"CANCELLED"}
        for line in warnings:
            self.report({"WARNING"}, line)
        return {"FINISHED"}


def _export_menu(menu, context) -> None:
    menu.layout.operator(EXPORT_SCENE_OT_phototaxis.bl_idname, text="Phototaxis (.toml)")


def _import_menu(menu, context) -> None:
    menu.layout.operator(IMPORT_SCENE_OT_phototaxis.bl_idname, text="Phototaxis, Nori, Mitsuba (.toml, .xml)")


_CLASSES = (EXPORT_SCENE_OT_phototaxis, IMPORT_SCENE_OT_phototaxis)


def register() -> None:
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.TOPBAR_MT_file_export.append(_export_menu)
    bpy.types.TOPBAR_MT_file_import.append(_import_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(_import_menu)
    bpy.types.TOPBAR_MT_file_export.remove(_export_menu)
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
