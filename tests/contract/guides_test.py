#!/usr/bin/env python3
"""guides_test.py FRACTURE_SERVER: runs the commands of README.md and proto/guides, because a reader copies them.

Every indented block with curl or bake that needs only a server and a mesh is run. It runs in a folder with a
barrel.glb, against a server on free ports. NOT_RUN names blocks that need other programs or machines.
"""
import hashlib
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "proto" / "guides").glob("*.md"))]
PATIENCE = 120
# Parts of blocks that install, build, stop or restart something, or that ask a remote server.
NOT_RUN = ("scripts/", "cmake --", "systemctl", "docker compose", "kubectl", "kill ", "example.org", "fracture-server serve", "serve --port")
SIDES = (0.9, 2.0, 0.9)  # half of x, the height, half of z, in metres


def barrel():
    """Returns a box of 1.8 x 2 x 1.8 m on the ground as a GLB, with the names that the guides use."""
    corners = [(sx * SIDES[0], y, sz * SIDES[2]) for y in (0.0, SIDES[1]) for sx, sz in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    quads = [(0, 1, 2, 3), (7, 6, 5, 4), (4, 5, 1, 0), (5, 6, 2, 1), (6, 7, 3, 2), (7, 4, 0, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    positions = b"".join(struct.pack("<3f", *c) for c in corners)
    indices = b"".join(struct.pack("<3H", *t) for t in triangles)
    low, high = [list(map(ends, zip(*corners))) for ends in (min, max)]
    document = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "barrel_large", "mesh": 0}],
        "materials": [{"name": "staves"}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": low, "max": high},
                      {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(positions)},
                        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(positions) + len(indices)}]}).encode()
    document += b" " * (-len(document) % 4)
    binary = positions + indices
    size = 12 + 8 + len(document) + 8 + len(binary)
    head = struct.pack("<4s2I", b"glTF", 2, size)
    return head + struct.pack("<I4s", len(document), b"JSON") + document + struct.pack("<I4s", len(binary), b"BIN\0") + binary


def blocks(text):
    """Yields the indented blocks of a page that are commands, as (line, text)."""
    for found in re.finditer(r"(?:^ {4}.*\n)+", text, re.MULTILINE):
        block = re.sub(r"^ {4}", "", found.group(), flags=re.MULTILINE)
        if re.search(r"\bcurl |fracture-server bake", block) and not any(part in block for part in NOT_RUN):
            yield text.count("\n", 0, found.start()) + 1, block


class Guides(unittest.TestCase):
    server = None

    def serve(self, *flags):
        """Starts a server that runs until the end of the test. Returns its port."""
        command = [self.server, "serve", "--port", "0", "--admin-port", "0", "--drain-delay", "0", "--log-format", "text", *flags]
        program = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        too_late = threading.Timer(PATIENCE, program.kill)
        too_late.start()
        self.addCleanup(program.stderr.close)
        self.addCleanup(program.wait, PATIENCE)
        self.addCleanup(program.terminate)
        self.addCleanup(too_late.cancel)
        log = ""
        for line in program.stderr:
            log += line
            found = re.search(r":(\d+) \(admin port \d+\)", line)
            if found:
                return found[1]
        return self.fail(log)

    def setUp(self):
        self.port = self.serve()

    def test_commands_work_as_they_stand(self):
        count = 0
        with tempfile.TemporaryDirectory(prefix="fracture-test-") as folder:
            place = pathlib.Path(folder)
            (place / "barrel.glb").write_bytes(barrel())
            (place / "assets").mkdir()
            (place / "assets" / "statue.glb").write_bytes(barrel())
            (place / "build/release").mkdir(parents=True)
            (place / "build/release/server").symlink_to(self.server.parent)
            for page in PAGES:
                text = page.read_text(encoding="utf-8")
                for rules in re.findall(r'^ {4}(\{"rules": .*(?:\n {4}.*)*)', text, re.MULTILINE):
                    (place / "marble.json").write_text(re.sub(r"^ {4}", "", rules, flags=re.MULTILINE), encoding="utf-8")
                for line, block in blocks(text):
                    with self.subTest(page=str(page.relative_to(ROOT)), line=line):
                        commands = block.replace("127.0.0.1:8080", f"127.0.0.1:{self.port}")
                        done = subprocess.run(["bash", "-euo", "pipefail", "-c", commands], cwd=place, text=True, capture_output=True,
                                              timeout=PATIENCE, env={**os.environ, "LC_ALL": "C.UTF-8"})
                        self.assertEqual(done.returncode, 0, commands + done.stdout[-500:] + done.stderr[-500:])
                        count += 1
        self.assertGreater(count, 10)

    def test_the_exact_number_is_exact(self):
        page = (ROOT / "proto/guides/exact-number-of-pieces.md").read_text(encoding="utf-8")
        block = next(block for _, block in blocks(page) if "python3" in block)
        with tempfile.TemporaryDirectory(prefix="fracture-test-") as folder:
            pathlib.Path(folder, "barrel.glb").write_bytes(barrel())
            commands = block.replace("127.0.0.1:8080", f"127.0.0.1:{self.port}")
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", commands], cwd=folder, text=True, check=True, capture_output=True,
                                  timeout=PATIENCE)
            self.assertEqual(done.stdout.split()[-1], "50")

    def test_the_team_may_send_jobs(self):
        """Blender sends jobs, and the guide says that its users can use Blender."""
        page = (ROOT / "proto/guides/team-server.md").read_text(encoding="utf-8")
        tokens = json.loads(re.search(r'^ {4}(\{"tenants": .*(?:\n {4}.*)*)', page, re.MULTILINE)[1])
        secret = "0123456789abcdef"
        with tempfile.TemporaryDirectory(prefix="fracture-test-") as folder:
            for number, tenant in enumerate(tokens["tenants"]):
                tenant["tokens"] = [{"sha256": hashlib.sha256(f"{secret}{number}".encode()).hexdigest()}]
            path = pathlib.Path(folder, "tokens")
            path.write_text(json.dumps(tokens), encoding="utf-8")
            port = self.serve("--token-file", str(path))
            for number, tenant in enumerate(tokens["tenants"]):
                with self.subTest(name=tenant["name"]):
                    headers = {"Authorization": f"Bearer {secret}{number}", "Content-Type": "model/gltf-binary", "Prefer": "respond-async"}
                    request = urllib.request.Request(f"http://127.0.0.1:{port}/fracture?fragments=4", barrel(), headers)
                    with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
                        self.assertEqual(answer.status, 202)


if __name__ == "__main__":
    Guides.server = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
