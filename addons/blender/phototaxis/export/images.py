"""Pictures: files that are used where they are, and those that are written for what no file says."""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import numpy as np

from .. import exr
from ..warnings import Warnings
from .fields import LUMINANCE, Constant, Picture
from .files import Files

#: Endings of files that Phototaxis reads.
_READABLE = {".png", ".jpg", ".jpeg", ".exr", ".tga", ".bmp", ".tif", ".tiff", ".webp", ".hdr"}
_FLOATS = {".exr", ".hdr"}
_NUMBERS = {"Non-Color", "Raw", "Generic Data", "Non-Colour Data"}
_LINEAR = {"Linear Rec.709", "Linear", "scene_linear", "Linear BT.709"} | _NUMBERS


def decode_srgb(stored: np.ndarray) -> np.ndarray:
    return np.where(stored <= 0.04045, stored / 12.92, ((np.maximum(stored, 0) + 0.055) / 1.055) ** 2.4)


class Images:
    """The pictures of one export."""

    def __init__(self, files: Files, scene_folder: Path, warnings: Warnings) -> None:
        self._files = files
        self._scene_folder = scene_folder
        self._warnings = warnings
        self._written: dict[tuple, str] = {}
        self._pixels: dict[str, np.ndarray | None] = {}

    def pixels(self, image) -> np.ndarray | None:
        """Rows from the bottom of linear red, green, blue, and alpha; nothing where there is no picture."""
        if image.name_full not in self._pixels:
            self._pixels[image.name_full] = self._decoded(image)
        return self._pixels[image.name_full]

    def _decoded(self, image) -> np.ndarray | None:
        if image.source == "TILED":
            self._warnings.add(f"image '{image.name}': tiles (UDIM) have no counterpart; its first tile counts")
        if image.source in {"SEQUENCE", "MOVIE"}:
            self._warnings.add(f"image '{image.name}': of a film one picture counts")
        width, height = image.size
        if width == 0 or height == 0 or image.channels == 0:
            self._warnings.add(f"image '{image.name}' cannot be read")
            return None
        flat = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(flat)
        stored = flat.reshape(height, width, image.channels)
        if image.channels < 3:
            alpha = stored[:, :, 1:2] if image.channels == 2 else np.ones_like(stored[:, :, :1])
            stored = np.concatenate([stored[:, :, :1]] * 3 + [alpha], axis=2)
        elif image.channels == 3:
            stored = np.concatenate([stored, np.ones_like(stored[:, :, :1])], axis=2)
        space = image.colorspace_settings.name
        if not image.is_float and space not in _LINEAR:
            if space != "sRGB":
                self._warnings.add(f"image '{image.name}': colour space '{space}' is taken for sRGB")
            stored = np.concatenate([decode_srgb(stored[:, :, :3]), stored[:, :, 3:]], axis=2)
        return stored

    def numbers_as_stored(self, image) -> bool:
        return image.colorspace_settings.name in _NUMBERS

    def file(self, image, as_numbers: bool) -> str | None:
        """The file whose values Phototaxis reads as Blender does: that of the image itself, if there is one.

        Whole numbers are decoded from sRGB where a colour is wanted, and are not where numbers are (`as_numbers`).
        """
        path = self._own_file(image)
        if path is None:
            return None
        space = image.colorspace_settings.name
        if path.suffix.lower() in _FLOATS:
            return self.name(path) if space in _LINEAR else None
        wanted = _NUMBERS if as_numbers else {"sRGB"}
        return self.name(path) if space in wanted and not image.is_float else None

    def _own_file(self, image) -> Path | None:
        if image.source != "FILE" or image.is_dirty:
            return None
        library = getattr(image, "library", None)
        path = Path(bpy.path.abspath(image.filepath, library=library)) if image.filepath else Path(image.name)
        if path.suffix.lower() not in _READABLE:
            return None
        if not image.packed_files:
            return path.resolve() if path.is_file() else None
        key = ("packed", image.name_full)
        if key not in self._written:
            data = image.packed_files[0].packed_file.data
            self._written[key] = str(self._files.picture(_stem(image.name), path.suffix.lower(), data))
        return Path(self._written[key])

    def name(self, path: Path) -> str:
        """A file as the scene file names it: by the way from its folder, if there is one."""
        try:
            return os.path.relpath(path, self._scene_folder).replace(os.sep, "/")
        except ValueError:
            return str(path)

    def baked(self, picture: Picture) -> str | None:
        """Writes the pixels of a picture, of floats and linear, once."""
        pixels = picture.pixels if picture.pixels is not None else self.pixels(picture.image)
        if pixels is None:
            return None
        if picture.channel == "alpha":
            pixels = pixels[:, :, 3:4]
        elif picture.channel in ("red", "green", "blue"):
            k = ("red", "green", "blue").index(picture.channel)
            pixels = pixels[:, :, k : k + 1]
        else:
            pixels = pixels[:, :, :3]
        key = (hash(pixels.tobytes()), pixels.shape)
        if key not in self._written:
            data = exr.encoded(np.ascontiguousarray(pixels[::-1]))
            self._written[key] = str(self._files.picture(_stem(picture.image.name), ".exr", data))
        return self.name(Path(self._written[key]))

    def mean(self, picture: Picture) -> Constant:
        """The mean of a picture, for what has no picture."""
        pixels = picture.pixels if picture.pixels is not None else self.pixels(picture.image)
        if pixels is None:
            return Constant(np.full(3, 0.5))
        mean = pixels.reshape(-1, pixels.shape[2]).mean(axis=0)
        if picture.channel == "alpha":
            mean = np.full(3, mean[3])
        elif picture.channel in ("red", "green", "blue"):
            mean = np.full(3, mean[("red", "green", "blue").index(picture.channel)])
        elif picture.channel == "luminance":
            mean = np.full(3, float(mean[:3] @ LUMINANCE))
        return Constant(mean[:3].astype(float) * picture.tint)


def _stem(name: str) -> str:
    """The name of an image without the ending of a file."""
    return Path(name).stem if Path(name).suffix.lower() in _READABLE else name
