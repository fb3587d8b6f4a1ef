"""Materials: what scatters light evenly agrees with Cycles block by block, other things on the whole."""

import unittest

import bpy
import numpy as np
from support import (
    compare,
    cube,
    different,
    empty_scene,
    exported,
    grey,
    light,
    link,
    material,
    node,
    picture_file,
    quad,
    render,
    several,
    steps,
    warnings,
    world,
)

PRINCIPLED = "ShaderNodeBsdfPrincipled"


def shown(shade, size: int = 32, tilt: float = 0.0):
    """A square of a material that fills the picture, under a lamp and an even sky."""
    scene = empty_scene(size, background=0.3)
    made = quad(4.0, shade() if callable(shade) else shade, rotation_euler=(tilt, 0, 0))
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 2.0
    light("POINT", 100.0, (1, 0.5, 3), shadow_soft_size=0)
    return made


def table() -> dict:
    """The only material that the export writes, but for lamps."""
    found = [m for name, m in exported("table")[1]["material"].items() if not name.startswith("light ")]
    assert len(found) == 1, found
    return found[0]


class Diffuse(unittest.TestCase):
    def test_a_colour(self):
        shown(lambda: material("red", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.3, 0.1, 1)))
        compare(self)

    def test_a_difference_of_three_percent_is_noticed(self):
        shown(lambda: grey(0.6))
        theirs = several("CYCLES")
        bpy.data.lights["point"].energy *= 1.03
        bpy.data.worlds["world"].node_tree.nodes["Background"].inputs["Strength"].default_value *= 1.03
        self.assertIsNotNone(different(theirs, several("PHOTOTAXIS")))

    def test_without_nodes_and_without_a_material(self):
        shown(lambda: bpy.data.materials.new("plain"))
        # Blender 5 has no materials without nodes.
        if not bpy.data.materials["plain"].use_nodes:
            bpy.data.materials["plain"].diffuse_color = (0.2, 0.5, 0.7, 1)
            compare(self, runs=3)
        bpy.data.meshes["quad"].materials.clear()
        ours, theirs = (render(engine)[:, :, :3].mean() for engine in ("PHOTOTAXIS", "CYCLES"))
        self.assertAlmostEqual(ours / theirs, 1, delta=0.02)

    def textured(self, space: str, **mapping):
        def shade():
            made = material("textured", "ShaderNodeBsdfDiffuse")
            picture = node(
                made, "ShaderNodeTexImage", image=picture_file(f"steps {space}", steps(), space), interpolation="Closest"
            )
            link(made, picture.outputs["Color"], made.node_tree.nodes["shader"].inputs["Color"])
            if mapping:
                move, coordinates = node(made, "ShaderNodeMapping", vector_type=mapping["kind"]), node(made, "ShaderNodeTexCoord")
                move.inputs["Scale"].default_value, move.inputs["Location"].default_value = (2, 0.5, 1), (0.25, 0.125, 0)
                link(made, coordinates.outputs["UV"], move.inputs["Vector"])
                link(made, move.outputs["Vector"], picture.inputs["Vector"])
            return made

        shown(shade)

    def test_a_picture_in_srgb_is_used_where_it_is(self):
        self.textured("sRGB")
        self.assertTrue(table()["reflectance"]["texture"].endswith("steps sRGB.png"))
        compare(self)

    def test_a_picture_of_numbers_as_a_colour(self):
        self.textured("Non-Color")
        self.assertTrue(table()["reflectance"]["texture"].endswith(".exr"))
        compare(self)

    def test_a_moved_picture(self):
        for kind in ("POINT", "TEXTURE"):
            with self.subTest(kind=kind):
                self.textured("sRGB", kind=kind)
                compare(self, runs=3)

    def test_a_packed_picture_is_written_out(self):
        self.textured("sRGB")
        bpy.data.images[0].pack()
        self.assertIn("files/", table()["reflectance"]["texture"])
        compare(self, runs=3)

    def test_nodes_that_change_a_picture(self):
        self.textured("sRGB")
        made = bpy.data.materials["textured"]
        picture, shader = made.node_tree.nodes["Image Texture"], made.node_tree.nodes["shader"]
        hue = node(made, "ShaderNodeHueSaturation")
        hue.inputs["Hue"].default_value, hue.inputs["Saturation"].default_value = 0.7, 0.6
        mix = node(made, "ShaderNodeMix", data_type="RGBA", blend_type="SCREEN")
        mix.inputs[0].default_value, mix.inputs[7].default_value = 0.4, (0.2, 0.4, 0.1, 1)
        gamma = node(made, "ShaderNodeGamma")
        gamma.inputs["Gamma"].default_value = 1.5
        link(made, picture.outputs["Color"], hue.inputs["Color"])
        link(made, hue.outputs["Color"], mix.inputs[6])
        link(made, mix.outputs[2], gamma.inputs["Color"])
        link(made, gamma.outputs["Color"], shader.inputs["Color"])
        self.assertEqual(warnings(), [])
        compare(self)

    def test_a_factor_keeps_the_file(self):
        self.textured("sRGB")
        made = bpy.data.materials["textured"]
        mix = node(made, "ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
        mix.inputs[0].default_value, mix.inputs[7].default_value = 1.0, (0.5, 0.25, 1, 1)
        link(made, made.node_tree.nodes["Image Texture"].outputs["Color"], mix.inputs[6])
        link(made, mix.outputs[2], made.node_tree.nodes["shader"].inputs["Color"])
        self.assertEqual(table()["reflectance"]["tint"], [0.5, 0.25, 1.0])
        compare(self, runs=3)

    def test_groups_reroutes_and_muted_nodes(self):
        made = shown(lambda: material("grouped", "ShaderNodeBsdfDiffuse")).data.materials[0]
        tree = bpy.data.node_groups.new("group", "ShaderNodeTree")
        tree.interface.new_socket("in", in_out="INPUT", socket_type="NodeSocketColor")
        tree.interface.new_socket("out", in_out="OUTPUT", socket_type="NodeSocketColor")
        begin, end, invert = (tree.nodes.new(k) for k in ("NodeGroupInput", "NodeGroupOutput", "ShaderNodeInvert"))
        tree.links.new(begin.outputs[0], invert.inputs["Color"])
        tree.links.new(invert.outputs[0], end.inputs[0])
        group, reroute, muted = node(made, "ShaderNodeGroup"), node(made, "NodeReroute"), node(made, "ShaderNodeGamma", mute=True)
        group.node_tree, muted.inputs["Gamma"].default_value = tree, 5.0
        group.inputs[0].default_value = (0.9, 0.5, 0.2, 1)
        link(made, group.outputs[0], reroute.inputs[0])
        link(made, reroute.outputs[0], muted.inputs["Color"])
        link(made, muted.outputs[0], made.node_tree.nodes["shader"].inputs["Color"])
        np.testing.assert_allclose(table()["reflectance"], [0.1, 0.5, 0.8], atol=1e-6)
        compare(self, runs=3)

    def test_colours_of_vertices(self):
        made = shown(lambda: material("vertices", "ShaderNodeBsdfDiffuse"))
        for domain, kind in (("CORNER", "BYTE_COLOR"), ("POINT", "FLOAT_COLOR")):
            colors = made.data.color_attributes.new(f"Col {kind}", kind, domain)
            values = np.random.default_rng(5).uniform(0.1, 0.9, (4, 4)).astype(np.float32)
            colors.data.foreach_set("color", values.reshape(-1))
            shade = made.data.materials[0]
            attribute = node(shade, "ShaderNodeVertexColor", layer_name=f"Col {kind}")
            link(shade, attribute.outputs["Color"], shade.node_tree.nodes["shader"].inputs["Color"])
            with self.subTest(domain=domain):
                compare(self, runs=3)


class Mixtures(unittest.TestCase):
    def mixed(self, first: str, second: str, share: float):
        """Of two shaders, over a white ground that is seen where the first square lets light pass."""

        def shade():
            made = material("mixture", "ShaderNodeMixShader")
            nodes = [node(made, kind) for kind in (first, second)]
            mix = made.node_tree.nodes["shader"]
            mix.inputs[0].default_value = share
            for k, each in enumerate(nodes):
                link(made, each.outputs[0], mix.inputs[k + 1])
                each.inputs["Color"].default_value = (
                    [(0.7, 0.4, 0.2, 1), (0.1, 0.5, 0.6, 1)][k] if "Transparent" not in each.bl_idname else (1, 1, 1, 1)
                )
            return made

        shown(shade).location = (0, 0, 0.3)
        quad(4.0, grey(0.9), "ground")

    def test_mixtures_that_a_scene_file_can_say(self):
        diffuse, translucent, transparent, glow = (
            f"ShaderNode{n}" for n in ("BsdfDiffuse", "BsdfTranslucent", "BsdfTransparent", "Emission")
        )
        for first, second in (
            (diffuse, diffuse),
            (diffuse, translucent),
            (transparent, diffuse),
            (diffuse, transparent),
            (diffuse, glow),
            (glow, transparent),
        ):
            with self.subTest(first=first, second=second):
                self.mixed(first, second, 0.3)
                self.assertEqual(warnings(), [])
                compare(self, runs=3)

    def test_others_are_said(self):
        self.mixed("ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlass", 0.3)
        self.assertIn("a mixture of 'diffuse' and 'dielectric' has no counterpart", " ".join(warnings()))

    def test_a_picture_cuts_out(self):
        pixels = steps()
        pixels[:, :, 3] = np.kron(np.random.default_rng(3).integers(0, 2, (4, 4)), np.ones((16, 16)))

        def shade():
            made = material("leaf", PRINCIPLED, Base_Color=(0.7, 0.2, 0.1, 1), Specular_IOR_Level=0.0)
            picture = node(made, "ShaderNodeTexImage", image=picture_file("leaf", pixels), interpolation="Closest")
            link(made, picture.outputs["Alpha"], made.node_tree.nodes["shader"].inputs["Alpha"])
            return made

        shown(shade).location = (0, 0, 0.3)
        quad(4.0, grey(0.9), "ground")
        self.assertEqual(table_of("leaf")["opacity"]["channel"], "alpha")
        compare(self)


def table_of(name: str) -> dict:
    return exported("table")[1]["material"][name]


class Principled(unittest.TestCase):
    def close(self, share: float, tilt: float = 0.5):
        ours, theirs = (render(e, samples=256)[:, :, :3].mean(axis=(0, 1)) for e in ("PHOTOTAXIS", "CYCLES"))
        self.assertGreater(theirs.min(), 0)
        self.assertLess(np.abs(ours / theirs - 1).max(), share, f"{ours} {theirs}")

    def shown(self, tilt=0.5, **inputs):
        shown(lambda: material("principled", PRINCIPLED, **inputs), tilt=tilt)

    def test_a_diffuse_base(self):
        self.shown(Base_Color=(0.6, 0.3, 0.1, 1), Specular_IOR_Level=0.0)
        compare(self)

    def test_a_dielectric(self):
        for roughness, ior, level in ((0.5, 1.45, 0.5), (0.2, 1.45, 0.5), (0.9, 1.45, 0.5), (0.5, 2.0, 0.5), (0.5, 1.45, 1.0)):
            self.shown(Base_Color=(0.6, 0.3, 0.1, 1), Roughness=roughness, IOR=ior, Specular_IOR_Level=level)
            with self.subTest(roughness=roughness, ior=ior, level=level):
                self.close(0.04)

    def test_a_metal(self):
        for roughness in (0.2, 0.5, 0.9):
            self.shown(Base_Color=(0.9, 0.6, 0.3, 1), Roughness=roughness, Metallic=1.0)
            with self.subTest(roughness=roughness):
                self.close(0.05)

    def test_metallic_and_roughness_of_a_picture(self):
        for name, space in (("Metallic", "Non-Color"), ("Roughness", "Non-Color"), ("Roughness", "sRGB")):

            def shade():
                made = material("mapped", PRINCIPLED, Base_Color=(0.8, 0.5, 0.3, 1), Roughness=0.4)
                picture = node(made, "ShaderNodeTexImage", image=picture_file(f"numbers {space}", steps(2), space))
                link(made, picture.outputs["Color"], made.node_tree.nodes["shader"].inputs[name])
                return made

            shown(shade, tilt=0.5)
            with self.subTest(name=name, space=space):
                self.close(0.08)

    def test_emission(self):
        self.shown(Base_Color=(0, 0, 0, 1), Specular_IOR_Level=0.0, Emission_Color=(1, 0.5, 0.2, 1), Emission_Strength=3.0)
        compare(self, runs=3)

    def test_what_has_no_counterpart_is_said(self):
        self.shown(Subsurface_Weight=0.5, Sheen_Weight=0.5, Transmission_Weight=0.2, Coat_Weight=1.0)
        said = " ".join(warnings())
        for word in ("subsurface scattering", "sheen", "transmission of 0.2", "a coat reflects at most a quarter"):
            self.assertIn(word, said)


class Others(unittest.TestCase):
    def test_glossy_and_glass(self):
        cases = [
            ("ShaderNodeBsdfAnisotropic", dict(Color=(0.8, 0.6, 0.3, 1), Roughness=0.5), 0.03),
            ("ShaderNodeBsdfAnisotropic", dict(Color=(0.8, 0.6, 0.3, 1), Roughness=0.0), 0.01),
            ("ShaderNodeBsdfGlass", dict(Color=(0.9, 0.7, 0.5, 1), Roughness=0.0, IOR=1.5), 0.02),
            ("ShaderNodeBsdfGlass", dict(Color=(0.9, 0.7, 0.5, 1), Roughness=0.3, IOR=1.3), 0.05),
            (PRINCIPLED, dict(Base_Color=(0.9, 0.7, 0.5, 1), Roughness=0.0, IOR=1.5, Transmission_Weight=1.0), 0.02),
        ]
        for kind, inputs, share in cases:
            scene = empty_scene(16, background=0.5)
            cube(1.0, material("glass", kind, **inputs), rotation_euler=(0.3, 0.5, 0.2))
            quad(
                20.0, material("ground", "ShaderNodeEmission", Color=(0.2, 0.5, 1, 1), Strength=1.0), "ground", location=(0, 0, -2)
            )
            scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.8
            with self.subTest(kind=kind, inputs=inputs):
                ours, theirs = (render(e, samples=512)[:, :, :3].mean(axis=(0, 1)) for e in ("PHOTOTAXIS", "CYCLES"))
                self.assertLess(np.abs(ours / theirs - 1).max(), share, f"{ours} {theirs}")

    def test_metals_of_indices(self):
        if not hasattr(bpy.types, "ShaderNodeBsdfMetallic"):
            self.skipTest("Blender has no Metallic BSDF before 4.3")
        shown(lambda: material("gold", "ShaderNodeBsdfMetallic", Roughness=0.4), tilt=0.5)
        shader = bpy.data.materials["gold"].node_tree.nodes["shader"]
        shader.fresnel_type = "PHYSICAL_CONDUCTOR"
        shader.inputs["IOR"].default_value, shader.inputs["Extinction"].default_value = (0.2, 0.4, 1.4), (4, 2.4, 1.6)
        ours, theirs = (render(e, samples=256)[:, :, :3].mean(axis=(0, 1)) for e in ("PHOTOTAXIS", "CYCLES"))
        self.assertLess(np.abs(ours / theirs - 1).max(), 0.03, f"{ours} {theirs}")

    def test_mixtures_by_fresnel(self):
        for first, roughness in (
            ("ShaderNodeBsdfDiffuse", 0.0),
            ("ShaderNodeBsdfDiffuse", 0.4),
            ("ShaderNodeBsdfTransparent", 0.0),
        ):
            for by, name, value in (("ShaderNodeFresnel", "IOR", 1.6), ("ShaderNodeLayerWeight", "Blend", 0.4)):

                def shade():
                    made = material("coated", "ShaderNodeMixShader")
                    base, gloss, fresnel = (node(made, kind) for kind in (first, "ShaderNodeBsdfAnisotropic", by))
                    gloss.inputs["Roughness"].default_value, fresnel.inputs[name].default_value = roughness, value
                    mix = made.node_tree.nodes["shader"]
                    link(made, fresnel.outputs[0], mix.inputs[0])
                    link(made, base.outputs[0], mix.inputs[1])
                    link(made, gloss.outputs[0], mix.inputs[2])
                    return made

                shown(shade, tilt=0.5)
                with self.subTest(first=first, roughness=roughness, by=by):
                    self.assertEqual(warnings(), [])
                    ours, theirs = (render(e, samples=256)[:, :, :3].mean() for e in ("PHOTOTAXIS", "CYCLES"))
                    self.assertLess(abs(ours / theirs - 1), 0.05)

    def test_a_map_of_normals(self):
        pixels = np.zeros((64, 64, 4))
        small = np.random.default_rng(4).uniform(-0.4, 0.4, (4, 4, 2))
        normals = np.concatenate([small, np.sqrt(1 - (small**2).sum(axis=2, keepdims=True))], axis=2)
        pixels[:, :, :3] = np.kron(normals / 2 + 0.5, np.ones((16, 16, 1)))
        pixels[:, :, 3] = 1

        def shade():
            made = material("relief", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7, 1))
            picture = node(made, "ShaderNodeTexImage", image=picture_file("normals", pixels, "Non-Color"), interpolation="Closest")
            relief = node(made, "ShaderNodeNormalMap")
            link(made, picture.outputs["Color"], relief.inputs["Color"])
            link(made, relief.outputs["Normal"], made.node_tree.nodes["shader"].inputs["Normal"])
            return made

        shown(shade)
        world(0.0)
        ours, theirs = (render(e, samples=64)[:, :, :3] for e in ("PHOTOTAXIS", "CYCLES"))
        a, b = (p.reshape(8, 4, 8, 4, 3).mean(axis=(1, 3)) for p in (ours, theirs))
        self.assertGreater(np.ptp(b) / b.mean(), 0.2)
        self.assertLess(np.abs(a / b - 1).max(), 0.03)

    def test_unknown_nodes_are_said(self):
        made = shown(lambda: material("noisy", "ShaderNodeBsdfDiffuse")).data.materials[0]
        noise = node(made, "ShaderNodeTexNoise")
        link(made, noise.outputs["Color"], made.node_tree.nodes["shader"].inputs["Color"])
        self.assertIn(
            "material 'noisy': node 'Noise Texture' (Noise Texture) has no counterpart; half counts in its place", warnings()
        )
