"""`[[light]]` tables as lights and a world of Blender."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..export.world import PICTURE_TO_BLENDER, SKIES
from ..warnings import Warnings
from .materials import Nodes, load


def add(tables: list[dict[str, Any]], collection, world: Matrix, folder: Path, warnings: Warnings):
    """Adds lights to a collection; returns a world of what shines from all around, black if nothing does."""
    for table in tables:
        if table["type"] in _LAMPS:
            _lamp(table, collection, world, warnings)
    around = [table for table in tables if table["type"] not in _LAMPS]
    made = bpy.data.worlds.new("World")
    made.use_nodes = True
    made.node_tree.nodes.clear()
    nodes = Nodes(made.node_tree)
    shaders = [_background(table, nodes, world, folder, warnings) for table in around]
    output = nodes.new("ShaderNodeOutputWorld", location=(300, 0))
    while len(shaders) > 1:
        both = nodes.new("ShaderNodeAddShader")
        for k in (1, 0):
            nodes.link(shaders.pop(), both.inputs[k])
        shaders.append(both.outputs[0])
    for shader in shaders:
        nodes.link(shader, output.inputs["Surface"])
    if around and around[0].get("light_group"):
        made.lightgroup = around[0]["light_group"]
    return made


def _lamp(table: dict[str, Any], collection, world: Matrix, warnings: Warnings) -> None:
    kind, key, scale = _LAMPS[table["type"]]
    value = table[key]
    strength = np.array(value if isinstance(value, list) else [value] * 3, float) * scale
    light = bpy.data.lights.new(table["type"], kind)
    light.energy = float(strength.max())
    light.color = strength / strength.max() if strength.any() else (1, 1, 1)
    made = bpy.data.objects.new(table["type"], light)
    collection.objects.link(made)
    made.lightgroup = table.get("light_group") or ""
    place = Vector(table.get("position", (0, 0, 0)))
    turn = Vector(table.get("direction", (0, 0, -1))).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    made.matrix_world = world @ Matrix.Translation(place) @ turn
    if kind == "SUN":
        light.angle = math.radians(table["angular_diameter"]) if table["type"] == "sun" else 0.0
    else:
        light.shadow_soft_size = 0.0
    if kind == "SPOT":
        _cone(table, light, warnings)


def _cone(table: dict[str, Any], light, warnings: Warnings) -> None:
    cutoff = min(table.get("cutoff_angle", 20.0), 90.0)
    beam = min(table.get("beam_angle", 15.0), cutoff)
    if table.get("cutoff_angle", 20.0) > 90:
        warnings.add("a spot is at most 180° wide in Blender")
    outer, inner = math.cos(math.radians(cutoff)), math.cos(math.radians(beam))
    light.spot_size = math.radians(2 * cutoff)
    light.spot_blend = (inner - outer) / (1 - outer) if outer < 1 else 0.0
    if beam < cutoff:
        warnings.add("the edge of a spot falls off by another curve in Blender")


def _background(table: dict[str, Any], nodes: Nodes, world: Matrix, folder: Path, warnings: Warnings):
    made = nodes.new("ShaderNodeBackground")
    if table["type"] == "constant":
        _colored(made, table["radiance"])
    elif table["type"] == "environment":
        _environment(table, made, nodes, world, folder, warnings)
    else:
        _sky(table, made, nodes, world, warnings)
    return made.outputs[0]


def _colored(background, value: Any) -> list[float]:
    """A colour whose largest part is 1, and the strength that brings it up."""
    color = value if isinstance(value, list) else [value] * 3
    strength = max(color)
    background.inputs["Strength"].default_value = strength
    color = [c / strength for c in color] if strength else color
    background.inputs["Color"].default_value = (*color, 1.0)
    return color


def _environment(table, background, nodes: Nodes, world: Matrix, folder: Path, warnings: Warnings) -> None:
    picture, coordinates = nodes.new("ShaderNodeTexEnvironment"), nodes.new("ShaderNodeTexCoord")
    picture.image = load(folder, table["path"], "sRGB", warnings)
    turn = np.array(world.to_3x3()) @ _to_world(table)
    # The node turns directions of the world into those of the picture.
    into = Matrix(PICTURE_TO_BLENDER @ turn.T)
    if into.determinant() < 0:
        warnings.add("mirrored surroundings have no counterpart; they are not mirrored")
        into = Matrix(PICTURE_TO_BLENDER @ (turn @ np.diag([-1.0, 1.0, 1.0])).T)
    move = nodes.new("ShaderNodeMapping", vector_type="POINT")
    move.inputs["Rotation"].default_value = into.to_euler()
    nodes.link(coordinates.outputs["Generated"], move.inputs["Vector"])
    nodes.link(move.outputs["Vector"], picture.inputs["Vector"])
    color, output = _colored(background, table.get("scale", 1.0)), picture.outputs["Color"]
    if color != [1.0, 1.0, 1.0]:
        mix = nodes.new("ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
        mix.inputs[0].default_value, mix.inputs[7].default_value = 1.0, (*color, 1.0)
        nodes.link(output, mix.inputs[6])
        output = mix.outputs[2]
    nodes.link(output, background.inputs["Color"])


def _to_world(table: dict[str, Any]) -> np.ndarray:
    if (rows := table.get("to_world")) is not None:
        flat = np.array(rows, float).reshape(-1)
        return flat.reshape(-1, 4)[:3, :3]
    return np.array(Matrix.Rotation(math.radians(table.get("rotate_y", 0.0)), 3, "Y"))


def _sky(table, background, nodes: Nodes, world: Matrix, warnings: Warnings) -> None:
    """A sky of Blender's own with the same sun, which is not as bright."""
    warnings.add("a sky becomes Blender's own, whose brightness and colours are about the same")
    turn = world.to_3x3()
    up, sun = turn @ Vector(table.get("up", (0, 1, 0))), turn @ Vector(table["sun_direction"]).normalized()
    if up.normalized().z < 0.999:
        warnings.add("a sky whose zenith is not up has no counterpart; it is up")
    node = nodes.new("ShaderNodeTexSky")
    names = [item.identifier for item in node.bl_rna.properties["sky_type"].enum_items]
    node.sky_type = "NISHITA" if "NISHITA" in names else "SINGLE_SCATTERING"
    node.sun_elevation = math.asin(min(max(sun.z, -1.0), 1.0))
    node.sun_rotation = math.atan2(sun.x, sun.y) % (2 * math.pi)
    node.sun_disc = table.get("sun", True)
    dust = max(table.get("turbidity", 3.0) - 2.0, 0.0)
    setattr(node, "dust_density" if hasattr(node, "dust_density") else "aerosol_density", dust)
    # Without its sun Blender's sky is darker, as the exporter has it.
    background.inputs["Strength"].default_value = table.get("scale", 1.0) / (1.0 if node.sun_disc else SKIES["NISHITA"])
    nodes.link(node.outputs["Color"], background.inputs["Color"])


#: Lights of Blender, the key of their strength and what it is multiplied by.
_LAMPS = {
    "point": ("POINT", "intensity", 4 * math.pi),
    "spot": ("SPOT", "intensity", 4 * math.pi),
    "directional": ("SUN", "irradiance", 1.0),
    "sun": ("SUN", "irradiance", 1.0),
}
