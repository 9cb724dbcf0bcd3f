#!/usr/bin/env python3
"""Tests `fracture-server bake --preview` and `--html` as a user runs them.

preview_test.py FRACTURE_SERVER uses scripts as renderers that do what a renderer must not do.
preview_test.py FRACTURE_SERVER FRACTURE_RENDER uses the real renderer. Exit code 77: no OpenGL here.
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest
import urllib.parse

from gltf_box import box_with_camera
from preview_support import BOX, OPEN, Case, ScriptCase, png

RENDERER = ""


class WithScripts(ScriptCase):
    def test_one_picture_of_one_mesh(self):
        renderer = self.renderer()
        self.bake("in/box.obj", "-o", "box.glb", "--preview", "pictures/box.png", *renderer)
        self.assertEqual(png(self.folder / "pictures/box.png")[:2], (512, 512))
        self.bake("in/box.obj", "-o", "box.glb", "--preview", "small.png", "--preview-size", "64", *renderer)
        self.assertEqual(png(self.folder / "small.png")[:2], (64, 64))
        told = self.bake("-", "-o", "-", "--format", "obj", "--preview", "piped.png", *renderer, data=BOX.encode())
        self.assertEqual(told, (self.folder / "box.glb").read_bytes(), "standard output has the fragments and no words")
        self.assertEqual(png(self.folder / "piped.png")[:2], (512, 512))
        self.assertEqual(list(pathlib.Path(self.folder).rglob(".*.part")), [])

    def test_pictures_of_many_are_drawn_by_few_processes_and_only_once(self):
        renderer = self.renderer()
        many = ["in", "-o", "out", "-j", "1", "--allow-refused", "1", "--preview", "pictures", *renderer]
        self.bake(*many)
        drawn = ["pictures/box.obj.glb.png", "pictures/sub/holed.obj.glb.png"]
        self.assertEqual(self.files("pictures"), drawn)
        self.assertEqual(png(self.folder / drawn[0])[:2], (256, 256))
        self.assertEqual(self.starts(), 1)
        lines = self.report()
        self.assertEqual([line.get("preview") for line in lines],
                         [{"file": drawn[0]}, None, {"file": drawn[1]}], "what was refused has no picture")
        before = [(self.folder / name).stat().st_mtime_ns for name in drawn]
        self.bake(*many)
        self.assertEqual(self.starts(), 1, "nothing to draw, no renderer")
        self.assertEqual([(self.folder / name).stat().st_mtime_ns for name in drawn], before)
        self.assertEqual(self.report(), lines)

        (self.folder / drawn[0]).unlink()
        self.bake(*many)
        self.assertEqual(self.starts(), 2)
        self.assertEqual(png(self.folder / drawn[0])[:2], (256, 256), "missing: drawn again")
        output = self.folder / "out/box.obj.glb"
        later = (self.folder / drawn[0]).stat().st_mtime + 10
        os.utime(output, (later, later))
        self.bake(*many)
        self.assertEqual(self.starts(), 3, "older than its output: drawn again")
        os.utime(output, (1, 1))
        self.bake(*many, "--preview-size", "128")
        self.assertEqual([png(self.folder / name)[0] for name in drawn], [128, 128], "of another size: drawn again")
        self.assertEqual(self.starts(), 4)
        self.bake(*many, "--preview-size", "128", "--seed", "5")
        self.assertEqual(self.starts(), 5, "made again: drawn again")

    def test_without_a_renderer_a_preview_is_refused_before_anything_is_made(self):
        bare = self.folder / "bin"
        bare.mkdir()
        for name in ("fracture-server", "fracture-import"):
            os.link(pathlib.Path(self.program).with_name(name), bare / name) if os.stat(self.program).st_dev == os.stat(
                bare).st_dev else (bare / name).write_bytes(pathlib.Path(self.program).with_name(name).read_bytes())
            (bare / name).chmod(0o755)

        def alone(*arguments, code):
            ended = subprocess.run([str(bare / "fracture-server"), "bake", *arguments], cwd=self.folder,
                                   capture_output=True, text=True, timeout=120, check=False,
                                   env={"PATH": str(self.folder / "empty")})
            self.assertEqual(ended.returncode, code, ended.stderr)
            return ended.stderr
        said = alone("in/box.obj", "-o", "box.glb", "--preview", "box.png", code=2)
        self.assertIn("no-program: fracture-render was not found", said)
        self.assertIn("--renderer", said)
        self.assertNotIn("box.glb", self.files())
        said = alone("in/box.obj", "-o", "box.glb", "--html", "r.html", "--renderer", "absent", code=2)
        self.assertIn("'absent'", said)
        self.assertNotIn("box.glb", self.files())
        said = alone("in", "-o", "out", "--html", "r.html", "--sites", "5", code=3)
        self.assertIn("no pictures are drawn: fracture-render was not found", said)
        page = self.page()
        self.assertEqual(page.pictures, [])
        self.assertIn("No pictures were drawn: fracture-render was not found", page.text)
        self.assertEqual(len(page.meshes()), 3)

    def test_a_renderer_that_hangs_crashes_or_lies_is_a_warning(self):
        ends = {"hangs": ("    signal.pause()", "did not answer within 1 s"),
                "dies": ("    os.kill(os.getpid(), 11)", "ended by signal 11"),
                "leaves": ("    sys.stderr.write('no\\x1b[31m display'); sys.exit(7)", "ended with exit code 7: no [31m display"),
                "babbles": ("    print('hello', flush=True)", "does not answer like fracture-render"),
                "floods": ("    print('x' * 1000000, flush=True)", "does not answer like fracture-render"),
                "refuses": ("    print('{\"output\": null, \"problem\": {\"detail\": \"' + line['file'] + ' has too much.\"}}', "
                            "flush=True); continue", "box.glb has too much."),
                "draws nothing": ("    print('{\"output\": 1}', flush=True); continue", "did not write a PNG of 512 x 512"),
                "draws another size": ("    width = 3", "did not write a PNG of 512 x 512")}
        for name, (body, why) in ends.items():
            with self.subTest(name):
                renderer = self.renderer(body)
                begun = time.monotonic()
                self.bake("in/box.obj", "-o", "box.glb", "--preview", "box.png", "--report", "report", "--force",
                          "--preview-timeout", "1", *renderer)
                self.assertLess(time.monotonic() - begun, 60, "a wait has an end")
                self.assertIn("box.glb: warning: no picture: ", self.words)
                line, = self.report("report")
                self.assertEqual(line["status"], "made")
                self.assertEqual(line["preview"]["file"], "box.png")
                self.assertIn(why, line["preview"]["warning"])
                self.assertNotIn("\x1b", self.words, "no colours for a terminal")
                self.assertFalse((self.folder / "box.png").exists())
        for pid in (self.folder / "log").read_text(encoding="utf-8").split():
            self.assertFalse(pathlib.Path(f"/proc/{pid}").exists(), "no process is left behind")
        self.write("renderer", "no program").chmod(0o755)
        self.bake("in/box.obj", "-o", "box.glb", "--preview", "box.png", "--renderer", "renderer", "--force")
        self.assertIn("cannot be started", self.words)

    def test_a_renderer_that_fails_again_and_again_is_given_up(self):
        for k in range(8):
            self.write(f"many/{k}.obj", BOX)
        self.bake("many", "-o", "out", "-j", "1", "--preview", "p", *self.renderer("    sys.exit(1)"))
        self.assertEqual(self.starts(), 3)
        self.assertIn("failed 3 times in a row", self.words)
        self.assertEqual([line["status"] for line in self.report()], ["made"] * 8)
        self.assertTrue(all("warning" in line["preview"] for line in self.report()))

    def test_a_stop_ends_a_picture(self):
        log = self.folder / "log"
        with subprocess.Popen([self.program, "bake", "in/box.obj", "-o", "box.glb", "--preview", "box.png", "--report", "r",
                               *self.renderer("    signal.pause()")], cwd=self.folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE) as child:
            deadline = time.monotonic() + 60
            while not log.exists() and time.monotonic() < deadline:
                time.sleep(0.02)  # pause: between two looks, until the deadline
            child.send_signal(signal.SIGTERM)
            child.communicate(timeout=60)
        line, = self.report("r")
        self.assertEqual(line["status"], "made", "what is made stays")
        self.assertNotIn("preview", line)

    def test_the_token_is_not_given_to_the_renderer(self):
        body = f"    open({str(self.folder / 'seen')!r}, 'w').write(json.dumps(dict(os.environ)))"
        self.bake("in/box.obj", "-o", "box.glb", "--preview", "box.png", *self.renderer(body),
                  environment={"FRACTURE_TOKEN": "secret-of-ours"})
        self.assertNotIn("secret-of-ours", (self.folder / "seen").read_text(encoding="utf-8"))

    def test_the_page_lists_dropped_things(self):
        self.write("eye.gltf", box_with_camera())
        self.bake("eye.gltf", "-o", "eye.glb", "--html", "eye.html", "--report", "r", *self.renderer())
        dropped = self.report("r")[0]["dropped"]
        row, = self.page("eye.html").meshes()[-1:]
        self.assertIn(f"Dropped: {len(dropped)}", row[-1])
        for entry in dropped:
            self.assertIn(f"{entry['what']} {entry['name']}: {entry['reason']}", row[-1])
        self.assertIn("eye <1>", [entry["name"] for entry in dropped])

    def test_the_page_has_a_row_for_each_job_the_slowest_first(self):
        renderer = self.renderer()
        self.bake("in", "-o", "out", "-j", "1", "--allow-refused", "1", "--html", "night/r.html", *renderer)
        page, lines = self.page("night/r.html"), self.report()
        rows = page.meshes()
        self.assertEqual(len(rows), len(lines))
        self.assertIn("open.obj", "".join(rows[0]))
        self.assertIn(lines[1]["problem"]["type"].rsplit("/", 1)[1], "".join(rows[0]))
        self.assertIn(lines[1]["problem"]["detail"], "".join(rows[0]))
        made = sorted((line for line in lines if line["status"] == "made"), key=lambda line: -line["seconds"])
        for row, line in zip(rows[1:], made):
            self.assertIn(line["input"], row[1])
            self.assertEqual(row[2], str(line["certificate"]["fragments"]))
            for sentence in line.get("warnings", []) + line.get("notes", []):
                self.assertIn(sentence, row[-1])
            self.assertEqual("Notes: 1" in row[-1], "holed" in line["input"])
        self.assertEqual([urllib.parse.unquote(picture["src"]) for picture in page.pictures],
                         [os.path.relpath(line["preview"]["file"], "night") for line in made])
        for picture in page.pictures:
            self.assertTrue((self.folder / "night" / urllib.parse.unquote(picture["src"])).exists())
            self.assertEqual(picture["loading"], "lazy")
        self.assertEqual(page.tags & {"script", "iframe", "object", "embed", "link", "form", "base"}, set())
        self.assertTrue(all(link.startswith(("#", "r.pictures/")) for link in page.links), page.links)
        again = self.bake("in", "-o", "out", "-j", "1", "--allow-refused", "1", "--html", "night/r.html", *renderer)
        self.assertIn(b"page in night/r.html", again)
        self.assertEqual(self.page("night/r.html").meshes(), rows, "what was kept has its row, too")
        self.assertEqual(self.starts(), 1)

    def test_names_are_text(self):
        names = ['<script>alert(1)<&script>.obj', 'a" onerror="alert(1).obj', "b'><img src=x onerror=alert(1)>.obj",
                 "javascript:alert(1).obj", "c?d#e%41&amp;.obj", "\u202ejbo.obj", "-o.obj", "new\nline.obj"]
        for name in names:
            self.write("evil/" + name, BOX)
        raw = os.fsencode(self.folder) + b"/evil/no\xff.obj"
        with open(raw, "w", encoding="utf-8") as file:
            file.write(BOX)
        self.write("evil/<b>open&.obj", OPEN)
        for turn in range(2):
            self.bake("evil", "-o", "out", "--html", "r.html", "--allow-refused", "1", *self.renderer())
            page = self.page()
            self.assertEqual(len(page.meshes()), len(names) + 2)
            self.assertEqual(page.tags & {"script", "b"}, set())
            self.assertEqual(len(page.pictures), len(names) + 1)
            shown = [urllib.parse.unquote(picture["src"]) for picture in page.pictures]
            for source in shown:
                self.assertTrue((self.folder / source).is_file(), source)
            for name in names:
                self.assertIn(f"r.pictures/{name}.glb.png", shown)
                self.assertIn("evil/" + name.replace("\n", " "), page.text)
            self.assertIn("evil/no\ufffd.obj", page.text)
            self.assertLessEqual(self.starts(), (os.cpu_count() or 1), f"turn {turn}: what is right is kept, whatever it is called")

    def test_what_lies_there_is_not_lost(self):
        renderer = self.renderer()
        note = self.write("note.html", "<p>mine</p>")
        self.bake("in", "-o", "out", "--html", "note.html", *renderer, code=2)
        self.assertIn("was not written by a bake", self.words)
        self.assertEqual(note.read_text(encoding="utf-8"), "<p>mine</p>")
        for wrong in (["in", "-o", "out", "--preview", "x.png"], ["in", "-o", "out", "--preview", "in/box.obj"],
                      ["in", "-o", "out", "--preview", "-"], ["in", "-o", "out", "--html", "-"],
                      ["in/box.obj", "-o", "box.glb", "--preview", "box.jpg"],
                      ["in/box.obj", "-o", "x.glb", "--html", "x.glb"],
                      ["in/box.obj", "-o", "x.glb", "--preview", "x.png", "--html", "x.png"],
                      ["in/box.obj", "-o", "x.glb", "--html", "in/box.obj"],
                      ["in/box.obj", "-o", "x.glb", "--html", "in"],
                      ["in/box.obj", "-o", "x.glb", "--preview", "x.png", "--preview-size", "1"],
                      ["in/box.obj", "-o", "x.glb", "--preview", "x.png", "--preview-timeout", "0"],
                      ["in/box.obj", "-o", "x.glb"]):
            with self.subTest(wrong=wrong):
                before = self.files()
                self.bake(*wrong, *renderer, code=2)
                self.assertEqual(self.files(), before)

        # A preview does not overwrite a texture of the mesh.
        texture = b"\x89PNG not ours"
        (self.folder / "in/wood.png").write_bytes(texture)
        self.write("in/m.mtl", "newmtl wood\nmap_Kd wood.png\n")
        self.write("in/textured.obj", "mtllib m.mtl\nusemtl wood\n" + BOX)
        self.bake("in/textured.obj", "-o", "t.glb", "--preview", "in/wood.png", *renderer)
        self.assertIn("not overwritten", self.words)
        self.assertEqual((self.folder / "in/wood.png").read_bytes(), texture)

    def test_each_shard_has_its_page(self):
        manifest = [{"input": "in/box.obj", "output": "../a.glb"}, {"input": "in/box.obj", "output": "o/b.glb"}]
        self.write("work/m", "".join(json.dumps({**line, "input": "../in/box.obj"}) + "\n" for line in manifest))
        for k in range(2):
            self.bake("--manifest", "work/m", "--shard", f"{k}/2", "--html", "r.html", *self.renderer())
        self.assertEqual(self.files("r.pictures"), ["r.pictures/o/b.glb.png", "r.pictures/up/a.glb.png"])
        for k in range(2):
            self.assertEqual(len(self.page(f"r.{k}-of-2.html").meshes()), 1)


class WithTheRenderer(Case):
    def test_a_picture_shows_the_fragments_of_its_material(self):
        seen = {}
        for material in ("glass", "wood"):
            ended = subprocess.run([self.program, "bake", "in/box.obj", "-o", "x.glb", "--material", material, "--preview",
                                    f"{material}.png", "--preview-size", "128", "--renderer", RENDERER], cwd=self.folder,
                                   capture_output=True, text=True, timeout=300, check=False)
            self.assertEqual(ended.returncode, 0, ended.stderr)
            self.assertNotIn("no picture", ended.stderr)
            width, height, channels, rows = png(self.folder / f"{material}.png")
            self.assertEqual((width, height), (128, 128))
            colors = {row[x:x + channels] for row in rows for x in range(0, len(row), channels)}
            self.assertGreater(len(colors), 200, "something with light and shadow is there")
            seen[material] = rows
        pairs = [(a, b) for one, two in zip(seen["glass"], seen["wood"]) for a, b in zip(one, two)]
        self.assertGreater(sum(abs(a - b) > 16 for a, b in pairs) / len(pairs), 0.05, "other materials look otherwise")

    def test_many_and_their_page(self):
        (self.folder / "in/broken.obj").write_text("v nan", encoding="utf-8")
        self.bake("in", "-o", "out", "--allow-refused", "2", "--html", "r.html", "--preview-size", "64", "--renderer", RENDERER)
        page = self.page()
        self.assertEqual(len(page.pictures), 2)
        for picture in page.pictures:
            width, height, _, rows = png(self.folder / picture["src"])
            self.assertEqual((width, height), (64, 64))
            self.assertGreater(len(set(b"".join(rows))), 20)
        self.bake("in/box.obj", "-o", "box.gltf", "--preview", "gltf.png", "--preview-size", "64", "--renderer", RENDERER)
        self.assertEqual(png(self.folder / "gltf.png")[:2], (64, 64))
        told = self.bake("in/box.obj", "-o", "-", "--preview", "piped.png", "--preview-size", "64", "--renderer", RENDERER)
        self.assertTrue(told.startswith(b"glTF"))
        self.assertEqual(png(self.folder / "piped.png")[3], png(self.folder / "gltf.png")[3], "the same fragments")


if __name__ == "__main__":
    Case.program = str(pathlib.Path(sys.argv.pop(1)).resolve())
    if len(sys.argv) > 1 and not sys.argv[1].startswith("-") and os.path.exists(sys.argv[1]):
        RENDERER = str(pathlib.Path(sys.argv.pop(1)).resolve())
        if subprocess.run([RENDERER, "--list"], stdin=subprocess.DEVNULL, timeout=120, check=False).returncode == 1:
            print("skipped: no OpenGL here")
            sys.exit(77)
        del WithScripts
    else:
        del WithTheRenderer
    unittest.main()
