"""Evaluating nodes: what arrives at a socket, as far as a scene file can say it.

Nodes that reckon with colours or numbers are carried out: on constants, and pixel by pixel on pictures that
lie on the surface alike.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..warnings import Warnings
from .fields import LUMINANCE, Constant, Field, Mapping, Picture, VertexColors, constant
from .images import Images
from .operations import UnknownOperation, carry_out


def is_used(socket) -> bool:
    """Whether a socket means anything with the settings of its node."""
    return socket.enabled and not socket.is_unavailable


class Place:
    """A socket of a node within the groups around it."""

    def __init__(self, socket, groups: tuple = ()) -> None:
        self.socket = socket
        self.groups = groups

    def source(self) -> Place | None:
        """The output that feeds this input, through reroutes, groups and muted nodes; nothing where nothing does."""
        return self._followed()[1]

    def constant_place(self) -> Place:
        """The input whose own value counts where nothing feeds it: within groups that may be one of the group's."""
        return self._followed()[0]

    def _followed(self) -> tuple[Place, Place | None]:
        place = self
        for _ in range(1000):
            links = [link for link in place.socket.links if link.is_valid and not link.is_muted]
            further = Place(links[0].from_socket, place.groups)._within() if links else None
            if further is None or further.socket.is_output:
                return place, further
            place = further
        return place, None

    def _within(self) -> Place | None:
        """From an output to what really feeds it: an output of a node that does something, or an input to go on from."""
        node = self.socket.node
        if node.mute:
            inner = [link.from_socket for link in node.internal_links if link.to_socket == self.socket]
            return Place(inner[0], self.groups) if inner else None
        if node.type == "REROUTE":
            return Place(node.inputs[0], self.groups)
        if node.type == "GROUP" and node.node_tree:
            outs = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]
            inner = [s for n in outs for s in n.inputs if s.identifier == self.socket.identifier]
            return Place(inner[0], (*self.groups, node)) if inner else None
        if node.type == "GROUP_INPUT" and self.groups:
            outer = [s for s in self.groups[-1].inputs if s.identifier == self.socket.identifier]
            return Place(outer[0], self.groups[:-1]) if outer else None
        return self

    @property
    def node(self):
        return self.socket.node

    def input(self, *names: str) -> Place | None:
        """An enabled input of the node by its name or identifier, the first that there is."""
        for name in names:
            for socket in self.node.inputs:
                if name in (socket.name, socket.identifier) and is_used(socket):
                    return Place(socket, self.groups)
        return None


class Evaluator:
    """Evaluates sockets of one owner (a material, a light or a world), by whose name it warns."""

    def __init__(self, owner: str, images: Images, warnings: Warnings) -> None:
        self.owner = owner
        self.images = images
        self.warnings = warnings

    def warn(self, text: str) -> None:
        self.warnings.add(f"{self.owner}: {text}")

    def field(self, place: Place | None, default: float = 0.0) -> Field:
        """What a socket says. What cannot be said is a warning, and `default` stands in its place."""
        if place is None:
            return constant(default)
        source = place.source()
        if source is None:
            value = getattr(place.constant_place().socket, "default_value", default)
            return constant(value)
        return self._of_node(source)

    def color(self, place: Place | None, default: float = 0.0) -> np.ndarray:
        """A colour for what cannot have a picture: of one, the mean is taken, with a warning."""
        found = self.field(place, default)
        return self.plain(found, place.socket.name if place else "a value").color

    def number(self, place: Place | None, default: float = 0.0) -> float:
        found = self.field(place, default)
        return self.plain(found, place.socket.name if place else "a value").number

    def plain(self, found: Field, what: str) -> Constant:
        if isinstance(found, Picture):
            self.warn(f"{what} takes no picture; its mean counts")
            return self.images.mean(found)
        if isinstance(found, VertexColors):
            self.warn(f"{what} takes no colours of vertices; half counts")
            return Constant(found.tint * 0.5)
        return found

    def _of_node(self, place: Place) -> Field:
        node = place.node
        kind = node.type
        if kind in ("RGB", "VALUE"):
            return constant(node.outputs[0].default_value)
        if kind in ("TEX_IMAGE", "TEX_ENVIRONMENT"):
            return self._picture(place)
        if kind in ("VERTEX_COLOR", "ATTRIBUTE"):
            if kind == "ATTRIBUTE" and node.attribute_type != "GEOMETRY":
                self.warn(f"node '{node.name}': attributes of {node.attribute_type.lower()}s have no counterpart; half counts")
                return constant(0.5)
            return VertexColors(node.layer_name if kind == "VERTEX_COLOR" else node.attribute_name)
        return self._computed(place)

    def _picture(self, place: Place) -> Field:
        node, image = place.node, place.node.image
        if image is None or image.size[0] == 0:
            self.warn(f"node '{node.name}' has no picture that can be read; half counts")
            return constant(0.5)
        channel = "alpha" if place.socket.name == "Alpha" else None
        if node.type == "TEX_ENVIRONMENT":
            if node.projection != "EQUIRECTANGULAR":
                self.warn(f"node '{node.name}': a mirror ball is taken for a picture by longitude and latitude")
            return Picture(image, Mapping(), channel=channel, rotation=self._rotation(place.input("Vector")))
        mapping = self._mapping(place)
        if mapping is None:
            self.warn(f"node '{node.name}': pictures lie by texture coordinates (UV) only; the mean colour counts")
            return self.images.mean(Picture(image, Mapping(), channel=channel))
        return Picture(image, mapping, channel=channel)

    def _mapping(self, place: Place) -> Mapping | None:
        node = place.node
        if node.projection != "FLAT":
            return None
        if node.extension in ("CLIP", "MIRROR"):
            self.warn(
                f"node '{node.name}': extension '{node.extension.lower()}' is taken for "
                f"{'extend' if node.extension == 'CLIP' else 'repeat'}"
            )
        if node.interpolation in ("Cubic", "Smart"):
            self.warn(f"node '{node.name}': interpolation is linear")
        mapping = Mapping(clamp=node.extension in ("EXTEND", "CLIP"), nearest=node.interpolation == "Closest")
        vector = place.input("Vector")
        source = vector.source() if vector else None
        if source is not None and source.node.type == "MAPPING":
            found = self._moved(source, mapping)
            if found is None:
                return None
            mapping = found
            vector = source.input("Vector")
            source = vector.source() if vector else None
            if source is None:
                return None
        if source is None:
            return mapping
        if source.node.type == "UVMAP":
            return replace(mapping, uv_map=source.node.uv_map)
        return mapping if source.node.type == "TEX_COORD" and source.socket.name == "UV" else None

    def _moved(self, place: Place, mapping: Mapping) -> Mapping | None:
        """Scale and place of a node Mapping."""
        node = place.node
        location, rotation, scale = (self._vector(place.input(n)) for n in ("Location", "Rotation", "Scale"))
        if any(abs(r) > 1e-6 for r in rotation):
            self.warn(f"node '{node.name}': a turned picture has no counterpart; it is not turned")
        if node.vector_type == "TEXTURE":
            if not (scale[0] and scale[1]):
                return None
            scale = [1 / scale[0], 1 / scale[1]]
            location = [-location[0] * scale[0], -location[1] * scale[1]]
        elif node.vector_type != "POINT":
            location = [0.0, 0.0]
        return replace(mapping, scale=(float(scale[0]), float(scale[1])), offset=(float(location[0]), float(location[1])))

    def _vector(self, place: Place | None) -> list[float]:
        """A vector of a socket that nothing feeds."""
        if place is None:
            return [0.0, 0.0, 0.0]
        if place.source() is not None:
            self.warn(f"node '{place.node.name}': '{place.socket.name}' counts as it stands there, not as nodes make it")
        return list(place.constant_place().socket.default_value)

    def _rotation(self, vector: Place | None) -> np.ndarray:
        """The turn from directions of the world to those in which a picture of surroundings is looked up."""
        from mathutils import Euler

        source = vector.source() if vector else None
        turn = np.eye(3)
        if source is not None and source.node.type == "MAPPING":
            node = source.node
            turn = np.array(Euler(self._vector(source.input("Rotation"))).to_matrix())
            if node.vector_type == "TEXTURE":
                turn = turn.T
            scale = self._vector(source.input("Scale"))
            if (
                max(scale) - min(scale) > 1e-6
                or scale[0] <= 0
                or node.vector_type in ("POINT", "TEXTURE")
                and any(self._vector(source.input("Location")))
            ):
                self.warn(f"node '{node.name}': surroundings are turned, not stretched or moved")
            further = source.input("Vector")
            source = further.source() if further else None
        if source is not None and not (source.node.type == "TEX_COORD" and source.socket.name in ("Generated", "Object", "Normal")):
            if not (source.node.type == "NEW_GEOMETRY" and source.socket.name in ("Position", "Incoming", "Normal")):
                self.warn(f"node '{source.node.name}' has no counterpart where surroundings are looked up")
        return turn

    def _computed(self, place: Place) -> Field:
        node = place.node
        inputs = [Place(s, place.groups) for s in node.inputs if is_used(s)]
        fields = [self.field(p) for p in inputs]
        as_numbers = [p.socket.type == "VALUE" for p in inputs]
        try:
            if (scaled := _scaled(node, fields)) is not None:
                return scaled
            return self._carried_out(place, fields, as_numbers)
        except UnknownOperation:
            self.warn(f"node '{node.name}' ({node.bl_label}) has no counterpart; half counts in its place")
            return constant(0.5)

    def _carried_out(self, place: Place, fields: list[Field], as_numbers: list[bool]) -> Field:
        pictures = [f for f in fields if isinstance(f, Picture)]
        if any(isinstance(f, VertexColors) for f in fields):
            raise UnknownOperation
        if pictures and any(p.mapping != pictures[0].mapping for p in pictures):
            raise UnknownOperation
        arrays = [self._array(f, n) for f, n in zip(fields, as_numbers)]
        if len({a.shape for a in arrays if a.shape[:2] != (1, 1)}) > 1:
            raise UnknownOperation
        result = carry_out(place.node, place.socket, arrays)
        if result.ndim == 1:
            result = result.reshape(1, 1, -1)
        if not pictures:
            return constant(result.reshape(-1)[:3])
        result = np.broadcast_to(result, (*max((a.shape[:2] for a in arrays), key=math.prod), 3))
        return Picture(pictures[0].image, pictures[0].mapping, pixels=result.astype(np.float32), rotation=pictures[0].rotation)

    def _array(self, what: Field, as_number: bool) -> np.ndarray:
        """Rows, columns and three channels; a number is in all three."""
        if isinstance(what, Constant):
            pixels = what.color.reshape(1, 1, 3)
        else:
            pixels = what.pixels if what.pixels is not None else self.images.pixels(what.image)
            if pixels is None:
                raise UnknownOperation
            if what.channel is not None:
                k = {"red": 0, "green": 1, "blue": 2, "alpha": 3}[what.channel]
                pixels = np.repeat(pixels[:, :, k : k + 1], 3, axis=2)
            pixels = pixels[:, :, :3] * what.tint
        return np.repeat((pixels @ LUMINANCE)[:, :, None], 3, axis=2) if as_number else pixels


def _scaled(node, fields: list[Field]) -> Field | None:
    """A picture times a constant keeps its file, and vertices may be multiplied too."""
    multiplies = (
        node.type in ("MIX", "MIX_RGB") and node.blend_type == "MULTIPLY" or node.type == "MATH" and node.operation == "MULTIPLY"
    )
    if not multiplies or getattr(node, "use_clamp", False) or getattr(node, "clamp_result", False):
        return None
    operands = fields[:2]
    if node.type != "MATH":
        if not isinstance(fields[0], Constant) or fields[0].number != 1.0 or getattr(node, "data_type", "RGBA") != "RGBA":
            return None
        operands = fields[1:3]
    for a, b in (operands, operands[::-1]):
        if isinstance(a, Constant) and isinstance(b, (Picture, VertexColors)) and a.color.min() >= 0:
            return b.times(a.color)
    return None
