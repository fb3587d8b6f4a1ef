"""Meshes of Blender as files of triangles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .. import ply
from ..warnings import Warnings
from .files import Files
from .materials import Described


def _read(collection, name: str, kind, width: int, count: int | None = None) -> np.ndarray:
    found = np.empty((len(collection) if count is None else count) * width, kind)
    collection.foreach_get(name, found)
    return found.reshape(-1, width) if width > 1 else found


class Corners:
    """What a mesh says of the corners of its triangles."""

    def __init__(self, mesh) -> None:
        self.mesh = mesh
        self.positions = _read(mesh.vertices, "co", np.float32, 3)
        self.loops = _read(mesh.loop_triangles, "loops", np.int32, 3)
        self.vertices = _read(mesh.loop_triangles, "vertices", np.int32, 3)
        self.materials = _read(mesh.loop_triangles, "material_index", np.int32, 1)
        # Faces that are flat throughout need no normals.
        flat = mesh.normals_domain == "FACE"
        self.normals = None if flat else _read(mesh.corner_normals, "vector", np.float32, 3)

    def uvs(self, name: str) -> np.ndarray | None:
        """Texture coordinates of corners, by the name of their map or, without one, the one that renders."""
        layers = self.mesh.uv_layers
        found = layers.get(name) if name else next((layer for layer in layers if layer.active_render), layers.active)
        return None if found is None else _read(found.uv, "vector", np.float32, 2)

    def colors(self, name: str) -> np.ndarray | None:
        attributes = self.mesh.color_attributes
        found = attributes.get(name) if name else attributes.active_color
        if found is None:
            return None
        colors = _read(found.data, "color", np.float32, 4)[:, :3]
        if found.domain == "POINT":
            by_loop = np.empty(len(self.mesh.loops), np.int32)
            self.mesh.loops.foreach_get("vertex_index", by_loop)
            colors = colors[by_loop]
        return colors


def triangles(corners: Corners, chosen: np.ndarray, described: Described, owner: str, warnings: Warnings) -> ply.Triangles:
    """The chosen triangles; corners that are alike share a vertex."""
    loops, vertices = corners.loops[chosen].reshape(-1), corners.vertices[chosen].reshape(-1)
    uvs = corners.uvs(described.uv_map) if _has_pictures(described.table) else None
    if uvs is None and _has_pictures(described.table):
        warnings.add(f"object '{owner}' has no texture coordinates for material '{described.name}'")
    colors = corners.colors(described.vertex_colors) if described.vertex_colors is not None else None
    if colors is None and described.vertex_colors is not None:
        warnings.add(f"object '{owner}' has no colours of vertices '{described.vertex_colors}'")
    columns = [c[loops] for c in (corners.normals, uvs, colors) if c is not None]
    first, index = _shared(vertices, columns)
    at = loops[first]
    return ply.Triangles(
        corners.positions[vertices[first]],
        index.reshape(-1, 3),
        None if corners.normals is None else corners.normals[at],
        None if uvs is None else uvs[at],
        None if colors is None else colors[at],
    )


def _shared(vertices: np.ndarray, columns: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Where each different corner is first, and the number of each corner among these."""
    if not columns:
        _, first, index = np.unique(vertices, return_index=True, return_inverse=True)
        return first, index
    keys = np.concatenate([vertices[:, None].view(np.uint32), *(np.ascontiguousarray(c).view(np.uint32) for c in columns)], axis=1)
    keys = np.ascontiguousarray(keys)
    rows = keys.view(np.dtype((np.void, keys.shape[1] * 4))).reshape(-1)
    _, first, index = np.unique(rows, return_index=True, return_inverse=True)
    return first, index


def _has_pictures(table: dict) -> bool:
    return any(isinstance(v, dict) and "texture" in v for v in table.values())


def write(
    mesh, described: list[Described], name: str, files: Files, warnings: Warnings, flat: np.ndarray | None = None
) -> list[tuple[Path, Described]]:
    """Writes a mesh, made flat by a matrix where there is one: a file for each of the materials that some of its triangles have."""
    mesh.calc_loop_triangles()
    if not len(mesh.loop_triangles):
        return []
    corners = Corners(mesh)
    if flat is not None:
        corners.positions = (corners.positions @ flat[:3, :3].T + flat[:3, 3]).astype(np.float32)
        corners.normals = None
    slots = np.clip(corners.materials, 0, len(described) - 1)
    written: list[tuple[Path, Described]] = []
    distinct = {id(d): d for d in described}
    for one in distinct.values():
        chosen = np.isin(slots, [k for k, d in enumerate(described) if d is one])
        if not chosen.any():
            continue
        path = files.mesh(name if not written else f"{name} {one.name}")
        ply.write(path, triangles(corners, chosen, one, name, warnings))
        written.append((path, one))
    return written
