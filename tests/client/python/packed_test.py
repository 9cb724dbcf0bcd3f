#!/usr/bin/env python3
"""The package as users get it: a wheel, installed in a separate environment and used from an empty folder.

Needs pip, setuptools and wheel in the Python that builds (this one, otherwise the system's), but no network.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

from support import PACKAGE, PATIENCE, ROOT, Server, box_gltf, box_obj, glb, main

NEEDED = "import setuptools, wheel, venv, ensurepip, pip"  # setuptools first, because it brings its own distutils


def builder():
    """Returns a Python that can build a wheel offline."""
    for python in (sys.executable, shutil.which("python3", path=os.defpath)):
        if python and subprocess.run([python, "-c", NEEDED], capture_output=True, timeout=PATIENCE).returncode == 0:
            return python
    raise unittest.SkipTest("no Python here has pip, setuptools, wheel and venv (python3-pip, python3-setuptools, python3-wheel, "
                            "python3-venv)")


class Packed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        python = builder()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PIP_"))}
        checkout = cls.folder / "checkout"  # a copy, because setuptools leaves files behind
        source = checkout / PACKAGE.relative_to(ROOT)
        shutil.copytree(PACKAGE, source, ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
        shutil.copy(ROOT / ".gitignore", checkout)
        cls.run_program("git", "init", "--quiet", checkout)
        untracked = ["git", "-C", checkout, "ls-files", "--others", "--exclude-standard"]
        before, there = cls.run_program(*untracked), {path.name for path in source.iterdir()}
        offline = ["--no-index", "--disable-pip-version-check", "--no-cache-dir", "--quiet"]
        cls.run_program(python, "-m", "pip", "wheel", *offline, "--no-deps", "--no-build-isolation", "-w", cls.folder / "dist", source)
        cls.wheel, = (cls.folder / "dist").iterdir()
        cls.run_program(python, "-m", "pip", "wheel", *offline, "--no-deps", "--no-build-isolation", ".", cwd=source)
        cls.left = {path.name for path in source.iterdir()} - there
        cls.untracked = set(cls.run_program(*untracked).splitlines()) - set(before.splitlines())
        cls.run_program(python, "-m", "venv", cls.folder / "venv")  # without the system's packages
        cls.python = cls.folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
        cls.run_program(cls.python, "-m", "pip", "install", *offline, cls.wheel)
        cls.empty = cls.folder / "empty"
        cls.empty.mkdir()

    @classmethod
    def run_program(cls, *arguments, **options):
        done = subprocess.run(list(map(str, arguments)), env=cls.environment, capture_output=True, encoding="utf-8", timeout=5 * PATIENCE,
                              **options)
        if done.returncode != 0:
            raise AssertionError(f"{arguments} exits with {done.returncode}:\n{done.stdout}{done.stderr}")
        return done.stdout

    def test_the_wheel_has_the_package_and_nothing_else(self):
        self.assertRegex(self.wheel.name, r"^fracture_client-\d+\.\d+\.\d+-py3-none-any\.whl$")
        with zipfile.ZipFile(self.wheel) as wheel:
            names = {name for name in wheel.namelist() if ".dist-info/" not in name}
            metadata = wheel.read(next(n for n in wheel.namelist() if n.endswith("/METADATA"))).decode("utf-8")
        written = {f"fracture_client/{path.name}" for path in (PACKAGE / "fracture_client").iterdir() if path.is_file()}
        self.assertEqual(names, written)
        self.assertIn("fracture_client/py.typed", names)
        self.assertIn("Requires-Python: >=3.9", metadata)
        self.assertNotIn("Requires-Dist: numpy\n", metadata)  # numpy is optional
        self.assertIn("# fracture-client", metadata)

    def test_building_leaves_nothing_that_git_would_add(self):
        self.assertIn("build", self.left)
        self.assertIn(self.wheel.name, self.left)
        self.assertEqual(self.untracked, set())

    def test_it_is_imported_from_where_it_was_installed(self):
        where = self.run_program(self.python, "-W", "error", "-c", "import fracture_client; print(fracture_client.__file__)", cwd=self.empty)
        self.assertTrue(pathlib.Path(where.strip()).resolve().is_relative_to((self.folder / "venv").resolve()), where)

    def test_it_breaks_a_mesh_from_an_empty_folder(self):
        server = Server()
        self.addCleanup(server.stop)
        (self.empty / "box.obj").write_bytes(box_obj())
        said = self.run_program(self.python, "-m", "fracture_client", server.url, "box.obj", "out.glb", "fragments=20", cwd=self.empty)
        self.assertIn("20 fragments", said)
        self.assertEqual((self.empty / "out.glb").read_bytes()[:4], b"glTF")

    def test_the_program_of_the_readme_runs(self):
        server = Server()
        self.addCleanup(server.stop)
        program = re.search(r"```python\n(.*?)```", (PACKAGE / "README.md").read_text(encoding="utf-8"), re.DOTALL).group(1)
        self.assertLessEqual(len(program.strip().splitlines()), 10)
        document, buffer = box_gltf(None)
        (self.empty / "barrel.glb").write_bytes(glb.pack(json.loads(document), buffer))
        said = self.run_program(self.python, "-c", program.replace("http://127.0.0.1:8080", server.url), cwd=self.empty)
        self.assertRegex(said, r"^40 fragments; the largest weighs [\d.]+ kg\n[1-9]\d* new, \d+ changed, \d+ gone\n$")
        self.assertEqual((self.empty / "hit.glb").read_bytes()[:4], b"glTF")


if __name__ == "__main__":
    main()
