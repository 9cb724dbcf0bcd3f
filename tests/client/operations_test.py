#!/usr/bin/env python3
"""client/OPERATIONS.md: every operation of the interface is in a row, and every test that a cell names exists.

operations_test.py BUILD: a build folder, whose CTest knows the programs."""
import json
import pathlib
import re
import subprocess
import sys
import unittest

try:
    import yaml
except ImportError:
    yaml = None

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "client" / "OPERATIONS.md"
SKIPPED = 77
METHODS = ("get", "put", "post", "delete", "patch", "head", "options", "trace")
NONE = "–"


def tables(text):
    """Of a Markdown text: a list of (head, rows), each a list of cells."""
    found = []
    for block in re.findall(r"^(?:\|.*\n)+", text, re.MULTILINE):
        head, _, *rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in block.splitlines()]
        found.append((head, rows))
    return found


def claims(text):
    """The claims of the page: (row, program in CTest, test, calls before it)."""
    for head, rows in tables(text):
        beginnings = [(re.findall(r"`(\w+_)\*`$", cell) or [None])[0] for cell in head]
        for row in rows:
            for beginning, cell in zip(beginnings[1:], row[1:]):
                if cell == NONE:
                    continue
                *calls, test = re.findall(r"`([^`]+)`", cell)
                program, name = test.split(": ", 1)
                yield row[0], beginning + program, name, calls


def sources(program):
    """The texts in which the tests of a program stand."""
    found = re.fullmatch(r"client_(python|blender)_(\w+)", program)
    if found:
        return [ROOT / "tests" / "client" / found[1] / f"{found[2]}_test.py"]
    found = re.fullmatch(r"client_(typescript|page)_(\w+)", program)
    if found:
        return [ROOT / "tests" / "client" / found[1] / f"{found[2]}.test.mjs"]
    for lists in (ROOT / "tests").rglob("CMakeLists.txt"):
        found = re.search(rf"_test\({program}\s(.*?)\)", lists.read_text(encoding="utf-8"), re.DOTALL)
        if found:
            return [lists.parent / name for name in re.findall(r"\S+\.cpp", found[1])]
    return []


def has_test(text, name):
    if re.fullmatch(r"\w+\.\w+", name):
        suite, test = name.split(".")
        return re.search(rf"^TEST(_F|_P)?\({suite}, {test}\)", text, re.MULTILINE) is not None
    if name.startswith("test_"):
        return re.search(rf"^    def {name}\(self", text, re.MULTILINE) is not None
    return re.search(rf"^ *test\('{re.escape(name)}'", text.replace("\\'", "'"), re.MULTILINE) is not None


def offences(text, operations, programs):
    """What is wrong with the page, for these operations of the interface and these programs of CTest."""
    found = []
    first = [row[0] for head, rows in tables(text) if head[0] == "operation" for row in rows]
    rows = {name for cell in first if re.fullmatch(r"`\w+`(?: `\w+`)*", cell) for name in re.findall(r"\w+", cell)}
    found += [f"{name} has no row" for name in sorted(operations - rows)]
    found += [f"{name} is no operation of the interface" for name in sorted(rows - operations)]
    for row, program, name, calls in claims(text):
        if program not in programs:
            found.append(f"{row}: CTest has no {program}")
            continue
        code = "\n".join(path.read_text(encoding="utf-8") for path in sources(program) if path.is_file())
        if not has_test(code, name):
            found.append(f"{row}: {program} has no test '{name}'")
        for method in re.findall(r"\.(\w+)\(\)$", "\n".join(calls), re.MULTILINE):
            if not re.search(rf"\.{method}\b", code):
                found.append(f"{row}: the tests of {program} never call .{method}()")
    return found


def interface():
    document = yaml.safe_load((ROOT / "proto" / "openapi.yaml").read_text(encoding="utf-8"))
    return {item[method]["operationId"] for item in document["paths"].values() for method in METHODS if method in item}


class Page(unittest.TestCase):
    build = None

    @classmethod
    def setUpClass(cls):
        said = subprocess.run(["ctest", "--show-only=json-v1"], cwd=cls.build, check=True, capture_output=True, timeout=120).stdout
        cls.programs = {test["name"] for test in json.loads(said)["tests"]}
        cls.text = PAGE.read_text(encoding="utf-8")
        cls.operations = interface()

    def test_all_that_it_says_is_there(self):
        self.assertEqual(offences(self.text, self.operations, self.programs), [])
        self.assertGreater(len(list(claims(self.text))), 3 * len(self.operations))

    def test_what_is_missing_is_found(self):
        def changed(old, new):
            self.assertIn(old, self.text)
            return offences(self.text.replace(old, new), self.operations, self.programs)
        self.assertEqual(offences(self.text, self.operations | {"getTea"}, self.programs), ["getTea has no row"])
        self.assertEqual(len(changed("| `getJobs` |", "| `getTeas` |")), 2)
        self.assertIn("has no test 'test_inspekt'", changed("test_inspect`", "test_inspekt`")[0])
        self.assertIn("has no test 'a jop is cancelled'", changed("service: a job is cancelled", "service: a jop is cancelled")[0])
        self.assertIn("has no test 'Listed.TheOldestComesFirst'", changed("Listed.TheNewest", "Listed.TheOldest")[0])
        self.assertIn("CTest has no client_python_tea", changed("`server: test_inspect`", "`tea: test_inspect`")[0])
        self.assertIn("never call .inspekt()", changed("`client.inspect()` `server", "`client.inspekt()` `server")[0])
        self.assertEqual(len(offences(self.text, self.operations, self.programs - {"server_jobs_tests"})), self.text.count("`jobs_tests:"))


if __name__ == "__main__":
    if yaml is None:
        print("skipped: PyYAML is not installed (python3-yaml)")
        sys.exit(SKIPPED)
    Page.build = sys.argv.pop(1)
    unittest.main(verbosity=2)
