"""Scenes of Blender as scene files."""

from .scene import Exported, NoCamera, export

__all__ = ["Exported", "NoCamera", "export"]
