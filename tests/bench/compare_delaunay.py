#!/usr/bin/env python3
"""Runs bench_delaunay and its peers alternately on the same workloads and prints the ratios of their best times.

Usage: compare_delaunay.py BUILD_FOLDER [--rounds N] [--check] [WORKLOAD...]
Times are processor times; alternating makes a busy machine disturb all programs alike. With --check the sets of tetrahedra must agree with CGAL's
on generic inputs (lattices are left out: there each program has its own tie rule); the exit status says so.
"""
import argparse
import pathlib
import re
import subprocess
import sys

LINE = re.compile(r"^(\S+)\s+(\d+) points\s+([\d.]+) ms\s+(\d+) tets\s+hash (\w+)", re.M)
WORKLOADS = ["random_100", "random_1k", "random_10k", "random_100k", "random_1M",
             "lattice22_21st", "lattice22_integer", "sphere_10k", "clusters_50k"]


def run(program, workload, check):
    arguments = [str(program), "--runs", "1", workload] + (["--check"] if check else [])
    output = subprocess.run(arguments, capture_output=True, text=True)
    match = LINE.search(output.stdout)
    if output.returncode != 0 or not match:
        sys.exit(f"{program.name} {workload} failed:\n{output.stdout}{output.stderr}")
    return float(match[3]), int(match[4]), match[5]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("workloads", nargs="*", default=WORKLOADS)
    options = parser.parse_intermixed_args()
    folder = pathlib.Path(options.build) / "tests" / "bench"
    ours = folder / "bench_delaunay"
    peers = {name: folder / f"bench_delaunay_{name}" for name in ("cgal", "voropp")}
    peers = {name: path for name, path in peers.items() if path.exists()}

    print(f"{'workload':<18} {'ours ms':>10}" + "".join(f" {name + ' ms':>12} {'ratio':>6}" for name in peers))
    wrong = []
    for workload in options.workloads or WORKLOADS:
        best = {}
        answers = {}
        for round_number in range(options.rounds):
            for name, path in [("ours", ours), *peers.items()]:
                check = options.check and round_number == 0 and name != "voropp"
                ms, tets, digest = run(path, workload, check)
                best[name] = min(best.get(name, ms), ms)
                if check:
                    answers[name] = (tets, digest)
        line = f"{workload:<18} {best['ours']:>10.2f}"
        for name in peers:
            line += f" {best[name]:>12.2f} {best[name] / best['ours']:>6.2f}"
        if "cgal" in answers and not workload.startswith("lattice"):
            same = answers["ours"] == answers["cgal"]
            line += "  same tetrahedra" if same else f"  DIFFERENT: {answers}"
            if not same:
                wrong.append(workload)
        print(line, flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
