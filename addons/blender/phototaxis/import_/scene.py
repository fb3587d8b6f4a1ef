"""A whole scene. The program itself brings every kind of scene into one form, in which nothing is left unsaid."""

from __future__ import annotations

import tempfile
import tomllib
from pathlib import Path
from typing import Any

import bpy
from mathutils import Matrix

from .. import ply
from ..export.scene import Z_UP
from ..program import call
from ..warnings import Warnings
from . import camera, lights, meshes
from .materials import Materials

#: y becomes z.
_Y_TO_Z = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


class NotAScene(Exception):
    """The program cannot read the file, or Blender cannot take what is in it."""


def import_scene(context, path: Path, program: Path, up: str = "AUTO", use_settings: bool = True) -> list[str]:
    """Adds a scene to the present one, in a collection of the file's name. Returns warnings.

    Raises NotAScene, and OSError where a file cannot be read.
    """
    with tempfile.TemporaryDirectory(prefix="phototaxis-") as folder:
        plain = Path(folder) / "scene.toml"
        try:
            said = call([program, "convert", path, plain])
        except RuntimeError as error:
            raise NotAScene(str(error)) from error
        warnings = Warnings()
        for line in said:
            warnings.add(line.removeprefix("warning: "))
        document = tomllib.loads(plain.read_text(encoding="utf-8"))
        z_up = up == "Z" or up == "AUTO" and _says_z_up(path)
        world = Matrix.Identity(4) if z_up else _Y_TO_Z
        _Reader(context, plain, path.stem, world, warnings).read(document, use_settings)
    return list(warnings)


def _says_z_up(path: Path) -> bool:
    with open(path, "rb") as file:
        return Z_UP.encode() in file.readline()


class _Reader:
    def __init__(self, context, path: Path, name: str, world: Matrix, warnings: Warnings) -> None:
        self.context = context
        self.folder = path.parent
        self.world = world
        self.warnings = warnings
        self.collection = bpy.data.collections.new(name)
        context.scene.collection.children.link(self.collection)
        self.materials = Materials(self.folder, warnings)

    def read(self, document: dict[str, Any], use_settings: bool) -> None:
        for name, table in document.get("material", {}).items():
            self.materials.add(name, table)
        self.meshes(document)
        found = lights.add(document.get("light", []), self.collection, self.world, self.folder, self.warnings)
        if found is not None and use_settings:
            self.context.scene.world = found
        cameras = [("camera", document["camera"])] if "camera" in document else []
        cameras += document.get("cameras", {}).items()
        made = [camera.add(name, table, self.collection, self.world, self.warnings) for name, table in cameras]
        if use_settings and made:
            self.context.scene.camera = made[0]
        if use_settings:
            camera.settings(document, self.context.scene)

    def meshes(self, document: dict[str, Any]) -> None:
        """Meshes that stand by themselves, and instances: of a group of one mesh as objects that share it."""
        groups: dict[str, list[tuple[Any, Matrix]]] = {}
        for table in document.get("mesh", []):
            path = self.folder / table["path"]
            try:
                triangles = ply.read(path)
            except ValueError as error:
                raise NotAScene(str(error)) from error
            data = meshes.mesh(table.get("group") or path.stem, triangles)
            data.materials.append(self.materials.get(table.get("material", "")))
            matrix = _matrix(table)
            if "group" in table:
                groups.setdefault(table["group"], []).append((data, matrix))
            else:
                self.object(data, self.world @ matrix, self.collection)
        places: dict[str, list[Matrix]] = {name: [] for name in groups}
        for table in document.get("instance", []):
            places[table["group"]].append(self.world @ _matrix(table))
        for name, parts in groups.items():
            self.group(name, parts, places[name])

    def group(self, name: str, parts: list[tuple[Any, Matrix]], places: list[Matrix]) -> None:
        if len(parts) == 1:
            data, within = parts[0]
            for place in places:
                self.object(data, place @ within, self.collection)
            return
        apart = bpy.data.collections.new(name)
        for data, within in parts:
            self.object(data, within, apart)
        for place in places:
            instance = bpy.data.objects.new(name, None)
            instance.instance_type, instance.instance_collection = "COLLECTION", apart
            self.collection.objects.link(instance)
            instance.matrix_world = place

    def object(self, data, matrix: Matrix, collection) -> None:
        made = bpy.data.objects.new(data.name, data)
        collection.objects.link(made)
        made.matrix_world = matrix
        # Objects of Blender have no shear.
        if max(abs(v) for row in made.matrix_basis - matrix for v in row) > 1e-4 * max(
            1.0, max(abs(v) for row in matrix for v in row)
        ):
            data.transform(matrix)
            made.matrix_world = Matrix.Identity(4)


def _matrix(table: dict[str, Any]) -> Matrix:
    rows = table.get("matrix")
    return Matrix([*rows[:3], (0, 0, 0, 1)]) if rows else Matrix.Identity(4)
