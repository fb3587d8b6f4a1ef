"""Makes the pictures of docs/blender.md, with a Python that has Blender as a module.

PHOTOTAXIS=path/of/phototaxis python pictures.py
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parents[1]
sys.path.insert(0, str(HERE))
FOLDER = Path(tempfile.mkdtemp(prefix="phototaxis-pictures-"))


def render(engine: str, name: str, samples: int) -> np.ndarray:
    """A picture as the screen shows it, rows from the bottom."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.phototaxis.spp = engine, samples, samples
    scene.cycles.device, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = "CPU", False, False
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = scene.cycles.transmission_bounces = 15
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(FOLDER / f"{name}.png")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


def save(pixels: np.ndarray, path: Path) -> None:
    image = bpy.data.images.new(path.stem, pixels.shape[1], pixels.shape[0])
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).reshape(-1))
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()


def door() -> None:
    """The project's own scene, imported, by Cycles on the left and by Phototaxis on the right."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.phototaxis(filepath=str(PROJECT / "scenes/door.toml"))
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 224, 126
    halves = [render(engine, f"door-{engine}", 128) for engine in ("CYCLES", "PHOTOTAXIS")]
    save(np.concatenate(halves, axis=1), PROJECT / "docs/blender-door.png")


def shade(name: str, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def still_life() -> None:
    """A subdivided head, balls that share a mesh, a textured floor, a lamp and a sky."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 400, 225
    floor = shade("floor", Roughness=0.6)
    checks = bpy.data.images.new("checks", 256, 256)
    bright = (np.add.outer(np.arange(256) // 16, np.arange(256) // 16) % 2)[:, :, None]
    colors = np.concatenate([bright * [0.45, 0.42, 0.4] + 0.2, np.ones((256, 256, 1))], axis=2)
    checks.pixels.foreach_set(colors.astype(np.float32).reshape(-1))
    texture = floor.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = checks
    floor.node_tree.links.new(texture.outputs["Color"], floor.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    bpy.ops.mesh.primitive_plane_add(size=24)
    bpy.context.object.data.materials.append(floor)
    bpy.ops.mesh.primitive_monkey_add(size=2, location=(0, 0, 0.85), rotation=(-0.55, 0, 0.35))
    head = bpy.context.object
    head.modifiers.new("smooth", "SUBSURF").render_levels = 2
    bpy.ops.object.shade_smooth()
    head.data.materials.append(shade("gold", Base_Color=(1.0, 0.62, 0.25, 1), Metallic=1.0, Roughness=0.25))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.5, location=(1.9, -0.5, 0.5))
    glass = bpy.context.object
    bpy.ops.object.shade_smooth()
    glass.data.materials.append(shade("glass", Base_Color=(1, 1, 1, 1), Transmission_Weight=1.0, Roughness=0.0, IOR=1.5))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.22, location=(0, 0, -5))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(shade("paint", Base_Color=(0.1, 0.3, 0.55, 1), Roughness=0.2))
    for k in range(9):
        other = ball.copy()
        other.location = (-2.6 + 0.62 * k, -1.6 - 0.25 * math.sin(1.7 * k), 0.22)
        scene.collection.objects.link(other)
    bpy.data.objects.remove(ball)
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
    lamp.data.energy, lamp.data.size, lamp.data.color = 500, 1.5, (1, 0.85, 0.7)
    lamp.location, lamp.rotation_euler = (3.5, -2.5, 4.5), (0.75, 0.0, 0.95)
    scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.35, 0.5, 0.75, 1)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.6
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler, camera.data.lens = (0.6, -6.4, 2.5), (1.25, 0, 0.08), 42
    camera.data.dof.use_dof, camera.data.dof.aperture_fstop, camera.data.dof.focus_object = True, 1.4, head
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.view_settings.view_transform = "AgX"
    save(render("PHOTOTAXIS", "still-life", 256), PROJECT / "docs/blender-still-life.png")
    if "--cycles" in sys.argv:
        save(render("CYCLES", "still-life-cycles", 256), FOLDER / "still-life-by-cycles.png")
        print(FOLDER / "still-life-by-cycles.png")


if __name__ == "__main__":
    import phototaxis

    phototaxis.register()
    for make in (still_life, door):
        if make.__name__ in sys.argv or not {"door", "still_life"} & set(sys.argv):
            make()
    sys.stdout.flush()
    os._exit(0)
