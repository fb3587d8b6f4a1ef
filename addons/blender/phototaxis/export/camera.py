"""The camera and the picture: `[camera]` and `[film]`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..warnings import Warnings


@dataclass
class View:
    """The sections of a scene file, and where the part that is rendered lies among the pixels of the whole."""

    camera: dict[str, Any]
    film: dict[str, Any]


def export(scene, camera_object, matrix: np.ndarray, warnings: Warnings) -> View:
    """What `camera_object` sees from where `matrix` puts it, at the size of the scene's pictures."""
    render, camera = scene.render, camera_object.data
    width, height = size(render)
    if render.pixel_aspect_x != render.pixel_aspect_y:
        warnings.add("pixels are square; the aspect of pixels is left out")
    if render.use_multiview:
        warnings.add("stereo pictures have no counterpart; one view is rendered")
    table = _placed(matrix)
    window = _Window.of(camera, scene)
    film: dict[str, Any] = {}
    if camera.type == "PANO":
        _panorama(camera, table, warnings)
        film |= {"width": width, "height": height}
        if render.use_border:
            film["crop"] = border(render)
        return View(table, film)
    film |= _film(window, width, height, render, warnings)
    # The whole picture may be higher than the part that is shown of it.
    tall = window.height * film["height"] / height
    if camera.type == "ORTHO":
        table |= {"projection": "orthographic", "view_height": tall}
        if camera.dof.use_dof:
            warnings.add("an orthographic camera has no lens here; everything is sharp")
    else:
        table["vfov"] = math.degrees(2 * math.atan(tall / 2))
        _lens(camera_object, matrix, table, warnings)
    return View(table, film)


def shows(scene, camera_object, points: np.ndarray) -> bool:
    """Whether points of the world may be in the picture: whether the box about them is, as the camera sees it."""
    camera = camera_object.data
    if camera.type == "PANO":
        return True
    matrix = np.array(camera_object.matrix_world, float)
    axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
    seen = (points - matrix[:3, 3]) @ axes
    before = seen[seen[:, 2] < 0]
    if not len(before):
        return False
    flat = before[:, :2] if camera.type == "ORTHO" else before[:, :2] / -before[:, 2:]
    window = _Window.of(camera, scene)
    middle, half = np.array([window.x, window.y]), np.array([window.width, window.height]) / 2
    return bool((flat.min(axis=0) < middle + half).all() and (flat.max(axis=0) > middle - half).all())


def size(render) -> tuple[int, int]:
    share = render.resolution_percentage / 100
    return max(int(render.resolution_x * share), 1), max(int(render.resolution_y * share), 1)


def border(render) -> list[int]:
    """The region that is rendered: x and y from the upper left, width and height, as Blender rounds them."""
    width, height = size(render)
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    return [left, height - top, max(right - left, 1), max(top - bottom, 1)]


def _placed(matrix: np.ndarray) -> dict[str, Any]:
    """Blender's cameras look along −z, y is up; their scale means nothing."""
    eye = matrix[:3, 3]
    axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
    table = {"origin": _list(eye), "target": _list(eye - axes[:, 2]), "up": _list(axes[:, 1])}
    if np.linalg.det(axes) < 0:
        table["mirrored"] = True
    return table


@dataclass
class _Window:
    """What the picture shows of the plane at distance 1 (or, without perspective, of any): sides, and where its middle lies."""

    width: float
    height: float
    x: float
    y: float

    @classmethod
    def of(cls, camera, scene) -> _Window:
        corners = np.array([corner[:] for corner in camera.view_frame(scene=scene)], float)
        if camera.type != "ORTHO":
            corners = corners / -corners[:, 2:]
        low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
        return cls(*(high - low), *((high + low) / 2))


def _film(window: _Window, width: int, height: int, render, warnings: Warnings) -> dict[str, Any]:
    """The picture, or the part of a larger one about the axis: a shifted lens shows a part that is not in the middle."""
    film: dict[str, Any] = {}
    crop = border(render) if render.use_border else [0, 0, width, height]
    whole, first = [], []
    for k, (middle, side, pixels) in enumerate([(window.x, window.width, width), (-window.y, window.height, height)]):
        # In half pixels, for the larger picture has a whole number of them.
        halves = round(2 * middle / side * pixels)
        if abs(2 * middle / side * pixels - halves) > 0.02:
            warnings.add("the camera's shift is rounded to half a pixel")
        whole.append(pixels + abs(halves))
        first.append(max(halves, 0) + crop[k])
    film |= {"width": whole[0], "height": whole[1]}
    if [*first, *crop[2:]] != [0, 0, *whole]:
        film["crop"] = [*first, *crop[2:]]
    return film


def _lens(camera_object, matrix: np.ndarray, table: dict[str, Any], warnings: Warnings) -> None:
    camera = camera_object.data
    dof = camera.dof
    if not dof.use_dof:
        return
    if dof.aperture_blades >= 3 or dof.aperture_ratio != 1:
        warnings.add("the camera's aperture is a circle; blades and ratio are left out")
    distance = dof.focus_distance
    if dof.focus_object is not None:
        place = np.array(dof.focus_object.matrix_world)[:3, 3]
        if dof.focus_subtarget:
            warnings.add("the camera focuses on the origin of an object, not on its bone")
        distance = abs(float((place - matrix[:3, 3]) @ (matrix[:3, 2] / np.linalg.norm(matrix[:3, 2]))))
    table["aperture_radius"] = camera.lens * 1e-3 / (2 * max(dof.aperture_fstop, 1e-5))
    table["focus_distance"] = max(distance, 1e-5)


def _panorama(camera, table: dict[str, Any], warnings: Warnings) -> None:
    # The settings were Cycles' own before Blender 5.
    settings = camera if hasattr(camera, "panorama_type") else getattr(camera, "cycles", None)
    kind = getattr(settings, "panorama_type", "EQUIRECTANGULAR")
    if kind != "EQUIRECTANGULAR":
        warnings.add(f"a panorama of kind '{kind.lower()}' is taken for one by longitude and latitude")
    names = ("longitude_min", "longitude_max", "latitude_min", "latitude_max")
    whole = (-math.pi, math.pi, -math.pi / 2, math.pi / 2)
    if any(abs(getattr(settings, n, w) - w) > 1e-4 for n, w in zip(names, whole)):
        warnings.add("a panorama shows all directions; its range is left out")
    table["projection"] = "panorama"


def _list(values) -> list[float]:
    return [float(v) for v in values]
