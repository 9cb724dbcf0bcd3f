# SPDX-License-Identifier: GPL-3.0-or-later
"""Fractures through `fracture-server bake` on this machine. Results and messages equal those from a server."""
import os
import pathlib
import sys

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, add_cube, load, preferences  # noqa: E402


class Program(InBlender):
    def setUp(self):
        super().setUp()
        preferences().ask, preferences().program = "PROGRAM", os.environ["FRACTURE_TEST_SERVER"]

    def answer(self):
        work = support.part("run").begin(bpy.context)
        self.assertTrue(work.asking.wait(support.PATIENCE))
        self.assertIsNone(work.asking.error)
        return work.asking.answers[0]

    def test_the_bytes_are_those_of_a_server(self):
        load("spot.obj")
        support.give(material="ceramic", fragments=30, impacts="0,0.5,0.1")
        here = self.answer().glb
        preferences().ask = "SERVER"
        self.assertEqual(self.answer().glb, here)

    def test_the_description_is_that_of_a_server(self):
        here = support.part("preferences").ask_description(bpy.context).document
        preferences().ask = "SERVER"
        self.assertEqual(support.part("preferences").ask_description(bpy.context).document, here)

    def test_fragments_come_and_refusals_are_the_same(self):
        add_cube()
        made, = self.fracture(pattern="uniform", sites=12)
        self.assertEqual(len(support.fragments_of(made)), 12)
        add_cube("Other")
        support.give(pattern="grid", sites=10, radius=0.5)
        here = self.refused()
        self.assertIn("'radius'", here)
        preferences().ask = "SERVER"
        self.assertEqual(self.refused().replace(", HTTP 400", ""), here.replace(", HTTP 400", ""))

    def test_an_open_mesh_shows_its_edges(self):
        bpy.ops.mesh.primitive_plane_add()
        support.give()
        self.assertIn("The open edges of 'Plane' are selected", self.refused())


if __name__ == "__main__":
    support.main()
