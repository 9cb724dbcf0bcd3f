#!/usr/bin/env python3
"""The reader of GLBs, on files made by hand; arrays with and without numpy."""
import copy
import importlib.util
import json
import pathlib
import struct
import tempfile
import unittest
from unittest import mock

from support import caught, figures, main
from fracture_client import Answer, Bond, Delta, glb

HAS_NUMPY = importlib.util.find_spec("numpy") is not None

# A fragment of two triangles with two materials, a hull, and interleaved texture coordinates.
POSITIONS = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
INTERLEAVED = struct.pack("<16f", *(v for k in range(4) for v in (k, k + 0.5, 9, 9)))
INDICES = struct.pack("<6H", 0, 1, 2, 0, 2, 3)


def document():
    views = [(0, 48, {}), (48, 64, {"byteStride": 16}), (112, 12, {})]
    attributes = {"POSITION": 0, "TEXCOORD_0": 1}
    collider = {"geometry": {"mesh": 1, "convexHull": True}, "physicsMaterial": 0, "collisionFilter": 1}
    motion = {"mass": 5, "centerOfMass": [0, 0, 0], "inertiaDiagonal": [1, 2, 3], "inertiaOrientation": [0, 0, 0, 1]}
    own = {"id": 2 ** 53 - 1, "volume": 0.5, "mass": 5, "area": 3, "exterior_area": 2, "center_of_mass": [1, 2, 3], "level": 0,
           "parent": None, "anchored": True, "part": 4, "sites": [7, 9]}
    bonds = {"a": [1], "b": [2], "area": [0.25], "centroid": [[1, 2, 3]], "normal": [[0, 0, 1]], "strength": [100]}
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "extensions": {"KHR_physics_rigid_bodies": {"collisionFilters": [
            {"collisionSystems": ["0"]}, {"collisionSystems": ["3"], "notCollideWithSystems": ["5", "6"]}]}},
        "nodes": [{"name": "Fracture", "children": [1],
                   "extras": {"fracture": figures(bonds=bonds, delta={"new": [1], "changed": [2, 3], "gone": []})}},
                  {"name": "b\u00f6x_0", "mesh": 0, "translation": [1, 2, 3], "extras": {"fracture": own},
                   "extensions": {"KHR_physics_rigid_bodies": {"motion": motion, "collider": collider}}}],
        "materials": [{"name": "Outside"}, {"name": "Interior"}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 2, "material": 0},
                                   {"attributes": attributes, "indices": 3, "material": 1}]},
                   {"primitives": [{"attributes": {"POSITION": 0}, "indices": 2}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR"},
                      {"bufferView": 2, "byteOffset": 6, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size, **more} for at, size, more in views]}


BINARY = POSITIONS + INTERLEAVED + INDICES


class Reading(unittest.TestCase):
    def each_way(self):
        ways = [("memoryview", [None])] + ([("numpy", [])] if HAS_NUMPY else [])
        for name, cached in ways:
            with self.subTest(name), mock.patch.object(glb, "_NUMPY", cached):
                yield name

    def test_a_fragment_as_plain_values(self):
        for _ in self.each_way():
            answer = Answer(glb.pack(document(), BINARY))
            fragment, = answer.fragments
            self.assertEqual((fragment.id, fragment.name, fragment.node), (2 ** 53 - 1, "b\u00f6x_0", 1))
            self.assertEqual((fragment.translation, fragment.center_of_mass), ((1, 2, 3), (1, 2, 3)))
            self.assertEqual((fragment.volume, fragment.mass, fragment.area, fragment.exterior_area), (0.5, 5, 3, 2))
            self.assertEqual((fragment.inertia_diagonal, fragment.inertia_orientation), ((1, 2, 3), (0, 0, 0, 1)))
            self.assertEqual((fragment.anchored, fragment.part, fragment.sites, fragment.parent), (True, 4, (7, 9), None))
            self.assertEqual((fragment.collision_system, fragment.not_collide_with, fragment.triangles), (3, (5, 6), 2))
            self.assertEqual(fragment.materials, ("Outside", "Interior"))
            self.assertEqual([p.interior for p in fragment.primitives], [False, True])
            self.assertEqual([p.indices.tolist() for p in fragment.primitives], [[[0, 1, 2]], [[0, 2, 3]]])
            self.assertEqual(fragment.positions.tolist(), [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
            uvs = fragment.primitives[0].attributes["TEXCOORD_0"]
            self.assertEqual(uvs.tolist(), [[0, 0.5], [1, 1.5], [2, 2.5], [3, 3.5]])
            hull, = fragment.hulls
            self.assertEqual((hull.points.tolist(), hull.triangles.tolist()), (fragment.positions.tolist(), [[0, 1, 2]]))
            self.assertEqual(answer.bonds, [Bond(1, 2, 0.25, (1, 2, 3), (0, 0, 1), 100)])
            self.assertEqual(answer.delta, Delta((1,), (2, 3), ()))

    def test_the_node_of_an_instance_is_turned_and_scaled(self):
        file, half = document(), 0.5 ** 0.5
        # A quarter turn about y, after doubling: (x, y, z) -> (2 z, 2 y, -2 x).
        file["nodes"][1].update(rotation=[0, half, 0, half], scale=[2, 2, 2])
        file["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["motion"]["inertiaOrientation"] = [half, 0, 0, half]
        for _ in self.each_way():
            fragment, = Answer(glb.pack(file, BINARY)).fragments
            self.assertEqual((fragment.translation, fragment.positions.shape), ((1, 2, 3), (4, 3)))
            for found in (fragment.positions, fragment.hulls[0].points):
                for point, expected in zip(found.tolist(), [[0, 0, 0], [0, 0, -2], [0, 2, 0], [2, 0, 0]]):
                    for a, b in zip(point, expected):
                        self.assertAlmostEqual(a, b, 6)
            # The turn about x comes first: as a quaternion, (half, 0, 0, half) after (0, half, 0, half) is (1, 1, -1, 1) / 2.
            for a, b in zip(fragment.inertia_orientation, (0.5, 0.5, -0.5, 0.5)):
                self.assertAlmostEqual(a, b, 12)
            self.assertEqual(fragment.primitives[0].attributes["TEXCOORD_0"].tolist()[0], [0, 0.5])

    def test_arrays_are_views_of_the_file(self):
        for way in self.each_way():
            positions = Answer(glb.pack(document(), BINARY)).fragments[0].positions
            self.assertEqual(positions.shape, (4, 3))
            if way == "numpy":
                self.assertEqual(str(positions.dtype), "float32")
                self.assertFalse(positions.flags.owndata)
            else:
                self.assertIsInstance(positions, memoryview)
                self.assertEqual((positions[1, 0], positions.format), (1.0, "f"))

    @unittest.skipUnless(HAS_NUMPY, "numpy is not installed")
    def test_numpy_is_found_where_it_is(self):
        import numpy
        with mock.patch.object(glb, "_NUMPY", []):
            fragment, = Answer(glb.pack(document(), BINARY)).fragments
            self.assertIsInstance(fragment.positions, numpy.ndarray)
            corners = fragment.positions[fragment.primitives[0].indices] + fragment.translation
            self.assertEqual(corners.tolist(), [[[1, 2, 3], [2, 2, 3], [1, 3, 3]]])

    def test_every_type_of_component(self):
        for _ in self.each_way():
            for component, kind, values in ((5120, "b", (-1, 2)), (5121, "B", (1, 255)), (5122, "h", (-300, 3)), (5123, "H", (1, 65535)),
                                            (5125, "I", (1, 2 ** 32 - 1)), (5126, "f", (0.5, -2))):
                data = struct.pack(f"<2{kind}", *values)
                file = glb.Glb(glb.pack({"accessors": [{"bufferView": 0, "componentType": component, "count": 2, "type": "SCALAR"}],
                                         "bufferViews": [{"buffer": 0, "byteLength": len(data)}]}, data))
                self.assertEqual(file.array(0).tolist(), list(values))


class Damaged(unittest.TestCase):
    def wrong(self, change, binary=BINARY):
        """Returns the error that reading raises after a change of the document."""
        changed = copy.deepcopy(document())
        change(changed)
        error = caught(lambda: Answer(glb.pack(changed, binary)).fragments)
        self.assertEqual(error.type, "damaged")
        return error.detail

    def test_what_leads_out_of_the_file_is_named(self):
        def put(value, *path):
            def change(changed):
                for key in path[:-1]:
                    changed = changed[key]
                changed[path[-1]] = value
            return change
        self.assertIn("accessors[0]", self.wrong(put(5, "accessors", 0, "count")))
        self.assertIn("accessors[0]", self.wrong(put(-4, "accessors", 0, "byteOffset")))
        self.assertIn("accessors[0]", self.wrong(put(4, "accessors", 0, "componentType")))
        self.assertIn("bufferViews[0]", self.wrong(put(4000, "bufferViews", 0, "byteLength")))
        self.assertIn("bufferViews[9]", self.wrong(put(9, "accessors", 0, "bufferView")))
        self.assertIn("meshes[9]", self.wrong(put(9, "nodes", 1, "mesh")))
        self.assertIn("meshes[-1]", self.wrong(put(-1, "nodes", 1, "mesh")))
        self.assertIn("nodes[1]", self.wrong(put("much", "nodes", 1, "extras", "fracture", "volume")))
        self.assertIn("nodes[1]", self.wrong(lambda d: d["nodes"][1]["extras"]["fracture"].pop("mass")))
        self.assertIn("certificate", self.wrong(put({}, "nodes", 0, "extras")))
        self.assertIn("'nodes'", self.wrong(put(7, "nodes")))

    def test_files_that_are_none(self):
        whole = glb.pack(document(), BINARY)
        for content in (b"", b"glTF", whole[:100], whole[:-1], whole + b"x", b"gltf" + whole[4:], whole[:4] + b"\1" + whole[5:],
                        glb.pack({}, b"")[:20] + b"[]" + b" " * 2):
            self.assertEqual(caught(Answer, content).type, "damaged", content[:30])

    def test_bonds_of_several_lengths(self):
        changed = document()
        changed["nodes"][0]["extras"]["fracture"]["bonds"]["area"] = []
        answer = Answer(glb.pack(changed, BINARY))
        self.assertEqual(caught(lambda: answer.bonds).type, "damaged")


class Saving(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.answer = Answer(glb.pack(document(), BINARY))

    def test_a_file_is_read_back_as_it_was(self):
        path = self.answer.save(self.folder / "\u6728.glb")
        self.assertEqual(path.read_bytes(), self.answer.glb)
        self.assertEqual(Answer.load(str(path)).figures, self.answer.figures)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["\u6728.glb"])

    def test_gltf_is_one_text_with_the_same_buffer(self):
        text = json.loads(self.answer.save(self.folder / "a.gltf").read_text(encoding="utf-8"))
        head, data = text["buffers"][0].pop("uri").split(",")
        import base64
        self.assertEqual(base64.b64decode(data), BINARY + b"\0" * (-len(BINARY) % 4))
        self.assertEqual(head, "data:application/octet-stream;base64")
        self.assertEqual(text, glb.Glb(self.answer.glb).document)

    def test_json_is_the_figures(self):
        path = self.answer.save(self.folder / "a.json")
        self.assertEqual(json.loads(path.read_text(encoding="utf-8")), self.answer.figures)

    def test_an_ending_that_is_not_written_is_refused(self):
        for name in ("a.obj", "a.glb.zip", "a.GLBX", "a.stl"):
            error = caught(self.answer.save, self.folder / name)
            self.assertEqual(error.type, "bad-parameter")
            self.assertIn(f"'{pathlib.Path(name).suffix}' cannot be written", error.detail)
            self.assertIn(".glb, .gltf", error.detail)
        self.assertEqual(list(self.folder.iterdir()), [])
        for name in ("no ending", "A.GLB", ".hidden"):
            self.assertEqual(self.answer.save(self.folder / name).read_bytes(), self.answer.glb)

    def test_what_cannot_be_written_leaves_what_was_there(self):
        path = self.folder / "folder.glb"
        path.mkdir()
        with self.assertRaises(OSError) as raised:
            self.answer.save(path)
        self.assertEqual(raised.exception.filename, str(path))
        self.assertEqual([p.name for p in self.folder.iterdir()], ["folder.glb"])

    def test_an_answer_of_a_file_cannot_be_hit(self):
        self.assertEqual(caught(self.answer.hit, (0, 0, 0), 1).type, "bad-parameter")


if __name__ == "__main__":
    main()
