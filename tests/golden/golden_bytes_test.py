#!/usr/bin/env python3
"""Tests that the answers have the stored bytes. The comparison must find one flipped bit, a version that was forgotten
and one that was not stored."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import golden_bytes  # noqa: E402

PROGRAM = sys.argv.pop(1)


class GoldenBytes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.answers = golden_bytes.make_answers(PROGRAM, pathlib.Path(cls.folder.name))
        cls.hashes = golden_bytes.hashes_of(cls.answers)
        cls.version = golden_bytes.algorithm_of(PROGRAM)
        cls.stored_version, cls.stored = golden_bytes.read_stored()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_answers_have_the_stored_bytes(self):
        self.assertIsNone(golden_bytes.complaint(self.stored_version, self.stored, self.version, self.hashes))

    def test_every_request_has_its_own_answer(self):
        self.assertEqual(len(set(self.hashes.values())), len(self.hashes))
        self.assertGreaterEqual(len(self.hashes), len(golden_bytes.REQUESTS))

    def test_one_flipped_bit_is_found_in_every_file(self):
        for path in sorted(self.answers.iterdir()):
            whole = path.read_bytes()
            middle = len(whole) // 2
            path.write_bytes(whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1:])
            flipped = golden_bytes.hashes_of(self.answers)
            path.write_bytes(whole)
            said = golden_bytes.complaint(self.version, self.hashes, self.version, flipped)
            self.assertIn(f": {path.name}. If this is meant, raise kAlgorithmVersion", said)

    def test_a_new_version_needs_new_hashes(self):
        said = golden_bytes.complaint(self.version - 1, self.hashes, self.version, self.hashes)
        self.assertIn("scripts/golden --write", said)

    def test_a_request_without_a_stored_hash_is_found(self):
        fewer = dict(self.hashes)
        del fewer["uniform.glb"]
        self.assertIn("uniform.glb", golden_bytes.complaint(self.version, fewer, self.version, self.hashes))

    def test_a_released_version_keeps_its_hashes(self):
        def at_base(name):
            done = subprocess.run(["git", "-C", str(golden_bytes.ROOT), "show", f"{base}:{name}"], capture_output=True, text=True)
            if done.returncode != 0:
                self.skipTest(f"git has no {name} at the base {base}")
            return done.stdout
        if not shutil.which("git") or not (golden_bytes.ROOT / ".git").exists():
            self.skipTest("this is not a git checkout")
        sys.path.insert(0, str(golden_bytes.ROOT / "scripts/lib"))
        from checks.checkout import Checkout
        base = Checkout(golden_bytes.ROOT).base
        if not base:
            self.skipTest("the repository has no earlier commit to compare with")
        self.assertIsNone(golden_bytes.change_after_release(golden_bytes.STORED.read_text(), at_base("tests/golden/golden_bytes.tsv"),
                                                            at_base("CHANGELOG.md")))


class Released(unittest.TestCase):
    """The rules for the hashes of a version that is or is not released."""

    undated, dated = (f"# Changelog\n\n## Algorithm 28 - {day}\n\n### Added\n\n## Algorithm 27 - 2026-11-30\n"
                      for day in ("unreleased", "2026-12-24"))

    def test_only_hashes_of_the_newest_version_that_is_unreleased_are_replaced(self):
        self.assertIsNone(golden_bytes.refusal_of_unreleased(28, self.undated))
        for version, changelog in ((28, self.dated), (27, self.undated), (29, self.undated)):
            self.assertIn(f'is not "## Algorithm {version} - unreleased"', golden_bytes.refusal_of_unreleased(version, changelog))

    def test_a_hash_that_changes_after_the_release_is_found(self):
        before, after, more = "algorithm\t28\na.glb\t01\n", "algorithm\t28\na.glb\t02\n", "algorithm\t28\na.glb\t01\nb.glb\t03\n"
        self.assertIn("changed: a.glb", golden_bytes.change_after_release(after, before, self.dated))
        for table, base, changelog in ((after, before, self.undated), (before, before, self.dated), (more, before, self.dated),
                                       (after.replace("28", "29"), before, self.dated)):
            self.assertIsNone(golden_bytes.change_after_release(table, base, changelog))


if __name__ == "__main__":
    unittest.main()
