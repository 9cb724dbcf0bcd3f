#!/usr/bin/env python3
"""Tests scripts/lib/progress.py: what it reports about a build, and that the log has every line."""
import io
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "lib"))
import progress  # noqa: E402


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Progress(unittest.TestCase):
    def follow(self, lines, out):
        """Returns the log. Ten seconds pass with each line."""
        log, now = io.StringIO(), iter(range(0, 10_000, 10))
        progress.follow(lines, log, out, clock=lambda: next(now))
        return log.getvalue()

    def test_a_line_now_and_then_without_a_terminal(self):
        lines = ["cmake says something\n", *(f"[{k}/40] Building CXX object {k}\n" for k in range(1, 9))]
        out = io.StringIO()
        self.assertEqual(self.follow(lines, out), "".join(lines))
        self.assertEqual(out.getvalue().splitlines(), ["   building 1 of 40, about 13 minutes left", "   building 3 of 40, about 8 minutes left",
                                                       "   building 5 of 40, about 7 minutes left", "   building 7 of 40, about 6 minutes left"])

    def test_one_line_is_rewritten_on_a_terminal(self):
        out = Terminal()
        self.follow([f"[{k}/10] a\n" for k in range(1, 11)], out)
        written = out.getvalue()
        self.assertNotIn("\n", written)
        self.assertIn("building 9 of 10, about 10 seconds left", written)
        self.assertEqual(written.split("\r")[-1], "", "nothing is left of it")

    def test_times_in_words(self):
        for seconds, words in ((3, "10 seconds"), (44, "40 seconds"), (58, "1 minute"), (130, "2 minutes")):
            self.assertEqual(progress.in_words(seconds), words)


if __name__ == "__main__":
    unittest.main()
