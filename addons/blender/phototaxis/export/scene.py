"""A whole scene of Blender as a scene file with its meshes and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from .. import ply, toml
from ..warnings import Warnings
from . import camera, lights, meshes, world
from .files import Files, write
from .images import Images
from .materials import Described, Materials
from .nodes import Evaluator
from .settings import sections

#: The head of a scene file tells the importer that z points up.
Z_UP = "Z-up"
_MESHES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
#: Lights that are seen where nothing else is, so that the picture is opaque there.
_BACKGROUNDS = ("constant", "environment")
_NOT_RENDERED = {"EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE", "LIGHT", "GPENCIL", "GREASEPENCIL"}


@dataclass
class Exported:
    path: Path
    warnings: Warnings


class NoCamera(Exception):
    """There is nothing that the scene is seen by."""


def export(depsgraph, path: Path, extra_layers: list[str] | None = None, renders: bool = True) -> Exported:
    """Writes what `depsgraph` holds to the scene file `path`, and its meshes and pictures into the folder `NAME files` beside it.

    Raises NoCamera, and OSError where files cannot be written.
    """
    folder = path.with_name(f"{path.stem} files")
    writer = _Writer(depsgraph, path, Files(folder), renders)
    write(path, writer.document(extra_layers or []).encode())
    return Exported(path, writer.warnings)


class _Writer:
    def __init__(self, depsgraph, path: Path, files: Files, renders: bool) -> None:
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene_eval
        self.view_layer = depsgraph.view_layer_eval
        self.files = files
        #: Whether objects count that render, or those that the viewport shows.
        self.renders = renders
        self.warnings = Warnings()
        self.images = Images(files, path.parent, self.warnings)
        self.materials = Materials(self.images, self.warnings)
        self.places: dict[tuple, _Places] = {}
        self.tables: dict[str, list[dict[str, Any]]] = {"mesh": [], "instance": [], "light": []}
        self.groups: set[str] = set()

    def document(self, extra_layers: list[str]) -> str:
        seen = self.scene.camera
        if seen is None:
            raise NoCamera("the scene has no camera")
        self.walk()
        for places in self.places.values():
            self.write_places(places)
        self.surroundings()
        view = camera.export(self.scene, seen, np.array(seen.matrix_world, float), self.warnings)
        document = sections(self.scene, extra_layers, self.warnings)
        document["film"] = view.film | document["film"]
        document |= {"camera": view.camera, **self.tables}
        self.of_the_scene()
        used = {table.get("material") for table in self.tables["mesh"]}
        document["material"] = {one.name: one.table for one in self.materials if one.name in used}
        return toml.document(document, f"{Z_UP}. Written by the Phototaxis add-on for Blender.")

    def of_the_scene(self) -> None:
        working = getattr(getattr(bpy.data, "colorspace", None), "working_space", "Linear Rec.709")
        if working != "Linear Rec.709":
            self.warnings.add(f"colours are reckoned with in Linear Rec.709, not in {working}")
        if self.scene.render.use_motion_blur:
            self.warnings.add("motion blur has no counterpart")

    def walk(self) -> None:
        """Gathers meshes with the places where they stand, and writes lights."""
        for instance in self.depsgraph.object_instances:
            instanced = instance.object
            if not instance.show_self or not self.is_shown(instance):
                continue
            matrix = np.array(instance.matrix_world, float)
            if instanced.type == "LIGHT":
                self.light(instanced, matrix)
            elif instanced.type in _MESHES:
                self.mesh(instanced, matrix)
            elif instanced.type not in _NOT_RENDERED:
                self.warnings.add(f"object '{instanced.name}': a {instanced.type.lower()} has no counterpart and is left out")

    def is_shown(self, instance) -> bool:
        """A graph of the viewport holds what does not render, too."""
        if self.depsgraph.mode == "RENDER" or not self.renders:
            return True
        owner = instance.parent if instance.is_instance else instance.object
        return not instance.object.original.hide_render and not (owner and owner.original.hide_render)

    def light(self, instanced, matrix: np.ndarray) -> None:
        evaluator = Evaluator(f"light '{instanced.data.name}'", self.images, self.warnings)
        self.warn_of_visibility(instanced, ("visible_diffuse", "visible_glossy", "visible_transmission"))
        light = lights.export(instanced.data, matrix, evaluator)
        if light is None:
            return
        group = instanced.lightgroup
        if isinstance(light, dict):
            self.warn_of_a_sun(instanced, light)
            self.tables["light"].append(light | ({"light_group": group} if group else {}))
            return
        path = self.files.mesh(instanced.name)
        ply.write(path, light.mesh)
        table = {"type": "null", "emission": [float(c) for c in light.radiance]} | ({"light_group": group} if group else {})
        self.tables["mesh"].append(
            {"path": self.images.name(path), "material": self.materials.add(f"light {instanced.name}", table)}
        )
        if self.is_seen(light):
            self.warnings.add(f"light '{instanced.data.name}' has a size: the camera sees it, which it does not in Cycles")

    def warn_of_a_sun(self, instanced, light: dict[str, Any]) -> None:
        eye = np.array(self.scene.camera.matrix_world, float)[:3, 3]
        if light["type"] == "sun" and camera.shows(self.scene, self.scene.camera, (eye - 1e6 * np.array(light["direction"]))[None]):
            self.warnings.add(f"light '{instanced.data.name}' has a size: the camera sees it, which it does not in Cycles")

    def is_seen(self, lamp: lights.Lamp) -> bool:
        """Whether the camera sees the front of a lamp, unless something stands before it."""
        points, seen = lamp.mesh.positions, self.scene.camera
        a, b, c = (points[lamp.mesh.triangles[:, k]] for k in range(3))
        facing = (np.cross(b - a, c - a) * (np.array(seen.matrix_world)[:3, 3] - a)).sum(axis=1) > 0
        return (seen.data.type != "PERSP" or bool(facing.any())) and camera.shows(self.scene, seen, points)

    def warn_of_visibility(self, instanced, names: tuple[str, ...]) -> None:
        if instanced.type != "LIGHT" and (instanced.is_holdout or instanced.is_shadow_catcher):
            self.warnings.add(f"object '{instanced.name}' is no holdout or shadow catcher; it is a surface like others")
        hidden = [name.removeprefix("visible_") for name in names if not getattr(instanced, name, True)]
        if hidden:
            self.warnings.add(
                f"object '{instanced.name}' is not hidden from rays of some kinds ({', '.join(hidden)}); it is seen by all"
            )

    def mesh(self, instanced, matrix: np.ndarray) -> None:
        kinds = ("visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission", "visible_shadow")
        self.warn_of_visibility(instanced, kinds)
        self.warn_of_hair(instanced)
        axes = matrix[:3, :3] / max(np.abs(matrix[:3, :3]).max(), 1e-30)
        dimensions = np.linalg.matrix_rank(axes, tol=1e-7)
        if dimensions < 2:
            # A line or a point is not seen.
            return
        materials = [slot.material for slot in instanced.material_slots] or [None]
        described = [self.materials.of(self.overriding(m), instanced.lightgroup) for m in materials]
        data = instanced.data
        if dimensions == 2:
            # What is flat cannot be moved back; its triangles are written where they are.
            files = self.written(instanced, described, matrix)
            self.places[("flat", len(self.places))] = _Places(instanced.name, files, [np.eye(4)])
            return
        # Curves and the like share their data where modifiers make different meshes of it.
        shares = instanced.type == "MESH" or not len(instanced.modifiers)
        key = (data.as_pointer() if data and shares else instanced.original.as_pointer(), *(one.name for one in described))
        if key not in self.places:
            written = self.written(instanced, described)
            self.places[key] = _Places(instanced.name, written, [])
        self.places[key].matrices.append(matrix)

    def overriding(self, material):
        return getattr(self.view_layer, "material_override", None) or material

    def warn_of_hair(self, instanced) -> None:
        for system in instanced.particle_systems:
            if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                self.warnings.add(f"object '{instanced.name}': hair has no counterpart and is left out")

    def written(self, instanced, described: list[Described], matrix: np.ndarray | None = None) -> list[tuple[Path, Described]]:
        mesh = instanced.to_mesh()
        if mesh is None:
            return []
        try:
            return meshes.write(mesh, described, instanced.name, self.files, self.warnings, matrix)
        finally:
            instanced.to_mesh_clear()

    def write_places(self, places: _Places) -> None:
        """A mesh that stands in one place stands there; else it is a group with instances."""
        if len(places.matrices) == 1:
            for path, one in places.files:
                self.tables["mesh"].append(
                    {"path": self.images.name(path), "material": one.name, "matrix": _rows(places.matrices[0])}
                )
            return
        if not places.files:
            return
        group = self.unused_group(places.name)
        for path, one in places.files:
            self.tables["mesh"].append({"path": self.images.name(path), "material": one.name, "group": group})
        self.tables["instance"] += [{"group": group, "matrix": _rows(matrix)} for matrix in places.matrices]

    def unused_group(self, name: str) -> str:
        chosen, count = name, 0
        while chosen in self.groups:
            count += 1
            chosen = f"{name}-{count}"
        self.groups.add(chosen)
        return chosen

    def surroundings(self) -> None:
        around = getattr(self.view_layer, "world_override", None) or self.scene.world
        group = around.lightgroup if around and hasattr(around, "lightgroup") else ""
        found = world.export(around, self.images, self.warnings)
        if self.scene.render.film_transparent and found:
            self.warnings.add("a transparent film is one only where nothing shines around: the world is in the picture")
        if not self.scene.render.film_transparent and not any(light["type"] in _BACKGROUNDS for light in found):
            # A black one: the film is opaque where nothing is seen, and dark scenes stay dark.
            found.append({"type": "constant", "radiance": 0.0})
        self.tables["light"] += [light | ({"light_group": group} if group else {}) for light in found]


@dataclass
class _Places:
    """A mesh in its files, and where it stands."""

    name: str
    files: list[tuple[Path, Described]]
    matrices: list[np.ndarray]


def _rows(matrix: np.ndarray) -> list[list[float]]:
    return [[float(v) for v in row] for row in matrix[:3]]
