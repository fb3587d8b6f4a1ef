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
#: Kinds through which no light passes.
OPAQUE = {"diffuse", "mirror", "conductor", "plastic", "principled"}


@dataclass(frozen=True)
class Surface:
    """How light is scattered (`kind` and `values` of a `[material]`), and what goes over it."""

    kind: str
    values: dict[str, Any] = field(default_factory=dict)
    emission: Field | None = None
    opacity: Field | None = None
    relief: dict[str, Any] | None = None
    #: Whether the back shines and scatters as the front does; else it is dark, and black.
    emission_two_sided: bool = True
    two_sided: bool = True

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


def scatter_alike(a: Surface, b: Surface) -> bool:
    return a.kind == b.kind and a.values.keys() == b.values.keys() and all(same(v, b.values[k]) for k, v in a.values.items())


def same(a: Any, b: Any) -> bool:
    """Whether two fields or other values say the same."""
    if isinstance(a, Constant) and isinstance(b, Constant):
        return bool((a.color == b.color).all())
    if isinstance(a, Picture) and isinstance(b, Picture):
        untouched = a.pixels is None and b.pixels is None or a.pixels is not None and np.array_equal(a.pixels, b.pixels)
        return (
            untouched
            and a.image == b.image
            and a.mapping == b.mapping
            and a.channel == b.channel
            and bool((a.tint == b.tint).all())
        )
    if isinstance(a, VertexColors) and isinstance(b, VertexColors):
        return a.layer == b.layer and bool((a.tint == b.tint).all())
    return type(a) is type(b) and a == b
