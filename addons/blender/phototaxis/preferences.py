"""Where the program is."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import bpy
from bpy.props import StringProperty


class ProgramMissing(Exception):
    """The program phototaxis is not where it is looked for."""


class PhototaxisPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program",
        subtype="FILE_PATH",
        description="The program phototaxis; without it, the environment variable PHOTOTAXIS or the search path says where it is",
    )

    def draw(self, context) -> None:
        self.layout.prop(self, "program")
        try:
            self.layout.label(text=f"In use: {program()}")
        except ProgramMissing as missing:
            self.layout.label(text=str(missing), icon="ERROR")


def program() -> Path:
    """The program: of the preferences, else of the variable PHOTOTAXIS, else on the search path.

    Raises ProgramMissing.
    """
    addon = bpy.context.preferences.addons.get(__package__)
    chosen = addon.preferences.program if addon else ""
    chosen = bpy.path.abspath(chosen) if chosen else os.environ.get("PHOTOTAXIS", "")
    if chosen:
        if not Path(chosen).is_file():
            raise ProgramMissing(f"there is no program {chosen}: say in the add-on's preferences where phototaxis is")
        return Path(chosen)
    found = shutil.which("phototaxis")
    if found is None:
        raise ProgramMissing("the program phototaxis is not on the search path: say in the add-on's preferences where it is")
    return Path(found)


def register() -> None:
    bpy.utils.register_class(PhototaxisPreferences)


def unregister() -> None:
    bpy.utils.unregister_class(PhototaxisPreferences)
