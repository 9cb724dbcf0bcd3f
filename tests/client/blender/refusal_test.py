# SPDX-License-Identifier: GPL-3.0-or-later
"""An error shows the server's words and the place of the problem."""
import pathlib
import socket
import sys

import bmesh
import bpy
from mathutils import Vector

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, add_cube, load, preferences  # noqa: E402


def selected_edges():
    """Returns the number of faces of each selected edge of the mesh in edit mode."""
    mesh = bmesh.from_edit_mesh(bpy.context.edit_object.data)
    return [len(edge.link_faces) for edge in mesh.edges if edge.select]


class Refused(InBlender):
    def test_an_open_mesh_shows_its_open_edges_in_edit_mode(self):
        item = load("plane_holes.obj")[0]
        item.location, item.rotation_euler = (3, 2, 1), (0.2, 0.3, 0.4)
        bpy.context.view_layer.update()
        support.give(repair="strict")
        words = self.refused()
        self.assertIn("repair=strict fills no holes: 341 open edges", words)
        self.assertIn("mesh-not-closed, HTTP 422", words)
        self.assertIn(f"The open edges of '{item.name}' are selected", words)
        self.assertEqual(bpy.context.mode, "EDIT_MESH")
        self.assertEqual(selected_edges(), [1] * 341)

    def test_a_hole_that_a_modifier_made_is_shown_by_an_empty(self):
        item = add_cube(location=(1, 2, 3))
        group = item.vertex_groups.new(name="Gone")
        group.add([0], 1.0, "REPLACE")
        hole = item.modifiers.new("", "MASK")
        hole.vertex_group, hole.invert_vertex_group = "Gone", True
        corner = item.matrix_world @ item.data.vertices[0].co
        support.give(repair="strict")
        words = self.refused()
        self.assertIn("The empty 'Fracture: ", words)
        mark = next(entry for entry in bpy.data.objects if entry.name.startswith("Fracture: "))
        self.assertEqual(bpy.context.mode, "OBJECT")
        self.assertAlmostEqual(min(abs((mark.location - Vector(corner)).length - distance) for distance in (2, 2 * 2 ** 0.5)), 0,
                               places=4)

    def test_what_bounds_no_volume_is_refused_without_a_parameter(self):
        bpy.ops.mesh.primitive_plane_add()
        support.give()
        self.assertIn("mesh-not-closed", self.refused())

    def test_the_second_object_is_the_one_that_is_shown(self):
        a = add_cube("A")
        bpy.ops.mesh.primitive_plane_add()
        b = bpy.context.object
        b.name = "B"
        support.select(a, b)
        support.give()
        self.assertIn("The open edges of 'B' are selected", self.refused())
        self.assertEqual(bpy.context.edit_object.name, "B")
        self.assertEqual([item.name for item in bpy.data.collections], [])

    def test_a_wrong_parameter_is_named_with_its_range(self):
        add_cube()
        support.give(pattern="grid", sites=10, radius=0.5)
        words = self.refused()
        self.assertIn("radius", words)
        self.assertIn("bad-parameter, HTTP 400", words)
        support.give(levels="3,many")
        self.assertIn("levels", self.refused())
        support.give(nodes="Nobody")
        self.assertIn("Nobody", self.refused())

    def test_all_that_is_wrong_is_said_at_once(self):
        add_cube()
        support.give(levels="x", points="1,2")
        words = self.refused()
        self.assertIn("'levels'", words)
        self.assertIn("'points'", words)

    def test_no_server(self):
        with socket.socket() as free:  # bound but not listening, so nobody answers there
            free.bind(("127.0.0.1", 0))
            preferences().url = f"http://127.0.0.1:{free.getsockname()[1]}"
            preferences().timeout = 1
            add_cube()
            before = sorted(bpy.data.objects.keys())
            self.assertIn("(connection)", self.refused())
            self.assertEqual(sorted(bpy.data.objects.keys()), before)
            with self.assertRaises(RuntimeError):
                bpy.ops.fracture.describe()

    def test_no_server_at_all_of_that_name(self):
        preferences().url = "127.0.0.1:80"
        add_cube()
        self.assertIn("bad-url", self.refused())

    def test_no_program(self):
        preferences().ask, preferences().program = "PROGRAM", "/nowhere/fracture-server"
        add_cube()
        self.assertIn("'/nowhere/fracture-server' cannot be started", self.refused())

    def test_nothing_is_selected(self):
        self.assertIn("Select the objects", self.refused())

    def test_an_object_without_faces(self):
        mesh = bpy.data.meshes.new("Points")
        mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
        item = bpy.data.objects.new("Points", mesh)
        bpy.context.scene.collection.objects.link(item)
        support.select(item)
        self.assertIn("no faces", self.refused())


if __name__ == "__main__":
    support.main()
