#!/usr/bin/env python3
"""Tests how `fracture-server bake` handles names of files, nodes and materials that strangers chose.

Usage: names_test.py FRACTURE_SERVER [unittest arguments].
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""

BOX = """o lid
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
"""
FEW = ("--sites", "4", "-j", "1")


def rule(match, parameters=None):
    return {"match": match, "parameters": {} if parameters is None else parameters}


class Names(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def bake(self, *arguments, **more):
        return subprocess.run([PROGRAM, "bake", *arguments], cwd=self.folder, capture_output=True, timeout=120, check=False,
                              **more)

    def mesh(self, name, text=BOX):
        path = os.path.join(os.fsencode(self.folder), name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def rules(self, *rules):
        (self.folder / "r").write_text(json.dumps({"rules": rules}), encoding="utf-8")
        return "--rules", "r"

    def test_a_name_that_is_no_utf8_is_baked_and_so_are_the_others(self):
        for name in (b"in/a.obj", b"in/inv\xff.obj", b"in/lat\xe9/c.obj"):
            self.mesh(name)
        self.mesh(b"in/bad\xff.obj", "v 0 0 0\n")
        ended = self.bake("in/", "-o", "out/", *FEW)
        self.assertEqual(ended.returncode, 3, ended.stderr)
        for name in (b"out/a.obj.glb", b"out/inv\xff.obj.glb", b"out/lat\xe9/c.obj.glb"):
            self.assertTrue(os.path.exists(os.path.join(os.fsencode(self.folder), name)), name)
        lines = [json.loads(line) for line in (self.folder / "out/bake.ndjson").read_text(encoding="utf-8").splitlines()]
        self.assertEqual([line["status"] for line in lines], ["made", "refused", "made", "made"])
        self.assertIn(b"3 kept, 1 refused", self.bake("in/", "-o", "out/", *FEW).stdout)
        ended = self.bake("in/a.obj", "-o", b"q\xff.glb", "--report", "q.ndjson", *FEW)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertTrue(os.path.exists(os.path.join(os.fsencode(self.folder), b"q\xff.glb")))

    def test_explain_asks_no_server(self):
        self.mesh(b"a.obj")
        ended = self.bake("a.obj", "-o", "b.glb", "--explain", "--server", "http://127.0.0.1:1", "--seed", "3")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(ended.stderr, b"")
        self.assertEqual(ended.stdout, b"a.obj -> b.glb\n  seed=3  (command line)\n")

    def test_no_name_speaks_to_the_terminal(self):
        self.mesh(b"in/a\x1b[31m\n.obj")
        self.mesh(b"in/b.obj", "o c\x1b[2J\n" + BOX)
        for how in (("--explain",), ()):
            ended = self.bake("in/", "-o", "out/", *FEW, *self.rules(rule({"node": "c*"}, {"seed": 3})), *how)
            said = ended.stdout + ended.stderr
            self.assertEqual(ended.returncode, 0, said)
            self.assertNotIn(b"\x1b", said)
        (self.folder / "in/c\x1b[31m.obj").write_text("v 0 0 0\n", encoding="utf-8")
        ended = self.bake("in/", "-o", "out/", *FEW)
        self.assertEqual(ended.returncode, 3, ended.stderr)
        self.assertIn(b"in/c\\x1b[31m.obj", ended.stderr)
        self.assertNotIn(b"\x1b", ended.stderr)

    def test_an_empty_name_is_refused(self):
        self.mesh(b"a.obj")
        for flag in ("--rules", "--report", "--depfile", "--keep-failures", "--dump-stages", "--server"):
            ended = self.bake("a.obj", "-o", "b.glb", *FEW, flag, "")
            self.assertEqual(ended.returncode, 2, flag)
            self.assertIn(flag.encode(), ended.stderr)
        self.assertFalse((self.folder / "b.glb").exists())

    def test_rules_see_names_in_the_format_that_is_given(self):
        self.mesh(b"a.dat")
        for source, text in (("a.dat", None), ("-", BOX.encode())):
            ended = self.bake(source, "-o", "b.glb", "--format", "obj", "--explain", *self.rules(rule({"node": "lid"})), input=text)
            self.assertIn(b"node 'lid' matches 'lid'", ended.stdout, ended.stderr)

    def test_a_mesh_that_was_not_read_makes_no_rule_useless(self):
        self.mesh(b"a.obj")
        (self.folder / "m").write_text('{"input": "a.obj", "output": "a.glb"}\n{"input": "absent.obj", "output": "b.glb"}\n',
                                       encoding="utf-8")
        rules = self.rules(rule({"path": "absent*", "node": "x"}), rule({"path": "never*"}))
        for how in (("--explain",), ("--sites", "4", "--server", "http://127.0.0.1:1", "--explain"), ("--sites", "4")):
            ended = self.bake("--manifest", "m", *rules, *how)
            self.assertEqual(ended.returncode, 1, ended.stderr)
            self.assertNotIn(b"Rule 1 ", ended.stderr)
            self.assertIn(b"Rule 2 of 'r' (path \"never*\") matches no mesh.", ended.stderr)

    def test_matching_is_refused_beyond_its_limit_and_the_rest_is_baked(self):
        self.mesh(b"in/big.obj", "".join(f"o {'a' * 100}{k}\n" for k in range(20000)) + BOX)
        self.mesh(b"in/small.obj")
        patterns = [f"*a*a*{k}b" for k in range(40)]
        rules = self.rules(*[rule({"node": patterns})] * 1000)
        ended = self.bake("in/", "-o", "out/", *FEW, *rules)
        self.assertEqual(ended.returncode, 3, ended.stderr)
        self.assertIn(b"in/big.obj: too-large", ended.stderr)
        self.assertTrue((self.folder / "out/small.obj.glb").exists())

    def test_a_stop_ends_matching(self):
        for k in range(200):  # Each of them takes about a second.
            self.mesh(b"in/%03d.obj" % k, "".join(f"o {'a' * 100}{k}\n" for k in range(2000)) + BOX)
        rules = self.rules(*[rule({"node": [f"*a*a*{k}b" for k in range(40)]})] * 1000)
        with subprocess.Popen([PROGRAM, "bake", "in/", "-o", "out/", *FEW, *rules], cwd=self.folder,
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            self.assertTrue(process.stderr.read(1))  # the first one is done
            process.send_signal(signal.SIGTERM)
            start = time.monotonic()
            process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130)
            self.assertLess(time.monotonic() - start, 60)


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
