"""The world: surroundings as `[[light]]`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..warnings import Warnings
from .fields import Constant, Field, Picture, VertexColors, constant
from .images import Images
from .nodes import Evaluator, Place
from .surfaces import times

#: From the frame of a picture of surroundings (its middle is +z, the first row +y) to Blender's (middle +x, first row +z).
PICTURE_TO_BLENDER = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
#: Blender's skies by ours, of a surface that looks up. That of Hošek and Wilkie is in 2π/683 of our unit; Preetham's has no
#: unit, and the one without a name scatters light once, so that it is darker than the sky is. With its sun, which is most of
#: its light, it is as ours.
SKIES = {"HOSEK_WILKIE": 2 * math.pi / 683, "PREETHAM": 1 / 15, "NISHITA": 1 / 2.8}


def export(world, images: Images, warnings: Warnings) -> list[dict[str, Any]]:
    if world is None:
        return []
    if not world.use_nodes or world.node_tree is None:
        return _light(constant(world.color), Evaluator("world", images, warnings))
    evaluator = Evaluator(f"world '{world.name}'", images, warnings)
    output = world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")
    if output is None:
        return []
    if output.inputs["Volume"].is_linked:
        evaluator.warn("its volume has no counterpart and is left out")
    return _of_shader(Place(output.inputs["Surface"]), evaluator)


def _of_shader(place: Place, evaluator: Evaluator) -> list[dict[str, Any]]:
    source = place.source()
    if source is None:
        return []
    node = source.node
    if node.type in ("BACKGROUND", "EMISSION"):
        strength = evaluator.number(source.input("Strength"), 1.0)
        color = source.input("Color")
        if (sky := _sky_node(color)) is not None:
            return _sky(sky, strength, evaluator)
        return _light(times(evaluator.field(color, 1.0), strength), evaluator)
    if node.type == "ADD_SHADER":
        return [light for socket in node.inputs for light in _of_shader(Place(socket, source.groups), evaluator)]
    if node.type == "MIX_SHADER":
        return _mixed(source, evaluator)
    evaluator.warn(f"shader '{node.name}' ({node.bl_label}) has no counterpart; there it is dark")
    return []


def _mixed(source: Place, evaluator: Evaluator) -> list[dict[str, Any]]:
    share, first, second = (Place(s, source.groups) for s in source.node.inputs[:3])
    by = share.source()
    if by is not None and by.node.type == "LIGHT_PATH":
        evaluator.warn("a world that the camera sees other than surfaces do has no counterpart; it is as surfaces see it")
        return _of_shader(first, evaluator)
    weight = evaluator.number(share, 0.5)
    parts = [(first, 1 - weight), (second, weight)]
    return [_dimmed(light, w) for place, w in parts if w > 0 for light in _of_shader(place, evaluator)]


def _dimmed(light: dict[str, Any], weight: float) -> dict[str, Any]:
    key = "radiance" if light["type"] == "constant" else "scale"
    value = light[key]
    return light | {key: [v * weight for v in value] if isinstance(value, list) else value * weight}


def _light(color: Field, evaluator: Evaluator) -> list[dict[str, Any]]:
    if isinstance(color, VertexColors):
        evaluator.warn("a world has no vertices; half counts")
        color = Constant(color.tint * 0.5)
    if isinstance(color, Constant):
        radiance = [float(max(c, 0)) for c in color.color]
        return [{"type": "constant", "radiance": radiance}] if any(radiance) else []
    return _environment(color, evaluator)


def _environment(picture: Picture, evaluator: Evaluator) -> list[dict[str, Any]]:
    if picture.rotation is None:
        evaluator.warn(f"image '{picture.image.name}' lies by texture coordinates; its mean is taken for all around")
        return _light(evaluator.images.mean(picture), evaluator)
    file = evaluator.images.file(picture.image, as_numbers=False) if picture.pixels is None else None
    file = file or evaluator.images.baked(picture)
    if file is None:
        return []
    to_world = picture.rotation.T @ PICTURE_TO_BLENDER
    rows = [[*(float(v) for v in row), 0.0] for row in to_world] + [[0.0, 0.0, 0.0, 1.0]]
    scale = [float(max(c, 0)) for c in picture.tint]
    return [{"type": "environment", "path": file, "scale": scale, "to_world": rows}]


def _sky_node(place: Place | None):
    source = place.source() if place else None
    return source if source is not None and source.node.type == "TEX_SKY" else None


def _sky(place: Place, strength: float, evaluator: Evaluator) -> list[dict[str, Any]]:
    """A clear sky. Blender's models are others than Hošek and Wilkie's with its sun, but for that of this name."""
    node = place.node
    sky: dict[str, Any] = {"type": "sky", "up": [0.0, 0.0, 1.0]}
    if node.sky_type in ("PREETHAM", "HOSEK_WILKIE"):
        sun = np.array(node.sun_direction[:], float)
        sky |= {"turbidity": min(max(node.turbidity, 1.0), 10.0), "sun": False}
        if node.sky_type == "HOSEK_WILKIE":
            sky["ground_albedo"] = float(node.ground_albedo)
        scale = SKIES[node.sky_type]
    else:
        up, turn = node.sun_elevation, node.sun_rotation
        sun = np.array([math.sin(turn) * math.cos(up), math.cos(turn) * math.cos(up), math.sin(up)])
        dust = getattr(node, "dust_density", getattr(node, "aerosol_density", 1.0))
        sky |= {"turbidity": min(max(2.0 + dust, 1.0), 10.0), "sun": bool(node.sun_disc)}
        scale = 1.0 if node.sun_disc else SKIES["NISHITA"]
        if node.sun_disc and abs(node.sun_intensity - 1) > 1e-6:
            evaluator.warn("the sun's own intensity is left out")
    if node.sky_type != "HOSEK_WILKIE":
        evaluator.warn("a sky is one of Hošek and Wilkie's: its brightness and colours are about those of Blender's")
    if sun[2] < 0:
        evaluator.warn("the sun stands on the horizon, not below it")
        sun[2] = 0.0
    return [sky | {"sun_direction": [float(v) for v in sun], "scale": float(strength * scale)}]
