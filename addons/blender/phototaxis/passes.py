"""Layers of the program's picture as passes of Blender."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .exr import Picture

_CRYPTOMATTE = {"use_pass_cryptomatte_object": "CryptoObject", "use_pass_cryptomatte_material": "CryptoMaterial"}
#: Passes that other engines have, and nothing here makes.
_NOT_MADE = {
    "use_pass_mist": "Mist",
    "use_pass_vector": "Vector",
    "use_pass_uv": "UV",
    "use_pass_object_index": "Object Index",
    "use_pass_material_index": "Material Index",
    "use_pass_environment": "Environment",
    "use_pass_shadow": "Shadow",
    "use_pass_ambient_occlusion": "Ambient Occlusion",
    "use_pass_diffuse_direct": "Diffuse Direct",
    "use_pass_diffuse_indirect": "Diffuse Indirect",
    "use_pass_glossy_direct": "Glossy Direct",
    "use_pass_glossy_indirect": "Glossy Indirect",
    "use_pass_glossy_color": "Glossy Color",
    "use_pass_transmission_direct": "Transmission Direct",
    "use_pass_transmission_indirect": "Transmission Indirect",
    "use_pass_transmission_color": "Transmission Color",
    "use_pass_subsurface_direct": "Subsurface Direct",
    "use_pass_subsurface_indirect": "Subsurface Indirect",
    "use_pass_subsurface_color": "Subsurface Color",
    "use_pass_cryptomatte_asset": "Cryptomatte Asset",
}


@dataclass(frozen=True)
class Pass:
    """A pass of Blender, and the channels of the picture that it is made of."""

    name: str
    ids: str
    kind: str
    channels: tuple[str, ...]
    #: What `render.layers` must say for them.
    layer: str | None = None


def wanted(view_layer, denoised: bool) -> list[Pass]:
    """The passes of a view layer beside the picture itself."""
    own = view_layer.phototaxis
    all_of_them = [
        (view_layer.use_pass_z, Pass("Depth", "Z", "VALUE", ("Z",))),
        (view_layer.use_pass_normal, Pass("Normal", "XYZ", "VECTOR", ("Ns.X", "Ns.Y", "Ns.Z"))),
        (view_layer.use_pass_position, Pass("Position", "XYZ", "VECTOR", ("P.X", "P.Y", "P.Z"), "P")),
        (view_layer.use_pass_diffuse_color, _color("DiffCol", "albedo")),
        (view_layer.use_pass_emit, _color("Emit", "emission", "emission")),
        (own.use_pass_direct, _color("Direct", "direct", "direct")),
        (own.use_pass_indirect, _color("Indirect", "indirect", "indirect")),
        (own.use_pass_variance, _color("Variance", "variance")),
        (own.use_pass_samples, Pass("Samples", "X", "VALUE", ("samples.Y",))),
        (denoised, Pass("Noisy Image", "RGBA", "COLOR", ("R", "G", "B", "A"))),
    ]
    groups = [_color(f"Combined_{group.name}", f"light_group_{group.name}", "light_groups") for group in view_layer.lightgroups]
    return [each for is_wanted, each in all_of_them if is_wanted] + groups + _cryptomattes(view_layer)


def _color(name: str, layer: str, asked: str | None = None) -> Pass:
    return Pass(name, "RGB", "COLOR", (f"{layer}.R", f"{layer}.G", f"{layer}.B"), asked)


def _cryptomattes(view_layer) -> list[Pass]:
    # Two ranks to a pass; the program has three passes of them.
    count = min((view_layer.pass_cryptomatte_depth + 1) // 2, 3)
    kinds = [kind for key, kind in _CRYPTOMATTE.items() if getattr(view_layer, key)]
    names = [f"{kind}{k:02}" for kind in kinds for k in range(count)]
    return [Pass(n, "RGBA", "COLOR", tuple(f"{n}.{c}" for c in "RGBA"), "cryptomatte") for n in names]


def not_made(view_layer) -> list[str]:
    return [name for key, name in _NOT_MADE.items() if getattr(view_layer, key, False)]


def combined(picture: Picture) -> np.ndarray | None:
    """The picture itself, without noise where that was asked for."""
    alpha = "A" if "A" in picture.channels else "R"
    pixels = picture.layer("denoised.R", "denoised.G", "denoised.B", alpha)
    if pixels is None:
        pixels = picture.layer("R", "G", "B", alpha)
    if pixels is not None and alpha != "A":
        pixels[:, :, 3] = 1
    return pixels


def fill(result_layer, picture: Picture, passes: list[Pass]) -> None:
    """Puts a picture into the passes of a layer of Blender's render result."""
    _set(result_layer.passes, "Combined", combined(picture))
    for each in passes:
        _set(result_layer.passes, each.name, picture.layer(*each.channels))


def _set(passes, name: str, pixels: np.ndarray | None) -> None:
    target = passes.get(name)
    if target is None or pixels is None:
        return
    # Blender's rows begin at the bottom.
    target.rect.foreach_set(np.ascontiguousarray(pixels[::-1, :, : target.channels], np.float32).reshape(-1))


def metadata(picture: Picture, layer: str) -> dict[str, str]:
    """What programs need to name the ids of Cryptomatte by: Blender calls its passes by their view layer."""
    found: dict[str, dict[str, str]] = {}
    for name, data in picture.attributes.items():
        if name.startswith("cryptomatte/"):
            _, key, what = name.split("/", 2)
            found.setdefault(key, {})[what] = data.decode("utf-8", "replace")
    renamed: dict[str, str] = {}
    for texts in found.values():
        texts["name"] = f"{layer}.{texts['name']}"
        key = f"{murmur3(texts['name'].encode()):08x}"[:7]
        renamed |= {f"cryptomatte/{key}/{what}": text for what, text in texts.items()}
    return renamed


def murmur3(data: bytes) -> int:
    """MurmurHash3 of 32 bits with seed 0, by which Cryptomatte names what belongs together."""
    mask, value = 0xFFFFFFFF, 0

    def scrambled(block: int) -> int:
        block = block * 0xCC9E2D51 & mask
        return (block << 15 | block >> 17) * 0x1B873593 & mask

    whole = len(data) // 4 * 4
    for at in range(0, whole, 4):
        value ^= scrambled(int.from_bytes(data[at : at + 4], "little"))
        value = ((value << 13 | value >> 19) * 5 + 0xE6546B64) & mask
    value ^= scrambled(int.from_bytes(data[whole:], "little")) ^ len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
        value = (value ^ value >> shift) * factor & mask
    return value ^ value >> 16
