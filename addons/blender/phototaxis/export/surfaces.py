"""Surfaces as a scene file describes them, and how two of them are mixed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .fields import Constant, Field, Picture, VertexColors, constant

#: Keys that take a picture, and whether it is one of numbers. Others take constants only.
COLORS = {"reflectance", "transmittance", "base_color"}
NUMBERS = {"metallic", "roughness", "specular"}
#: Reflections of metals and mirrors take a picture; those of glass and coats do not.
METALS = {"conductor", "mirror"}


@dataclass(frozen=True)
class Surface:
    """How light is scattered (`kind` and `values` of a `[material]`), and what goes over it."""

    kind: str
    values: dict[str, Any] = field(default_factory=dict)
    emission: Field | None = None
    opacity: Field | None = None
    relief: dict[str, Any] | None = None

    @property
    def emits(self) -> bool:
        return self.emission is not None


def black() -> Surface:
    return Surface("diffuse", {"reflectance": constant(0.0)})


def is_black(surface: Surface) -> bool:
    """Whether nothing is scattered; it may shine."""
    reflectance = surface.values.get("reflectance")
    return surface.kind == "diffuse" and isinstance(reflectance, Constant) and not reflectance.color.any()


def times(what: Field, factor) -> Field:
    factor = np.broadcast_to(np.asarray(factor, float), 3)
    return Constant(what.color * factor) if isinstance(what, Constant) else what.times(factor)


def plus(a: Field, b: Field) -> Field | None:
    """The sum, where it can be said."""
    if isinstance(a, Constant) and isinstance(b, Constant):
        return Constant(a.color + b.color)
    if isinstance(a, Constant) and not a.color.any():
        return b
    if isinstance(b, Constant) and not b.color.any():
        return a
    return None


def blend(a: Field, b: Field, share: float) -> Field | None:
    """(1 − share) of the first and `share` of the second, where that can be said."""
    return plus(times(a, 1 - share), times(b, share))


def complement(what: Field) -> Field | None:
    """1 minus a number."""
    if isinstance(what, Constant):
        return Constant(1 - what.color)
    return None


def shown(surface: Surface, share: Field) -> Surface | None:
    """A surface of which only a share is there."""
    if surface.kind == "null" and not surface.emits:
        return surface
    if isinstance(share, Constant) and share.number >= 1:
        return surface
    if surface.opacity is None:
        return replace(surface, opacity=share)
    if isinstance(share, Constant) and isinstance(surface.opacity, Constant):
        return replace(surface, opacity=Constant(share.color * surface.opacity.color))
    return None


__all__ = ["COLORS", "Constant", "Field", "METALS", "NUMBERS", "Picture", "Surface", "VertexColors"]
