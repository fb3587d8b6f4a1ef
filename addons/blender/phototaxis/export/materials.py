"""Materials of Blender as `[material]` tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..warnings import Warnings
from .fields import Constant, Field, Picture, VertexColors, constant
from .images import Images
from .nodes import Evaluator, Place
from .shaders import surface_of
from .surfaces import COLORS, METALS, NUMBERS, OPAQUE, Surface

#: What objects without a material are made of, as in Cycles before Blender 5 and since.
_DEFAULT_DIFFUSE = {"type": "diffuse", "reflectance": 0.8}
_DEFAULT_PRINCIPLED = {"type": "plastic", "reflectance": 0.8, "int_ior": 1.5, "alpha": 0.25, "energy_conserving": True}
_TINTS = {"emission": np.inf}


@dataclass
class Described:
    """A material as it is written, and what its meshes need for it."""

    name: str
    table: dict[str, Any]
    uv_map: str = ""
    vertex_colors: str | None = None


class Materials:
    """The materials of one export, each of them written once for each group of lights that it is in."""

    def __init__(self, images: Images, warnings: Warnings) -> None:
        self._images = images
        self._warnings = warnings
        self._described: dict[tuple[str, str], Described] = {}
        self._names: set[str] = set()

    def __iter__(self):
        return iter(self._described.values())

    def of(self, material, light_group: str = "") -> Described:
        """The description of a material of Blender, or of none at all."""
        key = (material.name_full if material else "", light_group)
        if key not in self._described:
            described = self._describe(material)
            if described.table.get("emission") is None:
                light_group = ""
            if light_group:
                described.table["light_group"] = light_group
            described.name = self._unused(f"{described.name} ({light_group})" if light_group else described.name)
            self._described[key] = described
        return self._described[key]

    def add(self, name: str, table: dict[str, Any]) -> str:
        """A material that is none of Blender's; returns its name."""
        name = self._unused(name)
        self._described[("", "own " + name)] = Described(name, table)
        return name

    def _unused(self, name: str) -> str:
        chosen, count = name, 0
        while chosen in self._names:
            count += 1
            chosen = f"{name}-{count}"
        self._names.add(chosen)
        return chosen

    def _describe(self, material) -> Described:
        if material is None:
            return Described("no material", dict(_DEFAULT_PRINCIPLED if bpy.app.version >= (5, 0) else _DEFAULT_DIFFUSE))
        evaluator = Evaluator(f"material '{material.name}'", self._images, self._warnings)
        writer = _Writer(evaluator, Described(material.name, {}))
        writer.write(self._surface(material, evaluator))
        return writer.described

    def _surface(self, material, evaluator: Evaluator) -> Surface:
        if not material.use_nodes or material.node_tree is None:
            return Surface("diffuse", {"reflectance": constant(material.diffuse_color)})
        output = material.node_tree.get_output_node("CYCLES") or material.node_tree.get_output_node("ALL")
        if output is None:
            return Surface("diffuse", {"reflectance": constant(0.0)})
        for name in ("Volume", "Displacement"):
            if output.inputs[name].is_linked:
                evaluator.warn(f"its {name.lower()} has no counterpart and is left out")
        surface = output.inputs["Surface"]
        if not surface.is_linked and output.inputs["Volume"].is_linked:
            return Surface("null")
        return surface_of(Place(surface), evaluator)


class _Writer:
    def __init__(self, evaluator: Evaluator, described: Described) -> None:
        self.evaluator = evaluator
        self.described = described

    def write(self, surface: Surface) -> None:
        table = self.described.table
        table["type"] = surface.kind
        for key, what in surface.values.items():
            table[key] = self._value(key, what, surface.kind)
        if surface.opacity is not None and surface.kind != "null":
            table["opacity"] = self._number(surface.opacity, "opacity")
        if surface.emission is not None:
            table["emission"] = self._color(surface.emission, "emission")
            table["emission_two_sided"] = surface.emission_two_sided
        if not surface.two_sided and surface.kind in OPAQUE:
            table["two_sided"] = False
        if surface.relief is not None:
            self._relief(surface.relief)

    def _value(self, key: str, what: Any, kind: str) -> Any:
        if not isinstance(what, (Constant, Picture, VertexColors)):
            return what
        if key in NUMBERS:
            return self._number(what, key)
        if key in COLORS or key == "specular_reflectance" and kind in METALS:
            return self._color(what, key)
        color = self.evaluator.plain(what, key.replace("_", " ")).color
        return [float(max(c, 0)) for c in color]

    def _color(self, what: Field, key: str) -> Any:
        most = _TINTS.get(key, 1.0)
        if isinstance(what, Constant):
            if what.color.max() > most:
                self.evaluator.warn(f"a colour above 1 is taken for 1 ({key.replace('_', ' ')})")
            return [float(c) for c in np.clip(what.color, 0, most)]
        if isinstance(what, VertexColors):
            return (
                {"vertex_color": True} | self._tint(what.tint, most, key)
                if self._colored(what.layer)
                else [float(c) for c in what.tint]
            )
        file = None if what.pixels is not None or what.channel else self.evaluator.images.file(what.image, as_numbers=False)
        file = file or self.evaluator.images.baked(what)
        if file is None:
            return 0.5
        return {"texture": file} | self._mapped(what) | self._tint(what.tint, most, key)

    def _number(self, what: Field, key: str) -> Any:
        """A number between 0 and 1; a picture's values count as they are stored."""
        if isinstance(what, Constant):
            return min(max(what.number, 0.0), 1.0)
        if isinstance(what, VertexColors):
            if key == "opacity" or not self._colored(what.layer):
                return self.evaluator.plain(what, key).number
            return {"vertex_color": True} | self._tint(what.tint, 1.0, key)
        images = self.evaluator.images
        if not (what.tint == 1).all():
            pixels = what.pixels if what.pixels is not None else images.pixels(what.image)
            if pixels is None:
                return 0.5
            scale = np.append(what.tint, 1.0)[: pixels.shape[2]] if what.channel != "alpha" else what.tint[0]
            what = Picture(what.image, what.mapping, channel=what.channel, pixels=(pixels * scale).astype(np.float32))
        as_stored = what.channel == "alpha" or images.numbers_as_stored(what.image)
        file = (
            images.file(what.image, as_numbers=images.numbers_as_stored(what.image)) if what.pixels is None and as_stored else None
        )
        if file is not None:
            return {"texture": file} | self._mapped(what) | {"channel": what.channel or "luminance"}
        file = images.baked(what)
        return 0.5 if file is None else {"texture": file} | self._mapped(what) | {"channel": "luminance"}

    def _relief(self, relief: dict) -> None:
        picture: Picture = relief["picture"]
        images = self.evaluator.images
        numbers = images.numbers_as_stored(picture.image)
        file = None if picture.pixels is not None else images.file(picture.image, as_numbers=True)
        if not numbers and relief["key"] == "normal_map":
            self.evaluator.warn(f"image '{picture.image.name}' of normals has a colour space; it should be Non-Color")
        file = file or images.baked(picture)
        if file is not None:
            self.described.table[relief["key"]] = {"texture": file} | self._mapped(picture) | relief["more"]

    def _tint(self, tint: np.ndarray, most: float, key: str) -> dict:
        if (tint == 1).all():
            return {}
        if tint.max() > most:
            self.evaluator.warn(f"a picture is brightened by no more than 1 ({key.replace('_', ' ')})")
        return {"tint": [float(c) for c in np.clip(tint, 0, most)]}

    def _mapped(self, picture: Picture) -> dict:
        name = picture.mapping.uv_map
        if self._maps is not None and self._maps != name:
            self.evaluator.warn("pictures that lie by several maps of texture coordinates all lie by one of them")
        else:
            self._maps = self.described.uv_map = name
        return picture.mapping.keys()

    _maps: str | None = None

    def _colored(self, layer: str) -> bool:
        if self.described.vertex_colors not in (None, layer):
            self.evaluator.warn(f"colours of vertices '{layer}': one set of them can be used")
            return False
        self.described.vertex_colors = layer
        return True
