#!/usr/bin/env python3
"""Proves that each check of scripts/check finds an offence planted for it, and finds nothing in the same checkout
without it."""
import shutil
import subprocess
import sys
import types
import unittest
import unittest.mock

from planted import CLEAN, ROOT, PlantedCheckout

sys.path.insert(0, str(ROOT / "scripts" / "lib"))
from checks import alone  # noqa: E402


class Checks(PlantedCheckout):
    def test_format(self):
        self.needs("clang-format")
        self.expect_clean("format")
        self.plant("common/base/vec.cpp", '#include "common/base/vec.hpp"\nint   twice( int x ){return x+x;}\n')
        self.expect_found("format", "common/base/vec.cpp:1:", "repair: scripts/check --fix format")
        self.assertEqual(self.check("--fix", "format")[0], 0)
        self.assertIn("int twice(int x) { return x + x; }", (self.root / "common/base/vec.cpp").read_text())

    def test_format_leaves_drawings_and_literals_alone(self):
        self.needs("clang-format")
        drawing = "//   a ---- b" + " " * 60 + "a drawing that is wider than the column limit of the formatter\n//   |\n"
        literal = 'const char* text = "' + "a word " * 16 + '";\n'
        self.plant("common/base/drawn.cpp", drawing + literal)
        self.check("--fix", "format")
        laid_out = (self.root / "common/base/drawn.cpp").read_text()
        self.assertIn(drawing, laid_out)
        self.assertIn("a word " * 16, laid_out)

    def test_shell(self):
        self.needs("shellcheck")
        self.expect_clean("shell")
        self.plant("scripts/run", "#!/usr/bin/env bash\nwork= other=1\necho \"$work$other\"\n")
        self.expect_found("shell", "scripts/run:2:", "SC1007")

    def test_python(self):
        self.needs("flake8")
        self.expect_clean("python")
        self.plant("scripts/count.py", "import os\nimport sys\n\nprint(len(sys.argv))\n")
        self.expect_found("python", "scripts/count.py:1:", "'os' imported but unused")

    def test_spelling(self):
        self.needs("codespell")
        self.expect_clean("spelling")
        self.plant("common/base/vec.hpp", "// What is recieved.\n#pragma once\nint twice(int x);\n")
        self.expect_found("spelling", "common/base/vec.hpp:1:", "received", "repair: scripts/check --fix spelling")
        self.assertEqual(self.check("--fix", "spelling")[0], 0)
        self.assertIn("received", (self.root / "common/base/vec.hpp").read_text())

    def test_links(self):
        self.expect_clean("links")
        for text, said in (("[a](common/gone.hpp)\n", "links to common/gone.hpp, which does not exist"),
                           ("[a](#nowhere)\n", "links to #nowhere, and README.md has no such heading"),
                           ("The file common/base/gone.hpp says more.\n", "names common/base/gone.hpp, which does not exist"),
                           ("See geometry.md.\n", "names geometry.md, which does not exist")):
            self.plant("README.md", "# Title\n\n" + text)
            self.expect_found("links", "README.md:3: " + said)
        self.plant("README.md", CLEAN["README.md"])
        self.plant("common/base/vec.hpp", "// The rule stands in exact/ties.md.\n#pragma once\nint twice(int x);\n")
        self.expect_found("links", "common/base/vec.hpp:1: names exact/ties.md")

    def test_includes(self):
        self.expect_clean("includes")
        # The library is linked, but only through another linked library.
        self.plant("server/service.cpp", '#include "common/base/vec.hpp"\n#include "common/solid/solid.hpp"\n')
        self.expect_found("includes", "server/service.cpp:1: includes common/base/vec.hpp", "does not declare fracture_base")
        self.plant("server/CMakeLists.txt", "fracture_library(service SOURCES service.cpp DEPS fracture::solid fracture::base)\n")
        self.expect_clean("includes")
        # An include against the order of the rooms.
        self.plant("common/base/vec.cpp", '#include "common/solid/solid.hpp"\n')
        self.expect_found("includes", "common/base/vec.cpp:1: includes common/solid/solid.hpp", "does not declare fracture_solid")
        # A library from outside the project.
        self.plant("common/base/vec.cpp", "#include <zstd.h>\n")
        self.expect_found("includes", "common/base/vec.cpp:1: includes zstd.h")

    def test_includes_finds_sources_that_nobody_compiles(self):
        self.plant("common/lost/lost.cpp", "int lost;\n")
        self.expect_found("includes", "common/lost/lost.cpp:1: no CMakeLists.txt compiles it")

    def test_includes_finds_a_source_that_needs_the_include_of_its_neighbour(self):
        # A unity build reads both files as one: the <string> of the first file is enough for the second.
        self.plant("common/base/CMakeLists.txt", "fracture_library(base SOURCES vec.cpp words.cpp)\n")
        self.plant("common/base/vec.cpp", '#include "common/base/vec.hpp"\n\n#include <string>\n\n'
                   "int twice(int x) { return std::stoi(std::to_string(x + x)); }\n")
        self.plant("common/base/words.cpp", "std::string word() { return {}; }\n")
        self.expect_found("includes", "common/base/words.cpp:1: 'string' in namespace 'std' does not name a type",
                          "(common/base/words.cpp does not compile alone)")
        self.plant("common/base/words.cpp", "#include <string>\n\nstd::string word() { return {}; }\n")
        self.expect_clean("includes")

    def test_includes_finds_a_header_that_needs_what_is_included_before_it(self):
        header = "#pragma once\n%s\nstd::string four_in_words();\n"
        self.plant("common/solid/words.hpp", header % "")
        self.plant("common/solid/solid.cpp", '#include <string>\n\n#include "common/base/vec.hpp"\n#include "common/solid/words.hpp"\n\n'
                   "int four() { return twice(2); }\n")
        self.expect_found("includes", "common/solid/words.hpp:3: 'string' in namespace 'std'",
                          "(common/solid/words.hpp does not compile alone)")
        self.plant("common/solid/words.hpp", header % "#include <string>\n")
        self.expect_clean("includes")
        self.plant("common/solid/lost.hpp", "#pragma once\n")
        self.expect_found("includes", "common/solid/lost.hpp:1: no compiled source includes it")

    def test_includes_finds_a_source_that_lost_an_include_because_a_header_changed(self):
        between = '#pragma once\n%sint four();\n'
        self.plant("common/solid/solid.hpp", between % '#include "common/base/vec.hpp"\n')
        self.plant("server/service.cpp", '#include "common/solid/solid.hpp"\n\nint eight() { return twice(four()); }\n')
        self.commit("a source uses what a header of a header declares")
        self.expect_clean("includes")
        self.plant("common/solid/solid.hpp", between % "")
        self.expect_found("includes", "server/service.cpp:3: 'twice' was not declared in this scope")

    def test_includes_names_a_file_that_takes_long_to_read(self):
        words = ["g++", "-I.", "-w", "-fsyntax-only", "-x", "c++", "-"]
        checkout = types.SimpleNamespace(root=self.root)
        self.assertIsNone(alone.compile_alone(checkout, "common/base/vec.cpp", words))
        with unittest.mock.patch.object(alone, "MOST_TO_READ", 0):
            self.assertRegex(alone.compile_alone(checkout, "common/base/vec.cpp", words),
                             "^common/base/vec.cpp:1: the compiler needs 0 s to read it; at most 0 are allowed: include less, or split the file$")

    def test_includes_compiles_what_changed_and_all_of_it_on_demand(self):
        self.plant("common/base/CMakeLists.txt", "fracture_library(base SOURCES vec.cpp words.cpp)\n")
        self.plant("common/base/words.cpp", "std::string word() { return {}; }\n")
        self.commit("the fault")
        self.plant("README.md", "# Title\n")
        self.commit("something else")
        self.expect_clean("includes")
        self.assertEqual(self.check("--all", "includes")[0], 1)

    def test_includes_remembers_what_compiled_until_it_changes(self):
        def compiled():
            return (self.root / "build/tidy/compiled_alone.txt").read_text().splitlines()
        self.assertEqual(self.check("--all", "includes")[0], 0)
        # Three files are compiled: vec.cpp, solid.cpp and service.cpp. Each header is the first include of one of them.
        self.assertEqual(len(compiled()), 3)
        self.assertEqual(self.check("--all", "includes")[0], 0)
        self.assertEqual(len(compiled()), 3)
        self.plant("common/base/vec.hpp", "#pragma once\nint twice(int x);  // of a whole number\n")
        self.assertEqual(self.check("--all", "includes")[0], 0)
        self.assertEqual(len(compiled()), 5)  # vec.cpp and solid.cpp again, which include it
        self.plant("common/base/vec.hpp", "#pragma once\nstd::string twice(int x);\n")
        self.assertEqual(self.check("--all", "includes")[0], 1)

    def test_waits(self):
        self.expect_clean("waits")
        for name, text in (("tests/a_test.cpp", "void f() { std::this_thread::sleep_for(1ms); }\n"),
                           ("tests/b_test.cpp", "void f() { while (!done) std::this_thread::yield(); }\n"),
                           ("tests/e_test.cpp", "void f() { changed.wait(lock, [] { return open; }); }\n"),
                           ("tests/c_test.py", "import time\ntime.sleep(1)\n"),
                           ("tests/d", "#!/usr/bin/env bash\nuntil ready; do sleep 0.1; done\n")):
            self.plant(name, text)
            self.expect_found("waits", name)
            (self.root / name).unlink()
        self.plant("tests/a_test.cpp", "// pause: a client that sends a byte a second\nstd::this_thread::sleep_for(1s);\n")
        self.expect_clean("waits")

    def test_names(self):
        self.expect_clean("names")
        header = "// %s\n#pragma once\ninline constexpr int kMostTwice = 7;\nint twice(int x);\n"
        for text, said in (("At most kLeastTwice.", "names kLeastTwice, which does not exist"),
                           ("Like fracture::thrice(), but smaller.", "names thrice(), which does not exist")):
            self.plant("common/base/vec.hpp", header % text)
            self.expect_found("names", "common/base/vec.hpp:1: " + said)
        self.plant("common/base/vec.hpp", header % "At most Limits::kMostTwice. Used by fracture::twice().")
        self.expect_clean("names")
        self.plant("README.md", "# Title\n\nThe limit is `kFewTwice`.\n")
        self.expect_found("names", "README.md:3: names kFewTwice, which does not exist")
        self.plant("README.md", "# Title\n\nThe limit is `kMostTwice`.\n")
        self.expect_clean("names")

    def test_length(self):
        self.expect_clean("length")
        for name, line in (("common/base/vec.cpp", "int x;\n"), ("scripts/count.py", "x = 1\n"), ("scripts/run", "true\n")):
            first = "#!/usr/bin/env bash\n" if name == "scripts/run" else line
            self.plant(name, first + line * 400)
            self.expect_found("length", name + ":401: has 401 lines; at most 400 are allowed")
            self.plant(name, first + line * 399)
            self.expect_clean("length")
        # A file that is known to be too long must leave the list when it no longer is.
        self.plant("common/fragment/assemble.cpp", "int x;\n" * 401)
        self.expect_clean("length")
        self.plant("common/fragment/assemble.cpp", "int x;\n" * 400)
        self.expect_found("length", "common/fragment/assemble.cpp:1: is short enough: remove it from NOT_YET")

    def test_tidy(self):
        self.needs("clang-tidy")
        self.expect_clean("tidy")
        self.plant("common/base/vec.cpp", '#include "common/base/vec.hpp"\n\nint twice(int x) { return x == x ? x + x : 0; }\n')
        self.expect_found("tidy", "common/base/vec.cpp:3:", "misc-redundant-expression")

    def test_an_archive_without_history_is_checked_too(self):
        shutil.rmtree(self.root / ".git")
        self.plant("build/x.py", "import os\n")
        self.expect_clean("python")
        self.plant("scripts/count.py", "import sys\nimport os\n\nprint(len(sys.argv))\n")
        self.expect_found("python", "scripts/count.py")
        self.expect_clean("tidy")
        self.plant("common/base/vec.hpp", "#pragma once\nstd::string twice(int x);\n")
        self.assertIn("without git history", self.check("includes")[1])
        self.assertEqual(self.check("--all", "includes")[0], 1)

    def test_a_missing_tool_is_said_and_is_no_success(self):
        self.plant("bin/git", "")
        (self.root / "bin/git").unlink()
        (self.root / "bin/git").symlink_to(shutil.which("git"))
        done = subprocess.run([sys.executable, str(ROOT / "scripts/check"), "--root", str(self.root), "python"], text=True,
                              capture_output=True, env={"PATH": str(self.root / "bin")})
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn("flake8 is not installed", done.stderr)
        self.assertIn("scripts/install-deps check", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
