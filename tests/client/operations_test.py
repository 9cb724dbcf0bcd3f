#!/usr/bin/env python3
"""Checks client/OPERATIONS.md: every operation of the interface has a row, and operations.txt names a test for each
call in a row.

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
TESTS = ROOT / "tests" / "client" / "operations.txt"
SKIPPED = 77
METHODS = ("get", "put", "post", "delete", "patch", "head", "options", "trace")
NONE = "–"
HIT = "of"  # the row of postMeshFracture for a hit on an answer
OTHERS = {"bake": "bake", "inspect": "bake", "health": "bake", "Blender": "blender"}  # names in the last column, and their clients


def calls(page):
    """The rows of the page: (operation, {client: method, or None for a client without methods})."""
    for line in re.findall(r"^\| (?:`|… with).*$", page, re.MULTILINE):
        operation, python, typescript, others = [cell.strip() for cell in line.strip("|").split("|")]
        called = {client: re.search(r"\.(\w+)\(\)", cell)[1] for client, cell in (("python", python), ("typescript", typescript))
                  if cell != NONE}
        called |= {OTHERS[name]: None for name in re.findall(r"\w+", others.replace("--server", "")) if name in OTHERS}
        yield HIT if operation.startswith("…") else operation.strip("`"), called


def numbers(page):
    return re.findall(r"^(\d+)\. ", page, re.MULTILINE)


def claims(lines):
    """The lines of operations.txt: (client, operation or number, program in CTest, test)."""
    return [re.fullmatch(r"(\w+) (\w+) (\w+): (.+)", line).groups() for line in lines.splitlines() if not line.startswith("#")]


def sources(program):
    """The source files that contain the tests of a program."""
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


def code_of(program):
    return "\n".join(path.read_text(encoding="utf-8") for path in sources(program) if path.is_file())


def has_test(text, name):
    if re.fullmatch(r"\w+\.\w+", name):
        suite, test = name.split(".")
        return re.search(rf"^TEST(_F|_P)?\({suite}, {test}\)", text, re.MULTILINE) is not None
    if name.startswith("test_"):
        return re.search(rf"^    def {name}\(self", text, re.MULTILINE) is not None
    return re.search(rf"^ *test\('{re.escape(name)}'", text.replace("\\'", "'"), re.MULTILINE) is not None


def offences(page, lines, operations, programs):
    """The errors in the page and in operations.txt, for these operations of the interface and these programs of CTest.
    """
    found = []
    rows = dict(calls(page))
    found += [f"{name} has no row" for name in sorted(operations - set(rows))]
    found += [f"{name} is no operation of the interface" for name in sorted(set(rows) - operations - {HIT})]
    tests = {}
    for client, subject, program, name in claims(lines):
        tests.setdefault((client, subject), []).append(program)
        if subject not in rows and subject not in numbers(page):
            found.append(f"{client} {subject}: the page has no such row or number")
        if program not in programs:
            found.append(f"{client} {subject}: CTest has no {program}")
        elif not has_test(code_of(program), name):
            found.append(f"{client} {subject}: {program} has no test '{name}'")
    tested = {subject for _, subject in tests}
    found += [f"{number}: operations.txt has no test" for number in numbers(page) if number not in tested]
    for operation, called in rows.items():
        for client, method in ({"http": None} | called).items():
            wanted = tests.get((client, operation))
            if not wanted:
                found.append(f"{client} {operation}: operations.txt has no test")
            elif method and not any(re.search(rf"\.{method}\b", code_of(program)) for program in wanted):
                found.append(f"{client} {operation}: the tests of {', '.join(wanted)} never call .{method}()")
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
        cls.page = PAGE.read_text(encoding="utf-8")
        cls.lines = TESTS.read_text(encoding="utf-8")
        cls.operations = interface()

    def test_all_that_it_says_is_there(self):
        self.assertEqual(offences(self.page, self.lines, self.operations, self.programs), [])
        self.assertEqual(len(numbers(self.page)), 21)
        self.assertGreater(len(claims(self.lines)), 170)

    def test_what_is_missing_is_found(self):
        def changed(old, new):
            self.assertIn(old, self.page + self.lines)
            return offences(self.page.replace(old, new), self.lines.replace(old, new), self.operations, self.programs)
        self.assertEqual(offences(self.page, self.lines, self.operations | {"getTea"}, self.programs), ["getTea has no row"])
        self.assertEqual(changed("| `getJobs` |", "| `getTeas` |")[:2], ["getJobs has no row", "getTeas is no operation of the interface"])
        self.assertIn("has no test 'test_inspekt'", changed("test_inspect\n", "test_inspekt\n")[0])
        self.assertIn("has no test 'a jop is cancelled'", changed("service: a job is cancelled", "service: a jop is cancelled")[0])
        self.assertIn("has no test 'Listed.TheOldestComesFirst'", changed("Listed.TheNewest", "Listed.TheOldest")[0])
        self.assertIn("CTest has no client_python_tea", changed("client_python_server: test_inspect", "client_python_tea: test_inspect")[0])
        self.assertIn("never call .inspekt()", changed("`client.inspect()` | `inspect`", "`client.inspekt()` | `inspect`")[0])
        self.assertEqual(changed("| `health` |", "| `health`, Blender |"), [f"blender {name}: operations.txt has no test"
                                                                            for name in ("getLivez", "getReadyz")])
        self.assertIn("21: the page has no such row or number", changed("\n21. ", "\n22. ")[0])
        self.assertIn("22: operations.txt has no test", changed("\n21. ", "\n22. ")[-1])
        gone = offences(self.page, self.lines, self.operations, self.programs - {"server_jobs_tests"})
        self.assertEqual(len(gone), self.lines.count(" server_jobs_tests:"))


if __name__ == "__main__":
    if yaml is None:
        print("skipped: PyYAML is not installed (python3-yaml)")
        sys.exit(SKIPPED)
    Page.build = sys.argv.pop(1)
    unittest.main(verbosity=2)
