"""The package that `make blender-addon` makes: Blender takes it, installs it, and renders with it."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import bpy

PACK = Path(__file__).resolve().parents[1] / "pack.py"
INSTALL = """
import bpy, os, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
bpy.context.preferences.addons["bl_ext.user_default.phototaxis"].preferences.program = sys.argv[2]
scene = bpy.context.scene
scene.render.engine = "PHOTOTAXIS"
bpy.ops.mesh.primitive_plane_add()
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
scene.camera, camera.location = camera, (0, 0, 5)
scene.render.resolution_x = scene.render.resolution_y = 8
scene.render.filepath = sys.argv[3]
bpy.ops.render.render(write_still=True)
sys.stdout.flush()
os._exit(0)
"""


class Package(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="phototaxis-package-"))
        self.package = self.folder / "phototaxis.zip"
        subprocess.run([sys.executable, PACK, self.package], check=True, stdout=subprocess.DEVNULL)

    def test_blenders_own_check(self):
        check = next(Path(p) for p in Path(bpy.utils.resource_path("LOCAL")).rglob("blender_ext.py"))
        done = subprocess.run([sys.executable, check, "validate", self.package], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_it_is_installed_and_renders(self):
        picture = self.folder / "picture.png"
        command = [sys.executable, "-c", INSTALL, str(self.package), os.environ["PHOTOTAXIS"], str(picture)]
        # Nothing of the user's own Blender is read or written.
        environment = os.environ | {"BLENDER_USER_RESOURCES": str(self.folder / "resources"), "PHOTOTAXIS": ""}
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        self.assertTrue(picture.is_file(), done.stdout + done.stderr)
