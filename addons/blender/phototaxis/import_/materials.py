"""`[material]` tables as materials of nodes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy

from ..warnings import Warnings
from .meshes import COLORS

_WHITE = (1.0, 1.0, 1.0)


class Materials:
    """The materials of a scene by their names there, which Blender may have had to change."""

    def __init__(self, folder: Path, warnings: Warnings) -> None:
        self._folder = folder
        self._warnings = warnings
        self._made: dict[str, Any] = {}

    def add(self, name: str, table: dict[str, Any]) -> None:
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        made.node_tree.nodes.clear()
        _Builder(made, table, self._folder, self._warnings).build()
        self._made[name] = made

    def get(self, name: str):
        return self._made.get(name)


class Nodes:
    """Nodes that are made one after another, each to the left of what it feeds."""

    def __init__(self, tree) -> None:
        self.tree = tree
        self._count = 0

    def new(self, kind: str, **settings):
        made = self.tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(made, key, value)
        self._count += 1
        made.location = (-220 * (self._count % 6), 180 * (self._count // 6))
        return made

    def link(self, output, to) -> None:
        self.tree.links.new(output, to)


class _Builder:
    def __init__(self, material, table: dict[str, Any], folder: Path, warnings: Warnings) -> None:
        self.material = material
        self.table = table
        self.folder = folder
        self.warnings = warnings
        self.nodes = Nodes(material.node_tree)

    def warn(self, text: str) -> None:
        self.warnings.add(f"material '{self.material.name}': {text}")

    def build(self) -> None:
        """The shader, with emission, one side, and what is cut out, in this order."""
        output = self.nodes.new("ShaderNodeOutputMaterial", location=(300, 0))
        kind = self.table["type"]
        shader = _SHADERS[kind](self)
        front, back = shader, shader
        if not _is_dark(self.table.get("emission", 0.0)):
            front = self.shining(shader)
            if self.table.get("emission_two_sided", False):
                back = front
        if self.table.get("two_sided", True) is False and kind in ("diffuse", "mirror", "conductor", "plastic", "principled"):
            back = None if back is shader or back is front else back
        if back is not front:
            front = self.sides(front, back)
        if (opacity := self.table.get("opacity", 1.0)) != 1.0:
            front = self.cut(front, opacity)
        self.nodes.link(front, output.inputs["Surface"])

    def shining(self, shader):
        emission = self.nodes.new("ShaderNodeEmission")
        self.radiance(emission)
        if self.table["type"] == "diffuse" and _is_dark(self.table.get("reflectance", 0.5)):
            return emission.outputs[0]
        both = self.nodes.new("ShaderNodeAddShader")
        self.nodes.link(shader, both.inputs[0])
        self.nodes.link(emission.outputs[0], both.inputs[1])
        return both.outputs[0]

    def radiance(self, emission) -> None:
        value = self.table["emission"]
        tint = value.get("tint", _WHITE) if isinstance(value, dict) else value
        tint = [float(c) for c in (tint if isinstance(tint, (list, tuple)) else [tint] * 3)]
        # Blender's colours are between 0 and 1; the strength is the rest.
        strength = max(tint)
        emission.inputs["Strength"].default_value = strength
        tint = [c / strength for c in tint] if strength else tint
        self.color(emission.inputs["Color"], value | {"tint": tint} if isinstance(value, dict) else tint)

    def sides(self, front, back):
        mix, geometry = self.nodes.new("ShaderNodeMixShader"), self.nodes.new("ShaderNodeNewGeometry")
        self.nodes.link(geometry.outputs["Backfacing"], mix.inputs[0])
        self.nodes.link(front, mix.inputs[1])
        if back is None:
            back = self.nodes.new("ShaderNodeBsdfDiffuse")
            back.inputs["Color"].default_value = (0, 0, 0, 1)
            back = back.outputs[0]
        self.nodes.link(back, mix.inputs[2])
        return mix.outputs[0]

    def cut(self, shader, opacity):
        mix, passing = self.nodes.new("ShaderNodeMixShader"), self.nodes.new("ShaderNodeBsdfTransparent")
        self.number(mix.inputs[0], opacity, channel="alpha")
        self.nodes.link(passing.outputs[0], mix.inputs[1])
        self.nodes.link(shader, mix.inputs[2])
        return mix.outputs[0]

    def color(self, socket, value: Any) -> None:
        """A colour, a picture or the colours of vertices at a socket."""
        if not isinstance(value, dict):
            socket.default_value = (*_rgb(value), 1.0)
            return
        output = self.colors_of_vertices() if value.get("vertex_color") else self.picture(value, "sRGB").outputs["Color"]
        tint = _rgb(value.get("tint", 1.0))
        if tint != _WHITE:
            mix = self.nodes.new("ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
            mix.inputs[0].default_value, mix.inputs[7].default_value = 1.0, (*tint, 1.0)
            self.nodes.link(output, mix.inputs[6])
            output = mix.outputs[2]
        self.nodes.link(output, socket)

    def number(self, socket, value: Any, channel: str = "luminance") -> None:
        if not isinstance(value, dict):
            socket.default_value = float(value)
            return
        if value.get("vertex_color"):
            self.nodes.link(self.colors_of_vertices(), socket)
            return
        picture = self.picture(value, "Non-Color")
        channel = value.get("channel", channel)
        if channel in ("red", "green", "blue"):
            parts = self.nodes.new("ShaderNodeSeparateColor")
            self.nodes.link(picture.outputs["Color"], parts.inputs[0])
            self.nodes.link(parts.outputs[channel.capitalize()], socket)
            return
        # A picture without an alpha channel gives its luminance.
        has_alpha = picture.image is not None and picture.image.channels == 4 and picture.image.depth in (32, 64, 128)
        self.nodes.link(picture.outputs["Alpha" if channel == "alpha" and has_alpha else "Color"], socket)

    def colors_of_vertices(self):
        return self.nodes.new("ShaderNodeVertexColor", layer_name=COLORS).outputs["Color"]

    def picture(self, value: dict[str, Any], space: str):
        made = self.nodes.new("ShaderNodeTexImage")
        made.image = load(self.folder, value["texture"], space, self.warnings)
        made.extension = "EXTEND" if value.get("clamp") else "REPEAT"
        made.interpolation = "Closest" if value.get("nearest") else "Linear"
        scale, offset = (_pair(value.get(key, default)) for key, default in (("scale", 1.0), ("offset", 0.0)))
        if scale != (1.0, 1.0) or offset != (0.0, 0.0):
            move, coordinates = self.nodes.new("ShaderNodeMapping"), self.nodes.new("ShaderNodeTexCoord")
            move.inputs["Scale"].default_value, move.inputs["Location"].default_value = (*scale, 1.0), (*offset, 0.0)
            self.nodes.link(coordinates.outputs["UV"], move.inputs["Vector"])
            self.nodes.link(move.outputs["Vector"], made.inputs["Vector"])
        return made

    def shader(self, kind: str, **settings):
        """A shader with the relief of the surface."""
        made = self.nodes.new(kind, **settings)
        if "Normal" in made.inputs and (normal := self.relief()) is not None:
            self.nodes.link(normal, made.inputs["Normal"])
        return made

    def relief(self):
        if (normals := self.table.get("normal_map")) is not None:
            made = self.nodes.new("ShaderNodeNormalMap")
            made.inputs["Strength"].default_value = normals.get("strength", 1.0)
            self.nodes.link(self.picture(normals, "Non-Color").outputs["Color"], made.inputs["Color"])
            return made.outputs["Normal"]
        if (heights := self.table.get("bump_map")) is not None:
            height = heights.get("height", 1.0)
            made = self.nodes.new("ShaderNodeBump", invert=height < 0)
            made.inputs["Strength"].default_value, made.inputs["Distance"].default_value = 1.0, abs(height)
            self.nodes.link(self.picture(heights, "Non-Color").outputs["Color"], made.inputs["Height"])
            return made.outputs["Normal"]
        return None

    def diffuse(self):
        made = self.shader("ShaderNodeBsdfDiffuse")
        self.color(made.inputs["Color"], self.table.get("reflectance", 0.5))
        return made.outputs[0]

    def transmitter(self):
        both, through = self.nodes.new("ShaderNodeAddShader"), self.shader("ShaderNodeBsdfTranslucent")
        self.color(through.inputs["Color"], self.table.get("transmittance", 0.25))
        reflected = self.shader("ShaderNodeBsdfDiffuse")
        self.color(reflected.inputs["Color"], self.table.get("reflectance", 0.25))
        self.nodes.link(reflected.outputs[0], both.inputs[0])
        self.nodes.link(through.outputs[0], both.inputs[1])
        return both.outputs[0]

    def metal(self):
        table = self.table
        if "eta" in table or "k" in table:
            return self.metal_of_indices()
        beckmann = table.get("distribution") == "beckmann"
        distribution = "MULTI_GGX" if table.get("energy_conserving") else "BECKMANN" if beckmann else "GGX"
        made = self.shader("ShaderNodeBsdfAnisotropic", distribution=distribution)
        self.color(made.inputs["Color"], table.get("specular_reflectance", 1.0))
        made.inputs["Roughness"].default_value = math.sqrt(table.get("alpha", 0.0))
        return made.outputs[0]

    def metal_of_indices(self):
        """Fresnel's law of metals, which Blender has since 4.3; before, the principled shader comes near it."""
        eta, k = (_rgb(self.table.get(key, default)) for key, default in (("eta", 1.0), ("k", 0.0)))
        tint = self.table.get("specular_reflectance", 1.0)
        grey = not isinstance(tint, dict) and min(_rgb(tint)) == max(_rgb(tint))
        if hasattr(bpy.types, "ShaderNodeBsdfMetallic") and grey:
            distribution = "MULTI_GGX" if self.table.get("energy_conserving") else "GGX"
            if self.table.get("distribution") == "beckmann" and distribution == "GGX":
                distribution = "BECKMANN"
            made = self.shader("ShaderNodeBsdfMetallic", fresnel_type="PHYSICAL_CONDUCTOR", distribution=distribution)
            made.inputs["IOR"].default_value, made.inputs["Extinction"].default_value = eta, k
            made.inputs["Roughness"].default_value = math.sqrt(self.table.get("alpha", 0.0))
            return made.outputs[0] if _rgb(tint) == _WHITE else self.dimmed(made.outputs[0], _rgb(tint)[0])
        self.warn("a metal's indices of refraction become the colour that it has seen from the front")
        made = self.shader("ShaderNodeBsdfPrincipled")
        made.inputs["Metallic"].default_value = 1.0
        front = [((n - 1) ** 2 + x**2) / ((n + 1) ** 2 + x**2) for n, x in zip(eta, k)]
        self.color(made.inputs["Base Color"], tint if isinstance(tint, dict) else [f * t for f, t in zip(front, _rgb(tint))])
        made.inputs["Roughness"].default_value = math.sqrt(self.table.get("alpha", 0.0))
        return made.outputs[0]

    def dimmed(self, shader, share: float):
        """A share of what a shader reflects; black takes the rest."""
        mix, black = self.nodes.new("ShaderNodeMixShader"), self.nodes.new("ShaderNodeBsdfDiffuse")
        mix.inputs[0].default_value, black.inputs["Color"].default_value = share, (0, 0, 0, 1)
        self.nodes.link(black.outputs[0], mix.inputs[1])
        self.nodes.link(shader, mix.inputs[2])
        return mix.outputs[0]

    def glass(self):
        table = self.table
        ior = table.get("int_ior", 1.5) / table.get("ext_ior", 1.0)
        reflected, refracted = (_rgb(table.get(key, 1.0)) for key in ("specular_reflectance", "specular_transmittance"))
        if table.get("thin"):
            return self.pane(ior, reflected, refracted)
        roughness = math.sqrt(table.get("alpha", 0.0))
        if reflected == _WHITE and refracted != _WHITE:
            made = self.shader("ShaderNodeBsdfPrincipled")
            made.inputs["Transmission Weight"].default_value = 1.0
            # Two surfaces of a body take the colour together.
            self.color(made.inputs["Base Color"], [c * c for c in refracted])
        else:
            if reflected != refracted:
                self.warn("glass that reflects another colour than it lets pass has that of what passes")
            distribution = "BECKMANN" if table.get("distribution") == "beckmann" else "GGX"
            made = self.shader("ShaderNodeBsdfGlass", distribution=distribution)
            self.color(made.inputs["Color"], list(refracted))
        made.inputs["IOR"].default_value, made.inputs["Roughness"].default_value = ior, roughness
        return made.outputs[0]

    def pane(self, ior: float, reflected, refracted):
        """Without bending: what Fresnel's law reflects, and what goes straight on."""
        if refracted != _WHITE:
            self.warn("the colour of a thin pane of glass is left out")
        mix, by = self.nodes.new("ShaderNodeMixShader"), self.nodes.new("ShaderNodeFresnel")
        by.inputs["IOR"].default_value = ior
        gloss = self.shader("ShaderNodeBsdfAnisotropic", distribution="GGX")
        gloss.inputs["Roughness"].default_value = 0.0
        self.color(gloss.inputs["Color"], list(reflected))
        self.nodes.link(by.outputs[0], mix.inputs[0])
        self.nodes.link(self.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
        self.nodes.link(gloss.outputs[0], mix.inputs[2])
        return mix.outputs[0]

    def plastic(self):
        table = self.table
        if not table.get("energy_conserving"):
            self.warn("a plastic becomes one that conserves energy, as Blender's do")
        if table.get("distribution") == "beckmann" and table.get("alpha", 0.0) > 0:
            self.warn("Beckmann's distribution of a coat becomes GGX")
        made = self.shader("ShaderNodeBsdfPrincipled")
        ior = table.get("int_ior", 1.5) / table.get("ext_ior", 1.0)
        if table.get("nonlinear"):
            self.under_coat(made.inputs["Base Color"], table.get("reflectance", 0.5), _internal_reflectance(ior))
        else:
            self.color(made.inputs["Base Color"], table.get("reflectance", 0.5))
        made.inputs["IOR"].default_value = ior
        made.inputs["Roughness"].default_value = math.sqrt(table.get("alpha", 0.0))
        self.color(made.inputs["Specular Tint"], table.get("specular_reflectance", 1.0))
        return made.outputs[0]

    def under_coat(self, socket, value: Any, internal: float) -> None:
        """A base that light meets again and again, as the coat reflects it back: R(1 − ρ)/(1 − Rρ)."""
        if not isinstance(value, dict):
            self.color(socket, [c * (1 - internal) / (1 - c * internal) for c in _rgb(value)])
            return
        parts = []
        for factor in (1 - internal, internal):
            part = self.nodes.new("ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
            part.inputs[0].default_value, part.inputs[7].default_value = 1.0, (factor, factor, factor, 1.0)
            self.color(part.inputs[6], value)
            parts.append(part.outputs[2])
        rest, share = (self.nodes.new("ShaderNodeMix", data_type="RGBA", blend_type=kind) for kind in ("SUBTRACT", "DIVIDE"))
        rest.inputs[0].default_value, rest.inputs[6].default_value = 1.0, (1.0, 1.0, 1.0, 1.0)
        share.inputs[0].default_value = 1.0
        self.nodes.link(parts[1], rest.inputs[7])
        self.nodes.link(parts[0], share.inputs[6])
        self.nodes.link(rest.outputs[2], share.inputs[7])
        self.nodes.link(share.outputs[2], socket)

    def principled(self):
        table = self.table
        made = self.shader("ShaderNodeBsdfPrincipled")
        self.color(made.inputs["Base Color"], table.get("base_color", 0.5))
        # Of index 1.5, Blender's level of specular reflection is Disney's.
        made.inputs["IOR"].default_value = 1.5
        for name, key, default in (
            ("Metallic", "metallic", 0.0),
            ("Roughness", "roughness", 0.5),
            ("Specular IOR Level", "specular", 0.5),
        ):
            self.number(made.inputs[name], table.get(key, default))
        if clearcoat := table.get("clearcoat", 0.0):
            made.inputs["Coat Weight"].default_value = clearcoat / 4
            made.inputs["Coat Roughness"].default_value = math.sqrt(0.1 - 0.099 * table.get("clearcoat_gloss", 1.0))
        if sheen := table.get("sheen", 0.0):
            self.warn("sheen is of another kind in Blender")
            made.inputs["Sheen Weight"].default_value = sheen
        return made.outputs[0]

    def passing(self):
        return self.nodes.new("ShaderNodeBsdfTransparent").outputs[0]


def _internal_reflectance(ior: float) -> float:
    """What a smooth surface of this index reflects of even light from within: 1 − (1 − R)/n², with R of what comes from without."""
    steps, reflected = 1000, 0.0
    for k in range(steps):
        cosine = math.sqrt((k + 0.5) / steps)
        inside = math.sqrt(max(1 - (1 - cosine * cosine) / (ior * ior), 0.0))
        parallel, across = (ior * cosine - inside) / (ior * cosine + inside), (cosine - ior * inside) / (cosine + ior * inside)
        reflected += (parallel * parallel + across * across) / (2 * steps)
    return 1 - (1 - reflected) / (ior * ior)


def load(folder: Path, name: str, space: str, warnings: Warnings):
    """A picture; those of the temporary folder are packed into Blender's file."""
    path = folder / name
    layered = ".exr:" in name
    if layered:
        warnings.add(f"picture '{name}': a layer of a file has no counterpart; its first layer counts")
        path = Path(str(path).rpartition(":")[0])
    try:
        image = bpy.data.images.load(str(path), check_existing=True)
    except RuntimeError as error:
        warnings.add(f"picture '{name}' cannot be read: {error}")
        return None
    wanted = "Linear Rec.709" if space == "sRGB" and (image.is_float or path.suffix.lower() in (".exr", ".hdr")) else space
    if image.users > 0 and image.colorspace_settings.name != wanted:
        image = image.copy()
    image.colorspace_settings.name = wanted
    image.alpha_mode = "CHANNEL_PACKED" if not image.is_float else image.alpha_mode
    if path.resolve().is_relative_to(folder.resolve()) and not image.packed_file:
        image.pack()
    return image


def _is_dark(value: Any) -> bool:
    return not isinstance(value, dict) and not any(_rgb(value))


def _rgb(value: Any) -> tuple[float, float, float]:
    r, g, b = value if isinstance(value, (list, tuple)) else (value,) * 3
    return float(r), float(g), float(b)


def _pair(value: Any) -> tuple[float, float]:
    u, v = value if isinstance(value, (list, tuple)) else (value, value)
    return float(u), float(v)


_SHADERS = {
    "diffuse": _Builder.diffuse,
    "diffuse_transmitter": _Builder.transmitter,
    "mirror": _Builder.metal,
    "conductor": _Builder.metal,
    "dielectric": _Builder.glass,
    "plastic": _Builder.plastic,
    "principled": _Builder.principled,
    "null": _Builder.passing,
}
