"""The render engine: the picture is the program's, and passes, cancel and errors arrive."""

import os
import subprocess
import unittest
import unittest.mock

import bpy
import numpy as np
from support import FOLDER, blender_picture, cube, empty_scene, exported, grey, light, material, quad, render

from phototaxis import exr, passes, preferences
from phototaxis.program import Progress, Run


def still_life(size: int = 32):
    scene = empty_scene(size, background=0.2)
    quad(4.0, grey(0.6), "ground", location=(0, 0, -0.5))
    cube(0.8, material("paint", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.2, 0.1, 1)), "box", rotation_euler=(0.3, 0.4, 0))
    light("AREA", 20.0, (1, 0.5, 2), (0.4, 0.3, 0), size=0.5)
    return scene


def write_all_layers(scene) -> None:
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
        settings.use_exr_interleave = True
    settings.file_format, settings.exr_codec = "OPEN_EXR_MULTILAYER", "ZIP"


def compositor(scene, kind: str):
    """A node whose matte becomes the picture."""
    if hasattr(scene, "compositing_node_group"):
        tree = scene.compositing_node_group = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        output = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("CompositorNodeComposite")
    made = tree.nodes.new(kind)
    tree.links.new(made.outputs["Matte"], output.inputs[0])
    return made


def murmur3_of(name: str) -> int:
    """As the program itself has it, in the key of the layer's metadata."""
    still_life(8)
    picture = by_hand("hash", "--layers", "cryptomatte", "--spp", "1")
    keys = [k.split("/")[1] for k, v in picture.attributes.items() if k.startswith("cryptomatte/") and v == name.encode()]
    digits = f"{passes.murmur3(name.encode()):08x}"
    return int(keys[0] + digits[7:], 16)


def channel(picture, prefix: str, name: str) -> str:
    """Blender writes the channels of some passes in small letters."""
    return next(n for n in (prefix + name, prefix + name.lower()) if n in picture.channels)


def by_hand(name: str, *more: str):
    """The program's picture of what is exported."""
    path, _ = exported(name)
    picture = FOLDER / f"{name}.exr"
    subprocess.run([preferences.program(), "render", path, "-o", picture, "-q", *more], check=True)
    return exr.read(picture)


class Engine(unittest.TestCase):
    def test_the_picture_is_that_of_the_command_line(self):
        scene = still_life()
        scene.phototaxis.spp, scene.phototaxis.seed = 16, 3
        ours = render("PHOTOTAXIS", seed=3, samples=16)
        np.testing.assert_array_equal(ours, by_hand("still").layer("R", "G", "B", "A"))

    def test_passes(self):
        scene = still_life()
        layer = bpy.context.view_layer
        for name in ("z", "normal", "position", "diffuse_color", "emit", "cryptomatte_object", "cryptomatte_material"):
            setattr(layer, f"use_pass_{name}", True)
        layer.pass_cryptomatte_depth = 4
        layer.phototaxis.use_pass_direct = layer.phototaxis.use_pass_indirect = layer.phototaxis.use_pass_variance = True
        layer.phototaxis.use_pass_samples = True
        scene.phototaxis.spp, scene.render.engine = 8, "PHOTOTAXIS"
        write_all_layers(scene)
        scene.render.filepath = str(FOLDER / "passes.exr")
        bpy.ops.render.render(write_still=True)
        found = exr.read(FOLDER / "passes.exr")
        hand = by_hand("passes", "--layers", "P,emission,direct,indirect,cryptomatte")
        for each in passes.wanted(layer, False):
            with self.subTest(each=each.name):
                theirs = found.layer(*(channel(found, f"{layer.name}.{each.name}.", i) for i in each.ids))
                np.testing.assert_array_equal(theirs, hand.layer(*each.channels))
        names = {name.rsplit("/", 1)[1] for name in found.attributes if name.startswith("cryptomatte/")}
        self.assertLessEqual({"name", "hash", "conversion", "manifest"}, names)
        self.assertIn(b"box", b"".join(v for n, v in found.attributes.items() if n.endswith("/manifest")))

    def test_mattes_by_name(self):
        """Blender's own node finds what the program has named."""
        scene = still_life()
        bpy.context.view_layer.use_pass_cryptomatte_object = True
        scene.phototaxis.spp, scene.render.engine = 16, "PHOTOTAXIS"
        scene.render.film_transparent, scene.world = True, None
        bpy.data.objects.remove(bpy.data.objects["ground"])
        matte = compositor(scene, "CompositorNodeCryptomatteV2")
        matte.source, matte.layer_name, matte.matte_id = "RENDER", f"{bpy.context.view_layer.name}.CryptoObject", "box"
        scene.render.filepath = str(FOLDER / "matte.exr")
        bpy.ops.render.render(write_still=True)
        found = blender_picture(FOLDER / "matte.exr")[:, :, 0]
        self.assertEqual((found.min(), found.max()), (0.0, 1.0))
        np.testing.assert_allclose(found, by_hand("matte").channels["A"], atol=0.01)

    def test_hashes(self):
        # Of the specification of Cryptomatte and of MurmurHash3 itself.
        for text, value in (
            (b"", 0),
            (b"hello", 0x248BFA47),
            (b"hello, world", 0x149BBB7F),
            (b"CryptoObject", murmur3_of("CryptoObject")),
        ):
            self.assertEqual(passes.murmur3(text), value)

    def test_what_is_seen_of_position_and_depth_is_blenders_world(self):
        scene = still_life()
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 1.0
        bpy.data.objects.remove(bpy.data.objects["box"])
        hand = by_hand("flat", "--layers", "P")
        np.testing.assert_allclose(hand.channels["P.Z"], -0.5, atol=1e-5)
        np.testing.assert_allclose(hand.channels["Z"], 3.5, atol=1e-5)
        np.testing.assert_allclose(hand.channels["Ns.Z"], 1, atol=1e-5)

    def test_errors_of_the_program_are_shown(self):
        scene = empty_scene()
        scene.render.engine = "PHOTOTAXIS"
        with self.assertRaisesRegex(RuntimeError, "the scene has no triangles"):
            bpy.ops.render.render()
        bpy.context.scene.camera = still_life().camera
        before = os.environ["PHOTOTAXIS"]
        os.environ["PHOTOTAXIS"] = "/nowhere/phototaxis"
        try:
            bpy.context.scene.render.engine = "PHOTOTAXIS"
            with self.assertRaisesRegex(RuntimeError, "preferences"):
                bpy.ops.render.render()
        finally:
            os.environ["PHOTOTAXIS"] = before

    def test_a_cancel_ends_after_the_pass_with_the_picture_so_far(self):
        still_life()
        bpy.context.scene.phototaxis.spp = 10_000_000
        path, _ = exported("long")
        run = Run([str(preferences.program()), "render", str(path), "-o", str(FOLDER / "long.exr"), "--progress", "json"])
        heard = []
        while (said := run.heard(0.1)) is not None:
            if isinstance(said, Progress):
                heard.append(said)
                if said.samples:
                    run.stop()
        self.assertEqual(run.code, 130)
        self.assertGreater(exr.read(FOLDER / "long.exr").channels["samples.Y"].min(), 0)
        self.assertEqual({p.stage for p in heard} - {"loading", "textures", "building", "rendering", "writing"}, set())

    def test_a_cancel_of_blenders_keeps_the_picture(self):
        scene = still_life()
        scene.phototaxis.spp, scene.render.engine = 10_000_000, "PHOTOTAXIS"
        asked: list[int] = []
        scene.render.filepath = str(FOLDER / "cancelled.exr")
        with unittest.mock.patch("phototaxis.engine._Render.is_cancelled", lambda _: asked.append(1) or len(asked) > 20):
            bpy.ops.render.render(write_still=True)
        self.assertGreater(blender_picture(FOLDER / "cancelled.exr")[:, :, :3].min(), 0)

    def test_the_picture_grows_while_it_renders(self):
        scene = still_life()
        scene.phototaxis.spp, scene.phototaxis.every, scene.render.engine = 10_000_000, 1, "PHOTOTAXIS"
        scene.render.filepath = str(FOLDER / "grown.exr")
        shown: list[float] = []

        def fill(layer, picture, wanted):
            shown.append(float(picture.channels["samples.Y"].min()))
            passes_fill(layer, picture, wanted)

        passes_fill = passes.fill
        with unittest.mock.patch("phototaxis.passes.fill", fill):
            with unittest.mock.patch("phototaxis.engine._Render.is_cancelled", lambda _: len(shown) >= 2):
                bpy.ops.render.render(write_still=True)
        self.assertGreaterEqual(len(shown), 3)
        self.assertGreater(shown[0], 0)
        self.assertLess(shown[0], shown[-1])
        self.assertGreater(blender_picture(FOLDER / "grown.exr")[:, :, :3].min(), 0)

    def test_the_film_is_opaque_or_transparent(self):
        scene = still_life()
        bpy.data.objects.remove(bpy.data.objects["ground"])
        scene.world = None
        for transparent, least in ((False, 1.0), (True, 0.0)):
            scene.render.film_transparent = transparent
            ours, theirs = (render(e, samples=32)[:, :, 3] for e in ("PHOTOTAXIS", "CYCLES"))
            with self.subTest(transparent=transparent):
                self.assertEqual((theirs.min(), theirs.max()), (least, 1.0))
                self.assertEqual((ours.min(), ours.max()), (least, 1.0))
                self.assertLess(abs(ours.mean() - theirs.mean()), 0.01)

    def test_without_lights_it_is_dark(self):
        scene = still_life()
        scene.world = None
        bpy.data.objects.remove(bpy.data.objects["area"])
        self.assertEqual(render("PHOTOTAXIS", samples=4)[:, :, :3].max(), 0)

    def test_light_groups_are_passes(self):
        scene = still_life()
        layer = bpy.context.view_layer
        for name in ("lamp", "around"):
            layer.lightgroups.add(name=name)
        bpy.data.objects["area"].lightgroup, scene.world.lightgroup = "lamp", "around"
        scene.phototaxis.spp, scene.render.engine = 8, "PHOTOTAXIS"
        write_all_layers(scene)
        scene.render.filepath = str(FOLDER / "groups.exr")
        bpy.ops.render.render(write_still=True)
        found = exr.read(FOLDER / "groups.exr").channels
        parts = [found[f"{layer.name}.Combined_{name}.G"].astype(float) for name in ("lamp", "around")]
        self.assertGreater(min(part.mean() for part in parts), 0)
        whole = found[f"{layer.name}.Combined.G"].astype(float)
        self.assertLess(abs(sum(part.mean() for part in parts) / whole.mean() - 1), 0.02)

    def test_settings_of_all_methods_are_understood(self):
        scene = still_life(8)
        for method in ("auto", "adaptive", "grid", "voronoi", "sdtree", "none"):
            for sampling in ("q-cos", "product", "q"):
                scene.phototaxis.method, scene.phototaxis.sampling = method, sampling
                scene.phototaxis.filter, scene.phototaxis.roulette = "gaussian", "throughput"
                with self.subTest(method=method, sampling=sampling):
                    self.assertGreater(by_hand("method", "--spp", "2").channels["R"].mean(), 0)

    def test_view_layers_have_their_own_objects(self):
        scene = still_life()
        other = scene.view_layers.new("other")
        collection = bpy.data.collections.new("apart")
        scene.collection.children.link(collection)
        box = bpy.data.objects["box"]
        scene.collection.objects.unlink(box)
        collection.objects.link(box)
        other.layer_collection.children["apart"].exclude = True
        scene.phototaxis.spp, scene.render.engine = 4, "PHOTOTAXIS"
        write_all_layers(scene)
        scene.render.filepath = str(FOLDER / "layers.exr")
        bpy.ops.render.render(write_still=True)
        found = exr.read(FOLDER / "layers.exr").channels
        first, second = (found[f"{name}.Combined.G"].astype(float) for name in (scene.view_layers[0].name, "other"))
        self.assertGreater(abs(first - second).max(), 0.05)
        self.assertGreater(second.min(), 0)


class Files(unittest.TestCase):
    def test_exr_there_and_back(self):
        for shape in ((3, 5, 1), (7, 2, 3), (20, 33, 4)):
            pixels = np.random.default_rng(1).normal(size=shape).astype(np.float32)
            (FOLDER / "back.exr").write_bytes(exr.encoded(pixels))
            names = {1: "Y", 3: "RGB", 4: "RGBA"}[shape[2]]
            np.testing.assert_array_equal(exr.read(FOLDER / "back.exr").layer(*names), pixels)

    def test_faulty_pictures_are_errors(self):
        (FOLDER / "fault.exr").write_bytes(exr.encoded(np.ones((9, 9, 3), np.float32)))
        whole = (FOLDER / "fault.exr").read_bytes()
        for size in range(0, len(whole), 37):
            (FOLDER / "cut.exr").write_bytes(whole[:size])
            with self.assertRaises(ValueError):
                exr.read(FOLDER / "cut.exr")
