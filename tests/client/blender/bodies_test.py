# SPDX-License-Identifier: GPL-3.0-or-later
"""Collections, rigid bodies and breakable constraints made from an answer: they hold and break in Blender's own
simulation."""
import pathlib
import sys

import bpy
from mathutils import Vector

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, bonds_of, fragments_of, load, select, settings  # noqa: E402


class Physics(InBlender):
    def test_each_fragment_is_a_body_and_each_bond_a_constraint(self):
        load("kk_barrel_large.glb")
        work = support.part("run").begin(bpy.context)
        self.assertTrue(work.asking.wait(support.PATIENCE))
        answer = work.asking.answers[0]
        (made,), *_ = work.finish(bpy.context)
        scene = bpy.context.scene
        self.assertEqual(len(fragments_of(made.collection)), answer.certificate["fragments"])
        joints = bonds_of(made.collection)
        pairs = sorted((item.rigid_body_constraint.object1.name, item.rigid_body_constraint.object2.name) for item in joints)
        names = {fragment.id: made.objects[fragment.id].name for fragment in answer.fragments}
        self.assertEqual(pairs, sorted((names[bond.a], names[bond.b]) for bond in answer.bonds))
        self.assertGreater(len(pairs), len(names) / 2)
        step = 1 / (scene.render.fps * scene.rigidbody_world.substeps_per_frame)
        by_pair = {(names[bond.a], names[bond.b]): bond for bond in answer.bonds}
        for item in joints:
            joint = item.rigid_body_constraint
            bond = by_pair[joint.object1.name, joint.object2.name]
            self.assertEqual((joint.type, joint.use_breaking, joint.enabled), ("FIXED", True, True))
            self.assertAlmostEqual(joint.breaking_threshold / (bond.strength * step), 1, places=5)
            self.assertAlmostEqual(bond.strength, answer.parameters["bond_strength"] * bond.area, delta=1e-6 * bond.strength)
        for fragment in answer.fragments:
            item = made.objects[fragment.id]
            body = item.rigid_body
            self.assertEqual((body.type, body.collision_shape), ("ACTIVE", "CONVEX_HULL"))
            self.assertAlmostEqual(body.mass / fragment.mass, 1, places=5)
            self.assertAlmostEqual(body.friction, answer.parameters["friction"], places=6)
            self.assertAlmostEqual(body.restitution, answer.parameters["restitution"], places=6)
            x, y, z = fragment.center_of_mass
            self.assertLess((item.location - Vector((x, -z, y))).length, 1e-5)
            self.assertEqual(item["fracture_id"], str(fragment.id))
            self.assertEqual(item["fracture_mass"], fragment.mass)

    def test_a_hierarchy_is_nested_collections(self):
        item = support.add_cube()
        root = self.fracture(levels="3,10,40")[0]
        inner = [child for child in root.children if not child.name.endswith("bonds")]
        self.assertEqual(len(inner), 3)
        self.assertEqual(sum(len(child.children) for child in inner), 10)
        self.assertEqual(sum(len(leaf.objects) for child in inner for leaf in child.children), 40)
        self.assertEqual(len(root.objects), 0)
        for cluster in inner:
            self.assertAlmostEqual(sum(piece["fracture_volume"] for piece in fragments_of(cluster)), cluster["fracture_volume"], places=9)
        self.assertTrue(item.hide_get() and item.hide_render)

    def test_an_original_that_was_a_body_is_one_no_more(self):
        item = support.add_cube()
        bpy.ops.rigidbody.object_add()
        self.fracture(sites=5)
        self.assertNotIn(item.name, bpy.context.scene.rigidbody_world.collection.objects)

    def test_several_objects_are_broken_each_by_itself_or_together(self):
        a, b = support.add_cube("A"), support.add_cube("B", location=(2, 0, 0))
        select(a, b)
        self.assertEqual([len(fragments_of(made)) for made in self.fracture(sites=10)], [10, 10])
        for item in (a, b):
            item.hide_set(False)
        select(a, b)
        settings().together = True
        together, = self.fracture(fragments=10)
        self.assertAlmostEqual(len(fragments_of(together)), 10, delta=1)
        self.assertEqual({piece.name.split("_")[0] for piece in fragments_of(together)}, {"A", "B"})

    def test_bodies_and_constraints_can_be_left_out(self):
        support.add_cube()
        settings().bodies = False
        made, = self.fracture(sites=5)
        self.assertIsNone(bpy.context.scene.rigidbody_world)
        self.assertEqual(len(made.all_objects), 5)

    def centers_after(self, pieces, frames):
        """Returns where the pieces are in the first frame of the simulation and in a later one."""
        found = []
        for frame in range(1, frames + 1):
            bpy.context.scene.frame_set(frame)
            if frame in (1, frames):
                graph = bpy.context.evaluated_depsgraph_get()
                found.append([piece.evaluated_get(graph).matrix_world.translation.copy() for piece in pieces])
        return found

    def test_what_nothing_moves_stays_where_it_is(self):
        for material in ("brick", "glass", "stone"):
            with self.subTest(material):
                support.empty_scene()
                support.add_cube()
                pieces = fragments_of(self.fracture(material=material, fragments=30)[0])
                bpy.context.scene.gravity = (0, 0, 0)
                first, last = self.centers_after(pieces, 24)
                self.assertLess(max((b - a).length for a, b in zip(first, last)), 0.005)

    def fall(self, strength):
        """Drops a box from three metres. Returns by how much a distance between two pieces changed, and the lowest
        centre."""
        support.empty_scene()
        support.add_cube("Vase", location=(0, 0, 4))
        settings().strength = strength
        pieces = fragments_of(self.fracture(material="stone", fragments=15)[0])
        bpy.ops.mesh.primitive_plane_add(size=50)
        bpy.ops.rigidbody.object_add(type="PASSIVE")
        first, last = self.centers_after(pieces, 60)
        self.assertLess(max(point.z for point in last), max(point.z for point in first) - 1)
        changes = [abs((last[i] - last[k]).length - (first[i] - first[k]).length) for i in range(len(last)) for k in range(i)]
        return max(changes), min(point.z for point in last)

    def test_strong_bonds_hold_in_a_fall_and_weak_ones_break(self):
        held, low = self.fall(1e6)
        self.assertLess(held, 0.02)
        self.assertGreater(low, 0)
        apart, low = self.fall(0.1)
        self.assertGreater(apart, 0.2)
        self.assertGreater(low, 0)


if __name__ == "__main__":
    support.main()
