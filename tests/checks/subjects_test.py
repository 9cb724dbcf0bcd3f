#!/usr/bin/env python3
"""Tests scripts/check subjects: the commits of a branch need subjects of the form `area: verb object`."""
import os
import subprocess
import sys
import unittest
from unittest import mock

from planted import ROOT, PlantedCheckout

sys.path.insert(0, str(ROOT / "scripts" / "lib"))
sys.dont_write_bytecode = True
from checks import subjects  # noqa: E402

GOOD = ("delaunay: reuse the last located tetrahedron", "server, tests: mend two races", "import_worker: divide the pool by workers",
        "http: let a client close its connection, and say so in the log", "scripts/bench: write results as CSV", "tests: re-read a file",
        "a: " + "b" * 30 + " " + "c" * 38)
BAD = {"Who waits for the end of a parallel loop stays awake": "is not `area: verb object`",
       "The snapshot that forgets is tested where it forgets": "is not `area: verb object`",
       "Delaunay: reuse the last tetrahedron": "is not `area: verb object`",
       "delaunay : reuse it": "is not `area: verb object`",
       "delaunay: reuse": "is not `area: verb object`",
       "delaunay: Reuse the last tetrahedron": "but continues with 'Reuse'",
       "docs: CONTRIBUTING says how": "but continues with 'CONTRIBUTING'",
       "hollow: the inner sides have fewer triangles": "'the', which is not a verb",
       "hollow: what bends has more triangles": "'what', which is not a verb",
       "delaunay: reuse the last tetrahedron.": "ends with a period",
       "a: " + "b" * 30 + " " + "c" * 39: "has 73 characters"}


class Subjects(PlantedCheckout):
    def test_subjects(self):
        for subject in GOOD:
            self.assertEqual(list(subjects.faults(subject)), [], subject)
        for subject, fault in BAD.items():
            self.assertIn(fault, "; ".join(subjects.faults(subject)), subject)

    def test_only_commits_of_the_branch_count(self):
        self.commit_empty("What main has is no matter")
        self.commit_empty("base: double a number")
        self.expect_clean("subjects")
        self.git("checkout", "--quiet", "-b", "branch")
        self.commit_empty("base: halve a number")
        self.commit_empty("base: halve it again")
        self.expect_clean("subjects")
        self.commit_empty("Halves a number")
        self.commit_empty("base: halve it once more")
        self.expect_found("subjects", "'Halves a number' is not `area: verb object`", "1 found")

    def test_the_base_may_be_named(self):
        self.commit_empty("Halves a number")
        self.commit_empty("base: halve it again")
        self.expect_clean("subjects")
        with mock.patch.dict(os.environ, {"FRACTURE_CHECK_BASE": "HEAD~2"}):
            done = subprocess.run([sys.executable, str(ROOT / "scripts/check"), "--root", str(self.root), "subjects"], text=True,
                                  capture_output=True)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)

    def test_a_merge_has_the_subject_that_git_gives_it(self):
        self.git("checkout", "--quiet", "-b", "branch")
        self.git("checkout", "--quiet", "-b", "other")
        self.commit_empty("base: halve a number")
        self.git("checkout", "--quiet", "branch")
        self.git("-c", "user.name=a", "-c", "user.email=a@b", "-c", "core.hooksPath=/dev/null", "merge", "--quiet", "--no-ff", "other")
        self.expect_clean("subjects")

    def commit_empty(self, subject):
        self.git("-c", "user.name=a", "-c", "user.email=a@b", "-c", "core.hooksPath=/dev/null", "commit", "--quiet", "--allow-empty",
                 "-m", subject)


if __name__ == "__main__":
    unittest.main(verbosity=2)
