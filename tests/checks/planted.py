"""A small checkout in a temporary folder in which no check of scripts/check finds anything. Tests plant offences in it.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGETS = """function(fracture_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_library(fracture_${name} STATIC ${ARG_SOURCES})
  add_library(fracture::${name} ALIAS fracture_${name})
  target_include_directories(fracture_${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(fracture_${name} PUBLIC ${ARG_DEPS})
endfunction()
"""
CLEAN = {
    ".gitignore": "/build/\n",
    ".clang-format": (ROOT / ".clang-format").read_text(),
    ".clang-tidy": (ROOT / ".clang-tidy").read_text(),
    ".flake8": (ROOT / ".flake8").read_text(),
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.25)\nproject(planted CXX)\ninclude(targets.cmake)\n"
                      "add_subdirectory(common/base)\nadd_subdirectory(common/solid)\nadd_subdirectory(server)\n",
    "CMakePresets.json": '{"version": 6, "configurePresets": [{"name": "release", "generator": "Ninja", '
                         '"cacheVariables": {"CMAKE_EXPORT_COMPILE_COMMANDS": "ON"}}]}',
    "README.md": "# Title\n\nSee [base](common/base/vec.hpp) and [below](#the-end).\n\n## The end\n",
    "common/base/CMakeLists.txt": "fracture_library(base SOURCES vec.cpp)\n",
    "common/base/vec.hpp": "#pragma once\nint twice(int x);\n",
    "common/base/vec.cpp": '#include "common/base/vec.hpp"\n\nint twice(int x) { return x + x; }\n',
    "common/solid/CMakeLists.txt": "fracture_library(solid SOURCES solid.cpp DEPS fracture::base)\n",
    "common/solid/solid.hpp": "#pragma once\nint four();\n",
    "common/solid/solid.cpp": '#include "common/base/vec.hpp"\n\nint four() { return twice(2); }\n',
    "server/CMakeLists.txt": "fracture_library(service SOURCES service.cpp DEPS fracture::solid)\n",
    "server/service.cpp": '#include "common/solid/solid.hpp"\n\nint eight() { return 2 * four(); }\n',
    "targets.cmake": TARGETS,
    "scripts/run": "#!/usr/bin/env bash\necho \"$1\"\n",
    "scripts/count.py": "import sys\n\nprint(len(sys.argv))\n",
    "tests/wait_test.cpp": "bool ready() { return eventually(kPatience, \"it\", done); }\n",
}


class PlantedCheckout(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="fracture-test-")
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name, text in CLEAN.items():
            self.plant(name, text)
        self.git("init", "--quiet", "--initial-branch=main")
        self.commit("clean")

    def git(self, *arguments):
        subprocess.run(["git", "-C", str(self.root), *arguments], check=True, capture_output=True)

    def commit(self, subject):
        self.git("add", "--all")
        self.git("-c", "user.name=a", "-c", "user.email=a@b", "-c", "core.hooksPath=/dev/null", "commit", "--quiet", "-m", subject)

    def plant(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def check(self, *arguments):
        done = subprocess.run([sys.executable, str(ROOT / "scripts/check"), "--root", str(self.root), *arguments],
                              text=True, capture_output=True,
                              env={name: value for name, value in os.environ.items() if name != "FRACTURE_CHECK_BASE"})
        return done.returncode, done.stdout + done.stderr

    def expect_clean(self, check):
        status, said = self.check(check)
        self.assertEqual(status, 0, said)

    def expect_found(self, check, *words):
        status, said = self.check(check)
        self.assertEqual(status, 1, said)
        for word in words:
            self.assertIn(word, said)
        self.assertIn("repair: ", said)

    def needs(self, tool):
        if not shutil.which(tool):
            self.skipTest(f"{tool} is not installed")
