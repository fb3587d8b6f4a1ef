"""What a socket of a node says: a number or colour, a picture, or the colours of vertices."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class Mapping:
    """Where a picture lies on a surface."""

    uv_map: str = ""
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamp: bool = False
    nearest: bool = False

    def keys(self) -> dict:
        found: dict = {}
        if self.scale != (1.0, 1.0):
            found["scale"] = list(self.scale)
        if self.offset != (0.0, 0.0):
            found["offset"] = list(self.offset)
        if self.clamp:
            found["clamp"] = True
        if self.nearest:
            found["nearest"] = True
        return found


@dataclass(frozen=True)
class Constant:
    """A colour; a number is a grey one."""

    color: np.ndarray

    @property
    def number(self) -> float:
        return float(self.color @ LUMINANCE)

    @property
    def is_grey(self) -> bool:
        return bool(np.ptp(self.color) == 0)


@dataclass(frozen=True)
class Picture:
    """A picture by name of its `bpy.types.Image`, untouched but for a factor, or pixels that nodes have made of it.

    `pixels` are rows from the bottom, linear. `channel` is the one that counts where a number is wanted.
    """

    image: object
    mapping: Mapping
    tint: np.ndarray = field(default_factory=lambda: np.ones(3))
    channel: str | None = None
    pixels: np.ndarray | None = None
    #: The turn from directions in the world to those of a picture of surroundings.
    rotation: np.ndarray | None = None

    def times(self, color: np.ndarray) -> Picture:
        return replace(self, tint=self.tint * color)


@dataclass(frozen=True)
class VertexColors:
    layer: str
    tint: np.ndarray = field(default_factory=lambda: np.ones(3))

    def times(self, color: np.ndarray) -> VertexColors:
        return replace(self, tint=self.tint * color)


Field = Constant | Picture | VertexColors


def constant(value) -> Constant:
    """A constant of a number or of the first three of a colour."""
    if isinstance(value, (int, float)):
        return Constant(np.full(3, float(value)))
    return Constant(np.array([float(v) for v in list(value)[:3]]))
