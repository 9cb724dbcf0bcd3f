#!/usr/bin/env python3
"""Tests that the answers have the stored bytes. The comparison must find one flipped bit, a version that was forgotten
and one that was not stored."""
import pathlib
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


if __name__ == "__main__":
    unittest.main()
