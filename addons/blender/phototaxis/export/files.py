"""The folder beside a scene file, and the files in it."""

from __future__ import annotations

from pathlib import Path


class Files:
    """What one export writes. What it has not written itself is left alone: pictures of the scene may be in the same folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._taken: set[str] = set()
        folder.mkdir(parents=True, exist_ok=True)

    def mesh(self, name: str) -> Path:
        """Where a mesh goes; one of an earlier export is replaced."""
        return next(path for path in self._candidates(name, ".ply") if self._takes(path))

    def picture(self, name: str, suffix: str, data: bytes) -> Path:
        """Writes a picture, unless it is there; another of the same name stays, and this one gets a number."""
        for path in self._candidates(name, suffix):
            if path.exists() and path.read_bytes() != data:
                continue
            if self._takes(path):
                write(path, data)
                return path
        raise AssertionError("numbers have no end")

    def _candidates(self, name: str, suffix: str):
        clean = "".join(c if c.isalnum() or c in "-_. " else "_" for c in name).strip(" .")[:100] or "unnamed"
        yield self.folder / f"{clean}{suffix}"
        count = 0
        while True:
            count += 1
            yield self.folder / f"{clean}-{count}{suffix}"

    def _takes(self, path: Path) -> bool:
        # Some systems do not tell capital letters from small ones.
        name = path.name.casefold()
        if name in self._taken:
            return False
        self._taken.add(name)
        return True


def write(path: Path, data: bytes) -> None:
    """A file that is whole or not there."""
    partial = path.with_name(path.name + ".part")
    partial.write_bytes(data)
    partial.replace(path)
