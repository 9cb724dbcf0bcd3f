#!/usr/bin/env python3
"""Merging the part that a hit changed with the earlier answer, without a server."""
import copy
import unittest

from support import Client, FaultServer, answer as http_answer, caught, digest, figures, main, problem, small_glb
from fracture_client import Answer, glb
from fracture_client.groups import Groups
from fracture_client.merge import _in_order, _Piece, merge


class Parts(unittest.TestCase):
    """Deltas that do not belong to this answer."""

    def delta(self, **more):
        return {"delta": {"new": [], "changed": [], "gone": [], **more}}

    def test_they_are_refused(self):
        whole = glb.Glb(small_glb())
        for said in ({}, self.delta(new=[7]), self.delta(changed=[7]), self.delta(gone=[7]),
                     {**self.delta(), "certificate": {"fragments": 1}}):
            self.assertEqual(caught(merge, whole, glb.Glb(small_glb(**said))).type, "damaged", said)
        same = glb.Glb(merge(whole, glb.Glb(small_glb(**self.delta()))))
        self.assertEqual(same.document["nodes"][0]["extras"]["fracture"]["delta"], self.delta()["delta"])

    def test_fragments_are_ordered_by_their_first_site_part_and_id(self):
        """A changed fragment may have lost its first site or part."""
        def pieces(*places):
            return [_Piece(None, {}, {"id": id, "sites": [site], "part": part}) for id, site, part in places]

        stay = pieces((2, 5, 0), (6, 8, 0), (4, 8, 0), (9, 9, 0))
        after = pieces((3, 5, 1), (7, 8, 0), (5, 8, 0), (8, 8, 0), (1, 9, 0))
        self.assertEqual([piece.id for piece in _in_order(stay, after)], [2, 3, 4, 5, 6, 7, 8, 1, 9])

    def test_groups_of_both_answers_are_written_as_the_server_does(self):
        """Groups without content are left out, and names are those that the server gives if these names are taken."""
        def group(index, name, children, source=None):
            return {"name": name, "children": children, "extras": {"fracture": {"source": {"index": index, "name": source or name}}, "hp": index}}

        def fragment(id):
            return {"name": f"Cube_{id}", "extras": {"fracture": {"id": id}}}

        def answer(*nodes):
            return glb.Glb(glb.pack({"asset": {"version": "2.0"}, "nodes": list(nodes)}, b""))

        # The source: 0 House {2 Cube, 3 Cube.1, 5 Lid_group}, 7 Gone.
        before = answer({"children": [4, 6]}, fragment(0), fragment(1), {"name": "sign", "mesh": 0}, group(0, "House", [5]),
                        group(2, "Cube", [1, 3]), group(7, "Gone", [2]))
        delta = answer({"children": [3]}, fragment(2), fragment(3), group(0, "House_group", [4, 5], "House"),
                       group(3, "Cube_1_group", [1], "Cube.1"), group(5, "Lid_group", [2]))
        groups = Groups(before, delta)
        old, new = before.document["nodes"], delta.document["nodes"]
        self.assertEqual([groups.above(node) for node in (old[1], old[2], old[3], new[1], new[2], old[4])], [2, 7, 2, 3, 5, None])
        for taken, names in ((set(), ["House", "Cube", "Cube_1", "Lid_group"]),
                             ({"Cube_1", "Lid_group", "House", "House_group"}, ["House_2_group", "Cube", "Cube_1_group", "Lid_group_group"])):
            nodes = [{}] * 5
            self.assertEqual(groups.append_to(nodes, [(2, 1), (3, 2), (5, 3), (2, 4)], set(taken)), [5])
            self.assertEqual(nodes[5:], [{**group(index, name, children), "extras": extras} for index, name, children, extras in (
                (0, names[0], [6, 7, 8], old[4]["extras"]), (2, names[1], [1, 4], old[5]["extras"]), (3, names[2], [2], new[4]["extras"]),
                (5, names[3], [3], new[5]["extras"]))])
        nodes = [{}, {}]
        self.assertEqual((groups.append_to(nodes, [(None, 1)], set()), nodes), ([1], [{}, {}]))

    def test_a_bond_that_leads_nowhere_is_refused(self):
        bond = {"a": [1], "b": [2], "area": [1], "centroid": [[0, 0, 0]], "normal": [[0, 0, 0]], "strength": [1]}
        part = glb.Glb(small_glb(**self.delta(), bonds=bond))
        self.assertIn("bond", caught(merge, glb.Glb(small_glb()), part).detail)

    def test_only_what_the_server_calls_a_delta_is_put_together(self):
        """Only a forgotten answer is requested again by its parameters. Any other problem is the caller's."""
        def handler(asked):
            if asked.number == 0:
                return http_answer(200, small_glb(), digest(small_glb()) + "Content-Location: /fractures/sha256:1\r\n")
            return problem(422, "too-complex")
        with FaultServer(handler) as server, Client(server.url) as client:
            answer = client.mesh("sha256:" + "0" * 64).fracture()
            self.assertEqual(caught(answer.hit, (0, 0, 0), 1).type, "too-complex")
            self.assertEqual(len(server.asked), 2)
            self.assertEqual(copy.deepcopy(answer.figures), figures())

    def test_a_hit_has_the_origin_of_the_file_and_the_answer_that_of_its_root(self):
        document, binary = glb.Glb(small_glb()).document, b""
        document["nodes"][0]["translation"] = [500000, 30, 4649776]
        far = glb.pack(document, binary)
        asked = []

        class Mesh:
            def fracture(self, parameters, **_):
                asked.append(parameters)
                return Answer(far, self)

        answer = Answer(far, Mesh(), {"content-location": "/fractures/sha256:1"})
        self.assertEqual(answer.offset, (500000, 30, 4649776))
        self.assertEqual(Answer(small_glb()).offset, (0, 0, 0))
        answer.hit((0.5, 1, 2), 1)
        answer.hit([(0.5, 1, 2), (0, 0, 0)], 1)
        self.assertEqual([each["local_point"] for each in asked],
                         [[500000.5, 31, 4649778], [[500000.5, 31, 4649778], [500000, 30, 4649776]]])


if __name__ == "__main__":
    main()
