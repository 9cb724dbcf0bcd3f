#!/usr/bin/env python3
"""python -m fracture_client and the example, as separate programs: what they write and print, and their exit codes."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

from support import PACKAGE, PATIENCE, ROOT, FaultServer, Reply, WithServer, answer, box_obj, deserted_url, digest, eventually, \
    main, problem, small_glb, stored
from fracture_client import Answer, Client, command

EXAMPLE = ROOT / "client" / "examples" / "integrate.py"


class Programs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.mesh = self.folder / "b\u00f6x.obj"
        self.mesh.write_bytes(box_obj())
        self.out = self.folder / "out.glb"

    def environment(self, **more):
        kept = {name: value for name, value in os.environ.items() if name not in ("FRACTURE_TOKEN", "PYTHONPATH")}
        return {**kept, "PYTHONPATH": str(PACKAGE), "PYTHONDONTWRITEBYTECODE": "1", "PYTHONIOENCODING": "utf-8", **more}

    def run_command(self, *arguments, **environment):
        return self.run_program([sys.executable, "-m", "fracture_client", *map(str, arguments)], **environment)

    def run_program(self, arguments, **environment):
        return subprocess.run(arguments, cwd=self.folder, env=self.environment(**environment), capture_output=True, encoding="utf-8",
                              timeout=PATIENCE)

    def exits(self, code, said, *arguments, **environment):
        done = self.run_command(*arguments, **environment)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertIn(said, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual([path.name for path in self.folder.iterdir()], [self.mesh.name])


class WrongUse(Programs):
    def test_the_command_line_is_judged_first(self):
        self.exits(command.USAGE, "SERVER, MESH, OUT")
        self.exits(command.USAGE, "fragments=40", deserted_url(), self.mesh, self.out, "sites")
        self.exits(command.USAGE, ".gltf", deserted_url(), self.mesh, "out.fbx")
        self.exits(command.USAGE, "http://127.0.0.1:8080", "127.0.0.1:8080", self.mesh, self.out)
        self.exits(command.USAGE, "--timeout", deserted_url(), self.mesh, self.out, "--timeout", "-1")
        self.exits(command.USAGE, "gone", deserted_url(), self.mesh, self.out, "--token-file", "gone")
        self.exits(command.UNREACHABLE, "gone.obj", deserted_url(), "gone.obj", self.out)
        self.exits(command.UNREACHABLE, "nowhere", deserted_url(), self.mesh, "nowhere/out.glb")

    def test_help_names_everything(self):
        done = self.run_command("--help")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for word in ("SERVER MESH OUT", "name=value", "--job", "--token-file", "examples:", "exits with", "130"):
            self.assertIn(word, done.stdout)

    def test_nobody_there(self):
        self.exits(command.UNREACHABLE, "connection", deserted_url(), self.mesh, self.out, "--timeout", "0.2")

    def test_what_the_server_says_decides_the_code(self):
        for status, slug, code in ((400, "bad-parameter", 3), (422, "mesh-not-closed", 3), (401, "unauthorized", 3), (500, "internal", 4),
                                   (504, "deadline-exceeded", 4), (503, "overloaded", 1), (429, "over-share", 1)):
            with self.subTest(slug), FaultServer(lambda asked: problem(status, slug, "Retry-After: 1000\r\n")) as server:
                self.exits(code, slug, server.url, self.mesh, self.out)
        with FaultServer(lambda asked: answer(200, "<html>a page</html>")) as server:
            self.exits(command.UNREACHABLE, "damaged", server.url, self.mesh, self.out)
        with FaultServer(lambda asked: answer(404, "<html>a page</html>")) as server:
            self.exits(command.FAILED, "a page", server.url, self.mesh, self.out)

    def test_the_token_comes_from_a_file_or_the_environment(self):
        def handler(asked):
            return answer(200, small_glb(), digest(small_glb())) if asked.method == "POST" else stored(200)
        file = self.folder.parent / (self.folder.name + ".token")
        file.write_text("of-the-file\nand more\n")
        self.addCleanup(file.unlink)
        for arguments, environment, wanted in (([], {}, None), ([], {"FRACTURE_TOKEN": "of-the-world"}, "Bearer of-the-world"),
                                               (["--token-file", file], {"FRACTURE_TOKEN": "x"}, "Bearer of-the-file")):
            with FaultServer(handler) as server:
                done = self.run_command(*arguments, server.url, self.mesh, self.out, **environment)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual({asked.field("Authorization") for asked in server.asked}, {wanted})

    def test_warnings_and_notes_are_told_apart_and_once(self):
        of_mesh = {"warnings": ["An image was left out."], "notes": ["1 hole was filled."],
                   "dropped": [{"what": "light", "name": "Lamp", "reason": "none"}]}
        glb = small_glb(report={"warnings": of_mesh["warnings"] + ["The cuts are flat."], "notes": of_mesh["notes"] + ["2 pieces are small."],
                                "dropped": of_mesh["dropped"] + [{"what": "camera", "name": "", "reason": "none"}]})

        def handler(asked):
            return answer(200, glb, digest(glb)) if asked.method == "POST" else stored(200, of_mesh)
        for quiet, wanted in ((["--quiet"], ""), ([], "mesh: warning: An image was left out.\nmesh: note: 1 hole was filled.\n"
                                                      "mesh: dropped: light Lamp: none\n"
                                                      "answer: warning: The cuts are flat.\nanswer: note: 2 pieces are small.\n"
                                                      "answer: dropped: camera: none\n")):
            with FaultServer(handler) as server:
                done = self.run_command(*quiet, server.url, self.mesh, self.out)
                self.assertEqual((done.returncode, done.stderr), (0, wanted))
        with FaultServer(handler) as server, Client(server.url) as client:
            made = client.put(self.mesh).fracture()
            self.assertEqual((made.warnings[-1], made.notes[-1], len(made.warnings), len(made.notes)),
                             ("The cuts are flat.", "2 pieces are small.", 2, 2))
            self.assertEqual(made.dropped, [("light", "Lamp", "none"), ("camera", "", "none")])

    def test_an_interrupt_closes_the_connection(self):
        def handler(asked):
            return stored(200) if asked.method == "GET" else Reply(silent=True)
        with FaultServer(handler) as server:
            program = subprocess.Popen([sys.executable, "-m", "fracture_client", server.url, str(self.mesh), str(self.out)],
                                       env=self.environment(), stderr=subprocess.PIPE, text=True)
            eventually("the request", lambda: len(server.asked) == 2)
            program.send_signal(signal.SIGINT)
            _, errors = program.communicate(timeout=PATIENCE)
            self.assertEqual((program.returncode, errors), (command.INTERRUPTED, "fracture_client: interrupted\n"))
            eventually("the server to see it", lambda: server.closed_by_client == 1)


class Real(Programs, WithServer):
    def test_each_ending(self):
        for ending in ("glb", "gltf", "json"):
            out = self.folder / f"\u6728.{ending}"
            done = self.run_command(self.server.url, self.mesh, "--quiet", out, "sites=7", "seed=3")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn("7 fragments, 1 m", done.stdout)
        whole = self.client.put(self.mesh).fracture(sites=7, seed=3)
        self.assertEqual((self.folder / "\u6728.glb").read_bytes(), whole.glb)
        self.assertEqual(json.loads((self.folder / "\u6728.json").read_text(encoding="utf-8")), whole.figures)
        self.assertEqual(json.loads((self.folder / "\u6728.gltf").read_text(encoding="utf-8"))["nodes"], whole._file.document["nodes"])

    def test_lost_output_is_an_error(self):
        for redirection, reason in (("> /dev/full", "No space left on device"), (">&-", "it is closed")):
            with self.subTest(redirection):
                done = self.run_program(["sh", "-c", f'"$@" {redirection}', "sh", sys.executable, "-m", "fracture_client", self.server.url,
                                         str(self.mesh), str(self.out), "--quiet", "sites=7"])
                self.assertEqual((done.returncode, done.stderr),
                                 (command.UNREACHABLE, f"fracture_client: cannot write to standard output: {reason}\n"))
                self.assertEqual(len(Answer.load(self.out).fragments), 7)

    def test_values_are_those_of_a_query(self):
        done = self.run_command(self.server.url, self.mesh, self.out, "material=stone", "impacts=0,0.5,0;0.2,1,0", "nodes=0", "fragments=9")
        self.assertEqual(done.returncode, 0, done.stderr)
        parameters = Answer.load(self.out).parameters
        self.assertEqual((parameters["impacts"], parameters["nodes"], parameters["fragments"]),
                         ([[0, 0.5, 0], [0.2, 1, 0]], ["0"], 9))

    def test_every_wrong_parameter_is_named(self):
        self.exits(command.REFUSED, "chocolate", self.server.url, self.mesh, self.out, "material=chocolate", "sites=0")
        done = self.run_command(self.server.url, self.mesh, self.out, "material=chocolate", "sites=0")
        self.assertIn("'sites'", done.stderr)

    def test_a_job_with_its_progress(self):
        done = self.run_command(self.server.url, self.mesh, self.out, "--job", "sites=40")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("done 100 %", done.stderr)
        self.assertEqual(Answer.load(self.out).glb, self.client.put(self.mesh).fracture(sites=40).glb)

    def test_the_example_runs_as_it_stands(self):
        self.assertTrue(os.access(EXAMPLE, os.X_OK))
        for parameters in ({"sites": 12}, {"sites": 12, "physics": "none"}):
            done = self.run_program([str(EXAMPLE), self.server.url, str(self.mesh), str(self.out), json.dumps(parameters)], PYTHONPATH="")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            lines = done.stdout.splitlines()
            self.assertEqual(len(lines), 12)
            self.assertAlmostEqual(sum(float(line.split()[1]) for line in lines), 1000, places=1)  # a cubic metre of the default density
        done = self.run_program([str(EXAMPLE), self.server.url, str(self.mesh), str(self.out), '{"sites": 0}'])
        self.assertEqual(done.returncode, 1)
        self.assertIn("'sites'", done.stderr)
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    main()
