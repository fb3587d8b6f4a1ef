"""Principled BSDF as a material of a scene file."""

from __future__ import annotations

import math

import numpy as np

from .fields import Constant, Field, constant
from .nodes import Evaluator, Place
from .surfaces import Surface, times

_ONE, _ZERO = constant(1.0), constant(0.0)


def principled(place: Place, evaluator: Evaluator) -> Surface:
    """Glass where half or more is transmitted, a coated or bare diffuse surface where nothing varies, else Disney's model."""
    read = _Inputs(place, evaluator)
    read.warn_of_what_is_left_out()
    transmission = read.constant("Transmission Weight")
    if 0 < transmission < 1:
        evaluator.warn(f"transmission of {transmission:.2g} is taken for {'1' if transmission >= 0.5 else '0'}")
    surface = _glass(read) if transmission >= 0.5 else _opaque(read)
    return Surface(surface.kind, surface.values, _emission(read), _opacity(read))


class _Inputs:
    def __init__(self, place: Place, evaluator: Evaluator) -> None:
        self.place = place
        self.evaluator = evaluator

    def field(self, name: str, default: float = 0.0) -> Field:
        return self.evaluator.field(self.place.input(name), default)

    def constant(self, name: str, default: float = 0.0) -> float:
        return self.evaluator.number(self.place.input(name), default)

    def warn_of_what_is_left_out(self) -> None:
        left_out = [("Subsurface Weight", "subsurface scattering"), ("Sheen Weight", "sheen"), ("Anisotropic", "anisotropy")]
        left_out += [("Thin Film Thickness", "a thin film"), ("Diffuse Roughness", "roughness of the diffuse base")]
        for name, what in left_out:
            place = self.place.input(name)
            if place is not None and (place.source() is not None or place.constant_place().socket.default_value):
                self.evaluator.warn(f"{what} is left out")
        coat = self.place.input("Coat Normal")
        if coat is not None and coat.source() is not None:
            self.evaluator.warn("the coat's own normal is left out")


def reflectance_of_index(ior: float) -> float:
    return ((ior - 1) / (ior + 1)) ** 2


def _index_of_reflectance(f0: float) -> float:
    root = math.sqrt(min(max(f0, 0.0), 0.99))
    return (1 + root) / (1 - root)


def _specular(read: _Inputs) -> tuple[float, Field]:
    """The index of refraction, and the level of specular reflection that multiplies what it reflects (0.5 is once)."""
    return max(read.constant("IOR", 1.5), 1e-3), read.field("Specular IOR Level", 0.5)


def _glass(read: _Inputs) -> Surface:
    base = read.evaluator.plain(read.field("Base Color", 0.8), "the colour of glass")
    values = {"int_ior": read.constant("IOR", 1.5), "alpha": read.constant("Roughness", 0.5) ** 2}
    # Light passes two surfaces of a body; each takes its half, as in Blender.
    if (root := np.sqrt(np.clip(base.color, 0, 1))).min() < 1:
        values["specular_transmittance"] = Constant(root)
    return Surface("dielectric", values)


def _opaque(read: _Inputs) -> Surface:
    metallic, roughness = read.field("Metallic"), read.field("Roughness", 0.5)
    ior, level = _specular(read)
    coat = read.constant("Coat Weight")
    tint = read.evaluator.color(read.place.input("Specular Tint"), 1.0)
    plain = isinstance(roughness, Constant) and isinstance(level, Constant) and not coat
    if plain and isinstance(metallic, Constant) and metallic.number == 0:
        f0 = reflectance_of_index(ior) * 2 * level.number
        return _dielectric(read, f0, roughness.number, tint)
    return _disney(read, metallic, roughness, ior, level, coat, tint)


def _dielectric(read: _Inputs, f0: float, roughness: float, tint: np.ndarray) -> Surface:
    base = read.field("Base Color", 0.8)
    if f0 == 0 or not tint.any():
        return Surface("diffuse", {"reflectance": base})
    values = {"reflectance": base, "int_ior": _index_of_reflectance(f0), "alpha": roughness**2, "energy_conserving": True}
    if tint.min() < 1:
        read.evaluator.warn("the tint of specular reflection counts at grazing angles as well")
        values["specular_reflectance"] = Constant(np.clip(tint, 0, 1))
    return Surface("plastic", values)


def _disney(read: _Inputs, metallic: Field, roughness: Field, ior: float, level: Field, coat: float, tint: np.ndarray) -> Surface:
    # Disney's model reflects 0.08 times its own level.
    specular = times(level, 2 * reflectance_of_index(ior) / 0.08)
    if isinstance(specular, Constant) and specular.number > 1:
        read.evaluator.warn("so strong a specular reflection has no counterpart; the strongest is taken")
        specular = _ONE
    if tint.min() < 1:
        read.evaluator.warn("the tint of specular reflection is left out")
    values = {"base_color": read.field("Base Color", 0.8), "metallic": metallic, "roughness": roughness, "specular": specular}
    values["energy_conserving"] = True
    if coat:
        _coat(read, coat, values)
    return Surface("principled", values)


def _coat(read: _Inputs, coat: float, values: dict) -> None:
    roughness, ior = read.constant("Coat Roughness", 0.03), read.constant("Coat IOR", 1.5)
    if read.evaluator.color(read.place.input("Coat Tint"), 1.0).min() < 1:
        read.evaluator.warn("the coat's tint is left out")
    # Disney's coat reflects a quarter of what one of index 1.5 does, and its α is 0.1 dull and 0.001 clear.
    weight = 4 * coat * reflectance_of_index(ior) / reflectance_of_index(1.5)
    if weight > 1:
        read.evaluator.warn("a coat reflects at most a quarter of what it does in Blender")
    values["clearcoat"] = min(weight, 1.0)
    values["clearcoat_gloss"] = min(max((0.1 - roughness**2) / (0.1 - 0.001), 0.0), 1.0)


def _emission(read: _Inputs) -> Field | None:
    strength = read.constant("Emission Strength")
    if strength <= 0:
        return None
    color = times(read.field("Emission Color", 1.0), strength)
    return None if isinstance(color, Constant) and not color.color.any() else color


def _opacity(read: _Inputs) -> Field | None:
    alpha = read.field("Alpha", 1.0)
    return None if isinstance(alpha, Constant) and alpha.number >= 1 else alpha
