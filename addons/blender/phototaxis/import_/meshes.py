"""Triangles as meshes of Blender."""

from __future__ import annotations

import bpy
import numpy as np

from .. import ply

#: The names by which materials find these.
UVS, COLORS = "UVMap", "Color"


def mesh(name: str, triangles: ply.Triangles):
    """A mesh whose vertices are joined where they lie at the same place, as Blender's own are."""
    positions, joined = np.unique(triangles.positions, axis=0, return_inverse=True)
    corners = triangles.triangles.reshape(-1)
    vertices = joined.reshape(-1)[corners]
    a, b, c = vertices.reshape(-1, 3).T
    kept = np.repeat((a != b) & (b != c) & (c != a), 3)
    vertices, corners = vertices[kept], corners[kept]
    made = bpy.data.meshes.new(name)
    made.vertices.add(len(positions))
    made.vertices.foreach_set("co", positions.astype(np.float32).reshape(-1))
    made.loops.add(len(vertices))
    made.loops.foreach_set("vertex_index", vertices.astype(np.int32))
    made.polygons.add(len(vertices) // 3)
    made.polygons.foreach_set("loop_start", np.arange(0, len(vertices), 3, dtype=np.int32))
    if triangles.uvs is not None:
        layer = made.uv_layers.new(name=UVS)
        layer.uv.foreach_set("vector", triangles.uvs[corners].astype(np.float32).reshape(-1))
    if triangles.colors is not None:
        colors = made.color_attributes.new(COLORS, "FLOAT_COLOR", "CORNER")
        values = np.concatenate([triangles.colors[corners], np.ones((len(corners), 1))], axis=1)
        colors.data.foreach_set("color", values.astype(np.float32).reshape(-1))
    smooth = triangles.normals is not None
    made.polygons.foreach_set("use_smooth", np.full(len(vertices) // 3, smooth))
    made.update(calc_edges=True)
    if smooth:
        made.normals_split_custom_set(triangles.normals[corners].tolist())
    return made
