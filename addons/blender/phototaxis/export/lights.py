"""Lights of Blender: points, spots and suns as `[[light]]`, and what has an area as surfaces that emit.

A lamp of Blender gives P watts times its colour. A point sends P/4π W/sr in all directions, an area of size A the radiance P/πA, a
sphere of radius r P/4π²r², and a sun P W/m².
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import ply
from .nodes import Evaluator, Place

_SEGMENTS = 64
#: Scene files take a sun of at least this diameter.
_LEAST_SUN = math.radians(0.01)
_LARGEST_SUN = math.radians(90)


@dataclass
class Lamp:
    """A light that is a surface: its triangles in the world, and the radiance of their front."""

    mesh: ply.Triangles
    radiance: np.ndarray


def export(light, matrix: np.ndarray, evaluator: Evaluator) -> dict[str, Any] | Lamp | None:
    """A light that stands where `matrix` says, as a table of a scene file or as a surface; nothing where it is dark."""
    strength = _strength(light, evaluator)
    _warn_of_the_rest(light, evaluator)
    if not strength.any():
        return None
    if (strength < 0).any():
        evaluator.warn("a light that takes light away has no counterpart; it is left out")
        return None
    return _KINDS[light.type](light, matrix, strength, evaluator)


def _strength(light, evaluator: Evaluator) -> np.ndarray:
    """Colour times energy."""
    strength = np.array(light.color[:], float) * light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    if getattr(light, "use_temperature", False):
        strength *= np.array(light.temperature_color[:], float)
    if not light.use_nodes or light.node_tree is None:
        return strength
    output = light.node_tree.get_output_node("CYCLES") or light.node_tree.get_output_node("ALL")
    source = Place(output.inputs["Surface"]).source() if output else None
    if source is None:
        return np.zeros(3)
    if source.node.type != "EMISSION":
        evaluator.warn(f"shader '{source.node.name}' has no counterpart; the light's own strength counts")
        return strength
    factor = evaluator.number(source.input("Strength"), 1.0)
    return strength * factor * evaluator.color(source.input("Color"), 1.0)


def _warn_of_the_rest(light, evaluator: Evaluator) -> None:
    if not light.use_shadow:
        evaluator.warn("lights without shadows have no counterpart; it casts them")
    if not getattr(light, "normalize", True):
        evaluator.warn("a strength that is not normalised by size is taken for one that is")
    cycles = getattr(light, "cycles", None)
    if getattr(cycles, "max_bounces", 1024) < 1024:
        evaluator.warn("a limit of bounces has no counterpart")


def _direction(matrix: np.ndarray) -> np.ndarray:
    """Where a light shines: along its own −z."""
    along = -matrix[:3, 2]
    return along / np.linalg.norm(along)


def _point(light, matrix, strength, evaluator) -> dict | Lamp:
    radius = light.shadow_soft_size
    if radius <= 0:
        return {"type": "point", "position": _list(matrix[:3, 3]), "intensity": _list(strength / (4 * math.pi))}
    mesh, area = sphere(matrix[:3, 3], radius)
    return Lamp(mesh, strength / (math.pi * area))


def _spot(light, matrix, strength, evaluator) -> dict:
    if light.shadow_soft_size > 0:
        evaluator.warn("a spot has no size; its shadows are sharp")
    if light.use_square:
        evaluator.warn("a square spot is taken for a round one")
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    if scale.max() > scale.min() * 1.001:
        evaluator.warn("a spot of uneven scale is taken for a round one")
    half = max(light.spot_size / 2, math.radians(0.01))
    beam = _beam(half, light.spot_blend)
    if light.spot_blend > 0:
        evaluator.warn("the blurred edge of a spot falls off by another curve, of the same power")
    place = {"position": _list(matrix[:3, 3]), "direction": _list(_direction(matrix))}
    angles = {"cutoff_angle": math.degrees(half), "beam_angle": math.degrees(min(beam, half))}
    return {"type": "spot"} | place | {"intensity": _list(strength / (4 * math.pi))} | angles


def _beam(half: float, blend: float) -> float:
    """The half angle of the even beam with which a spot sends as much light as Blender's.

    The edge of Blender's is a smooth step in the cosine.
    """
    if blend <= 0:
        return half
    inner = math.cos(half) + (1 - math.cos(half)) * min(blend, 1.0)
    wanted = (1 - inner) + (inner - math.cos(half)) / 2

    def sent(beam: float) -> float:
        """Of a spot that falls evenly with the angle from `beam` to `half`, over 2π."""
        if half - beam < 1e-9:
            return 1 - math.cos(half)
        return 1 - (math.sin(half) - math.sin(beam)) / (half - beam)

    low, high = 0.0, half
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if sent(middle) < wanted else (low, middle)
    return low


def _sun(light, matrix, strength, evaluator) -> dict:
    direction = {"direction": _list(_direction(matrix)), "irradiance": _list(strength)}
    if light.angle < _LEAST_SUN:
        return {"type": "directional"} | direction
    if light.angle > _LARGEST_SUN:
        evaluator.warn("a sun is at most 90° wide")
    return {"type": "sun"} | direction | {"angular_diameter": math.degrees(min(light.angle, _LARGEST_SUN))}


def _area(light, matrix, strength, evaluator) -> Lamp | None:
    if getattr(getattr(light, "cycles", None), "is_portal", False):
        return None
    if light.spread < math.pi - 1e-3:
        evaluator.warn("an area light shines evenly to all sides; its spread is left out")
    width = light.size
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else width
    u, v = matrix[:3, 0] * width / 2, matrix[:3, 1] * height / 2
    if light.shape in ("SQUARE", "RECTANGLE"):
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    else:
        angles = np.arange(_SEGMENTS) * 2 * math.pi / _SEGMENTS
        corners = np.stack([np.cos(angles), np.sin(angles)], axis=1) * math.sqrt(_circle_to_polygon())
    area = _polygon_area(corners) * np.linalg.norm(np.cross(u, v))
    if area <= 0:
        return None
    positions = matrix[:3, 3] + corners @ np.stack([u, v])
    fan = np.array([[0, k + 1, k] for k in range(1, len(corners) - 1)])
    # The front is where −z points, whatever the matrix mirrors.
    if np.linalg.det(matrix[:3, :3]) < 0:
        fan = fan[:, ::-1]
    return Lamp(ply.Triangles(positions, fan), strength / (math.pi * area))


def _polygon_area(corners: np.ndarray) -> float:
    x, y = corners.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


def _circle_to_polygon() -> float:
    """The area of a circle over that of the regular polygon in it."""
    return 2 * math.pi / (_SEGMENTS * math.sin(2 * math.pi / _SEGMENTS))


def sphere(centre: np.ndarray, radius: float) -> tuple[ply.Triangles, float]:
    """Triangles about a sphere, an icosahedron cut three times, of the sphere's area; and that area."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden)]
    corners += [(0, -1, -golden), (0, 1, -golden), (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8)]
    faces += [(3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    points, triangles = np.array(corners, float), np.array(faces)
    for _ in range(3):
        points, triangles = _halved(points, triangles)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    wanted = 4 * math.pi * radius**2
    return ply.Triangles(centre + points * math.sqrt(wanted / area), triangles), wanted


def _halved(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle in four, by the middles of its edges."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = index.reshape(3, -1) + len(points)
    a, b, c = triangles.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    middles = points[unique].mean(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True) / np.linalg.norm(points[0])
    return np.concatenate([points, middles]), np.concatenate([np.stack(p, axis=1) for p in parts])


def _list(values) -> list[float]:
    return [float(v) for v in values]


_KINDS = {"POINT": _point, "SPOT": _spot, "SUN": _sun, "AREA": _area}
