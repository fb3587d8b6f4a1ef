"""Where things are in the picture: Blender's cameras and ours show the same."""

import unittest

import bpy
import numpy as np
from support import cube, empty_scene, exported, material, render, warnings


def lit_things():
    """Emissive cubes here and there, without any symmetry."""
    places = [(-0.6, 0.3, 0), (0.4, 0.5, 0.2), (0.5, -0.4, 0.5), (-0.2, -0.6, -0.5)]
    for k, place in enumerate(places):
        shade = material(f"glow {k}", "ShaderNodeEmission", Color=(0.2 + 0.2 * k, 1 - 0.2 * k, 0.5, 1), Strength=1.0)
        cube(0.45, shade, f"cube {k}", location=place, rotation_euler=(0.3 * k, 0.2, 0.1))


class Cameras(unittest.TestCase):
    def setUp(self):
        self.scene = empty_scene(32, background=0.05)
        self.scene.render.resolution_y = 24
        lit_things()
        self.camera = self.scene.camera
        self.camera.location, self.camera.rotation_euler = (0.4, -0.7, 2.8), (0.25, 0.15, 0.5)

    def same(self, tolerance=0.02):
        """Light only goes from emitters to the camera: blocks of 4 × 4 pixels differ by how edges are sampled alone."""
        ours, theirs = render("PHOTOTAXIS", samples=256), render("CYCLES", samples=256)
        self.assertEqual(ours.shape, theirs.shape)
        h, w = (n // 4 * 4 for n in ours.shape[:2])
        a, b = (p[:h, :w, :3].reshape(h // 4, 4, w // 4, 4, 3).mean(axis=(1, 3)) for p in (ours, theirs))
        self.assertGreater(np.ptp(b), 0.1)
        self.assertLess(np.abs(a - b).max(), tolerance)

    def test_perspective_by_sensor_and_shape_of_the_picture(self):
        for fit in ("AUTO", "HORIZONTAL", "VERTICAL"):
            for size in ((32, 24), (24, 32)):
                with self.subTest(fit=fit, size=size):
                    self.scene.render.resolution_x, self.scene.render.resolution_y = size
                    self.camera.data.sensor_fit, self.camera.data.lens = fit, 40
                    self.camera.data.sensor_height = 20
                    self.same()

    def test_a_wrong_angle_is_noticed(self):
        self.camera.data.lens = 40
        ours = render("PHOTOTAXIS", samples=16)
        self.camera.data.lens = 44
        self.assertGreater(np.abs(render("CYCLES", samples=16) - ours)[:, :, :3].max(), 0.1)

    def test_percentage(self):
        self.scene.render.resolution_percentage = 150
        self.same()

    def test_shift(self):
        self.camera.data.shift_x, self.camera.data.shift_y = 0.125, -0.25
        self.assertEqual(warnings(), [])
        self.same()

    def test_a_region(self):
        render_settings = self.scene.render
        render_settings.use_border = True
        render_settings.border_min_x, render_settings.border_max_x = 0.25, 0.875
        render_settings.border_min_y, render_settings.border_max_y = 0.125, 0.75
        self.camera.data.shift_x = 0.125
        for crop in (True, False):
            render_settings.use_crop_to_border = crop
            with self.subTest(crop=crop):
                self.same()

    def test_orthographic(self):
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 2.3
        self.camera.data.shift_y = 0.0625
        self.same()

    def test_panorama(self):
        self.camera.data.type = "PANO"
        (
            self.camera.data if hasattr(self.camera.data, "panorama_type") else self.camera.data.cycles
        ).panorama_type = "EQUIRECTANGULAR"
        self.scene.render.resolution_x, self.scene.render.resolution_y = 32, 16
        self.camera.location = (0, 0, 0.1)
        self.same()

    def test_depth_of_field(self):
        dof = self.camera.data.dof
        dof.use_dof, dof.aperture_fstop, dof.focus_distance = True, 0.1, 1.5
        self.same()
        target = bpy.data.objects.new("focus", None)
        self.scene.collection.objects.link(target)
        target.location = (0.5, -0.4, 0.5)
        dof.focus_object = target
        self.same()

    def test_a_scaled_and_mirrored_parent(self):
        for scale in ((2, 2, 2), (-1, 1, 1)):
            with self.subTest(scale=scale):
                self.camera.scale = scale
                self.same()

    def test_without_a_camera_nothing_is_written(self):
        self.scene.camera = None
        with self.assertRaisesRegex(RuntimeError, "no camera"):
            exported("none")


if __name__ == "__main__":
    unittest.main()
