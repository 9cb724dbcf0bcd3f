#!/usr/bin/env python3
"""Tests what fracture-client writes if its command line, the film's program or the server is not as it should be.

Usage: outputs_test.py FRACTURE_CLIENT [unittest arguments].
"""
import http.server
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import unittest

PROGRAM = ""
NO_REQUESTS = ("--headless", "--fixed-step", "--no-requests", "--seconds", "0.1")


class Refusing(http.server.BaseHTTPRequestHandler):
    """A server that answers at once, so that tests need not wait."""
    protocol_version = "HTTP/1.1"

    def do_PUT(self):
        self.rfile.read(int(self.headers.get("Content-Length", 0)))
        body = b'{"type": "/problems/bad-parameter", "detail": "No."}'
        self.send_response(400)
        self.send_header("Content-Type", "application/problem+json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    do_GET = do_POST = do_PUT

    def log_message(self, *arguments):
        pass


class Outputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Refusing)
        cls.server.daemon_threads = True
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()

    @classmethod
    def tearDownClass(cls):
        cls.server.shutdown()
        cls.server.server_close()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def client(self, *arguments, **environment):
        if "--port" not in arguments:
            arguments += ("--host", "127.0.0.1", "--port", str(self.server.server_address[1]))
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=120,
                              check=False, env={**os.environ, **environment})

    def test_two_files_of_one_name_are_refused_and_stay(self):
        (self.folder / "x").write_text("kept", encoding="utf-8")
        (self.folder / "link").symlink_to("x")
        (self.folder / "hard").hardlink_to(self.folder / "x")
        (self.folder / "box.obj").write_text("kept", encoding="utf-8")
        for arguments in (("--replay", "x", "--wav", "x"), ("--replay", "x", "--log", "./link"),
                          ("--replay", "x", "--wav", "hard"), ("--record", "same", "--wav", "same"),
                          ("--record", "lg", "--log", "lg"), ("--wav", "new", "--log", "../" + self.folder.name + "/new"),
                          ("--record", "lg/", "--log", "lg"), ("box.obj", "--wav", "box.obj")):
            with self.subTest(arguments=arguments):
                ended = self.client(*NO_REQUESTS, *arguments)
                self.assertEqual(ended.returncode, 2, ended.stderr)
                for flag in arguments[::2]:
                    self.assertIn(flag if flag.startswith("--") else "the mesh", ended.stderr)
                self.assertRegex(ended.stderr, "are both '[^']+'")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["box.obj", "hard", "link", "x"])
        self.assertEqual((self.folder / "x").read_text(encoding="utf-8"), "kept")
        self.assertEqual((self.folder / "box.obj").read_text(encoding="utf-8"), "kept")
        ended = self.client(*NO_REQUESTS, "--wav", "/dev/null", "--log", "/dev/null")
        self.assertEqual(ended.returncode, 0, ended.stderr)

    def test_an_empty_name_is_refused(self):
        for flag in ("--record", "--wav", "--log", "--replay"):
            ended = self.client(*NO_REQUESTS, flag, "")
            self.assertNotEqual(ended.returncode, 0, flag)
            self.assertIn(flag, ended.stderr)

    def test_a_film_that_fails_leaves_sound_and_log_whole(self):
        tools = self.folder / "tools"
        tools.mkdir()
        (tools / "ffmpeg").write_text("#!/bin/sh\ncat >/dev/null\nexit 3\n", encoding="utf-8")
        (tools / "ffmpeg").chmod(0o700)
        ended = self.client(*NO_REQUESTS, "--width", "64", "--height", "64", "--record", "a.gif", "--wav", "a.wav", "--log", "a.log",
                            PATH=f"{tools}:{os.environ['PATH']}")
        if "EGL" in ended.stderr or "OpenGL" in ended.stderr:
            self.skipTest(ended.stderr)
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertIn("ffmpeg failed", ended.stderr)
        self.assertFalse((self.folder / "a.gif").exists())
        sound = (self.folder / "a.wav").read_bytes()
        self.assertEqual(int.from_bytes(sound[40:44], "little"), len(sound) - 44)
        self.assertGreater(len(sound), 44 + 4 * 4000, "a tenth of a second")
        lines = [json.loads(line) for line in (self.folder / "a.log").read_text(encoding="utf-8").splitlines()]
        self.assertEqual(len([line for line in lines if "hash" in line]), 12, "steps of a tenth of a second")

    def test_an_absent_server_is_said_once(self):
        with socket.socket() as held:  # bound but not listening
            held.bind(("127.0.0.1", 0))
            port = held.getsockname()[1]
            ended = self.client("--headless", "--host", "127.0.0.1", "--port", str(port), "--seconds", "3")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(ended.stderr.count(f"no server answers at 127.0.0.1:{port}"), 1, ended.stderr)


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
