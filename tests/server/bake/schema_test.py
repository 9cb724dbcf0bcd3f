#!/usr/bin/env python3
"""Compares proto/bake/*.schema.json with `fracture-server bake`.

Every line of a report that the program writes fits its schema. If a schema refuses a manifest or rules, the
program refuses them as well, with exit code 2.

Usage: schema_test.py FRACTURE_SERVER [unittest arguments]. Exit code 77: Debian's python3-jsonschema is
missing.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import jsonschema
except ImportError:
    print("skipped: the Python package jsonschema is missing")
    sys.exit(77)

from gltf_box import box_with_camera

PROGRAM = ""
SCHEMAS = pathlib.Path(__file__).resolve().parents[3] / "proto" / "bake"

BOX = """o lid
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
"""
OPEN = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"

FITS, BREAKS = True, False
MANIFESTS = [
    (FITS, {"input": "box.obj", "output": "a.glb"}),
    (FITS, {"input": "./-", "output": "a.glb"}),
    (FITS, {"input": "box.obj", "output": "a.gltf", "parameters": {}}),
    (FITS, {"input": "box.obj", "output": "a.obj"}),
    (FITS, {"input": "box.obj", "output": "a.glb", "parameters": {"sites": 4, "pattern": "impact", "impacts": [[0, 0, 0]]}}),
    (BREAKS, []),
    (BREAKS, "box.obj"),
    (BREAKS, {}),
    (BREAKS, {"input": "box.obj"}),
    (BREAKS, {"output": "a.glb"}),
    (BREAKS, {"input": "", "output": "a.glb"}),
    (BREAKS, {"input": "-", "output": "a.glb"}),
    (BREAKS, {"input": "box.obj", "output": "-"}),
    (BREAKS, {"input": 3, "output": "a.glb"}),
    (BREAKS, {"input": "box.obj", "output": ["a.glb"]}),
    (BREAKS, {"input": "box.obj", "output": "a.glb", "parameters": [1]}),
    (BREAKS, {"input": "box.obj", "output": "a.glb", "parameters": None}),
    (BREAKS, {"input": "box.obj", "output": "a.glb", "sites": 4}),
]


def rule(match, parameters=None):
    return {"rules": [{"match": match, "parameters": {} if parameters is None else parameters}]}


RULES = [
    (FITS, rule({"path": "*"})),
    (FITS, rule({"path": ["a", "b"], "node": "lid", "material": "oak*"}, {"sites": 4})),
    (FITS, rule({"path": "a" * 1000})),
    (FITS, rule({"path": ["a"] * 100})),
    (FITS, {"rules": rule({"path": "*"})["rules"] * 1000}),
    (BREAKS, {"rules": rule({"path": "*"})["rules"] * 1001}),
    (BREAKS, rule({"path": ["a"] * 101})),
    (BREAKS, rule({"path": "a" * 1001})),
    (BREAKS, rule({"path": "a\0b"})),
    (BREAKS, rule({"path": ""})),
    (BREAKS, rule({"path": []})),
    (BREAKS, rule({"path": [""]})),
    (BREAKS, rule({"path": 1})),
    (BREAKS, rule({"path": ["a", 1]})),
    (BREAKS, rule({"path": None})),
    (BREAKS, rule({})),
    (BREAKS, rule([])),
    (BREAKS, rule("*")),
    (BREAKS, rule({"file": "*"})),
    (BREAKS, rule({"path": "*"}, [])),
    (BREAKS, rule({"path": "*"}, "sites=4")),
    (BREAKS, {"rules": [{"match": {"path": "*"}}]}),
    (BREAKS, {"rules": [{"parameters": {}}]}),
    (BREAKS, {"rules": [{"match": {"path": "*"}, "parameters": {}, "name": "a"}]}),
    (BREAKS, {"rules": [1]}),
    (BREAKS, {"rules": []}),
    (BREAKS, {"rules": {}}),
    (BREAKS, {"rules": rule({"path": "*"})["rules"], "version": 1}),
    (BREAKS, {}),
    (BREAKS, []),
    (BREAKS, 1),
]


def validator(name):
    schema = json.loads((SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


class Schemas(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for name, text in {"box.obj": BOX, "open.obj": OPEN, "holed.gltf": box_with_camera(missing=1)}.items():
            (self.folder / name).write_text(text, encoding="utf-8")

    def bake(self, *arguments):
        return subprocess.run([PROGRAM, "bake", *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=120, check=False)

    def write(self, name, *lines):
        (self.folder / name).write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")

    def test_every_line_of_a_report_fits(self):
        # A file that the mesh refers to is not overwritten. The bake knows it only after it has read the
        # mesh.
        (self.folder / "names.obj").write_text("mtllib e.glb\n" + BOX, encoding="utf-8")
        (self.folder / "e.glb").write_text("newmtl red\n", encoding="utf-8")
        (self.folder / "renderer").write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
        (self.folder / "renderer").chmod(0o755)
        few = {"sites": 4}
        self.write("m", {"input": "box.obj", "output": "a.glb", "parameters": few},
                   {"input": "holed.gltf", "output": "b.obj", "parameters": {**few, "keep_center": [99, 0, 0], "keep_radius": 1}},
                   {"input": "open.obj", "output": "c.glb", "parameters": few},
                   {"input": "absent.obj", "output": "d.glb"},
                   {"input": "names.obj", "output": "e.glb", "parameters": few},
                   {"input": "box.obj", "output": "g.glb", "parameters": {"nodes": "handle"}})
        fits = validator("report")
        for turn in ("made", "kept"):
            ended = self.bake("--manifest", "m", "-q", "--preview", "pictures", "--renderer", "renderer")
            self.assertNotEqual(ended.returncode, 2, ended.stderr)
            lines = [json.loads(line) for line in (self.folder / "m.report").read_text(encoding="utf-8").splitlines()]
            for line in lines:
                fits.validate(line)
            self.assertEqual([line["status"] for line in lines],
                             ["made", "made", "refused", "unreadable", "unwritable", "refused"], turn)
            self.assertIn("contains no part of the mesh", lines[1]["warnings"][0])
            self.assertIn("1 hole was filled", lines[1]["notes"][0])
            self.assertIn({"what": "camera", "name": "eye <1>"}, [{k: v for k, v in entry.items() if k != "reason"}
                                                              for entry in lines[1]["dropped"]])
            self.assertFalse({"warnings", "notes", "dropped"} & set(lines[0]), "nothing to say of a box")
            self.assertEqual(lines[5]["problem"]["known"], ["lid"])
            seen = set().union(*lines)
            self.assertEqual(seen, set(fits.schema["properties"]), "each member that is described is written")
            self.assertLessEqual(set(fits.schema["properties"]["certificate"]["properties"]),
                                 set(lines[0]["certificate"]))

    def test_lines_that_no_bake_writes_do_not_fit(self):
        self.write("m", {"input": "box.obj", "output": "a.glb", "parameters": {"sites": 4}},
                   {"input": "absent.obj", "output": "d.glb"})
        self.bake("--manifest", "m", "-q")
        made, unreadable = [json.loads(line) for line in
                            (self.folder / "m.report").read_text(encoding="utf-8").splitlines()]
        fits = validator("report")
        for line in (made, unreadable):
            self.assertTrue(fits.is_valid(line))
            for name in line:
                self.assertFalse(fits.is_valid({k: v for k, v in line.items() if k != name}), f"without {name}")
        for wrong in ({**made, "status": "done"}, {**made, "status": "refused"}, {**made, "digest": "sha256:0"},
                      {**made, "more": 1}, {**made, "problem": {"detail": "a"}}, {**made, "warnings": []}, {**made, "notes": []},
                      {**made, "dropped": []}, {**made, "dropped": [{"what": "camera"}]},
                      {**made, "beside": []}, {**made, "beside": [{"path": "a.mtl"}]},
                      {**made, "preview": {}}, {**made, "preview": "a.png"}, {**unreadable, "preview": {"file": "a.png"}},
                      {**unreadable, "problem": {}}, {**unreadable, "key": made["key"]},
                      {**unreadable, "problem": {"detail": "a", "request_id": "1"}}):
            self.assertFalse(fits.is_valid(wrong), wrong)

    def test_manifests_that_the_schema_refuses_are_refused(self):
        fits = validator("manifest")
        for verdict, line in MANIFESTS:
            with self.subTest(line=str(line)[:100]):
                self.assertEqual(fits.is_valid(line), verdict)
                self.write("m", line)
                ended = self.bake("--manifest", "m", "--explain")
                self.assertEqual(ended.returncode == 2, not verdict, ended.stderr)
                self.assertFalse((self.folder / "m.report").exists(), "--explain makes nothing")

    def test_rules_that_the_schema_refuses_are_refused(self):
        fits = validator("rules")
        for verdict, document in RULES:
            with self.subTest(document=str(document)[:100]):
                self.assertEqual(fits.is_valid(document), verdict)
                self.write("r", document)
                ended = self.bake("box.obj", "-o", "out/", "--rules", "r", "--explain")
                self.assertEqual(ended.returncode, 0 if verdict else 2, ended.stderr)
                if not verdict:
                    self.assertRegex(ended.stderr, "'r'")
                self.assertFalse((self.folder / "out").exists(), "--explain makes nothing")

    def test_explain_names_the_rule_and_where_each_parameter_comes_from(self):
        self.write("r", rule({"node": "l?d"}, {"material": "glass"}))
        self.write("m", {"input": "box.obj", "output": "a.glb", "parameters": {"sites": 4}},
                   {"input": "open.obj", "output": "b.glb"})
        ended = self.bake("--manifest", "m", "--rules", "r", "--explain", "--seed", "3", "--sites", "9")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(ended.stdout.splitlines(), [
            "box.obj -> a.glb", "  rule 1 of r: node 'l?d' matches 'lid'", '  assign=l?d:glass  (rule 1)',
            "  seed=3  (command line)", "  sites=4  (line 1 of the manifest)", "open.obj -> b.glb",
            "  no rule of r matches", "  seed=3  (command line)", "  sites=9  (command line)"])
        self.write("r", rule({"path": "*.fbx"}))
        ended = self.bake("--manifest", "m", "--rules", "r", "--explain")
        self.assertIn("Rule 1 of 'r' (path \"*.fbx\") matches no mesh.", ended.stderr)
        self.write("r", rule({"path": "*"}, {"colour": 3}))
        ended = self.bake("--manifest", "m", "--rules", "r")
        self.assertEqual(ended.returncode, 2)
        self.assertIn("Rule 1 of 'r': ", ended.stderr)
        self.assertFalse((self.folder / "a.glb").exists(), "nothing is made")


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
