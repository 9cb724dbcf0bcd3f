#!/usr/bin/env python3
"""Tests scripts/lib/count_tests.py: the counts of a ctest run and of a second run."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

COUNT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "lib" / "count_tests.py"


class Counting(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.run_folder = pathlib.Path(folder.name) / "release"

    def write(self, programs, folder="", reports=None, seconds=None):
        """Writes the results. `programs` holds names and statuses as ctest writes them. `reports` holds the cases of
        each GoogleTest program with their results."""
        place = self.run_folder / folder
        (place / "gtest").mkdir(parents=True)
        cases = "".join(f'<testcase name="{name}" status="{"run" if status == "skipped" else status}" time="{(seconds or {}).get(name, 0)}">'
                        f'{"<skipped/>" if status == "skipped" else ""}{"<failure/>" if status == "fail" else ""}</testcase>'
                        for name, status in programs.items())
        (place / "junit.xml").write_text(f"<testsuite>{cases}</testsuite>")
        for program, outcomes in (reports or {}).items():
            tests = [{"name": case, "result": "SKIPPED" if came == "skipped" else "COMPLETED",
                      **({"failures": [{}]} if came == "fail" else {})} for case, came in outcomes.items()]
            (place / "gtest" / f"{program}.json").write_text(json.dumps({"testsuites": [{"name": "Suite", "testsuite": tests}]}))

    def counted(self, *lines, code, options=(), folders=()):
        done = subprocess.run([sys.executable, COUNT, *options, self.run_folder, *folders], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.stdout.splitlines(), done.returncode, done.stderr), (list(lines), code, ""))

    def test_programs_and_their_cases(self):
        self.write({"script": "run", "absent": "skipped", "cases": "run"}, reports={"cases": {"A": "good", "B": "good", "C": "skipped"}})
        self.counted("3 passed, 0 failed, 2 skipped", code=0)

    def test_a_failure_and_a_crash(self):
        self.write({"script": "fail", "cases": "fail", "crash": "fail"},
                   reports={"cases": {"A": "good", "B": "fail"}, "crash": {"A": "good"}})
        self.counted("FAILED release: script", "FAILED release: cases: Suite.B", "FAILED release: crash", "2 passed, 3 failed, 0 skipped", code=1)

    def test_what_passes_at_the_second_try_counts_and_is_named(self):
        self.write({"script": "fail", "steady": "run"})
        self.write({"script": "run"}, "again")
        self.counted("UNSTEADY release: passed only when run again alone: script", "2 passed, 0 failed, 0 skipped", code=0)

    def test_what_fails_twice_has_failed(self):
        self.write({"cases": "fail"}, reports={"cases": {"A": "fail", "B": "good"}})
        self.write({"cases": "fail"}, "again", {"cases": {"A": "good", "B": "fail"}})
        self.counted("FAILED release: cases: Suite.A", "1 passed, 1 failed, 0 skipped", code=1)

    def test_the_slowest_are_named(self):
        self.write({f"t{k}": "run" for k in range(12)}, seconds={f"t{k}": 1.2 + k for k in range(12)})
        names = ", ".join(f"t{k} {1.2 + k:.0f} s" for k in range(11, 1, -1))
        self.counted(f"slowest of release: {names}", "12 passed, 0 failed, 0 skipped", code=0)

    def test_a_skipped_program_needs_a_reason(self):
        self.write({"absent": "skipped", "partly": "run", "wholly": "run", "script": "run"},
                   reports={"partly": {"A": "good", "B": "skipped"}, "wholly": {"A": "skipped"}})
        may_skip = self.run_folder / "may_skip.txt"
        may_skip.write_text("# a comment\nabsent: no such machine here\n")
        self.counted("FAILED wholly: skipped entirely in every run, and may_skip.txt gives no reason",
                     "2 passed, 1 failed, 3 skipped", code=1, options=("--may-skip", may_skip))
        may_skip.write_text("absent: no such machine here\nwholly: nor here\n")
        self.counted("2 passed, 0 failed, 3 skipped", code=0, options=("--may-skip", may_skip))
        self.counted("2 passed, 0 failed, 3 skipped", code=0)

    def test_a_program_that_one_of_two_runs_executed_is_not_skipped(self):
        self.write({"allocator": "run"}, reports={"allocator": {"A": "good"}})
        self.write({"allocator": "run"}, "../asan", {"allocator": {"A": "skipped"}})
        may_skip = self.run_folder / "may_skip.txt"
        may_skip.write_text("")
        self.counted("1 passed, 0 failed, 1 skipped", code=0, options=("--may-skip", may_skip), folders=[self.run_folder.parent / "asan"])

    def test_no_report_and_no_test_are_failures(self):
        self.counted("FAILED release: ctest wrote no report", "0 passed, 1 failed, 0 skipped", code=1)
        self.write({})
        self.counted("0 passed, 0 failed, 0 skipped", code=1)


if __name__ == "__main__":
    unittest.main()
