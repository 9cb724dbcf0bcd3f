#!/usr/bin/env python3
"""example_test.py EXAMPLE: runs the example of common/README.md on a cube, and compares the page with the
file that was compiled."""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CUBE = "\n".join([f"v {x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1)] +
                 ["f 1 2 4 3", "f 5 7 8 6", "f 1 5 6 2", "f 3 4 8 7", "f 1 3 7 5", "f 2 6 8 4", ""])


class Example(unittest.TestCase):
    def test_breaks_a_cube_whose_volumes_add_up(self):
        with tempfile.TemporaryDirectory(prefix="fracture-test-") as folder:
            mesh, glb = pathlib.Path(folder, "cube.obj"), pathlib.Path(folder, "fragments.glb")
            mesh.write_text(CUBE)
            said = subprocess.run([program, mesh, glb], text=True, capture_output=True, check=True).stdout
            self.assertEqual(said, "20 fragments, volume 1 of 1 m3\n")
            data = glb.read_bytes()
            document = json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])
            certificate = document["nodes"][document["scenes"][0]["nodes"][0]]["extras"]["fracture"]["certificate"]
            self.assertEqual(certificate["fragments"], 20)
            self.assertEqual(certificate["open_edges"], 0)

    def test_says_why_a_mesh_is_refused(self):
        with tempfile.TemporaryDirectory(prefix="fracture-test-") as folder:
            mesh = pathlib.Path(folder, "triangle.obj")
            mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            done = subprocess.run([program, mesh, "unwritten.glb"], text=True, capture_output=True)
            self.assertEqual(done.returncode, 3)
            self.assertNotEqual(done.stderr, "")

    def test_the_readme_shows_what_is_compiled(self):
        source = (ROOT / "tests/pipeline/example.cpp").read_text()
        shown = source[source.index("  const Execution execution"):source.index("  std::ofstream(")]
        shown = "".join(line[2:] if line.startswith("  ") else line for line in shown.splitlines(True))
        readme = (ROOT / "common/README.md").read_text()
        block = readme[readme.index("```cpp\n") + 7:]
        self.assertEqual(block[:block.index("```")], shown, "copy the lines of tests/pipeline/example.cpp into common/README.md")


if __name__ == "__main__":
    program = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
