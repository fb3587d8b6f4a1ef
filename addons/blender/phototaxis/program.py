"""Running the program and hearing how far it is."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import threading
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Progress:
    """A line that the program says of itself."""

    stage: str
    seconds: float
    share: float | None
    samples: int | None
    left_seconds: float | None

    def text(self) -> str:
        parts = [self.stage.capitalize()]
        if self.samples is not None:
            parts.append(f"{self.samples} samples")
        if self.left_seconds is not None:
            parts.append(f"{self.left_seconds:.0f} s left")
        return " | ".join(parts)


@dataclass
class Run:
    """A process of the program, whose standard error is read as it comes."""

    arguments: list[str]
    messages: list[str] = field(default_factory=list)
    stopping: bool = False

    def __post_init__(self) -> None:
        # A group of its own: Ctrl-C in Blender's terminal is Blender's to pass on.
        apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP} if os.name == "nt" else {"start_new_session": True}
        self._process = subprocess.Popen(
            self.arguments, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **apart
        )
        self._lines: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read, name="phototaxis", daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self._lines.put(line.decode("utf-8", "replace").strip())
        self._lines.put(None)

    def heard(self, seconds: float) -> Progress | None | bool:
        """What it says of its progress within the time; `True` where it says nothing, `None` when it has ended."""
        try:
            line = self._lines.get(timeout=seconds)
        except queue.Empty:
            return True
        if line is None:
            self._process.wait()
            return None
        try:
            said = json.loads(line)
        except ValueError:
            said = {"message": line}
        if "stage" in said:
            return Progress(*(said.get(k) for k in ("stage", "seconds", "share", "samples", "left_seconds")))
        if said.get("message"):
            self.messages.append(str(said["message"]))
        return True

    def stop(self) -> None:
        """Asks for the end: the pass is finished and the picture written."""
        if not self.stopping:
            self.stopping = True
            self._process.send_signal(signal.CTRL_BREAK_EVENT if os.name == "nt" else signal.SIGINT)

    def kill(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()

    @property
    def code(self) -> int:
        return self._process.returncode


def call(arguments: list[str | Path]) -> list[str]:
    """Runs the program to its end. Returns what it said.

    Raises RuntimeError with its last words where it fails.
    """
    done = subprocess.run([str(a) for a in arguments], stdin=subprocess.DEVNULL, capture_output=True)
    lines = [line.strip() for line in done.stderr.decode("utf-8", "replace").splitlines() if line.strip()]
    if done.returncode != 0:
        raise RuntimeError(" ".join(lines) or f"the program ended with code {done.returncode}")
    return lines
