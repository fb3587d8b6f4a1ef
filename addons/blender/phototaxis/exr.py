"""OpenEXR pictures of scan lines, uncompressed or compressed with ZIP: what Phototaxis writes.

Blender's Python has no way to the layers of such a file that works while it renders.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

_MAGIC = 20000630
_TYPES = ("<u4", "<f2", "<f4")
_LINES = {0: 1, 2: 1, 3: 16}


@dataclass
class Picture:
    """Channels by name, as arrays of rows from the top; `origin` is where the first pixel lies in the whole picture."""

    channels: dict[str, np.ndarray]
    origin: tuple[int, int] = (0, 0)
    attributes: dict[str, bytes] = field(default_factory=dict)

    def layer(self, *names: str) -> np.ndarray | None:
        """Some channels as one array of rows, columns and channels, if they are all there."""
        if any(name not in self.channels for name in names):
            return None
        return np.stack([self.channels[name].astype(np.float32) for name in names], axis=2)


def _name(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(b"\0", at)
    return data[at:end].decode("utf-8", "replace"), end + 1


def _attributes(data: bytes) -> tuple[dict[str, bytes], int]:
    at, found = 8, {}
    while data[at] != 0:
        name, at = _name(data, at)
        _, at = _name(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        found[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data: bytes) -> list[tuple[str, np.dtype]]:
    at, found = 0, []
    while data[at] != 0:
        name, at = _name(data, at)
        found.append((name, np.dtype(_TYPES[struct.unpack_from("<i", data, at)[0]])))
        at += 16
    return found


def _unzip(data: bytes, size: int) -> bytes:
    """Undoes ZIP compression: differences of bytes, and even and odd bytes in halves of their own."""
    if len(data) == size:
        return data
    raw = np.frombuffer(zlib.decompress(data), np.uint8).astype(np.int64)
    if len(raw) != size:
        raise ValueError("a block of another size than its header says")
    raw[1:] -= 128
    halves = (np.cumsum(raw) & 255).astype(np.uint8)
    out = np.empty(size, np.uint8)
    out[0::2] = halves[: (size + 1) // 2]
    out[1::2] = halves[(size + 1) // 2 :]
    return out.tobytes()


def read(path: Path) -> Picture:
    """Reads all channels.

    Raises ValueError where the file is of another kind, or is cut off.
    """
    data = Path(path).read_bytes()
    try:
        magic, version = struct.unpack_from("<ii", data, 0)
        if magic != _MAGIC or version & 0x1A00:
            raise ValueError("not an OpenEXR picture of scan lines")
        return _read(data)
    except (struct.error, IndexError, KeyError, zlib.error, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error


def _read(data: bytes) -> Picture:
    attributes, at = _attributes(data)
    channels = _channels(attributes["channels"])
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    lines = _LINES[attributes["compression"][0]]
    size = sum(kind.itemsize for _, kind in channels) * width
    planes = {name: np.empty((height, width), kind) for name, kind in channels}
    blocks = -(-height // lines)
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        first, length = struct.unpack_from("<ii", data, offset)
        first -= top
        rows = min(lines, height - first)
        block = np.frombuffer(_unzip(data[offset + 8 : offset + 8 + length], rows * size), np.uint8).reshape(rows, size)
        begin = 0
        for name, kind in channels:
            end = begin + width * kind.itemsize
            planes[name][first : first + rows] = np.ascontiguousarray(block[:, begin:end]).view(kind)
            begin = end
    return Picture(planes, (left, top), attributes)


def _attribute(name: str, kind: str, data: bytes) -> bytes:
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data


def encoded(pixels: np.ndarray) -> bytes:
    """A file of rows (from the top) of red, green and blue, or of one number, or of red, green, blue and alpha."""
    height, width, count = pixels.shape
    names = {1: "Y", 3: "BGR", 4: "ABGR"}[count]
    order = {1: [0], 3: [2, 1, 0], 4: [3, 2, 1, 0]}[count]
    channels = b"".join(n.encode() + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for n in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", _MAGIC, 2) + _attribute("channels", "chlist", channels)
    header += _attribute("compression", "compression", b"\0") + _attribute("dataWindow", "box2i", window)
    header += _attribute("displayWindow", "box2i", window) + _attribute("lineOrder", "lineOrder", b"\0")
    header += _attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + _attribute("screenWindowCenter", "v2f", bytes(8))
    header += _attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    size = width * count * 4
    begin = len(header) + 8 * height
    offsets = begin + np.arange(height, dtype="<u8") * (size + 8)
    rows = np.empty(height, dtype=[("y", "<i4"), ("size", "<i4"), ("data", "<f4", (count, width))])
    rows["y"], rows["size"] = np.arange(height), size
    rows["data"] = pixels[:, :, order].transpose(0, 2, 1)
    return header + offsets.tobytes() + rows.tobytes()
