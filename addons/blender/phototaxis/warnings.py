"""What the user is told of a scene: each sentence once, in the order in which it came up."""

from __future__ import annotations


class Warnings:
    def __init__(self) -> None:
        self._lines: dict[str, None] = {}

    def add(self, line: str) -> None:
        self._lines.setdefault(line)

    def __iter__(self):
        return iter(self._lines)

    def __len__(self) -> int:
        return len(self._lines)
