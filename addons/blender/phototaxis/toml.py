"""Writing TOML. (Python itself can only read it.)"""

from __future__ import annotations

import json
import math
from typing import Any

# Tables that are written under a heading of their own; all others stand within braces.
_HEADED = ("camera", "film", "integrator", "guiding", "render")


def string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def value(what: Any) -> str:
    """One value as TOML. Numbers keep all their digits."""
    if isinstance(what, bool):
        return "true" if what else "false"
    if isinstance(what, int):
        return str(what)
    if isinstance(what, float):
        if not math.isfinite(what):
            raise ValueError(f"{what} is no number for a scene file")
        return repr(what)
    if isinstance(what, str):
        return string(what)
    if isinstance(what, dict):
        return "{ " + ", ".join(f"{key} = {value(item)}" for key, item in what.items()) + " }"
    return "[" + ", ".join(value(item) for item in what) + "]"


def _table(heading: str, table: dict[str, Any]) -> str:
    return "\n".join([heading, *(f"{key} = {value(item)}" for key, item in table.items())]) + "\n"


def document(scene: dict[str, Any], comment: str) -> str:
    """A scene file: sections, `[material.NAME]`, and lists of `[[mesh]]`, `[[instance]]` and `[[light]]`."""
    parts = [f"# {comment}\n"]
    parts += [_table(f"[{name}]", scene[name]) for name in _HEADED if scene.get(name)]
    for name in ("mesh", "instance", "light"):
        parts += [_table(f"[[{name}]]", table) for table in scene.get(name, [])]
    for name, table in scene.get("material", {}).items():
        parts.append(_table(f"[material.{string(name)}]", table))
    return "\n".join(parts)
