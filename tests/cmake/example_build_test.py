#!/usr/bin/env python3
"""Configures and builds common/cmake/example as another project would: what is made, what is made again, what fails.

    example_build_test.py --generator Ninja --program BUILD/server/fracture-server [--installed]

With --installed the package is found below a prefix. Otherwise its place and the program are named.

Exits with 77 if the generator's tool is missing.
"""
import argparse, os, pathlib, shutil, subprocess, sys, tempfile, unittest

options = None
ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = {"Ninja": "ninja", "Unix Makefiles": "make"}


class ExampleBuild(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="fracture-test-")
        self.addCleanup(folder.cleanup)
        self.source = pathlib.Path(folder.name) / "my game"  # a space, as in many studios' paths
        self.build = self.source / "build tree"
        shutil.copytree(ROOT / "common/cmake/example", self.source)
        self.crate = self.build / "crate.gltf.glb"
        self.pane = self.build / "broken/pane.gltf"
        where = [f"-Dfracture_DIR={ROOT}/common/cmake", f"-DFRACTURE_SERVER_PROGRAM={options.program}"]
        if options.installed:
            prefix = pathlib.Path(folder.name) / "usr"
            (prefix / "bin").mkdir(parents=True)
            (prefix / "bin/fracture-server").symlink_to(options.program)
            (prefix / "lib/cmake/fracture").mkdir(parents=True)
            for name in ("FractureBake.cmake", "fracture-config.cmake"):
                shutil.copy(ROOT / "common/cmake" / name, prefix / "lib/cmake/fracture")
            where = [f"-DCMAKE_PREFIX_PATH={prefix}"]
        self.run_cmake("-S", self.source, "-B", self.build, "-G", options.generator, *where)

    def run_cmake(self, *arguments, good=True):
        done = subprocess.run(["cmake", *map(str, arguments)], text=True, capture_output=True)
        if good:
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        else:
            self.assertNotEqual(done.returncode, 0, done.stdout)
        return done.stdout + done.stderr

    def make(self, good=True):
        return self.run_cmake("--build", self.build, good=good)

    def times(self):
        return {path: path.stat().st_mtime_ns for path in (self.crate, self.pane)}

    def touch(self, name, newer_than):
        path = self.source / "assets" / name
        while True:  # a file system's clock may tick slowly
            os.utime(path)
            if path.stat().st_mtime_ns > newer_than.stat().st_mtime_ns:
                return

    def expect_made_again(self, *again):
        before = self.times()
        self.make()
        after = self.times()
        self.assertEqual({p.name for p in after if after[p] != before[p]}, {p.name for p in again})

    def test_makes_each_asset_once_and_again_when_what_it_is_made_of_changes(self):
        self.make()
        direct = self.source / "direct.glb"
        subprocess.run([options.program, "bake", self.source / "assets/crate.gltf", "-o", direct, "-q", "--sites", "40",
                        "--material", "wood"], check=True)
        self.assertEqual(self.crate.read_bytes(), direct.read_bytes())
        shown = subprocess.run([self.build / "game"], text=True, capture_output=True, check=True).stdout
        self.assertEqual(shown.count(" bytes\n"), 2)
        self.expect_made_again()
        self.touch("crate.bin", self.crate)  # a buffer
        self.expect_made_again(self.crate)
        self.touch("pane.mtl", self.pane)  # a material library
        self.expect_made_again(self.pane)
        self.touch("pane.obj", self.pane)
        self.expect_made_again(self.pane)
        self.expect_made_again()
        lists = self.source / "CMakeLists.txt"
        lists.write_text(lists.read_text().replace("sites=40", "sites=41 max-fragments=30"))
        self.expect_made_again(self.crate)  # a parameter

    def test_an_obj_has_its_materials_beside_it(self):
        lists = self.source / "CMakeLists.txt"
        lists.write_text(lists.read_text() + "fracture_add_baked_asset(TARGET game INPUT assets/crate.gltf OUTPUT tools/crate.obj\n"
                         "                         PARAMETERS sites=9)\n")
        self.make()
        made = self.build / "tools/crate.obj"
        self.assertIn("\nmtllib crate.mtl\n", made.read_text())
        self.assertIn("\nnewmtl Interior\n", made.with_suffix(".mtl").read_text())
        before = made.stat().st_mtime_ns
        self.make()
        self.assertEqual(made.stat().st_mtime_ns, before)
        self.touch("crate.bin", made)
        self.make()
        self.assertGreater(made.stat().st_mtime_ns, before)

    def test_a_refused_asset_fails_the_build_with_the_reason(self):
        buffer = self.source / "assets/crate.bin"
        whole = buffer.read_bytes()
        buffer.write_bytes(whole[:100])
        said = self.make(good=False)
        self.assertIn("crate.gltf", said)
        self.assertIn("malformed-mesh", said)
        self.assertFalse(self.crate.exists())
        buffer.write_bytes(whole)
        self.make()
        self.assertTrue(self.crate.exists())

    def test_mistakes_are_said_when_the_project_is_configured(self):
        lists = self.source / "CMakeLists.txt"
        good = lists.read_text()
        for wrong, reason in (("INPUT assets/crate.gltf PARAMETERS sites", "'sites' must be a parameter"),
                              ("INPUT assets/crate.gltf OUTPUT crate.fbx",
                               "OUTPUT ends in '.fbx', which bake does not write"),
                              ("PARAMETERS sites=1", "TARGET and INPUT are required"),
                              ("nonsense INPUT assets/crate.gltf", "'nonsense' is not an argument of this function")):
            lists.write_text(good + f"fracture_add_baked_asset(TARGET game {wrong})\n")
            self.assertIn(reason, " ".join(self.run_cmake(self.build, good=False).split()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--generator", default="Ninja")
    parser.add_argument("--program", required=True)
    parser.add_argument("--installed", action="store_true")
    options, rest = parser.parse_known_args()
    options.program = pathlib.Path(options.program).resolve()
    for tool in ("cmake", TOOLS[options.generator], "c++"):
        if not shutil.which(tool):
            print(f"skipped: {tool} is not installed")
            sys.exit(77)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
