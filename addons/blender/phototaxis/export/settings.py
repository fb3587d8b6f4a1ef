"""How it is rendered: `[film]`, `[integrator]`, `[guiding]` and `[render]`."""

from __future__ import annotations

from typing import Any

from ..warnings import Warnings

_TONES = {"Standard": "srgb", "Raw": "srgb", "AgX": "agx", "Filmic": "agx"}


def sections(scene, extra_layers: list[str], warnings: Warnings) -> dict[str, dict[str, Any]]:
    """The sections by name; `extra_layers` are those that the picture has to have besides."""
    settings = scene.phototaxis
    render: dict[str, Any] = {"spp": settings.spp, "seed": settings.seed, "sampler": settings.sampler}
    if settings.use_time:
        render["time"] = float(settings.time)
    if extra_layers:
        render["layers"] = extra_layers
    integrator = {"max_depth": settings.max_depth, "light_sampler": settings.light_sampler, "roulette": settings.roulette}
    return {"film": _film(scene, warnings), "integrator": integrator, "guiding": settings.guiding(), "render": render}


def _film(scene, warnings: Warnings) -> dict[str, Any]:
    view = scene.view_settings
    if view.view_transform not in _TONES:
        warnings.add(f"view transform '{view.view_transform}': the PNG has that of AgX")
    tone = _TONES.get(view.view_transform, "agx")
    return {"filter": scene.phototaxis.filter, "exposure": float(view.exposure), "tone": tone}
