"""Meshes as binary PLY files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}


@dataclass
class Triangles:
    """Triangles by the numbers of their vertices; what is `None` the mesh does not have."""

    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    uvs: np.ndarray | None = None
    colors: np.ndarray | None = None


def write(path: Path, mesh: Triangles) -> None:
    """Writes a mesh. Colours are linear, from 0 to 1."""
    columns = [(("x", "y", "z"), mesh.positions), (("nx", "ny", "nz"), mesh.normals), (("s", "t"), mesh.uvs)]
    columns.append((("red", "green", "blue"), mesh.colors))
    columns = [(names, data) for names, data in columns if data is not None]
    names = [name for group, _ in columns for name in group]
    vertices = np.concatenate([data for _, data in columns], axis=1).astype("<f4")
    faces = np.empty(len(mesh.triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = mesh.triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    partial = path.with_name(path.name + ".part")
    with open(partial, "wb") as file:
        file.write("\n".join(header).encode())
        file.write(vertices.tobytes())
        file.write(faces.tobytes())
    partial.replace(path)


def _header(file, path: Path) -> list[tuple[str, int, list[list[str]]]]:
    """The elements of a PLY file: name, count and properties of each."""
    if file.readline().strip() != b"ply" or file.readline().split()[:2] != [b"format", b"binary_little_endian"]:
        raise ValueError(f"{path} is no binary PLY file")
    elements: list[tuple[str, int, list[list[str]]]] = []
    while (words := file.readline().decode("utf-8", "replace").split()) != ["end_header"]:
        if not words:
            raise ValueError(f"{path}: its header has no end")
        if words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            elements[-1][2].append(words[1:])
    return elements


def read(path: Path) -> Triangles:
    """Reads a mesh as Phototaxis writes it: binary, first vertices and then nothing but triangles."""
    with open(path, "rb") as file:
        elements = _header(file, path)
        if [name for name, _, _ in elements] != ["vertex", "face"] or any(p[0] == "list" for p in elements[0][2]):
            raise ValueError(f"{path} holds more than vertices and faces")
        count = elements[0][1]
        vertex = np.dtype([(name, "<" + _TYPES[kind]) for kind, name in elements[0][2]])
        vertices = np.frombuffer(file.read(count * vertex.itemsize), vertex)
        if len(elements[1][2]) != 1 or elements[1][2][0][0] != "list":
            raise ValueError(f"{path}: its faces are no list of vertices")
        _, of_count, of_corner, _ = elements[1][2][0]
        face = np.dtype([("count", "<" + _TYPES[of_count]), ("corners", "<" + _TYPES[of_corner], 3)])
        faces = np.frombuffer(file.read(elements[1][1] * face.itemsize), face)
    if len(vertices) != count or len(faces) != elements[1][1] or (faces["count"] != 3).any():
        raise ValueError(f"{path} is cut off, or has faces of more than three corners")

    def columns(*names: str) -> np.ndarray | None:
        if any(name not in vertex.names for name in names):
            return None
        return np.stack([vertices[name].astype(np.float32) for name in names], axis=1)

    uvs = columns("s", "t") if "s" in vertex.names else columns("u", "v")
    corners = faces["corners"].astype(np.int32)
    return Triangles(columns("x", "y", "z"), corners, columns("nx", "ny", "nz"), uvs, columns("red", "green", "blue"))
