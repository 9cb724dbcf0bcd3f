"""Entries of `assign`, and what a server makes of them in a request's JSON."""
import json
import unittest

from support import main

from fracture_client import assignment
from fracture_client.upload import json_text


class Assignments(unittest.TestCase):
    def test_an_entry_has_its_selectors_material_and_parameters(self):
        self.assertEqual(assignment("glass", node="Window*"), {"node": "Window*", "material": "glass"})
        self.assertEqual(assignment("wood", slot=("Oak", "Pine*"), part=[3, 4], stretch=6),
                         {"slot": ["Oak", "Pine*"], "part": [3, 4], "material": "wood", "stretch": 6})
        self.assertEqual(assignment(part=0, rough_amplitude=0.1), {"part": 0, "rough_amplitude": 0.1})

    def test_an_entry_without_parts_or_properties_is_refused(self):
        for wrong in (lambda: assignment("glass"), lambda: assignment(node="a")):
            with self.assertRaises(ValueError):
                wrong()

    def test_entries_are_sent_as_json(self):
        sent = json.loads(json_text({"assign": [assignment("glass", node="Window*")]}))
        self.assertEqual(sent, {"assign": [{"node": "Window*", "material": "glass"}]})


if __name__ == "__main__":
    main()
