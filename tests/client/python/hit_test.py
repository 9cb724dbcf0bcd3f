#!/usr/bin/env python3
"""Hits: the part that the server sends, merged with the earlier answer, equals the whole answer.

The server itself is the judge: the same hit with delta=stated has every fragment.
"""
import base64
import json
import math
import os
import pathlib
import struct
import unittest

from support import WithServer, box_obj, caught, main
from fracture_client import Answer, glb

OPENED = {"shell": 0}  # glass and pottery as solids: walls would give different answers, but not better tests


def values(fragment):
    """Everything about a fragment except its name and its place in the file."""
    primitives = [(p.material, p.interior, p.indices.tolist(), {s: bytes(a) for s, a in p.attributes.items()})
                  for p in fragment.primitives]
    hulls = [(bytes(hull.points), hull.triangles.tolist()) for hull in fragment.hulls]
    sheet = [(p.material, p.indices.tolist(), {s: bytes(a) for s, a in p.attributes.items()}) for p in fragment.sheet]
    return (fragment.translation, fragment.volume, fragment.mass, fragment.area, fragment.exterior_area, fragment.center_of_mass,
            fragment.inertia_diagonal, fragment.inertia_orientation, fragment.anchored, fragment.part, fragment.sites, primitives,
            hulls, sheet)


def boxes_glb():
    """Nine nodes that place a unit cube, 4 m apart, with different turns about y and scales. The fifth one is the largest."""
    corners = [(x, y, z) for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]  # counter-clockwise from outside
    indices = [corner for a, b, c, d in sides for corner in (a, b, c, a, c, d)]
    binary = struct.pack("<24f", *(value for corner in corners for value in corner)) + struct.pack("<36H", *indices)
    nodes = []
    for k in range(9):
        scale = 1.4 if k == 4 else 0.8 + 0.05 * k
        nodes.append({"mesh": 0, "name": "box", "translation": [4 * (k % 3), 0, 4 * (k // 3)], "scale": [scale] * 3,
                      "rotation": [0, math.sin(0.35 * k), 0, math.cos(0.35 * k)]})
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                 {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}]
    return glb.pack({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(9))}], "nodes": nodes,
                     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], "accessors": accessors,
                     "bufferViews": views}, binary)


def house_glb():
    """A house of unit boxes: a wall with a beam below it that touches it, another wall, and a lamp that is not in the house. The name of
    "Wall_01" is that of a fragment of "Wall", if there are 10 to 99 fragments and the second one is of the wall."""
    document, binary = glb.Glb(boxes_glb()).document, glb.Glb(boxes_glb()).binary
    document["nodes"] = [
        {"name": "House", "children": [1, 3], "translation": [0, 0, 1], "extras": {"floors": 2}},
        {"name": "Wall", "mesh": 0, "children": [2], "scale": [3, 2, 1], "extras": {"hp": 7}},
        {"name": "Beam", "mesh": 0, "translation": [1, 0.25, 0]},
        {"name": "Wall_01", "mesh": 0, "translation": [9, 0, 0]},
        {"name": "Lamp", "mesh": 0, "translation": [0, 5, 0]},
        {"name": "socket", "translation": [0, 1, 0]}]
    document["scenes"] = [{"nodes": [0, 4, 5]}]
    return glb.pack(document, bytes(binary))


def tree(answer):
    """The names of the groups above each fragment, and above each other node that has no extras.fracture; innermost first."""
    nodes = answer._file.document["nodes"]
    above = {child: k for k, node in enumerate(nodes) for child in node.get("children", [])}

    def groups(k):
        names = []
        while k in above and above[k] != 0:
            k = above[k]
            names.append(nodes[k]["name"])
        return names

    own = [node.get("extras", {}).get("fracture", {}) for node in nodes]
    return {own[k].get("id", node["name"]): groups(k) for k, node in enumerate(nodes)
            if "id" in own[k] or (not own[k] and not {"id"} & own[above.get(k, 0)].keys())}


def bonds(answer):
    """The bonds, normalized so that the order of the ends does not matter."""
    ends = ((b, b.normal) if b.a < b.b else (b, tuple(-x for x in b.normal)) for b in answer.bonds)
    return sorted((min(b.a, b.b), max(b.a, b.b), b.area, b.centroid, tuple(x + 0.0 for x in normal), b.strength)
                  for b, normal in ends)


class Hits(WithServer):
    def check(self, merged, stated):
        """Checks that the merged answer equals the whole one, fragment by fragment and as a file."""
        self.assertEqual(merged.parameters, stated.parameters)
        self.assertEqual(merged.certificate, stated.certificate)
        self.assertEqual(merged.report, stated.report)
        self.assertEqual(merged.delta, stated.delta)
        ours, whole = {f.id: f for f in merged.fragments}, {f.id: f for f in stated.fragments}
        self.assertEqual(set(ours), set(whole))
        self.assertEqual(len(ours), len(merged.fragments))
        for id, fragment in whole.items():
            self.assertEqual(values(ours[id]), values(fragment), id)
        self.assertEqual(bonds(merged), bonds(stated))
        names = [node["name"] for node in merged._file.document["nodes"]]
        self.assertEqual(len(set(names)), len(names))
        self.assertLessEqual(max(len(name.encode()) for name in names), 63)
        for key, value in stated._file.document.items():  # everything except nodes, meshes and buffers, word for word
            if key not in ("nodes", "meshes", "accessors", "bufferViews", "extensions"):
                self.assertEqual(merged._file.document[key], value, key)
        self.assertEqual([f.id for f in merged.fragments], [f.id for f in stated.fragments])
        self.assertEqual(merged._file.document, stated._file.document)
        self.assertEqual(bytes(merged._file.binary), bytes(stated._file.binary))

    def hit_twice(self, mesh, radius=0.3, **parameters):
        """Hits the middle of a fragment, then one that the first hit made."""
        first = mesh.fracture(parameters)
        middle = max(first.fragments, key=lambda f: f.volume).center_of_mass
        merged = first.hit(middle, radius, 12)
        ask = {"local_point": middle, "local_radius": radius, "local_sites": 12, "delta": "stated"}
        stated = mesh.fracture(ask, of=first.location)
        self.assertTrue(stated.delta.new)
        self.assertNotEqual(merged.location, stated.location)  # only a part was sent, which is another resource
        self.check(merged, stated)
        new = next(f for f in merged.fragments if f.id in merged.delta.new)
        again = merged.hit([new.center_of_mass, middle], [radius / 2, radius / 3])
        ask = {"local_point": [new.center_of_mass, middle], "local_radius": [radius / 2, radius / 3], "delta": "stated"}
        self.check(again, mesh.fracture(ask, of=stated.location))
        return first, merged, again

    def test_every_pattern_and_material(self):
        catalogue = self.client.patterns()
        requests = [{"pattern": p["name"]} for p in catalogue["patterns"] if p["name"] != "points"]
        requests += [{"material": m["name"], **OPENED} for m in catalogue["materials"]]
        mesh = self.client.put(box_obj(1.0, 1.5, 0.7), format="obj")
        for request in requests:
            with self.subTest(**request):
                self.hit_twice(mesh, fragments=24, **request)

    def test_every_kind_of_physics(self):
        mesh = self.client.put(box_obj(), format="obj")
        for more in ({"physics": "omi"}, {"physics": "none"}, {"ue_collision": "ucx"}, {"physics": "omi", "ue_collision": "ucx"},
                     {"physics": "none", "ue_collision": "ucx"}):
            for cells in (1, 5):  # one hull per fragment, or several
                with self.subTest(**more, cells=cells):
                    self.hit_twice(mesh, sites=20, cells_per_fragment=cells, **more)

    def test_look_pivot_and_what_passes_through(self):
        text = box_obj(extra="o left") + b"o right\nv 2 0 0\nv 3 0 0\nv 2 1 0\nv 2 0 1\nf 9 11 10\nf 9 10 12\nf 9 12 11\nf 10 11 12\n"
        mesh = self.client.put(text, format="obj")
        names = mesh.report["nodes"]
        self.assertEqual(len(names), 2)
        for more in ({"nodes": [names[0]]}, {"pivot": "source"}, {"interior_color": "#ff0000"}, {"interior_crushed": 0.9},
                     {"rough_amplitude": 0.05}, {"dual": "barycenter"}, {"min_fraction": 0.004}, {"intact": "true"}):
            with self.subTest(**more):
                self.hit_twice(mesh, sites=20, **more)

    def test_an_uncut_node_may_have_the_name_of_a_later_fragment(self):
        # With two digits, no fragment is called left_100. The hit makes more than a hundred fragments, with three digits.
        text = box_obj(extra="o left") + b"o left_100\nv 2 0 0\nv 3 0 0\nv 2 1 0\nv 2 0 1\nf 9 11 10\nf 9 10 12\nf 9 12 11\nf 10 11 12\n"
        first, merged, again = self.hit_twice(self.client.put(text, format="obj"), sites=95, nodes=["left"])
        self.assertEqual(len(first.fragments), 95)
        self.assertGreater(len(merged.fragments), 101)
        for answer, name in ((first, "left_100"), (merged, "left_100_2"), (again, "left_100_2")):
            self.assertIn(name, [node["name"] for node in answer._file.document["nodes"] if "id" not in
                                 node.get("extras", {}).get("fracture", {})])

    def test_nodes_without_a_mesh_and_the_extras_of_nodes_stay(self):
        corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
        faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        indices = [corner for face in faces for k in (1, 2) for corner in (face[0], face[k], face[k + 1])]
        buffer = struct.pack("<24f36H", *(c for corner in corners for c in corner), *indices)
        text = json.dumps({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
            "nodes": [{"mesh": 0, "name": "box", "extras": {"hp": 120}}, {"name": "socket", "translation": [0, 1, 0]},
                      {"name": "turned", "rotation": [0, 1, 0, 0], "extras": {"socket": True}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                          {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
            "buffers": [{"byteLength": 168, "uri": "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()}]})
        _, _, again = self.hit_twice(self.client.put(text.encode(), format="gltf"), sites=20)
        nodes = again._file.document["nodes"]
        empty = [node for node in nodes[1:] if "mesh" not in node and "extensions" not in node]
        self.assertEqual([node["name"] for node in empty], ["socket", "turned"])
        self.assertEqual((empty[0]["translation"], empty[1]["extras"]), ([0, 1, 0], {"socket": True}))
        fragments = [node for node in nodes if "id" in node.get("extras", {}).get("fracture", {})]
        self.assertEqual({node["extras"]["hp"] for node in fragments}, {120})

    def test_the_hierarchy_of_the_source(self):
        mesh = self.client.put(house_glb(), format="glb")
        for more in ({}, {"nodes": ["House"]}, {"physics": "none"}, {"ue_collision": "ucx"}, {"sites": 90}, {"parts": "apart"}):
            with self.subTest(**more):
                first, merged, again = self.hit_twice(mesh, 0.8, **{"sites": 24, **more})
                for answer in (first, merged, again):
                    known, found = answer._file.document["nodes"], tree(answer)
                    self.assertEqual(found["socket"], [])
                    groups = {node["extras"]["fracture"]["source"]["name"]: node for node in known
                              if "source" in node.get("extras", {}).get("fracture", {})}
                    self.assertEqual(groups["House"]["extras"]["floors"], 2)
                    for fragment in answer.fragments:
                        source = fragment.name.rpartition("_")[0]
                        if source in ("Beam", "Lamp") and len(fragment.parts) == 1:
                            self.assertEqual(found[fragment.id], {"Beam": ["Beam", "Wall", "House"], "Lamp": ["Lamp"]}[source])
                    if "nodes" in more:
                        self.assertEqual(found["Lamp"], [])
        levels = mesh.fracture(levels=[3, 24])
        self.assertFalse(any("source" in node.get("extras", {}).get("fracture", {}) and "id" not in node["extras"]["fracture"]
                             for node in levels._file.document["nodes"]))
        self.assertEqual({fragment.extras["source"]["name"] for fragment in levels.fragments if len(fragment.parts) == 1},
                         {"Wall", "Beam", "Wall_01", "Lamp"})

    def test_long_names_in_other_scripts(self):
        mesh = self.client.put(box_obj(extra="o T\u00fcr_" + "\u684c\u5b50" * 20), format="obj")
        for more in ({}, {"physics": "none"}, {"ue_collision": "ucx"}):
            with self.subTest(**more):
                first, _, again = self.hit_twice(mesh, sites=9, **more)
                for answer in (first, again):
                    self.assertTrue(all(fragment.name.startswith("T\u00fcr_\u684c\u5b50") for fragment in answer.fragments))

    def test_sheets(self):
        pane = "v 0 1.2 0\nv 1 1.2 0\nv 1 1.2 1\nv 0 1.2 1\nf 9 10 11 12\n".encode()
        mesh = self.client.put(box_obj() + pane, format="obj")
        self.assertEqual(mesh.report["solid"]["sheets"], 1)
        for more in ({}, {"sheets": "whole"}, {"physics": "none"}, {"physics": "omi", "ue_collision": "ucx"}, {"cells_per_fragment": 5}):
            with self.subTest(**more):
                first, merged, again = self.hit_twice(mesh, sites=20, **more)
                carried = [primitive for fragment in again.fragments for primitive in fragment.sheet]
                self.assertEqual(bool(carried), "sheets" not in more)
                self.assertFalse(any(primitive.interior for primitive in carried))
                self.assertAlmostEqual(again.certificate["sheet_area_out"], 1, delta=1e-5)

    def test_instances(self):
        mesh = self.client.put(boxes_glb(), format="glb")
        for more in ({}, {"physics": "omi"}, {"ue_collision": "ucx"}, {"physics": "none"}, {"pivot": "source"}):
            with self.subTest(**more):
                first, merged, again = self.hit_twice(mesh, fragments=3, **more)
                counted = [answer.report.get("instances") for answer in (first, merged, again)]
                expected = [{"fragments": n, "shapes": 1} for n in (9, 8, 8)]  # the hits cut the fifth box
                self.assertEqual(counted, [None] * 3 if "pivot" in more else expected)

    def test_answers_that_are_about_all_fragments_come_as_a_whole(self):
        mesh = self.client.put(box_obj(), format="obj")
        for more in ({"levels": [3, 12]}, {"sites": 12, "anchor_plane": [[0, 0, 0], [0, 1, 0]]}, {"interior_detail": "stone"}):
            with self.subTest(**more):
                first = mesh.fracture(more)
                after = first.hit((0.5, 0.5, 0.5), 0.3)
                self.assertEqual(after.parameters["delta"], "stated")
                self.assertEqual(len(after.fragments), after.certificate["fragments"])
                self.assertEqual(bool(after.levels), "levels" in more)

    def test_the_same_request_without_delta_has_the_same_fragments(self):
        mesh = self.client.put(box_obj(), format="obj")
        first, merged, again = self.hit_twice(mesh, material="stone", fragments=20)
        parameters = {name: value for name, value in again.parameters.items() if name not in ("delta", "local_new")}
        self.assertEqual(len(parameters["local_point"]), 3)
        whole = mesh.fracture(parameters)
        self.assertIsNone(whole.delta)
        self.assertEqual({f.id: values(f) for f in again.fragments}, {f.id: values(f) for f in whole.fragments})
        self.assertEqual(bonds(again), bonds(whole))
        self.assertEqual(again.certificate, whole.certificate)

    def test_a_hit_that_changes_nothing(self):
        first = self.client.put(box_obj(), format="obj").fracture(sites=20)
        after = first.hit((50, 50, 50), 0.1)
        self.assertEqual(after.delta.new + after.delta.changed + after.delta.gone, ())
        self.assertEqual({f.id: values(f) for f in after.fragments}, {f.id: values(f) for f in first.fragments})

    def test_a_delta_without_fragments_has_no_nodes_of_meshes(self):
        other = b"o right\nv 2 0 0\nv 3 0 0\nv 2 1 0\nv 2 0 1\nf 9 11 10\nf 9 10 12\nf 9 12 11\nf 10 11 12\n"
        mesh = self.client.put(box_obj(extra="o left") + other, format="obj")
        first = mesh.fracture(sites=20, nodes=[mesh.report["nodes"][0]])
        miss = {"local_point": (50, 50, 50), "local_radius": 0.1, "delta": "only"}
        document = mesh.fracture(miss, of=first.location)._file.document
        self.assertNotIn("meshes", document)
        self.assertEqual([node["name"] for node in document["nodes"]], ["Fracture"])

    def test_an_answer_that_the_server_has_forgotten_is_hit_by_its_parameters(self):
        mesh = self.client.put(box_obj(), format="obj")
        first = mesh.fracture(sites=20)
        once = first.hit((0.5, 0.5, 0.5), 0.3, 9)
        twice = once.hit((0.4, 0.5, 0.5), 0.2)
        for known, point, radius, sites, wanted in ((first, (0.5, 0.5, 0.5), 0.3, 9, once), (once, (0.4, 0.5, 0.5), 0.2, None, twice)):
            lost = Answer(known.glb, mesh, {"content-location": "/fractures/sha256:" + "0" * 64})
            again = lost.hit(point, radius, sites)
            self.assertEqual(again._file.document, wanted._file.document)
            self.assertEqual(again.glb, wanted.glb)

    def test_one_of_thousands_of_parameters_too(self):
        mesh = self.client.put(box_obj(), format="obj")
        points = [((k * 7919 % 1000) / 1000, (k * 104729 % 997) / 997, (k * 1299709 % 991) / 991) for k in range(1, 301)]
        first = mesh.fracture(pattern="points", points=points)
        lost = Answer(first.glb, mesh, {})
        self.assertEqual(lost.hit((0.5, 0.5, 0.5), 0.3).glb, first.hit((0.5, 0.5, 0.5), 0.3).glb)

    def test_what_would_change_other_fragments_is_refused(self):
        first = self.client.put(box_obj(), format="obj").fracture(sites=20)
        error = caught(first.hit, (0.5, 0.5, 0.5), 0.3, seed=2)
        self.assertEqual((error.type, error.parameter), ("bad-parameter", "seed"))
        other = first.hit((0.5, 0.5, 0.5), 0.3, delta="none", interior_color="#00ff00")
        self.assertEqual(len(other.fragments), other.certificate["fragments"])
        self.assertIsNone(other.delta)

    @unittest.skipUnless(os.environ.get("FRACTURE_TEST_MESHES"), "FRACTURE_TEST_MESHES names no folder of meshes")
    def test_real_meshes(self):
        folders = [pathlib.Path(f) for f in os.environ["FRACTURE_TEST_MESHES"].split(":")]
        for name, material in (("kk_barrel_large.glb", "wood"), ("kk_column.glb", "stone"), ("suzanne.obj", "concrete")):
            path = next((folder / name for folder in folders if (folder / name).exists()), None)
            if path is not None:
                with self.subTest(name):
                    self.hit_twice(self.client.put(path), fragments=40, material=material, **OPENED)


if __name__ == "__main__":
    main()
