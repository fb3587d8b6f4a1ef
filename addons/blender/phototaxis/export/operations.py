"""What nodes do to colours and numbers, as Blender defines it, on arrays of rows, columns and three channels."""

from __future__ import annotations

import colorsys
from collections.abc import Callable

import numpy as np

from .fields import LUMINANCE


class UnknownOperation(Exception):
    """No node of those that are carried out here."""


def _safe_divide(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.where(b != 0, a / np.where(b != 0, b, 1), 0.0)


_MATH: dict[str, Callable[..., np.ndarray]] = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: _safe_divide(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: np.where(a >= 0, np.power(np.maximum(a, 0), b), 0.0),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b).astype(float),
    "GREATER_THAN": lambda a, b, c: (a > b).astype(float),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
}

_BLENDS: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "MIX": lambda a, b: b,
    "MULTIPLY": lambda a, b: a * b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "DIVIDE": lambda a, b: np.where(b != 0, a / np.where(b != 0, b, 1), a),
    "DARKEN": np.minimum,
    "LIGHTEN": np.maximum,
    "DIFFERENCE": lambda a, b: np.abs(a - b),
    "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b),
    "OVERLAY": lambda a, b: np.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b)),
}


def carry_out(node, output, inputs: list[np.ndarray]) -> np.ndarray:
    """The value of `output`, of the enabled inputs in their order.

    Raises UnknownOperation where the node does something else.
    """
    found = _NODES.get(node.type)
    if found is None:
        raise UnknownOperation
    return found(node, output, inputs)


def _math(node, output, inputs):
    operation = _MATH.get(node.operation)
    if operation is None:
        raise UnknownOperation
    result = operation(*inputs, *[None] * (3 - len(inputs)))
    return np.clip(result, 0, 1) if node.use_clamp else result


def _mix(node, output, inputs):
    factor, a, b = inputs
    kind = getattr(node, "data_type", "RGBA")
    if getattr(node, "clamp_factor", True):
        factor = np.clip(factor, 0, 1)
    if kind == "RGBA":
        blend = _BLENDS.get(node.blend_type)
        if blend is None:
            raise UnknownOperation
        b = blend(a, b)
    elif kind not in ("FLOAT", "VECTOR"):
        raise UnknownOperation
    result = a * (1 - factor) + b * factor
    clamps = kind == "RGBA" and (getattr(node, "clamp_result", False) or getattr(node, "use_clamp", False))
    return np.clip(result, 0, 1) if clamps else result


def _hue(node, output, inputs):
    """Hue, saturation and value, in HSV as Blender has it."""
    by_name = {s.name: v for s, v in zip([s for s in node.inputs if s.enabled], inputs)}
    hue, saturation, value, factor = (by_name[n] for n in ("Hue", "Saturation", "Value", "Fac" if "Fac" in by_name else "Factor"))
    color = by_name["Color"]

    def change(r, g, b, dh, ds, dv):
        h, s, v = colorsys.rgb_to_hsv(r, g, b)
        return colorsys.hsv_to_rgb((h + dh + 0.5) % 1.0, min(max(s * ds, 0), 1), v * dv)

    parts = np.broadcast_arrays(*(color[..., k] for k in range(3)), hue[..., 0], saturation[..., 0], value[..., 0])
    changed = np.stack(np.vectorize(change)(*parts), axis=-1)
    return np.maximum(color * (1 - factor) + changed * factor, 0)


def _ramp(node, output, inputs):
    at = np.clip(inputs[0][..., 0], 0, 1)
    steps = np.array([node.color_ramp.evaluate(k / 1024) for k in range(1025)])
    parts = [np.interp(at, np.linspace(0, 1, 1025), steps[:, k]) for k in range(4)]
    return np.stack([parts[3]] * 3 if output.name == "Alpha" else parts[:3], axis=-1)


def _map_range(node, output, inputs):
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        raise UnknownOperation
    value, low, high, to_low, to_high = inputs
    share = _safe_divide(value - low, high - low)
    return to_low + (np.clip(share, 0, 1) if node.clamp else share) * (to_high - to_low)


def _bright_contrast(node, output, inputs):
    color, bright, contrast = inputs
    return np.maximum((1 + contrast) * color + (bright - contrast / 2), 0)


def _separate(node, output, inputs):
    if getattr(node, "mode", "RGB") != "RGB":
        raise UnknownOperation
    k = [s.name for s in node.outputs].index(output.name)
    return np.repeat(inputs[0][..., k : k + 1], 3, axis=-1)


def _combine(node, output, inputs):
    if getattr(node, "mode", "RGB") != "RGB":
        raise UnknownOperation
    return np.stack(np.broadcast_arrays(*(part[..., 0] for part in inputs)), axis=-1)


def _blackbody(node, output, inputs):
    if inputs[0].size > 3:
        raise UnknownOperation
    return blackbody(float(inputs[0].flat[0])).reshape(1, 1, 3)


def blackbody(kelvin: float) -> np.ndarray:
    """Linear sRGB of a black body, of luminance 1: Planck's law under the CIE 1931 matching functions (Wyman et al. 2013)."""
    nm = np.arange(380.0, 781.0, 5.0)
    metres = nm * 1e-9
    light = metres**-5 / np.expm1(1.438777e-2 / (metres * max(kelvin, 500.0)))

    def lobe(mean, below, above):
        return np.exp(-0.5 * ((nm - mean) / np.where(nm < mean, below, above)) ** 2)

    x = 1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2)
    y = 0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1)
    z = 1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)
    xyz = np.array([(light * f).sum() for f in (x, y, z)])
    rgb = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]) @ xyz
    return np.maximum(rgb / (rgb @ LUMINANCE), 0)


_NODES = {
    "MATH": _math,
    "MIX": _mix,
    "MIX_RGB": _mix,
    "INVERT": lambda node, output, inputs: inputs[1] * (1 - inputs[0]) + (1 - inputs[1]) * inputs[0],
    "GAMMA": lambda node, output, inputs: np.power(np.maximum(inputs[0], 0), inputs[1]),
    "HUE_SAT": _hue,
    "BRIGHTCONTRAST": _bright_contrast,
    "VALTORGB": _ramp,
    "MAP_RANGE": _map_range,
    "CLAMP": lambda node, output, inputs: np.clip(inputs[0], inputs[1], inputs[2]),
    "RGBTOBW": lambda node, output, inputs: np.repeat((inputs[0] @ LUMINANCE)[..., None], 3, axis=-1),
    "SEPARATE_COLOR": _separate,
    "SEPRGB": _separate,
    "COMBINE_COLOR": _combine,
    "COMBRGB": _combine,
    "BLACKBODY": _blackbody,
}
