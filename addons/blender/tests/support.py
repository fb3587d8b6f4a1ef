"""Small scenes in Blender, pictures of them by Cycles and by Phototaxis, and how alike these are."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import bpy
import numpy as np

FOLDER = Path(tempfile.mkdtemp(prefix="phototaxis-blender-tests-"))
#: Rounding, and where Cycles lifts rays off surfaces: differences that are no more than this share mean nothing.
ROUNDING = 0.002
#: How often a comparison of pictures that are alike fails.
FALSE_ALARM = 1e-5


def empty_scene(size: int = 32, background: float = 0.0):
    """A scene of a camera at (0, 0, 3) that looks down, and a grey world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.pixel_filter_type = "CPU", 64, "BOX"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_indirect = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.blur_glossy = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 15
    world(background)
    camera = add(bpy.data.cameras.new("camera"), location=(0, 0, 3))
    scene.camera = camera
    return scene


def add(data, **place):
    """An object of some data in the scene."""
    made = bpy.data.objects.new(data.name, data)
    bpy.context.scene.collection.objects.link(made)
    for key, value in place.items():
        setattr(made, key, value)
    return made


def world(strength: float):
    made = bpy.data.worlds.new("world")
    made.use_nodes = True
    background = made.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = strength
    # Cycles otherwise takes seconds to find out where the world is bright.
    made.cycles.sampling_method, made.cycles.sample_map_resolution = "MANUAL", 64
    bpy.context.scene.world = made
    return made


def light(kind: str, energy: float, location=(0, 0, 4), rotation=(0, 0, 0), **more):
    made = bpy.data.lights.new(kind.lower(), kind)
    made.energy = energy
    for key, value in more.items():
        setattr(made, key, value)
    return add(made, location=location, rotation_euler=rotation)


def mesh(name: str, vertices, faces, material=None, **place):
    made = bpy.data.meshes.new(name)
    made.from_pydata([tuple(v) for v in vertices], [], faces)
    if material is not None:
        made.materials.append(material)
    return add(made, **place)


def quad(size: float = 2.0, material=None, name: str = "quad", **place):
    """A square about the origin that faces up, with texture coordinates."""
    h = size / 2
    made = mesh(name, [(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2, 3)], material, **place)
    layer = made.data.uv_layers.new(name="UVMap")
    layer.uv.foreach_set("vector", np.array([0, 0, 1, 0, 1, 1, 0, 1], np.float32))
    return made


def cube(size: float = 1.0, material=None, name: str = "cube", **place):
    h = size / 2
    corners = [(x, y, z) for x in (-h, h) for y in (-h, h) for z in (-h, h)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh(name, corners, faces, material, **place)


def material(name: str, node_type: str, **inputs):
    """A material of one shader; its inputs by their names with underscores."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new(node_type), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    shader.name = "shader"
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def grey(value: float):
    return material(f"grey {value}", "ShaderNodeBsdfDiffuse", Color=(value, value, value, 1))


def node(of, kind: str, **settings):
    """A node more in the material or world `of`."""
    made = of.node_tree.nodes.new(kind)
    for key, value in settings.items():
        setattr(made, key, value)
    return made


def link(of, output, to):
    of.node_tree.links.new(output, to)


def picture_file(name: str, pixels: np.ndarray, space: str = "sRGB"):
    """A picture in a PNG file, of rows from the bottom of stored red, green, blue and alpha."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=True)
    image.colorspace_settings.name = space
    image.pixels.foreach_set(pixels.astype(np.float32).reshape(-1))
    image.filepath_raw = str(FOLDER / f"{name}.png")
    image.file_format = "PNG"
    image.save()
    bpy.data.images.remove(image)
    loaded = bpy.data.images.load(str(FOLDER / f"{name}.png"))
    loaded.colorspace_settings.name = space
    return loaded


def steps(seed: int = 1, size: int = 4) -> np.ndarray:
    """A picture of a few squares of even colours."""
    small = np.random.default_rng(seed).integers(40, 240, (size, size, 4)) / 255
    small[:, :, 3] = 1
    return np.kron(small, np.ones((16, 16, 1)))


def render(engine: str, seed: int = 0, samples: int = 64) -> np.ndarray:
    """Rows from the top of red, green, blue and alpha."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.cycles.samples = scene.phototaxis.spp = samples
    scene.cycles.seed = scene.phototaxis.seed = seed
    scene.render.filepath = str(FOLDER / "rendered.exr")
    bpy.ops.render.render(write_still=True)
    return blender_picture(FOLDER / "rendered.exr")


def blender_picture(path: Path) -> np.ndarray:
    image = bpy.data.images.load(str(path))
    try:
        image.colorspace_settings.name = "Linear Rec.709"
        flat = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
        image.pixels.foreach_get(flat)
        return flat.reshape(image.size[1], image.size[0], image.channels)[::-1].astype(float)
    finally:
        bpy.data.images.remove(image)


def several(engine: str, runs: int = 6, samples: int = 64) -> np.ndarray:
    """Pictures with different seeds: runs, rows, columns, colours."""
    return np.stack([render(engine, seed, samples)[:, :, :3] for seed in range(1, runs + 1)])


def blocks(pictures: np.ndarray, side: int) -> np.ndarray:
    """Means of blocks, and of the whole: runs, and then all blocks and colours."""
    runs, height, width, colors = pictures.shape
    cut = pictures.reshape(runs, height // side, side, width // side, side, colors)
    return np.concatenate([cut.mean(axis=(2, 4)).reshape(runs, -1), pictures.mean(axis=(1, 2))], axis=1)


def t_limit(freedom: np.ndarray, tail: float) -> np.ndarray:
    """What Student's t exceeds, on either side, with probability `tail`."""
    angle = np.linspace(0, math.pi / 2, 20001)[:-1]
    tangent = np.tan(angle)
    limits = {}
    for n in np.unique(np.round(freedom, 1)):
        # With x = √n tan(a) the density is cos(a)^(n − 1), which is summed from the far end.
        density = np.cos(angle) ** (n - 1)
        beyond = np.cumsum(density[::-1])[::-1] / density.sum()
        limits[n] = math.sqrt(n) * tangent[min(np.searchsorted(-beyond, -tail), len(tangent) - 1)]
    return np.array([limits[n] for n in np.round(freedom, 1)])


def different(a: np.ndarray, b: np.ndarray, side: int = 8) -> str | None:
    """How two sets of pictures differ by Welch's t-test of all blocks, at one false alarm in 1/FALSE_ALARM; else nothing."""
    x, y = blocks(a, side), blocks(b, side)
    gap = np.abs(x.mean(axis=0) - y.mean(axis=0))
    variances = [part.var(axis=0, ddof=1) / len(part) for part in (x, y)]
    total = np.maximum(sum(variances), 1e-30)
    freedom = total**2 / np.maximum(sum(v**2 / (len(p) - 1) for v, p in zip(variances, (x, y))), 1e-60)
    limit = t_limit(np.clip(freedom, 1, 200), FALSE_ALARM / gap.size) * np.sqrt(total)
    excess = gap - limit - ROUNDING * np.abs(x.mean(axis=0))
    if excess.max() <= 0:
        return None
    k = int(excess.argmax())
    return f"{(excess > 0).sum()} of {gap.size} blocks differ, block {k}: {x.mean(axis=0)[k]:.5g} and {y.mean(axis=0)[k]:.5g}, noise {np.sqrt(total[k]):.2g}; means {x.mean():.5g} and {y.mean():.5g}"


def compare(test, runs: int = 6, samples: int = 64, side: int = 8) -> None:
    """Holds Phototaxis against Cycles in the present scene."""
    ours, theirs = several("PHOTOTAXIS", runs, samples), several("CYCLES", runs, samples)
    test.assertGreater(theirs.mean(), 0, "the picture is black")
    test.assertIsNone(different(theirs, ours, side))


def warnings() -> list[str]:
    """What an export of the present scene warns of."""
    from phototaxis.export import export

    return list(export(bpy.context.evaluated_depsgraph_get(), FOLDER / "warned.toml").warnings)


def exported(name: str = "exported") -> tuple[Path, dict]:
    """The present scene's file, and what it says."""
    import tomllib

    path = FOLDER / f"{name}.toml"
    bpy.ops.export_scene.phototaxis(filepath=str(path))
    return path, tomllib.loads(path.read_text())
