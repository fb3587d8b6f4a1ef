"""Meshes: modifiers, instances, normals, several materials."""

import unittest

import bpy
from support import (
    FOLDER,
    add,
    compare,
    cube,
    empty_scene,
    exported,
    grey,
    light,
    link,
    material,
    mesh,
    node,
    picture_file,
    quad,
    render,
    steps,
    warnings,
)

from phototaxis import ply


def lit(size: int = 32):
    scene = empty_scene(size, background=0.4)
    light("POINT", 100.0, (1.5, 1, 3), shadow_soft_size=0)
    scene.camera.data.lens = 40
    quad(30.0, grey(0.6), "ground", location=(0, 0, -1))
    return scene


def sphere(name: str, shade, **place):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.6)
    made = bpy.context.object
    made.name = name
    made.data.materials.append(shade)
    for key, value in place.items():
        setattr(made, key, value)
    return made


def triangles_of(path, table: dict) -> ply.Triangles:
    return ply.read(path.parent / table["path"])


class Geometry(unittest.TestCase):
    def test_modifiers_are_applied_as_in_renders(self):
        lit()
        made = cube(1.0, grey(0.7), "box", rotation_euler=(0.3, 0.4, 0))
        smooth = made.modifiers.new("smooth", "SUBSURF")
        smooth.levels, smooth.render_levels = 0, 2
        array = made.modifiers.new("array", "ARRAY")
        array.count = 2
        hidden = made.modifiers.new("hidden", "DECIMATE")
        hidden.show_render = False
        path, found = exported()
        box = next(m for m in found["mesh"] if "box" in m["path"])
        self.assertEqual(len(triangles_of(path, box).triangles), 2 * 2 * 6 * 16)
        compare(self)

    def test_the_viewport_has_its_own_levels(self):
        lit()
        made = cube(1.0, grey(0.7), "box")
        smooth = made.modifiers.new("smooth", "SUBSURF")
        smooth.levels, smooth.render_levels = 1, 2
        path = FOLDER / "shown.toml"
        bpy.ops.export_scene.phototaxis(filepath=str(path), objects="VIEWPORT")
        self.assertEqual(len(ply.read(FOLDER / "shown files" / "box.ply").triangles), 2 * 6 * 4)

    def test_smooth_flat_and_sharp_edges(self):
        lit()
        sphere("smooth", grey(0.7), location=(-0.6, 0, 0))
        bpy.ops.object.shade_smooth()
        sphere("flat", grey(0.7), location=(0.6, 0, 0))
        bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.4, depth=0.4, location=(0, 0.7, 0.2))
        made = bpy.context.object
        made.name = "sharp"
        made.data.materials.append(grey(0.7))
        for face in made.data.polygons:
            face.use_smooth = len(face.vertices) == 4
        sharp = made.data.attributes.new("sharp_edge", "BOOLEAN", "EDGE")
        sharp.data.foreach_set("value", [True] * len(made.data.edges))
        path, found = exported()
        by_name = {m["path"].split("/")[-1]: triangles_of(path, m) for m in found["mesh"]}
        self.assertIsNone(by_name["flat.ply"].normals)
        self.assertEqual(len(by_name["flat.ply"].positions), 16 * 7 + 2)
        self.assertIsNotNone(by_name["smooth.ply"].normals)
        compare(self)

    def test_instances_share_a_mesh(self):
        lit()
        leaf = sphere("leaf", grey(0.5), location=(0, 0, -50))
        other = add(leaf.data, location=(0.7, 0.3, 0), scale=(0.5, 1, -0.7), rotation_euler=(0.3, 0.2, 0.1))
        other.name = "other"
        spots = mesh("spots", [(-0.6, -0.6, 0), (0.6, -0.6, 0), (-0.6, 0.6, 0.2)], [])
        child = cube(0.4, grey(0.8), "child", location=(0, 0, 0))
        child.parent = spots
        spots.instance_type = "VERTS"
        collection = bpy.data.collections.new("collection")
        within = cube(0.3, material("blue", "ShaderNodeBsdfDiffuse", Color=(0.1, 0.2, 0.8, 1)), "within")
        bpy.context.scene.collection.objects.unlink(within)
        collection.objects.link(within)
        for place in ((0, 0.9, 0), (0, -0.9, 0.1)):
            empty = bpy.data.objects.new("instancer", None)
            bpy.context.scene.collection.objects.link(empty)
            empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", collection, place
        _, found = exported()
        counts = {group: sum(i["group"] == group for i in found["instance"]) for group in {i["group"] for i in found["instance"]}}
        self.assertEqual(counts, {"leaf": 2, "child": 3, "within": 2})
        self.assertEqual(len(found["mesh"]), 4)
        compare(self)

    def test_instances_of_geometry_nodes(self):
        lit()
        made = quad(2.0, grey(0.6), "grid")
        tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        scatter, ball = tree.nodes.new("GeometryNodeInstanceOnPoints"), tree.nodes.new("GeometryNodeMeshIcoSphere")
        ball.inputs["Radius"].default_value = 0.3
        tree.links.new(begin.outputs[0], scatter.inputs["Points"])
        tree.links.new(ball.outputs["Mesh"], scatter.inputs["Instance"])
        tree.links.new(scatter.outputs[0], end.inputs[0])
        made.modifiers.new("scatter", "NODES").node_group = tree
        _, found = exported()
        self.assertEqual(len(found["instance"]), 4)
        compare(self)

    def test_several_materials_and_texture_maps(self):
        lit()
        shades = [material(f"m{k}", "ShaderNodeBsdfDiffuse", Color=(0.2 + 0.3 * k, 0.5, 0.8 - 0.3 * k, 1)) for k in range(3)]
        made = cube(1.2, shades[0], "box", rotation_euler=(0.5, 0.6, 0.2))
        made.data.materials.append(shades[1])
        made.data.materials.append(None)
        made.data.polygons.foreach_set("material_index", [0, 1, 2, 0, 1, 2])
        # The object's own material in the place of the mesh's, in one of two objects that share it.
        other = add(made.data, location=(0.9, -0.6, 0), scale=(0.4, 0.4, 0.4))
        other.name = "other box"
        other.material_slots[0].link, other.material_slots[0].material = "OBJECT", shades[2]
        path, found = exported()
        boxes = [m for m in found["mesh"] if "box" in m["path"]]
        self.assertEqual(sum(len(triangles_of(path, m).triangles) for m in boxes), 24)
        self.assertEqual({m["material"] for m in boxes}, {"m0", "m1", "m2", "no material"})
        compare(self)

    def test_curves_and_texts(self):
        lit()
        curve = bpy.data.curves.new("ring", "CURVE")
        curve.dimensions, curve.bevel_depth = "3D", 0.1
        spline = curve.splines.new("POLY")
        spline.points.add(2)
        for point, co in zip(spline.points, [(-0.7, -0.5, 0, 1), (0.7, -0.5, 0.2, 1), (0, 0.6, 0, 1)]):
            point.co = co
        curve.materials.append(grey(0.8))
        add(curve)
        text = bpy.data.curves.new("text", "FONT")
        text.body, text.extrude = "A", 0.05
        text.materials.append(grey(0.3))
        add(text, location=(-0.4, 0.2, 0.1))
        other = add(curve, location=(0, 0, 0.4), scale=(0.4, 0.4, 0.4))
        array = other.modifiers.new("array", "ARRAY")
        array.count = 2
        self.assertEqual(warnings(), [])
        compare(self)

    def test_what_does_not_render_is_left_out(self):
        lit()
        hidden = cube(0.5, grey(0.7), "hidden", location=(0, 0, 0.5))
        hidden.hide_render = True
        self.assertEqual(len(exported()[1]["mesh"]), 1)
        hidden.hide_render, hidden.hide_viewport = False, True
        self.assertEqual(len(exported()[1]["mesh"]), 2)

    def test_what_is_scaled_flat(self):
        lit()
        cube(1.0, grey(0.8), "flat", scale=(1, 1, 0), rotation_euler=(0.3, 0.2, 0))
        cube(1.0, grey(0.8), "line", scale=(0, 0, 1))
        self.assertEqual(len(exported()[1]["mesh"]), 2)
        compare(self, runs=3)

    def test_hair_is_said_to_be_left_out(self):
        lit()
        made = quad(1.0, grey(0.5), "grown")
        made.modifiers.new("hair", "PARTICLE_SYSTEM")
        made.particle_systems[0].settings.type = "HAIR"
        self.assertIn("object 'grown': hair has no counterpart and is left out", warnings())

    def test_what_is_in_the_folder_stays(self):
        """A scene that was imported may have its own pictures there."""
        lit()
        folder = FOLDER / "again files"
        folder.mkdir()
        (folder / "notes.txt").write_text("mine")
        made = material("shade", "ShaderNodeBsdfDiffuse")
        steps_file = picture_file("steps", steps())
        inside = folder / "packed.png"
        inside.write_bytes(b"mine too")
        steps_file.pack()
        steps_file.name = "packed.png"
        picture = node(made, "ShaderNodeTexImage", image=steps_file)
        link(made, picture.outputs["Color"], made.node_tree.nodes["shader"].inputs["Color"])
        quad(1.0, made, "shown", location=(0, 0, 0.2))
        first = exported("again")[0].read_text()
        left = sorted(p.name for p in folder.iterdir())
        self.assertEqual(exported("again")[0].read_text(), first)
        self.assertEqual(sorted(p.name for p in folder.iterdir()), left)
        self.assertEqual((folder / "notes.txt").read_text(), "mine")
        self.assertEqual(inside.read_bytes(), b"mine too")
        self.assertIn("packed-1.png", left)

    def test_names_of_any_kind(self):
        lit()
        for name in ("a/b", "a:b", '"quoted" \\ back', "ünï", "..", " "):
            shade = material(name, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.5, 0.5, 1))
            cube(0.2, shade, name)
        _, found = exported()
        self.assertEqual(len(found["mesh"]), 7)
        self.assertIn('"quoted" \\ back', found["material"])
        render("PHOTOTAXIS", samples=1)
