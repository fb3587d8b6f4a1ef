"""Settings of the renderer, kept in each scene and view layer."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

_METHODS = [
    ("auto", "Automatic", "Adaptive cells for as long as that pays, judged by the first iterations"),
    ("adaptive", "Adaptive", "Cells of a grid that refine where it pays, by position and facing normal"),
    ("grid", "Grid", "Cells of a uniform grid (Dahm & Keller 2017)"),
    ("voronoi", "Voronoi", "Cells about sites on the surfaces (Dahm & Keller 2017)"),
    ("sdtree", "SD-Tree", "Leaves of a spatial tree, learnt from whole paths (Müller et al. 2017)"),
    ("none", "None", "No guide: directions from the material, and next-event estimation"),
]
_SAMPLING = [
    ("q-cos", "Light", "Directions by expected light and cosine"),
    ("product", "Product", "Directions by expected light and what the surface reflects: better for glossy surfaces, and slower"),
    ("q", "Radiance", "Directions by expected radiance alone"),
]
_LIGHT_SAMPLERS = [
    ("tree", "Tree", "By a hierarchy of lights, which knows what may arrive at the surface"),
    ("power", "Power", "By the power of the lights alone"),
]
_ROULETTES = [
    ("guided", "Guided", "Paths end and split by what the guide expects of going on"),
    ("throughput", "Throughput", "Paths end by what scattering leaves of their throughput"),
    ("none", "None", "No path ends at random"),
]
_FILTERS = [("box", "Box", "One pixel wide"), ("tent", "Tent", "Of radius 1"), ("gaussian", "Gaussian", "Cut off at 1.5 pixels")]
_SAMPLERS = [
    ("sobol", "Sobol'", "Evenly spread: less noise"),
    ("independent", "Independent", "Independent random numbers: noise that can be reckoned with"),
]


class PhototaxisSettings(bpy.types.PropertyGroup):
    spp: IntProperty(name="Samples", description="Samples per pixel", default=64, min=1, soft_max=65536)
    use_time: BoolProperty(name="Time Limit", description="Stop after a time, if the samples are not there before")
    time: FloatProperty(name="Time", description="Of rendering, without loading", default=60, min=0.01, unit="TIME_ABSOLUTE")
    seed: IntProperty(name="Seed", description="The same seed and samples make the same picture", default=0, min=0)
    max_depth: IntProperty(
        name="Path Length", description="Longest path from the camera: 1 sees lights only, 2 adds direct light", default=16, min=1
    )
    filter: EnumProperty(name="Pixel Filter", items=_FILTERS, default="box")
    sampler: EnumProperty(name="Sampler", description="How the samples of a pixel are spread", items=_SAMPLERS, default="sobol")
    light_sampler: EnumProperty(name="Lights", description="How a light is chosen", items=_LIGHT_SAMPLERS, default="tree")
    roulette: EnumProperty(name="Roulette", description="How paths end at random", items=_ROULETTES, default="guided")
    denoise: BoolProperty(name="Denoise", description="Remove the noise by Intel Open Image Denoise, which must be installed")
    method: EnumProperty(name="Guide", description="What learns where light comes from", items=_METHODS, default="auto")
    sampling: EnumProperty(name="Directions", description="What directions are drawn by", items=_SAMPLING, default="q-cos")
    resolution: IntProperty(
        name="Cells", description="Along the longest side of the scene, at the coarsest", default=16, min=1, max=128
    )
    memory: IntProperty(name="Memory (MiB)", description="What the guide may take", default=256, min=1)
    threads: IntProperty(name="Threads", description="0 takes all processors", default=0, min=0, max=1024)
    every: IntProperty(
        name="Update Every (s)", description="Seconds between two pictures while it renders", default=10, min=1, max=3600
    )

    def guiding(self) -> dict[str, Any]:
        """The section `[guiding]`: what means something with the method, for the rest is refused."""
        table: dict[str, Any] = {"method": self.method}
        if self.method == "none":
            return table
        table["memory"] = f"{self.memory} MiB"
        if self.method in ("auto", "adaptive", "grid"):
            table["resolution"] = self.resolution
        if self.method != "sdtree":
            table["sampling"] = self.sampling
        return table


class PhototaxisLayerSettings(bpy.types.PropertyGroup):
    use_pass_direct: BoolProperty(name="Direct", description="Light that one surface has scattered")
    use_pass_indirect: BoolProperty(name="Indirect", description="Light that several surfaces have scattered")
    use_pass_variance: BoolProperty(name="Variance", description="Of each pixel's mean")
    use_pass_samples: BoolProperty(name="Samples", description="How many samples each pixel has")


_CLASSES = (PhototaxisSettings, PhototaxisLayerSettings)


def register() -> None:
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.phototaxis = PointerProperty(type=PhototaxisSettings)
    bpy.types.ViewLayer.phototaxis = PointerProperty(type=PhototaxisLayerSettings)


def unregister() -> None:
    del bpy.types.ViewLayer.phototaxis
    del bpy.types.Scene.phototaxis
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
