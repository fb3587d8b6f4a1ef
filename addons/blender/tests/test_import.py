"""Scenes that are imported and rendered look as they do when the program renders them itself."""

import subprocess
import unittest
from pathlib import Path

import bpy
import numpy as np
from support import FOLDER, different, empty_scene, exported, picture_file, several, steps

from phototaxis import exr, ply, preferences

SCENES = Path(__file__).resolve().parents[3] / "scenes"
RUNS = 6


def by_hand(path: Path, size: tuple[int, int], samples: int, *more: str) -> np.ndarray:
    """The program's pictures of a scene by different seeds."""
    pictures = []
    for seed in range(1, RUNS + 1):
        command = [preferences.program(), "render", path, "--seed", str(seed), "--spp", str(samples), "--guide", "none", "-q"]
        command += ["--size", f"{size[0]}x{size[1]}", "-o", FOLDER / "hand.exr", *more]
        subprocess.run([str(c) for c in command], check=True)
        pictures.append(exr.read(FOLDER / "hand.exr").layer("R", "G", "B").astype(float))
    return np.stack(pictures)


def imported(path: Path):
    """The scene alone in Blender."""
    scene = empty_scene(8)
    bpy.data.objects.remove(scene.camera)
    bpy.ops.import_scene.phototaxis(filepath=str(path))
    scene.phototaxis.method = "none"
    return scene


def square(path: Path, uvs: bool = True) -> None:
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    colors = np.random.default_rng(2).uniform(0.1, 0.9, (4, 3))
    ply.write(
        path, ply.Triangles(corners, np.array([[0, 1, 2], [0, 2, 3]]), None, corners[:, :2] / 2 + 0.5 if uvs else None, colors)
    )


def scene_file(name: str, text: str) -> Path:
    path = FOLDER / f"{name}.toml"
    path.write_text(text)
    return path


HEAD = """
[camera]
origin = [0.2, 0.4, 5]
target = [0.1, 0, 0]
vfov = 35
[[mesh]]
path = "square.ply"
material = "ground"
rotate = { axis = [1, 0, 0], angle = -90 }
scale = 2
translate = [0, -1, 0]
[[mesh]]
path = "square.ply"
material = "shown"
rotate = { axis = [0, 1, 0], angle = 25 }
[material.ground]
type = "diffuse"
reflectance = [0.6, 0.5, 0.4]
"""
POINT = """
[[light]]
type = "point"
position = [1, 2, 3]
intensity = [20, 18, 15]
[[light]]
type = "constant"
radiance = [0.2, 0.3, 0.4]
"""


class Import(unittest.TestCase):
    def same(self, path: Path, size=(32, 24), samples: int = 64, extra: tuple[str, ...] = ()):
        theirs = by_hand(path, size, samples, *extra)
        scene = imported(path)
        scene.render.resolution_x, scene.render.resolution_y = size
        back, _ = exported("back")
        ours = by_hand(back, size, samples)
        self.assertGreater(theirs.mean(), 0)
        self.assertIsNone(different(theirs, ours))
        return back

    def test_the_projects_own_scene(self):
        self.same(SCENES / "cornell.toml", (32, 32))

    def test_cycles_renders_what_is_imported_alike(self):
        imported(SCENES / "cornell.toml")
        scene = bpy.context.scene
        scene.render.resolution_x = scene.render.resolution_y = 32
        self.assertIsNone(different(by_hand(SCENES / "cornell.toml", (32, 32), 64), several("CYCLES", RUNS, 64)))

    def test_a_changed_scene_is_noticed(self):
        theirs = by_hand(SCENES / "cornell.toml", (32, 32), 64)
        imported(SCENES / "cornell.toml")
        for shade in bpy.data.materials:
            for node in shade.node_tree.nodes:
                if node.type == "EMISSION":
                    node.inputs["Strength"].default_value *= 1.03
        self.assertIsNotNone(different(theirs, by_hand(exported("changed")[0], (32, 32), 64)))

    def test_materials(self):
        square(FOLDER / "square.ply")
        picture_file("steps", steps())
        picture_file("numbers", steps(3), "Non-Color")
        texture = 'texture = "steps.png"'
        cases = {
            "diffuse": f'type = "diffuse"\nreflectance = {{ {texture}, scale = [2, 1], offset = [0.25, 0], tint = [1, 0.5, 0.25], nearest = true }}',
            "one-sided": 'type = "diffuse"\ntwo_sided = false\nreflectance = 0.5\nemission = [1, 2, 0.5]',
            "two-sided": 'type = "diffuse"\nreflectance = 0.0\nemission = [1, 2, 0.5]\nemission_two_sided = true',
            "glowing": f'type = "diffuse"\nreflectance = 0.3\nemission = {{ {texture}, tint = [3, 2, 1] }}',
            "vertices": 'type = "diffuse"\nreflectance = { vertex_color = true, tint = 0.9 }',
            "leaf": 'type = "diffuse_transmitter"\nreflectance = [0.3, 0.4, 0.1]\ntransmittance = [0.2, 0.5, 0.1]',
            "cut": 'type = "diffuse"\nreflectance = 0.7\nopacity = { texture = "numbers.png", channel = "luminance" }',
            "cut red": 'type = "diffuse"\nreflectance = 0.7\nopacity = { texture = "numbers.png", channel = "red" }',
            "mirror": 'type = "mirror"\nspecular_reflectance = [0.9, 0.8, 0.5]',
            "gloss": 'type = "conductor"\nalpha = 0.3\nspecular_reflectance = [0.9, 0.8, 0.5]',
            "glass": 'type = "dielectric"\nalpha = 0.2\nspecular_transmittance = [0.9, 0.8, 0.5]',
            "pane": 'type = "dielectric"\nthin = true',
            "plastic": 'type = "plastic"\nenergy_conserving = true\nalpha = 0.2\nreflectance = [0.1, 0.3, 0.6]\nint_ior = 1.6',
            "metal": 'type = "principled"\nmetallic = 1.0\nroughness = 0.6\nenergy_conserving = true\nbase_color = [0.9, 0.6, 0.2]',
            "mapped": 'type = "principled"\nmetallic = 0.5\nroughness = { texture = "numbers.png" }\nenergy_conserving = true\nclearcoat = 0.5',
            "relief": 'type = "diffuse"\nnormal_map = { texture = "numbers.png", strength = 0.5 }',
            "bumps": 'type = "diffuse"\nbump_map = { texture = "numbers.png", height = 0.05 }',
        }
        if hasattr(bpy.types, "ShaderNodeBsdfMetallic"):
            cases["gold"] = 'type = "conductor"\neta = [0.143, 0.375, 1.442]\nk = [3.983, 2.386, 1.603]\nalpha = 0.3'
            cases["dim gold"] = cases["gold"] + "\nspecular_reflectance = 0.6"
        for name, text in cases.items():
            with self.subTest(name=name):
                self.same(scene_file("material", f"{HEAD}{POINT}\n[material.shown]\n{text}\n"), samples=32)

    def test_plastics_of_mitsuba_are_as_bright(self):
        """They have no exact counterpart; what is compared is the whole picture."""
        square(FOLDER / "square.ply")
        picture_file("steps", steps())
        for reflectance in ("[0.2, 0.5, 0.8]", '{ texture = "steps.png" }'):
            for nonlinear in ("false", "true"):
                text = f'type = "plastic"\nalpha = 0.1\nreflectance = {reflectance}\nnonlinear = {nonlinear}'
                path = scene_file("plastic", f"{HEAD}{POINT}\n[material.shown]\n{text}\n")
                theirs = by_hand(path, (32, 24), 64)
                scene = imported(path)
                scene.render.resolution_x, scene.render.resolution_y = 32, 24
                ours = by_hand(exported("plastic back")[0], (32, 24), 64)
                with self.subTest(reflectance=reflectance, nonlinear=nonlinear):
                    ratio = ours.mean(axis=(0, 1, 2)) / theirs.mean(axis=(0, 1, 2))
                    self.assertLess(np.abs(ratio - 1).max(), 0.04, f"{ratio}")

    def test_lights(self):
        square(FOLDER / "square.ply")
        pixels = np.ones((64, 128, 3), np.float32) * np.linspace(0.2, 2, 128)[None, :, None]
        pixels[:, :, 1] *= np.linspace(1, 0.1, 64)[:, None]
        (FOLDER / "around.exr").write_bytes(exr.encoded(pixels))
        cases = [
            'type = "point"\nposition = [1, 2, 3]\nintensity = [20, 10, 5]',
            'type = "directional"\ndirection = [-1, -2, -2]\nirradiance = [2, 3, 1]',
            'type = "sun"\ndirection = [-1, -2, -2]\nirradiance = [2, 3, 1]\nangular_diameter = 10',
            'type = "spot"\nposition = [1, 2, 3]\ndirection = [-1, -2, -3]\nintensity = 20\ncutoff_angle = 15\nbeam_angle = 15',
            'type = "environment"\npath = "around.exr"\nrotate_y = 40\nscale = [1, 2, 0.5]',
            'type = "sky"\nsun_direction = [1, 1, 1]\nscale = 0.1',
        ]
        shown = '[material.shown]\ntype = "diffuse"\nreflectance = [0.3, 0.5, 0.8]\n'
        for text in cases:
            with self.subTest(text=text):
                self.same(scene_file("lights", f"{HEAD}{shown}[[light]]\n{text}\n"), samples=32)

    def test_cameras(self):
        square(FOLDER / "square.ply")
        shown = '[material.shown]\ntype = "diffuse"\nreflectance = [0.3, 0.5, 0.8]\nemission = [0.2, 0.1, 0.5]\n'
        body = HEAD[HEAD.index("[[mesh]]") :] + shown + POINT
        for text in (
            "up = [0.3, 1, 0.1]\nvfov = 50\naperture_radius = 0.2\nfocus_distance = 4",
            'projection = "orthographic"\nview_height = 3',
            'projection = "panorama"',
            "vfov = 30\nmirrored = true",
        ):
            with self.subTest(text=text):
                self.same(scene_file("camera", f"[camera]\norigin = [1, 0.4, 5]\ntarget = [0.1, 0, 0]\n{text}\n{body}"), samples=32)

    def test_instances_and_a_part_of_the_picture(self):
        square(FOLDER / "square.ply")
        instances = "".join(
            f'[[instance]]\ngroup = "{g}"\nscale = [{0.3 + 0.1 * k}, 0.5, -1]\nrotate = {{ axis = [1, {k}, 0], angle = {40 * k} }}\n'
            f"translate = [{k - 1}, {0.3 + n}, {0.3 * k}]\n"
            for n, g in enumerate(("one", "two"))
            for k in range(3)
        )
        groups = (
            '[[mesh]]\npath = "square.ply"\ngroup = "one"\nmaterial = "shown"\n[[mesh]]\npath = "square.ply"\ngroup = "two"\n'
            'material = "ground"\n[[mesh]]\npath = "square.ply"\ngroup = "two"\nmaterial = "shown"\ntranslate = [0, 0, 0.5]\n'
        )
        shown = '[material.shown]\ntype = "diffuse"\nreflectance = [0.3, 0.5, 0.8]\n'
        text = f"[film]\nwidth = 48\nheight = 40\ncrop = [8, 4, 32, 24]\n{HEAD}{shown}{groups}{instances}{POINT}"
        path = scene_file("instances", text)
        back = self.same_as_it_is(path)
        self.assertEqual(back.read_text().count("[[instance]]"), 9)

    def same_as_it_is(self, path: Path) -> Path:
        """At the size that the scene itself has."""
        theirs = by_hand(path, (48, 40), 64)
        scene = imported(path)
        self.assertEqual((scene.render.resolution_x, scene.render.resolution_y), (48, 40))
        back, _ = exported("back")
        self.assertIsNone(different(theirs, by_hand(back, (48, 40), 64)))
        return back

    def test_nori(self):
        (FOLDER / "nori.obj").write_text("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n")
        mesh = '<mesh type="obj"><string name="filename" value="nori.obj"/>{}</mesh>'
        place = '<transform name="toWorld">{}</transform>'
        parts = [
            '<integrator type="path_mis"/>',
            '<camera type="perspective"><float name="fov" value="40"/><integer name="width" value="32"/><integer name="height" value="24"/>'
            + place.format('<lookat origin="0.3, 1, 6" target="0, 0.2, 0" up="0, 1, 0"/>')
            + "</camera>",
            mesh.format(
                '<bsdf type="diffuse"><color name="albedo" value="0.6, 0.4, 0.2"/></bsdf>'
                + place.format('<rotate axis="1, 0, 0" angle="-90"/><scale value="3, 1, 3"/><translate value="0, -1, 0"/>')
            ),
            mesh.format('<bsdf type="diffuse"/>' + place.format('<rotate axis="0, 1, 0" angle="30"/>')),
            mesh.format(
                '<emitter type="area"><color name="radiance" value="9, 8, 6"/></emitter>'
                + place.format('<rotate axis="1, 0, 0" angle="90"/><scale value="0.5, 1, 0.5"/><translate value="0.5, 2, 1"/>')
            ),
        ]
        path = FOLDER / "nori.xml"
        path.write_text(f"<scene>{''.join(parts)}</scene>")
        self.same(path)
        self.assertEqual((bpy.context.scene.render.resolution_x, bpy.context.scene.camera.name[:6]), (32, "camera"))

    def test_faults_are_said(self):
        empty_scene()
        with self.assertRaisesRegex(RuntimeError, "unknown|nothing"):
            bpy.ops.import_scene.phototaxis(filepath=str(scene_file("fault", "[camera]\nnothing = 1\n")))
        with self.assertRaisesRegex(RuntimeError, "Phototaxis"):
            bpy.ops.import_scene.phototaxis(filepath=str(FOLDER / "missing.toml"))

    def test_normals_and_axes_arrive(self):
        normals = np.array([[0, 0, 1], [0.6, 0, 0.8], [0, 0.6, 0.8]], float)
        ply.write(
            FOLDER / "one.ply", ply.Triangles(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float), np.array([[0, 1, 2]]), normals)
        )
        text = '[camera]\norigin = [0, 0, 3]\ntarget = [0, 0, 0]\n[[mesh]]\npath = "one.ply"\n[[light]]\ntype = "constant"\nradiance = 1\n'
        imported(scene_file("one", text))
        made = next(o for o in bpy.data.objects if o.type == "MESH")
        found = np.empty(9, np.float32)
        made.data.corner_normals.foreach_get("vector", found)
        # Blender keeps normals of its own in 16 bits.
        np.testing.assert_allclose(found.reshape(3, 3), normals, atol=1e-3)
        np.testing.assert_allclose(np.array(made.matrix_world)[:3, :3] @ [0, 1, 0], [0, 0, 1], atol=1e-6)
        bpy.ops.import_scene.phototaxis(filepath=str(exported("z up")[0]))
