"""Shaders of materials as surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .fields import Constant, Field, Picture, VertexColors, constant
from .nodes import Evaluator, Place
from .principled import principled, reflectance_of_index
from .surfaces import OPAQUE, Surface, black, blend, complement, is_black, plus, same, scatter_alike, shown, times

_MIRROR_BELOW = 1e-4


def surface_of(place: Place | None, evaluator: Evaluator) -> Surface:
    """The surface that a shader's socket makes."""
    source = place.source() if place else None
    if source is None:
        return black()
    node = source.node
    found = _SHADERS.get(node.type)
    if found is None:
        evaluator.warn(f"shader '{node.name}' ({node.bl_label}) has no counterpart; a diffuse surface stands in its place")
        return (
            _diffuse(source, evaluator)
            if source.input("Color", "Base Color")
            else Surface("diffuse", {"reflectance": constant(0.5)})
        )
    surface = found(source, evaluator)
    relief = _relief(source.input("Normal"), evaluator)
    return replace(surface, relief=relief) if relief else surface


def _alpha(place: Place, evaluator: Evaluator) -> float:
    alpha = evaluator.number(place.input("Roughness"), 0.0) ** 2
    if getattr(place.node, "distribution", "") == "ASHIKHMIN_SHIRLEY":
        evaluator.warn("Ashikhmin-Shirley's distribution is taken for GGX")
    return 0.0 if alpha < _MIRROR_BELOW else min(alpha, 1.0)


def _distribution(place: Place) -> dict:
    return {"distribution": "beckmann"} if getattr(place.node, "distribution", "") == "BECKMANN" else {}


def _diffuse(place: Place, evaluator: Evaluator) -> Surface:
    if place.node.type == "BSDF_DIFFUSE" and evaluator.number(place.input("Roughness")):
        evaluator.warn("roughness of a diffuse surface is left out")
    return Surface("diffuse", {"reflectance": evaluator.field(place.input("Color", "Base Color"), 0.8)})


def _glossy(place: Place, evaluator: Evaluator) -> Surface:
    if (anisotropy := place.input("Anisotropy")) and evaluator.number(anisotropy):
        evaluator.warn("anisotropy is left out")
    values = {"specular_reflectance": evaluator.field(place.input("Color"), 0.8), "alpha": _alpha(place, evaluator)}
    if place.node.distribution == "MULTI_GGX":
        values["energy_conserving"] = True
    return Surface("conductor", values | _distribution(place))


def _metallic(place: Place, evaluator: Evaluator) -> Surface:
    """Metallic BSDF of Blender 4.3 and newer."""
    if evaluator.number(place.input("Anisotropy")):
        evaluator.warn("anisotropy is left out")
    values = {"alpha": _alpha(place, evaluator)}
    if place.node.distribution == "MULTI_GGX":
        values["energy_conserving"] = True
    if place.node.fresnel_type == "PHYSICAL_CONDUCTOR":
        values["eta"], values["k"] = (Constant(evaluator.color(place.input(n))) for n in ("IOR", "Extinction"))
    else:
        evaluator.warn("a metal's edge tint is left out; it is as bright at grazing angles as elsewhere")
        values["specular_reflectance"] = evaluator.field(place.input("Base Color"), 0.6)
    return Surface("conductor", values | _distribution(place))


def _glass(place: Place, evaluator: Evaluator) -> Surface:
    color = np.clip(evaluator.color(place.input("Color"), 1.0), 0, 1)
    values = {"int_ior": max(evaluator.number(place.input("IOR"), 1.5), 1e-3), "alpha": _alpha(place, evaluator)}
    if color.min() < 1:
        values |= {"specular_reflectance": Constant(color), "specular_transmittance": Constant(color)}
    return Surface("dielectric", values | _distribution(place))


def _refraction(place: Place, evaluator: Evaluator) -> Surface:
    evaluator.warn("refraction without reflection has no counterpart; what Fresnel's law reflects is lost")
    surface = _glass(place, evaluator)
    return replace(surface, values=surface.values | {"specular_reflectance": constant(0.0)})


def _translucent(place: Place, evaluator: Evaluator) -> Surface:
    color = evaluator.field(place.input("Color"), 0.8)
    return Surface("diffuse_transmitter", {"reflectance": constant(0.0), "transmittance": color})


def _transparent(place: Place, evaluator: Evaluator) -> Surface:
    if (color := evaluator.color(place.input("Color"), 1.0)).min() < 1:
        evaluator.warn("a transparent colour has no counterpart; what is not let pass is stopped evenly")
        return replace(black(), opacity=constant(1 - float(color.mean())))
    return Surface("null")


def _emission(place: Place, evaluator: Evaluator) -> Surface:
    strength = evaluator.number(place.input("Strength"), 1.0)
    color = times(evaluator.field(place.input("Color"), 1.0), strength)
    return replace(black(), emission=color)


def _mix(place: Place, evaluator: Evaluator) -> Surface:
    first, second = (Place(s, place.groups) for s in place.node.inputs[1:3])
    factor = Place(place.node.inputs[0], place.groups)
    a, b = surface_of(first, evaluator), surface_of(second, evaluator)
    by = factor.source()
    if by is not None and by.node.type == "NEW_GEOMETRY" and by.socket.name == "Backfacing":
        return _sides(a, b, evaluator)
    fresnel = _fresnel(factor, evaluator)
    if fresnel is not None and (coated := _coated(a, b, fresnel)) is not None:
        return coated
    share = constant(0.1) if fresnel is not None else evaluator.field(factor, 0.5)
    return mixed(a, b, share, evaluator)


def _sides(front: Surface, back: Surface, evaluator: Evaluator) -> Surface:
    """A surface whose back is another: it may be black, and it may not shine."""
    alike = scatter_alike(front, back)
    if not alike and not (is_black(back) and front.kind in OPAQUE):
        evaluator.warn("a back that is another surface has no counterpart; it is as the front")
        return front
    shines_alike = back.emits and front.emits and same(front.emission, back.emission)
    if back.emits and not shines_alike:
        evaluator.warn("a back that shines otherwise has no counterpart; it is dark")
    return replace(front, two_sided=alike or is_black(front), emission_two_sided=shines_alike)


def _fresnel(place: Place, evaluator: Evaluator) -> float | None:
    """The index of refraction of a node Fresnel, or of Layer Weight's output of that name."""
    source = place.source()
    if source is None or source.socket.name not in ("Fac", "Factor", "Fresnel"):
        return None
    if source.node.type == "FRESNEL":
        return max(evaluator.number(source.input("IOR"), 1.45), 1.0)
    if source.node.type == "LAYER_WEIGHT":
        return 1 / max(1 - evaluator.number(source.input("Blend"), 0.5), 1e-5)
    return None


def _coated(base: Surface, coat: Surface, ior: float) -> Surface | None:
    """A gloss over a diffuse base, by Fresnel's law."""
    gloss = coat.values.get("specular_reflectance")
    if base.kind == "null" and not base.emits and coat.kind == "conductor" and coat.values["alpha"] == 0:
        return _pane(coat, ior)
    if base.kind != "diffuse" or coat.kind != "conductor" or not isinstance(gloss, Constant) or reflectance_of_index(ior) == 0:
        return None
    values = {"reflectance": base.values["reflectance"], "int_ior": ior, "alpha": coat.values["alpha"], "energy_conserving": True}
    if gloss.color.min() < 1:
        values["specular_reflectance"] = Constant(np.clip(gloss.color, 0, 1))
    return replace(base, kind="plastic", values=values, relief=base.relief or coat.relief)


def _pane(coat: Surface, ior: float) -> Surface | None:
    """A smooth reflection over what light passes unbent is a thin pane of glass."""
    gloss = coat.values["specular_reflectance"]
    if not isinstance(gloss, Constant):
        return None
    values = {"int_ior": ior, "thin": True}
    return Surface("dielectric", values if gloss.color.min() >= 1 else values | {"specular_reflectance": gloss}, relief=coat.relief)


def mixed(a: Surface, b: Surface, share: Field, evaluator: Evaluator) -> Surface:
    """`share` of the second surface and the rest of the first, as far as one material can be that; else the larger part."""
    if isinstance(share, Constant):
        if share.number <= 0:
            return a
        if share.number >= 1:
            return b
    for passing, other, weight in ((a, b, share), (b, a, complement(share))):
        if passing.kind == "null" and not passing.emits:
            found = shown(other, weight) if weight is not None else _inverted(other, share, evaluator)
            if found is not None:
                return found
    if isinstance(share, Constant):
        if (both := _blended(a, b, share.number)) is not None:
            return both
    part = share if isinstance(share, Constant) else evaluator.plain(share, "a mixture of shaders")
    evaluator.warn(f"a mixture of '{a.kind}' and '{b.kind}' has no counterpart; the larger part of it stands alone")
    return b if part.number >= 0.5 else a


def _inverted(surface: Surface, share: Field, evaluator: Evaluator) -> Surface | None:
    """A surface where a picture's share is transparent: the picture is turned over."""
    if not isinstance(share, Picture):
        return None
    pixels = evaluator.images.pixels(share.image) if share.pixels is None else share.pixels
    if pixels is None:
        return None
    flipped = replace(share, pixels=(1 - pixels).astype(np.float32), tint=np.ones(3))
    return shown(surface, flipped) if (share.tint == 1).all() else None


def _blended(a: Surface, b: Surface, share: float) -> Surface | None:
    """A surface that is both: of two that scatter alike, or where one of them only shines."""
    if a.opacity is not None or b.opacity is not None:
        return None
    emission = blend(a.emission or constant(0.0), b.emission or constant(0.0), share)
    if emission is None:
        return None
    emission = None if isinstance(emission, Constant) and not emission.color.any() else emission
    for black_one, other, weight in ((a, b, share), (b, a, 1 - share)):
        if is_black(black_one) and (faded := _faded(other, weight)) is not None:
            return replace(faded, emission=emission)
    kinds = {a.kind, b.kind}
    if kinds == {"diffuse"}:
        reflectance = blend(a.values["reflectance"], b.values["reflectance"], share)
        return reflectance and replace(a, values={"reflectance": reflectance}, emission=emission, relief=a.relief or b.relief)
    if kinds <= {"diffuse", "diffuse_transmitter"}:
        values = {}
        for key in ("reflectance", "transmittance"):
            values[key] = blend(a.values.get(key, constant(0.0)), b.values.get(key, constant(0.0)), share)
        if None not in values.values():
            return Surface("diffuse_transmitter", values, emission, None, a.relief or b.relief)
    return None


def _faded(surface: Surface, weight: float) -> Surface | None:
    """A surface that scatters a share of the light and swallows the rest."""
    keys = {"diffuse": ["reflectance"], "diffuse_transmitter": ["reflectance", "transmittance"]}
    keys |= {"conductor": ["specular_reflectance"], "dielectric": ["specular_reflectance", "specular_transmittance"]}
    if surface.kind not in keys:
        return None
    values = {key: times(surface.values.get(key, constant(1.0)), weight) for key in keys[surface.kind]}
    return replace(surface, values=surface.values | values)


def _add(place: Place, evaluator: Evaluator) -> Surface:
    a, b = (surface_of(Place(s, place.groups), evaluator) for s in place.node.inputs[:2])
    emission = plus(a.emission or constant(0.0), b.emission or constant(0.0))
    if emission is None or a.opacity is not None or b.opacity is not None:
        evaluator.warn("a sum of these shaders has no counterpart; the first stands alone")
        return a
    emission = None if isinstance(emission, Constant) and not emission.color.any() else emission
    for black_one, other in ((b, a), (a, b)):
        if is_black(black_one):
            return replace(other, emission=emission)
    if {a.kind, b.kind} == {"diffuse", "diffuse_transmitter"} and (both := _sum_of_sides(a, b)) is not None:
        return replace(both, emission=emission)
    for passing, other in ((a, b), (b, a)):
        if passing.kind == "null" and not is_black(other):
            evaluator.warn("a sum with a transparent shader has no counterpart; the other stands alone")
            return replace(other, emission=emission)
    if a.kind == b.kind == "diffuse":
        reflectance = plus(a.values["reflectance"], b.values["reflectance"])
        if reflectance is not None:
            return replace(a, values={"reflectance": reflectance}, emission=emission)
    evaluator.warn(f"a sum of '{a.kind}' and '{b.kind}' has no counterpart; the first stands alone")
    return replace(a, emission=emission)


def _sum_of_sides(a: Surface, b: Surface) -> Surface | None:
    """Light that is scattered back and light that is let through."""
    values = {}
    for key in ("reflectance", "transmittance"):
        values[key] = plus(a.values.get(key, constant(0.0)), b.values.get(key, constant(0.0)))
    return None if None in values.values() else Surface("diffuse_transmitter", values, relief=a.relief or b.relief)


def _relief(place: Place | None, evaluator: Evaluator) -> dict | None:
    """Maps of normals and heights: the key and the table of it, but for the picture's file."""
    source = place.source() if place else None
    if source is None:
        return None
    if source.node.type == "NORMAL_MAP":
        if source.node.space != "TANGENT":
            evaluator.warn(f"node '{source.node.name}': only normals in tangent space have a counterpart; it is left out")
            return None
        picture = evaluator.field(source.input("Color"))
        strength = evaluator.number(source.input("Strength"), 1.0)
        return _of_picture("normal_map", picture, {"strength": strength}, evaluator)
    if source.node.type == "BUMP":
        if (under := source.input("Normal")) and under.source() is not None:
            evaluator.warn(f"node '{source.node.name}': the relief below it is left out")
        picture = evaluator.field(source.input("Height"))
        height = evaluator.number(source.input("Distance"), 1.0) * evaluator.number(source.input("Strength"), 1.0)
        return _of_picture("bump_map", picture, {"height": -height if source.node.invert else height}, evaluator)
    evaluator.warn(f"node '{source.node.name}' has no counterpart where it makes normals; it is left out")
    return None


def _of_picture(key: str, picture: Field, more: dict, evaluator: Evaluator) -> dict | None:
    if not isinstance(picture, Picture):
        if isinstance(picture, VertexColors):
            evaluator.warn("a relief of colours of vertices is left out")
        return None
    return {"key": key, "picture": picture, "more": more}


_SHADERS = {
    "BSDF_PRINCIPLED": principled,
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_GLOSSY": _glossy,
    "BSDF_METALLIC": _metallic,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": _refraction,
    "BSDF_TRANSLUCENT": _translucent,
    "BSDF_TRANSPARENT": _transparent,
    "EMISSION": _emission,
    "MIX_SHADER": _mix,
    "ADD_SHADER": _add,
}
