# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests an answer in Blender: volumes, materials, texture coordinates and colours, in Blender's frame."""
import pathlib
import sys

import bpy
from mathutils import Vector

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, fragments_of, load, volume  # noqa: E402

CLOSE = 1e-6  # relative, because positions are in single precision


class Volumes(InBlender):
    def check_volume(self, objects, collections, scale=1.0):
        inside = sum(collection["fracture_volume"] for collection in collections)
        pieces = [item for collection in collections for item in fragments_of(collection)]
        total = sum(volume(item) for item in pieces) * scale ** 3
        self.assertLess(abs(total - inside), CLOSE * inside)
        self.assertLess(abs(sum(item["fracture_volume"] for item in pieces) - inside), 1e-9 * inside)
        self.assertEqual([item.name for item in pieces if support.open_edges(item.data)], [])
        return total

    def test_a_closed_mesh_is_as_large_as_its_fragments(self):
        for name in ("torus.obj", "spot.obj"):
            with self.subTest(name):
                support.empty_scene()
                items = load(name)
                made = self.fracture(material="stone", fragments=20)
                total = self.check_volume(items, made)
                before = sum(volume(item) for item in items)
                self.assertLess(abs(total - before), CLOSE * before)

    def test_a_repaired_mesh_is_as_large_as_the_server_says(self):
        for name in ("suzanne.obj", "kk_barrel_large.glb", "kk_bottle_A_brown.glb", "kk_chest.glb"):
            with self.subTest(name):
                support.empty_scene()
                items = load(name)
                self.check_volume(items, self.fracture(material="wood", fragments=30))

    def test_turned_mirrored_and_stretched_objects_keep_their_volume(self):
        item = load("spot.obj")[0]
        item.rotation_euler, item.location, item.scale = (0.3, 1.1, -2), (100, -50, 7), (-2, 0.5, 1.3)
        bpy.context.view_layer.update()
        before = volume(item)
        total = self.check_volume([item], self.fracture(pattern="uniform", sites=20))
        self.assertLess(abs(total - before), CLOSE * before)

    def test_a_sheared_object_keeps_its_volume(self):
        parent = support.add_empty((1, 2, 3))
        parent.scale = (1, 3, 0.5)
        item = support.add_cube()
        item.parent, item.rotation_euler = parent, (0.5, 0.4, 0.3)
        bpy.context.view_layer.update()
        total = self.check_volume([item], self.fracture(sites=20))
        self.assertAlmostEqual(total, 12.0, delta=1e-4)

    def test_the_unit_scale_makes_metres(self):
        bpy.context.scene.unit_settings.scale_length = 0.01
        item = support.add_cube(size=100)
        made = self.fracture(sites=20, density=1000)
        self.check_volume([item], made, scale=0.01)
        self.assertAlmostEqual(sum(piece["fracture_volume"] for piece in fragments_of(made[0])), 1.0, places=6)
        self.assertAlmostEqual(sum(piece["fracture_mass"] for piece in fragments_of(made[0])), 1000.0, places=3)
        low = min(v for piece in fragments_of(made[0]) for v in (piece.matrix_world @ Vector(corner) for corner in piece.bound_box)
                  for v in v)
        self.assertAlmostEqual(low, -50.0, places=3)

    def test_modifiers_are_applied(self):
        item = support.add_cube()
        item.modifiers.new("", "SUBSURF").levels = 2
        before = volume(item, evaluated=True)
        total = self.check_volume([item], self.fracture(sites=20))
        self.assertLess(before, 7)
        self.assertLess(abs(total - before), CLOSE * before)

    def test_fragments_fill_the_same_box(self):
        item = load("spot.obj")[0]
        item.rotation_euler = (0.3, 1.1, -2)
        bpy.context.view_layer.update()

        def box(items):
            points = [piece.matrix_world @ vertex.co for piece in items for vertex in piece.data.vertices]
            return [end(point[axis] for point in points) for end in (min, max) for axis in range(3)]
        before = box([item])
        after = box(fragments_of(self.fracture(material="stone", fragments=20)[0]))
        for a, b in zip(before, after):
            self.assertAlmostEqual(a, b, places=5)


class Looks(InBlender):
    def test_materials_are_those_of_the_object_and_cut_faces_have_one_more(self):
        items = load("kk_chest.glb")
        own = {slot.material for item in items for slot in item.material_slots}
        made = self.fracture(material="wood", fragments=30)
        seen, inner = set(), set()
        for piece in (piece for collection in made for piece in fragments_of(collection)):
            slots = [slot.material for slot in piece.material_slots]
            outside, inside = slots[:-1], slots[-1]
            self.assertLessEqual(set(outside), own)
            self.assertNotIn(inside, own)
            self.assertTrue(inside.name.startswith("Interior"))
            self.assertTrue(any(face.material_index == len(slots) - 1 for face in piece.data.polygons))
            seen.update(outside)
            inner.add(inside)
        self.assertEqual(seen, own)
        self.assertTrue(all(material.use_nodes for material in inner))

    def test_outer_faces_keep_their_material_area_and_texture_coordinates(self):
        item = support.add_cube()
        item.data.uv_layers[0].name = "Painted"
        for name in ("Red", "Blue"):
            item.data.materials.append(bpy.data.materials.new(name))
        for face in item.data.polygons:
            face.material_index = 1 if face.normal.z > 0.5 else 0

        def sums(pieces):
            found = {}
            for piece in pieces:
                mesh = piece.data
                layer = mesh.uv_layers["Painted"].data
                for face in mesh.polygons:
                    material = piece.material_slots[face.material_index].material
                    uv = [layer[corner].uv for corner in face.loop_indices]
                    turns = sum(a.x * b.y - b.x * a.y for a, b in zip(uv, uv[1:] + uv[:1])) / 2
                    area, flat = found.get(material.name, (0, 0))
                    found[material.name] = (area + face.area, flat + turns)
            return found
        before = sums([item])
        after = sums(fragments_of(self.fracture(pattern="uniform", sites=30)[0]))
        for name, both in before.items():
            for a, b in zip(both, after[name]):
                self.assertAlmostEqual(a, b, places=5)
        self.assertEqual(set(after) - set(before), {"Interior"})

    def test_a_texture_point_stays_where_it_is(self):
        item = load("spot.obj")[0]
        name = item.data.uv_layers[0].name
        layer = item.data.uv_layers[0].data
        where = {}
        for loop in item.data.loops:
            point = item.matrix_world @ item.data.vertices[loop.vertex_index].co
            where.setdefault(tuple(round(v, 4) for v in point), []).append(layer[loop.index].uv.copy())
        found = 0
        for piece in fragments_of(self.fracture(pattern="uniform", sites=20)[0]):
            layer = piece.data.uv_layers[name].data
            for face in piece.data.polygons:
                if face.material_index == len(piece.material_slots) - 1:
                    continue
                for corner in face.loop_indices:
                    point = piece.matrix_world @ piece.data.vertices[piece.data.loops[corner].vertex_index].co
                    for uv in where.get(tuple(round(v, 4) for v in point), ())[:1]:
                        known = where[tuple(round(v, 4) for v in point)]
                        self.assertLess(min((layer[corner].uv - entry).length for entry in known), 1e-4)
                        found += 1
        self.assertGreater(found, 1000)

    def test_a_texture_of_the_object_is_the_same_image_in_cut_faces(self):
        items = load("kk_chest.glb")
        made = self.fracture(fragments=20, interior="texture", interior_material=items[0].material_slots[0].material.name)
        inside = fragments_of(made[0])[0].material_slots[-1].material
        images = [node.image for node in inside.node_tree.nodes if node.type == "TEX_IMAGE"]
        own = [node.image for node in items[0].material_slots[0].material.node_tree.nodes if node.type == "TEX_IMAGE"]
        self.assertEqual(images, own)

    def test_the_relief_of_cut_faces_is_packed_and_linked(self):
        support.add_cube()
        before = set(bpy.data.images)
        inside = fragments_of(self.fracture(sites=10, interior_detail="stone")[0])[0].material_slots[-1].material
        new = set(bpy.data.images) - before
        self.assertEqual({node.image for node in inside.node_tree.nodes if node.type == "TEX_IMAGE"}, new)
        self.assertEqual(len(new), 2)
        self.assertTrue(all(image.packed_file and image.colorspace_settings.name == "Non-Color" for image in new))
        principled = next(node for node in inside.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        self.assertTrue(principled.inputs["Normal"].is_linked and principled.inputs["Roughness"].is_linked)

    def test_cut_faces_take_the_color_of_an_image_that_was_never_saved(self):
        item = support.add_cube()
        image = bpy.data.images.new("Drawn", 8, 8)
        image.pixels = [0.9, 0.1, 0.1, 1.0] * 64
        material = bpy.data.materials.new("Drawn")
        material.use_nodes = True
        texture = material.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        material.node_tree.links.new(texture.outputs["Color"], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
        item.data.materials.append(material)
        inside = fragments_of(self.fracture(sites=10)[0])[0].material_slots[-1].material
        red, green, _, _ = inside.diffuse_color
        self.assertGreater(red, 3 * green)
        self.assertTrue(image.is_dirty and not image.filepath)

    def test_color_attributes_come_back_under_their_name(self):
        item = support.add_cube()
        layer = item.data.color_attributes.new("Dirt", "FLOAT_COLOR", "POINT")
        for entry in layer.data:
            entry.color = (0.25, 0.5, 0.75, 1)
        for piece in fragments_of(self.fracture(sites=10)[0]):
            for entry in piece.data.color_attributes["Dirt"].data:
                if max(entry.color[:3]) < 0.99:  # cut faces are white
                    self.assertLess((Vector(entry.color[:3]) - Vector((0.25, 0.5, 0.75))).length, 1e-5)


if __name__ == "__main__":
    support.main()
