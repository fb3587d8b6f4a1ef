"""Packs the add-on as Blender installs it: `python3 pack.py OUT.zip`. Needs no Blender."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parents[1]


def files() -> dict[str, Path]:
    """What is in the add-on, by names within it."""
    folder = HERE / "phototaxis"
    found = {str(p.relative_to(folder)): p for p in sorted(folder.rglob("*")) if p.suffix in (".py", ".toml")}
    return found | {name: PROJECT / name for name in ("LICENSE-APACHE", "LICENSE-MIT")}


def main() -> None:
    target = Path(sys.argv[1])
    target.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, path in files().items():
            # The same files make the same package.
            packed.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), path.read_bytes(), zipfile.ZIP_DEFLATED)
    print(f"The add-on is {target}: in Blender, Edit > Preferences > Get Extensions > Install from Disk.")


if __name__ == "__main__":
    main()
