#!/usr/bin/env python3
"""Tests the results of scripts/bench: the stored files are complete, and the README and its chart match what they
generate."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "lib"))
sys.dont_write_bytecode = True
import bench_chart  # noqa: E402
import bench_results  # noqa: E402
from bench_results import Result  # noqa: E402
from bench_rows import Row, Sample, all_rows  # noqa: E402

loader = importlib.machinery.SourceFileLoader("bench", str(ROOT / "scripts" / "bench"))
bench = importlib.util.module_from_spec(importlib.util.spec_from_loader("bench", loader))
loader.exec_module(bench)
OURS = {"date": "2026-11-29", "algorithm": "22", "commit": "abc", "machine": "two cores"}


def result(case="a", kind="", against="", value="", ratio="", goal="", ours="2", benchmark="Delaunay", **more):
    fields = {**OURS, "benchmark": benchmark, "case": case, "threads": "1", "unit": "ms", "ours": ours, "median": "", "kind": kind,
              "against": against, "value": value, "ratio": ratio, "goal": goal}
    return Result(**{**fields, **more})


class Stored(unittest.TestCase):
    def setUp(self):
        self.files = bench_results.read_all(ROOT)

    def test_the_table_is_that_of_the_stored_results(self):
        page = (ROOT / bench_results.PAGE).read_text(encoding="utf-8")
        self.assertEqual(bench_results.with_table(page, self.files), page, "scripts/bench --table writes it")

    def test_the_page_is_short(self):
        self.assertLessEqual(len((ROOT / bench_results.PAGE).read_text(encoding="utf-8").split()), 900)

    def test_the_chart_is_that_of_the_stored_results(self):
        chart = (ROOT / bench_chart.PATH).read_text(encoding="utf-8")
        self.assertEqual(bench_chart.draw(self.files), chart, "scripts/bench --table writes it")

    def test_files_are_whole(self):
        self.assertTrue(self.files)
        known = {(row.benchmark, row.case) for row in all_rows()}
        for name, results in self.files.items():
            self.assertEqual(bench_results.write(results), (ROOT / bench_results.FOLDER / name).read_text(encoding="utf-8"))
            seen = set()
            for r in results:
                with self.subTest(name, row=r.row, against=r.against):
                    self.assertEqual(f"{r.date}.csv", name)
                    self.assertIn((r.benchmark, r.case), known)
                    self.assertIn(r.kind, bench_results.KINDS)
                    self.assertNotIn((r.row, r.kind, r.against), seen)
                    self.assertTrue(r.ours and r.unit in ("ms", "MiB", "/s"))
                    seen.add((r.row, r.kind, r.against))
                    if r.kind:
                        ratio = float(r.ours) / float(r.value) if r.unit == "/s" else float(r.value) / float(r.ours)
                        self.assertAlmostEqual(float(r.ratio) / ratio, 1, delta=0.04)  # both values are rounded
                    else:
                        self.assertEqual((r.against, r.value, r.ratio, r.goal), ("", "", "", ""))


class Files(unittest.TestCase):
    def test_what_is_written_is_read(self):
        results = [result(case="a, \"b\" × 3", kind="peer", against="CGAL", value="4", ratio="2.00", goal="1.5"), result(case="c")]
        self.assertEqual(bench_results.read(bench_results.write(results)), results)

    def test_files_with_other_columns_are_refused(self):
        good = bench_results.write([result()])
        for bad in ("", good.replace("goal", "aim", 1), good + "2026-11-29,22\n"):
            with self.assertRaises(ValueError):
                bench_results.read(bad)

    def test_what_is_measured_again_takes_the_place_of_the_older(self):
        old = [result("a", "peer", "CGAL", "4", "2.00"), result("a", "release", "v1", "3", "1.50"), result("b")]
        new = [result("a", "peer", "CGAL", "5", "2.50")]
        self.assertEqual(bench_results.merge(old, new), [old[2], new[0]])

    def test_the_table_has_the_newest_result_of_each_row(self):
        files = {"2026-11-28.csv": [result("a", "peer", "CGAL", "4", "2.00", date="2026-11-28"),
                                    result("b", "target", "", "1", "0.50", "1", date="2026-11-28"), result("c", date="2026-11-28")],
                 "2026-11-29.csv": [result("a", "peer", "CGAL", "6", "3.00", "3"), result("a", "peer", "Voro++", "9", "4.50"),
                                    result("a", "release", "v1", "3", "1.50", "1.7")]}
        self.assertEqual(bench_results.table(files).splitlines()[2:],
                         ["|Delaunay a|1|2 ms|1.50 × v1 (goal 1.7)|3.00 × CGAL (goal 3), 4.50 × Voro++|missed|22|11-29|",
                          "|Delaunay b|1|2 ms|||1 ms: missed|22|11-28|"])

    def test_a_page_without_a_place_for_the_table_is_refused(self):
        page = f"before\n{bench_results.BEGIN}\nold\n{bench_results.END}\nafter\n"
        done = bench_results.with_table(page, {"a": [result("a", "peer", "CGAL", "4", "2.00")]})
        self.assertTrue(done.startswith("before\n") and done.endswith("\nafter\n") and "old" not in done and "2.00 × CGAL" in done)
        with self.assertRaises(ValueError):
            bench_results.with_table("before\nafter\n", {})


class Chart(unittest.TestCase):
    def test_a_line_has_the_mean_of_the_cases_that_all_days_have(self):
        files = {"2026-11-28.csv": [result("a", "peer", "CGAL", "4", "2"), result("b", "peer", "CGAL", "4", "8"),
                                    result("c", "peer", "CGAL", "4", "99"), result("a", "peer", "Voro++", "4", "2")],
                 "2026-11-29.csv": [result("a", "peer", "CGAL", "4", "3"), result("b", "peer", "CGAL", "4", "12")]}
        (label, line), = bench_chart.series(files).items()
        self.assertEqual(label, "Delaunay vs CGAL")
        self.assertAlmostEqual(line["2026-11-28.csv"], 4)
        self.assertAlmostEqual(line["2026-11-29.csv"], 6)
        self.assertIn("Delaunay vs CGAL: 6<", bench_chart.draw(files))

    def test_labels_do_not_overlap(self):
        self.assertEqual(bench_chart.spread([10, 12, 50], 14), [10, 24, 50])

    def test_no_results_make_an_empty_chart(self):
        self.assertIn("</svg>", bench_chart.draw({}))


class Compared(unittest.TestCase):
    def compare(self, row, samples, start=True):
        return bench.compare(row, samples, start, "v1", OURS)

    def test_peers_release_and_target(self):
        row = Row("Delaunay", "1k", {}, goal_peer=3.2, goal_last=1.5, target=1)
        ours = [Sample(2, "x"), Sample(3, "x"), Sample(2.5, "x")]
        found = self.compare(row, {"ours": ours, "last": [Sample(3, "x")], "CGAL": [Sample(8)], "Voro++": [Sample(50)]})
        self.assertEqual([(r.kind, r.against, r.value, r.ratio, r.goal) for r in found],
                         [("peer", "CGAL", "8", "4.00", "3.2"), ("peer", "Voro++", "50", "25.0", ""), ("release", "v1", "3", "1.50", "1.5"),
                          ("target", "", "1", "0.50", "1.0")])
        self.assertEqual({(r.ours, r.median, r.commit, r.threads) for r in found}, {("2", "2.5", "abc", "1")})
        self.assertEqual([r.reached for r in found], [True, False, True, False])

    def test_another_release_has_no_goal(self):
        found = self.compare(Row("hit", "in 300 cells", {}, goal_last=1.5), {"ours": [Sample(2)], "last": [Sample(4)]}, start=False)
        self.assertEqual([(r.ratio, r.goal) for r in found], [("2.00", "")])

    def test_memory_and_rates(self):
        found, = self.compare(Row("Delaunay", "peak", {}, unit="MiB", memory=True),
                              {"ours": [Sample(9, peak=2048)], "CGAL": [Sample(1, peak=4096)]})
        self.assertEqual((found.ours, found.value, found.ratio), ("2", "4", "2.00"))
        found, = self.compare(Row("bake", "small files", {}, unit="/s", larger_is_better=True),
                              {"ours": [Sample(200), Sample(240)], "last": [Sample(120)]})
        self.assertEqual((found.ours, found.ratio), ("240", "2.00"))

    def test_a_row_that_is_compared_with_nothing(self):
        found, = self.compare(Row("fracture", "a", {}), {"ours": [Sample(2)]})
        self.assertEqual((found.kind, found.ours), ("", "2"))

    def test_other_answers_are_an_error(self):
        row = Row("Delaunay", "1k", {})
        for samples in ({"ours": [Sample(1, "x"), Sample(1, "y")]}, {"ours": [Sample(1, "x")], "CGAL": [Sample(1, "y")]}):
            with self.assertRaises(RuntimeError):
                self.compare(row, samples)

    def test_rows_have_names_of_their_own(self):
        with mock.patch("os.cpu_count", return_value=2):
            names = [(row.benchmark, row.case, row.threads) for row in all_rows()]
        self.assertEqual(len(names), len(set(names)))


if __name__ == "__main__":
    unittest.main()
