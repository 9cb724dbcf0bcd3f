#!/usr/bin/env python3
"""Everything in the JSON of a glTF file is in its answer, is applied to it, or is listed in `report.dropped`.

Usage: round_trip_test.py FRACTURE_SERVER DEFAULT_FOLDERS [unittest arguments]. The files are all GLB and glTF files in the folders of
FRACTURE_TEST_MESHES (or the default ones), and in folders called "import" next to them.
"""
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

import round_trip
from gltf_box import box_with_camera

PROGRAM, FOLDERS = "", []


def bake(source, output, *arguments):
    return subprocess.run([PROGRAM, "bake", str(source), "-o", str(output), "--sites", "30", "--force", "-q", *arguments],
                          capture_output=True, text=True, timeout=300, check=False)


class RoundTrip(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.output = self.folder / "out.glb"

    def test_of_all_files(self):
        if not FOLDERS:
            self.skipTest("FRACTURE_TEST_MESHES names no folder of meshes")
        files = sorted({path for folder in FOLDERS for path in folder.rglob("*") if path.suffix.lower() in (".glb", ".gltf")})
        read = 0
        for path in files:
            with self.subTest(path=str(path)):
                self.output.unlink(missing_ok=True)
                ended = bake(path, self.output)
                if ended.returncode == 3:  # refused
                    self.assertIn("unsupported-feature", ended.stderr)
                    continue
                self.assertEqual(ended.returncode, 0, ended.stderr)
                self.assertEqual(round_trip.lost(path, self.output), [])
                read += 1
        self.assertGreater(read, len(files) * 3 // 4)

    def made(self, change):
        """Bakes the box after change(document). Returns the paths of both files."""
        document = json.loads(box_with_camera())
        change(document)
        source = self.folder / "box.gltf"
        source.write_text(json.dumps(document), encoding="utf-8")
        ended = bake(source, self.output)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return source, self.output

    def test_of_what_a_file_can_contain(self):
        def change(document):
            variants = {"mappings": [{"material": 1, "variants": [0]}]}
            document.update({
                "extras": {"a": 1}, "materials": [{"name": "Paint", "extras": {"shader": "x"}}, {"name": "Snow"}],
                "extensionsUsed": ["KHR_materials_variants", "KHR_lights_punctual", "KHR_xmp_json_ld", "ACME_wind"],
                "extensions": {"KHR_materials_variants": {"variants": [{"name": "winter"}]},
                               "KHR_lights_punctual": {"lights": [{"type": "point", "name": "lamp"}]}},
                "samplers": [{"name": "nearest", "magFilter": 9728}], "textures": [{"sampler": 0, "source": 0}],
                "images": [{"uri": "absent.png"}], "animations": [{"name": "spin", "channels": [], "samplers": []}]})
            document["asset"].update({"copyright": "CC0", "extras": {"b": 2}})
            document["scenes"] += [{"name": "other", "nodes": [3]}]
            document["scenes"][0]["nodes"] += [2]
            document["nodes"] += [
                {"name": "socket", "translation": [1, 2, 3], "extras": {"slot": [1]}},
                {"name": "elsewhere", "mesh": 0}]
            document["nodes"][0].update({"extras": {"hp": 5}, "extensions": {"ACME_wind": {}}})
            mesh = document["meshes"][0]
            mesh.update({"name": "Cube", "extras": {"c": 3}})
            mesh["primitives"][0].update({"material": 0, "extras": {"d": 4}, "extensions": {"KHR_materials_variants": variants}})
        source, output = self.made(change)
        self.assertEqual(round_trip.lost(source, output), [])
        answer = round_trip.Gltf(output).json
        kept = [p["extensions"]["KHR_materials_variants"] for m in answer["meshes"] for p in m["primitives"] if p.get("material") == 0]
        self.assertTrue(kept)
        for extension in kept:
            self.assertEqual(extension, {"mappings": [{"material": 1, "variants": [0]}]})

    def test_finds_what_the_list_leaves_out(self):
        source, output = self.made(lambda document: document["nodes"][0].update(extras={"hp": 5}))
        data = output.read_bytes()
        size = struct.unpack_from("<I", data, 12)[0]
        text = json.loads(data[20:20 + size])
        report = next(n["extras"]["fracture"]["report"] for n in text["nodes"] if "report" in n.get("extras", {}).get("fracture", {}))
        report["dropped"] = []
        for node in text["nodes"]:
            node.get("extras", {}).pop("hp", None)
        changed = self.folder / "changed.gltf"
        changed.write_text(json.dumps(text), encoding="utf-8")
        self.assertEqual(round_trip.lost(source, changed), ["camera eye <1>", "extras box"])


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    default = sys.argv.pop(1)
    given = [pathlib.Path(name) for name in (os.environ.get("FRACTURE_TEST_MESHES") or default).split(":") if name]
    FOLDERS = [folder for folder in sorted({*given, *(path.parent / "import" for path in given)}) if folder.is_dir()]
    unittest.main()
