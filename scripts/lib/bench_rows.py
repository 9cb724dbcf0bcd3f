"""The rows of scripts/bench: the cases, the programs that measure them, and the goals.

A contender is `ours`, `last` (the release to compare with) or a peer. Each run gives a Sample. The programs check their
own results and fail if a result is wrong.
"""
import dataclasses
import json
import math
import os
import pathlib
import re
import subprocess
import tempfile
import threading
import time

NUMBER = r"([\d.]+)"
LONGEST = 900  # maximum seconds for one run of a program
MOST_SITES, HIT_SITES = 100_000, 30  # maximum sites of a request (common/pipeline); cells of a hit of bench_local_impact


class Unknown(Exception):
    """Raised if the program of an earlier release does not support a row."""


@dataclasses.dataclass
class Sample:
    value: float  # in milliseconds, or in the row's unit
    answer: str = ""  # a hash of the result, or empty if the program prints none
    peak: int = 0  # peak memory of the process, in KiB


@dataclasses.dataclass
class Row:
    benchmark: str
    case: str
    ask: dict  # contender -> function (Bench, Build) -> Sample; "ours" is also used for "last"
    threads: int = 1  # number of threads or cores used; 0: the program decides
    unit: str = "ms"
    goal_peer: float = 0  # times as fast as the first peer (goals of 22 November 2026); 0: none
    goal_last: float = 0  # times as fast as 205c8dc, if that is the release to compare with; 0: none
    target: float = 0  # target value in the row's unit; 0: none
    quick: bool = False
    rounds: int = 0  # maximum number of rounds; 0: the requested number
    larger_is_better: bool = False
    memory: bool = False  # compare peak memory in MiB

    @property
    def name(self):
        threads = f", {self.threads} threads" if self.threads > 1 else ""
        return f"{self.benchmark} {self.case}{threads}"


@dataclasses.dataclass
class Build:
    folder: pathlib.Path  # CMake's build folder
    known: bool = True  # True if its programs come from this checkout

    def program(self, name):
        path = self.folder / ("server" if name == "fracture-server" else "tests/bench") / name
        if not path.exists():
            raise Unknown(f"{path} is not built")
        return path


@dataclasses.dataclass
class Bench:
    ours: Build
    work: pathlib.Path  # temporary folder for the peers' inputs
    manifold: pathlib.Path  # tests/bench/manifold of this checkout
    checked: set = dataclasses.field(default_factory=set)  # cases already compared with peers


def run(command, environment=None):
    """Runs a program. Returns its standard output and its peak memory (KiB). Raises RuntimeError if it reports a failure."""
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        child = subprocess.Popen([str(word) for word in command], stdout=output, stderr=errors,
                                 env={**os.environ, **(environment or {})})
        alarm = threading.Timer(LONGEST, child.kill)
        alarm.start()
        _, status, usage = os.wait4(child.pid, 0)
        alarm.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        errors.seek(0)
        text = output.read()
        if child.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, command))} ended with {child.returncode}:\n{text[-600:]}{errors.read()[-600:]}")
        return text, usage.ru_maxrss


def found(pattern, text):
    match = re.search(pattern, text, re.M)
    if not match:
        raise Unknown(f"no line like {pattern!r}")
    return match


# -- the whole fracture

def fracture(mesh, sites, hulls, threads=1):
    label = f"{mesh}_{sites}"

    def ask(bench, build):
        text, peak = run([build.program("bench_fracture"), "--filter", label, "--only", label, "--seconds", "0.3",
                          "--hulls", "yes" if hulls else "no", "--threads", threads])
        line = found(rf"^{mesh} +\d+ triangles +{sites} sites {'with' if hulls else 'without'} hulls: .* at least {NUMBER} .*, (\w+)$",
                     text)
        return Sample(float(line[1]), line[2], peak)
    return ask


def manifold(mesh, sites):
    label = f"{mesh}_{sites}"

    def ask(bench, build):
        folder = bench.work / label
        if not folder.exists():
            run([bench.ours.program("bench_fracture"), "--filter", label, "--only", label, "--seconds", "0", "--out", folder])
        text, peak = run(["node", bench.manifold / "fracture.mjs", folder, label, "1"])
        return Sample(float(found(rf"manifold-3d {NUMBER} ms", text)[1]), peak=peak)
    return ask


# -- the tetrahedralization

def delaunay(workload, peer=""):
    """Returns the function that measures a workload. CGAL must find the same tetrahedra, except in lattices, where each program
    breaks ties in its own way."""
    compared = peer == "cgal" and not workload.startswith("lattice")

    def ask(bench, build):
        program = bench.ours.program(f"bench_delaunay_{peer}") if peer else build.program("bench_delaunay")
        text, peak = run([program, "--runs", "1", workload])
        line = found(rf"^{workload} +\d+ points +{NUMBER} ms +(\d+) tets +hash (\w+)", text)
        answer = "" if peer else line[3]
        if compared and workload not in bench.checked:
            bench.checked.add(workload)
            answer = found(r"hash (\w+)", run([program, "--runs", "1", workload, "--check"])[0])[1]
        return Sample(float(line[1]), answer, peak)
    return ask


def stage(name, threads=1):
    def ask(bench, build):
        text, peak = run([build.program("bench_stages"), "--threads", threads, "--runs", 1, name])
        line = found(rf"^{name} +{NUMBER} ms +hash (\w+)", text)
        return Sample(float(line[1]), line[2], peak)
    return ask


def read(name, peer=""):
    def ask(bench, build):
        text, peak = run([(bench.ours if peer else build).program("bench_readers"), "--runs", 1, name])
        return Sample(float(found(rf"^{name}{'_' + peer if peer else ''} +{NUMBER} ms", text)[1]), peak=peak)
    return ask


# -- hits

def hit(cells, line="without the untouched", hulls=False):
    """A hit on a stored answer. `line`: the time to take, of the changed fragments or ("a hit") of the whole answer."""
    def ask(bench, build):
        sites = min(cells, MOST_SITES - HIT_SITES)
        text, peak = run([build.program("bench_local_impact"), "--sites", sites, "--repeat", 2 if sites > 9999 else 7,
                          "--hulls", int(hulls)])
        kind = "with" if hulls else "without"
        return Sample(float(found(rf"^{kind} hulls:[^$]*?{line} {NUMBER} ms", text)[1]), peak=peak)
    return ask


# -- the server

def request(members, percentile, cores="", requests=200):
    def ask(bench, build):
        command = [bench.ours.program("bench_server"), "--collision", members, "--requests", requests]
        text, _ = run((["taskset", "-c", cores] if cores else []) + command,
                      {"FRACTURE_TEST_SERVER": str(build.program("fracture-server"))})
        line = found(rf"whole answer +p50 +{NUMBER} ms +p99 +{NUMBER} ms", text)
        return Sample(float(line[1 if percentile == 50 else 2]))
    return ask


# -- the command line

def torus(path, rings=32, around=16, radius=0.3):
    with open(path, "w") as out:
        for i in range(rings):
            for j in range(around):
                a, b = 2 * math.pi * i / rings, 2 * math.pi * j / around
                x = 1 + radius * math.cos(b)
                out.write(f"v {x * math.cos(a)} {radius * math.sin(b)} {x * math.sin(a)}\n")
        for i in range(rings):
            for j in range(around):
                corner = [(i + di) % rings * around + (j + dj) % around + 1 for di, dj in ((0, 0), (0, 1), (1, 1), (1, 0))]
                out.write("f {} {} {} {}\n".format(*corner))


def bake_one(bench, build):
    mesh = bench.work / "torus.obj"
    if not mesh.exists():
        torus(mesh)
    least = math.inf
    for _ in range(5):
        start = time.perf_counter()
        run([build.program("fracture-server"), "bake", mesh, "-o", bench.work / "torus.glb", "--sites", 20, "--quiet"])
        least = min(least, 1000 * (time.perf_counter() - start))
    return Sample(least)


def bake_many(bench, build, files=200):
    """Measures how many small files are baked per second, one job each, with two workers."""
    with tempfile.TemporaryDirectory(dir=bench.work) as folder:
        with open(f"{folder}/jobs.ndjson", "w") as jobs:
            for k in range(files):
                torus(f"{folder}/{k}.obj", radius=0.2 + 0.001 * k)
                jobs.write(json.dumps({"input": f"{k}.obj", "output": f"out/{k}.glb", "parameters": {"sites": 10}}) + "\n")
        start = time.perf_counter()
        run([build.program("fracture-server"), "bake", "--manifest", f"{folder}/jobs.ndjson", "--quiet"])
        return Sample(files / (time.perf_counter() - start))


# -- all of them

def all_rows():
    rows, cores = [], os.cpu_count()
    # mesh, sites: milliseconds of the peer, of the goal with hulls, and of 205c8dc with hulls
    for mesh, sites, peer, goal, before in (
            ("sphere2k", 10, 20.8, 0.6, 1.24), ("sphere2k", 50, 56, 1.4, 2.89), ("sphere2k", 200, 148, 3.6, 7.6),
            ("sphere2k", 1000, 529, 14, 29.7), ("sphere20k", 50, 337, 4, 8.9), ("sphere20k", 200, 778, 7.5, 17.5),
            ("sphere20k", 1000, 3277, 20, 44.7), ("torus2k", 50, 61, 1.3, 2.7), ("torus2k", 1000, 584, 14, 30.3),
            ("spot", 50, 149, 1.9, 4.0), ("spot", 1000, 1494, 15, 32), ("hammer", 50, 1034, 7, 15.8),
            ("hammer", 1000, 10627, 26, 58.1)):
        quick = (mesh, sites) in (("sphere2k", 50), ("sphere2k", 1000), ("sphere20k", 200))
        rows.append(Row("fracture", f"{mesh} × {sites}, hulls",
                        {"ours": fracture(mesh, sites, True), "manifold-3d": manifold(mesh, sites)},
                        goal_peer=peer / goal, goal_last=before / goal, quick=quick, rounds=3 if peer > 3000 else 0))
        rows.append(Row("fracture", f"{mesh} × {sites}", {"ours": fracture(mesh, sites, False)}, quick=quick))
    rows.append(Row("fracture", "sphere20k × 1000, hulls", {"ours": fracture("sphere20k", 1000, True, threads=2)}, threads=2))
    for points, peer, goal, before in (("1k", 2.9, 0.9, 0.97), ("10k", 34.7, 9.5, 12.9), ("100k", 377, 125, 184), ("1M", 3957, 1400, 2105)):
        workload = f"random_{points}"
        rows.append(Row("Delaunay", points, {"ours": delaunay(workload), "CGAL": delaunay(workload, "cgal"),
                                             "Voro++": delaunay(workload, "voropp")},
                        goal_peer=peer / goal, goal_last=before / goal, quick=points in ("1k", "10k"), rounds=3 if points == "1M" else 0))
    rows.append(Row("Delaunay", "1M, peak memory", {"ours": delaunay("random_1M"), "CGAL": delaunay("random_1M", "cgal")}, unit="MiB",
                    memory=True, goal_peer=589 / 420, goal_last=765 / 420, rounds=1))
    for name, workload, peer, goal, before in (("lattice 22³", "lattice22_21st", 180, 20, 41.7),
                                               ("integer lattice", "lattice22_integer", 53.6, 12, 22.3),
                                               ("on a sphere, 10k", "sphere_10k", 135, 30, 45.5)):
        rows.append(Row("Delaunay", name, {"ours": delaunay(workload), "CGAL": delaunay(workload, "cgal")},
                        goal_peer=peer / goal, goal_last=before / goal))
    rows.append(Row("canonical order", "100k sites", {"ours": stage("canonical_100k")}, goal_last=211 / 40, quick=True))
    for cells, goal, before in ((300, 2.5, 3.3), (3000, 3, 10), (30000, 6, 140), (100000, 12, 820)):
        rows.append(Row("hit", f"in {cells} cells", {"ours": hit(cells)}, goal_last=before / goal, quick=cells == 3000,
                        rounds=2 if cells > 9999 else 0))
    rows.append(Row("hit", "in 300 cells, whole answer", {"ours": hit(300, "a hit")}))
    rows.append(Row("hit", "in 300 cells, hulls", {"ours": hit(300, hulls=True)}))
    for size, threads, goal in (("1M", 1, 60), ("4M", 1, 260), ("1M", 2, 40), ("4M", 2, 170)):
        rows.append(Row("prepare", f"{size} triangles", {"ours": stage(f"prepare_{size}", threads)}, threads=threads, target=goal, rounds=3))
    rows.append(Row("read", "an OBJ with 1M triangles", {"ours": read("obj_1M"), "Assimp": read("obj_1M", "assimp")}, goal_peer=5, rounds=3))
    giant = {"ours": stage("giant_100k")}
    rows.append(Row("large answer", "100k sites in sphere20k, hulls, GLB", giant, target=1800, rounds=2))
    rows.append(Row("large answer", "100k sites in sphere20k, peak memory", giant, unit="MiB", memory=True, target=1024, rounds=1))
    flat = '"sites": 50'
    for name, members, one_core, p, goal, before in (
            ("p50", flat, True, 50, 2.4, 4.0), ("p99", flat, True, 99, 3.5, 5.5),
            ("p50", flat, False, 50, 1.9, 3.7), ("p99", flat, False, 99, 3, 5.1),
            ("stone, p50", flat + ', "material": "stone"', False, 50, 5, 27),
            ("wood, p50", flat + ', "material": "wood"', False, 50, 5, 0),
            ("glass with a hit, p50", '"material": "glass", "impacts": [[0, 0, 0.8]]', False, 50, 1.2, 1.6)):
        rows.append(Row("request", name, {"ours": request(members, p, "0" if one_core else "")}, threads=1 if one_core else cores,
                        goal_last=before / goal, quick=name == "p50" and not one_core))
    rows.append(Row("bake", "a small mesh", {"ours": bake_one}, threads=0, goal_last=47 / 12, quick=True))
    rows.append(Row("bake", "small files", {"ours": bake_many}, threads=cores, unit="/s", larger_is_better=True, goal_last=500 / 64))
    return rows
