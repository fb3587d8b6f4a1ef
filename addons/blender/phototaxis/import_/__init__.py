"""Scene files, and what the program can make scene files of, as scenes of Blender."""

from .scene import NotAScene, import_scene

__all__ = ["NotAScene", "import_scene"]
