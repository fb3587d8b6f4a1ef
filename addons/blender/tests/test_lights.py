"""Units: what a watt, a sun's strength and radiance bring, by Cycles and by Phototaxis; closed forms where there are some."""

import math
import unittest

import bpy
import numpy as np
from support import FOLDER, empty_scene, grey, light, link, material, node, quad, render, warnings, world

from phototaxis import exr


class Units(unittest.TestCase):
    def setUp(self):
        self.scene = empty_scene(16)
        self.scene.camera.data.type, self.scene.camera.data.ortho_scale = "ORTHO", 0.5
        self.scene.camera.location = (0, 0, 1)
        quad(2000, grey(0.8))

    def means(self, samples=256):
        return [render(engine, samples=samples)[:, :, :3].mean() for engine in ("PHOTOTAXIS", "CYCLES")]

    def same(self, share=0.01, samples=256):
        ours, theirs = self.means(samples)
        self.assertGreater(theirs, 0)
        self.assertLess(abs(ours / theirs - 1), share)
        return ours

    def test_a_point_of_one_watt(self):
        light("POINT", 1.0, (0, 0, 4), shadow_soft_size=0)
        found = self.same()
        self.assertAlmostEqual(found / (0.8 / math.pi / (4 * math.pi * 16)), 1, delta=0.01)

    def test_a_point_with_a_radius(self):
        made = light("POINT", 100.0, (1, 0.5, 4), shadow_soft_size=0.5)
        # Cycles can make a disk of it that faces what it lights.
        made.data.use_soft_falloff = False
        self.same()

    def test_colours_and_nodes_of_lights(self):
        made = light("POINT", 100.0, (1, 0.5, 4), shadow_soft_size=0)
        made.data.color, made.data.use_nodes = (1, 0.5, 0.25), True
        made.data.node_tree.nodes["Emission"].inputs["Strength"].default_value = 3.0
        ours, theirs = (render(e, samples=16)[:, :, :3].mean(axis=(0, 1)) for e in ("PHOTOTAXIS", "CYCLES"))
        np.testing.assert_allclose(ours, theirs, rtol=0.01)

    def test_areas_of_all_shapes(self):
        shapes = [
            ("SQUARE", (1, 1, 1)),
            ("RECTANGLE", (1, 1, 1)),
            ("DISK", (1, 1, 1)),
            ("ELLIPSE", (2, 0.5, 1)),
            ("SQUARE", (-1, 2, 1)),
        ]
        made = light("AREA", 10.0, (0.5, 0, 3), (0.2, 0.3, 0.4), size=1.5)
        made.data.size_y = 0.7
        for shape, scale in shapes:
            made.data.shape, made.scale = shape, scale
            with self.subTest(shape=shape, scale=scale):
                self.same()

    def test_an_area_light_is_dark_behind(self):
        light("AREA", 10.0, (0, 0, 3), (math.pi, 0, 0), size=1.0)
        self.assertEqual(self.means(16), [0.0, 0.0])

    def test_spots(self):
        for blend, share in ((0.0, 0.01), (0.5, 0.01), (1.0, 0.01)):
            for made in [o for o in bpy.data.objects if o.type == "LIGHT"]:
                bpy.data.objects.remove(made)
            # The whole of the beam is in the picture, so that power is compared.
            light("SPOT", 10.0, (0, 0, 0.3), spot_size=0.8, spot_blend=blend, shadow_soft_size=0)
            with self.subTest(blend=blend):
                self.same(share)

    def test_suns(self):
        made = light("SUN", 2.0, (0, 0, 5), (0.4, 0.2, 0))
        for angle in (0.0, 0.2):
            made.data.angle = angle
            with self.subTest(angle=angle):
                self.same()

    def test_an_emissive_plane_shines_to_both_sides(self):
        shade = material("glow", "ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=5.0)
        for turn in (0.0, math.pi):
            made = quad(1.0, shade, "lamp", location=(0, 0, 2), rotation_euler=(turn, 0.2, 0))
            with self.subTest(turn=turn):
                self.same()
            bpy.data.objects.remove(made)

    def test_what_has_no_counterpart_is_said(self):
        light("SPOT", 1.0, shadow_soft_size=0.5, spot_blend=0.3)
        light("AREA", 1.0, (0, 0, 0.9), (3.0, 0, 0), spread=1.0, size=0.1)
        said = " ".join(warnings())
        for word in ("its shadows are sharp", "blurred edge", "spread is left out", "the camera sees it"):
            self.assertIn(word, said)
        bpy.data.objects["area"].location = (5, 0, 0.9)
        self.assertNotIn("the camera sees it", " ".join(warnings()))


class Worlds(unittest.TestCase):
    def test_a_grey_world(self):
        empty_scene(16, background=0.7)
        quad(2, grey(0.5))
        ours, theirs = (render(e, samples=64)[:, :, :3].mean() for e in ("PHOTOTAXIS", "CYCLES"))
        self.assertAlmostEqual(ours / theirs, 1, delta=0.01)

    def test_pictures_around_turned_and_brightened(self):
        scene = empty_scene(32)
        # A scene has a triangle at least.
        quad(0.01, grey(0.5), location=(0, 0, -5))
        # Rows are many: the first and last are the poles themselves here, and half a row from them in Blender.
        pixels = np.zeros((256, 512, 3), np.float32)
        pixels[:, :, 0] = np.linspace(0.1, 1, 512)
        pixels[:, :, 1] = np.linspace(2, 0.1, 256)[:, None]
        pixels[64:128, 96:192, 2] = 1
        (FOLDER / "around.exr").write_bytes(exr.encoded(pixels))
        around = world(1.0)
        picture = node(around, "ShaderNodeTexEnvironment", image=bpy.data.images.load(str(FOLDER / "around.exr")))
        mapping, coordinates = node(around, "ShaderNodeMapping"), node(around, "ShaderNodeTexCoord")
        mapping.inputs["Rotation"].default_value = (0.3, 0.2, 1.1)
        link(around, coordinates.outputs["Generated"], mapping.inputs["Vector"])
        link(around, mapping.outputs["Vector"], picture.inputs["Vector"])
        background = around.node_tree.nodes["Background"]
        background.inputs["Strength"].default_value = 1.5
        link(around, picture.outputs["Color"], background.inputs["Color"])
        scene.camera.data.lens = 15
        for vector_type in ("POINT", "TEXTURE"):
            mapping.vector_type = vector_type
            for rotation in ((0, 0, 0), (1.2, 0.3, 0.7), (2.0, 0, 2.5)):
                scene.camera.rotation_euler = rotation
                with self.subTest(vector_type=vector_type, rotation=rotation):
                    ours, theirs = (render(e, samples=64)[:, :, :3] for e in ("PHOTOTAXIS", "CYCLES"))
                    a, b = (p.reshape(8, 4, 8, 4, 3).mean(axis=(1, 3)) for p in (ours, theirs))
                    self.assertGreater(np.ptp(b), 0.3)
                    self.assertLess(np.abs(a - b).max(), 0.04)

    def test_skies(self):
        scene = empty_scene(8)
        ground = quad(2, grey(0.8))
        # Below the horizon the skies differ.
        quad(20000, grey(0.0), "horizon", location=(0, 0, -2))
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.5
        around = world(2.0)
        sky = node(around, "ShaderNodeTexSky")
        link(around, sky.outputs[0], around.node_tree.nodes["Background"].inputs["Color"])
        names = [item.identifier for item in sky.bl_rna.properties["sky_type"].enum_items]
        for kind, turns, share in (("HOSEK_WILKIE", (-0.9, 0.9), 0.05), ("PREETHAM", (-0.9, 0.9), 0.4), ("NISHITA", (0.9,), 0.25)):
            # Where the sun stands shows in what leans to the east gets, beside what leans to the west.
            for turn in turns if kind in names else ():
                sky.sky_type, sky.sun_direction, ground.rotation_euler = kind, (0.5, 0.2, 0.6), (0, turn, 0)
                if kind == "NISHITA":
                    sky.sun_elevation, sky.sun_rotation = 0.8, 1.0
                with self.subTest(kind=kind, turn=turn):
                    ours, theirs = (render(e, samples=128)[:, :, :3].mean() for e in ("PHOTOTAXIS", "CYCLES"))
                    self.assertGreater(theirs, 0)
                    self.assertLess(abs(ours / theirs - 1), share)
