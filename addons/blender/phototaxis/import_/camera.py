"""`[camera]`, `[film]` and the settings of rendering."""

from __future__ import annotations

import math
from typing import Any

import bpy
from mathutils import Matrix, Vector

from ..warnings import Warnings

_TONES = {"srgb": "Standard", "agx": "AgX", "aces": "AgX"}


def add(name: str, table: dict[str, Any], collection, world: Matrix, warnings: Warnings):
    """A camera that sees the same; what the scene leaves to be found is where Blender puts cameras."""
    camera = bpy.data.cameras.new(name)
    made = bpy.data.objects.new(name, camera)
    collection.objects.link(made)
    made.matrix_world = world @ _place(name, table, warnings)
    if table.get("mirrored"):
        made.scale.x = -made.scale.x
    camera.sensor_fit, camera.sensor_height = "VERTICAL", 24.0
    projection = table.get("projection", "perspective")
    if projection == "orthographic":
        camera.type, camera.ortho_scale = "ORTHO", table.get("view_height", 1.0)
    elif projection == "panorama":
        camera.type = "PANO"
        (camera if hasattr(camera, "panorama_type") else camera.cycles).panorama_type = "EQUIRECTANGULAR"
    else:
        camera.lens = camera.sensor_height / 2 / math.tan(math.radians(table.get("vfov", 45.0)) / 2)
        if radius := table.get("aperture_radius", 0.0):
            camera.dof.use_dof = True
            camera.dof.aperture_fstop = camera.lens * 1e-3 / (2 * radius)
            camera.dof.focus_distance = table.get("focus_distance") or (_vector(table, "target") - _vector(table, "origin")).length
    return made


def _vector(table: dict[str, Any], key: str) -> Vector:
    return Vector(table.get(key, (0, 0, 0)))


def _place(name: str, table: dict[str, Any], warnings: Warnings) -> Matrix:
    if "origin" not in table or "target" not in table:
        warnings.add(f"camera '{name}' is to be found by the program; here it stands somewhere")
    origin = Vector(table.get("origin", (0, 0, 10)))
    back = (origin - _vector(table, "target")).normalized()
    right = Vector(table.get("up", (0, 1, 0))).cross(back).normalized()
    up = back.cross(right)
    rows = [(right[k], up[k], back[k], origin[k]) for k in range(3)]
    return Matrix([*rows, (0, 0, 0, 1)])


def settings(document: dict[str, Any], scene) -> None:
    """The size of the picture, the region of it, and how it is rendered."""
    film, render = document.get("film", {}), scene.render
    render.resolution_x, render.resolution_y = film.get("width", 1280), film.get("height", 720)
    render.resolution_percentage = 100
    render.use_border = "crop" in film
    if render.use_border:
        x, y, width, height = film["crop"]
        # In the middle of the pixel that Blender rounds down to.
        render.border_min_x, render.border_max_x = ((v + 0.5) / render.resolution_x for v in (x, x + width))
        bottom = render.resolution_y - y - height
        render.border_min_y, render.border_max_y = ((v + 0.5) / render.resolution_y for v in (bottom, bottom + height))
        render.use_crop_to_border = True
    scene.view_settings.view_transform = _TONES[film.get("tone", "srgb")]
    exposure = film.get("exposure", 0.0)
    scene.view_settings.exposure = exposure if isinstance(exposure, (int, float)) else 0.0
    ours = scene.phototaxis
    ours.filter = film.get("filter", "box")
    for section, key in (
        ("render", "spp"),
        ("render", "seed"),
        ("render", "sampler"),
        ("integrator", "light_sampler"),
        ("integrator", "roulette"),
    ):
        if key in document.get(section, {}):
            setattr(ours, key, document[section][key])
    ours.max_depth = min(document.get("integrator", {}).get("max_depth", 16), 2**31 - 1)
