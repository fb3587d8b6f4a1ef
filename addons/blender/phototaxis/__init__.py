"""Phototaxis in Blender: a render engine, and scenes written and read."""

from . import engine, operators, panels, preferences, properties

_MODULES = (preferences, properties, engine, panels, operators)


def register() -> None:
    for module in _MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(_MODULES):
        module.unregister()
