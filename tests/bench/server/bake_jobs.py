#!/usr/bin/env python3
"""A bake of many jobs on two workers. It writes the same bytes however it is divided, through a server, and
after SIGKILL.

    bake_jobs.py BUILD/server/fracture-server [--jobs 500] [--meshes FOLDER] [--rounds 3]

The jobs combine meshes with parameters. The meshes are those of FOLDER, otherwise of the first folder of
$FRACTURE_TEST_MESHES, otherwise generated. Three invalid meshes are refused in every run. Prints the wall and
processor times of one and of two workers: the least of the rounds, taken in turn because other work on the
machine can only add time. Fails if bytes, reports or exit codes are wrong. With --rounds 0 nothing is timed.
"""
import argparse, hashlib, itertools, json, math, os, pathlib, resource, signal, subprocess, sys, tempfile, time

POISON = 3
CHOICES = [{}, {"material": "wood"}, {"material": "glass"}, {"lloyd": 2}, {"pattern": "clustered"}, {"material": "stone"},
           {"min_fraction": 0.001}, {"levels": [4, 20, 60]}]


def generated(folder):
    """Writes tori of different thickness as OBJ: closed, 3,200 triangles each."""
    rings, sides, meshes = 80, 20, []
    for k in range(8):
        path = folder / f"torus{k}.obj"
        with path.open("w") as out:
            for i, j in itertools.product(range(rings), range(sides)):
                a, b, r = 2 * math.pi * i / rings, 2 * math.pi * j / sides, 0.1 + 0.03 * k
                x = 1 + r * math.cos(b)
                out.write(f"v {x * math.cos(a)} {r * math.sin(b)} {x * math.sin(a)}\n")
            at = lambda i, j: i % rings * sides + j % sides + 1
            for i, j in itertools.product(range(rings), range(sides)):
                out.write(f"f {at(i, j)} {at(i, j + 1)} {at(i + 1, j + 1)} {at(i + 1, j)}\n")
        meshes.append(path)
    return meshes


class Bake:
    def __init__(self, options, folder):
        self.program, self.folder, self.count = options.program, folder, options.jobs
        meshes = options.meshes or os.environ.get("FRACTURE_TEST_MESHES", "").split(":")[0]
        if meshes:
            found = [p for p in sorted(pathlib.Path(meshes).iterdir())
                     if p.suffix in (".obj", ".glb", ".ply", ".stl", ".STL") and p.stat().st_size < 3_000_000]
            # Only meshes that can be fractured, so that all refused meshes are our own.
            found = [p for p in found if subprocess.run([self.program, "inspect", p], capture_output=True).returncode < 2]
        else:
            found = generated(folder)
        poison = [folder / "poison.glb", folder / "poison.obj", folder / "poison.stl"]
        poison[0].write_bytes(b"glTF" + bytes(100))
        poison[1].write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        poison[2].write_bytes(bytes(80) + (10**9).to_bytes(4, "little"))
        self.jobs = []
        for k in range(self.count):
            # The invalid meshes are spread among the good ones, the first one at the beginning.
            if k % (self.count // POISON + 1) == 0:
                self.jobs.append((poison[len(self.jobs) * POISON // self.count], {}))
                continue
            parameters = {"sites": (20, 60, 150)[k % 3], "seed": k, **CHOICES[k // len(found) % len(CHOICES)]}
            if "levels" in parameters:
                del parameters["sites"]
            self.jobs.append((found[k % len(found)], parameters))

    def tree(self, name):
        """Makes a new folder with the manifest."""
        folder = self.folder / name
        folder.mkdir()
        with (folder / "night.ndjson").open("w") as out:
            for k, (mesh, parameters) in enumerate(self.jobs):
                out.write(json.dumps({"input": str(mesh), "output": f"out/{k % 7}/{k}.glb", "parameters": parameters}) + "\n")
        return folder

    def arguments(self, folder, *more):
        return [self.program, "bake", "--manifest", folder / "night.ndjson", "--quiet", *map(str, more)]

    def run(self, folder, *more, code=0):
        allow = () if code else ("--allow-refused", POISON)
        done = subprocess.run(self.arguments(folder, *allow, *more), capture_output=True, text=True)
        expect(done.returncode == code, f"{folder.name}: exit code {done.returncode}, not {code}\n{done.stderr[-2000:]}")

    def outputs(self, folder):
        return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest()
                for p in (folder / "out").rglob("*") if p.is_file()}

    def report(self, folder, shard=""):
        """Reads the report without the members that differ from run to run."""
        lines = [json.loads(line) for line in (folder / f"night.ndjson{shard}.report").read_text().splitlines()]
        for line in lines:
            line.pop("seconds", None)
            line["output"] = str(pathlib.Path(line["output"]).relative_to(folder))
        return lines


def expect(good, what):
    if not good:
        sys.exit(f"FAILED: {what}")


def times_of(bake, folder, workers):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.monotonic()
    bake.run(folder, "-j", workers, "--force")
    wall = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def check(bake):
    one = bake.tree("one")
    bake.run(one, "-j", 1, code=3)
    whole, report = bake.outputs(one), bake.report(one)
    expect(len(whole) == bake.count - POISON, f"{len(whole)} outputs of {bake.count - POISON}")
    status = [line["status"] for line in report]
    expect((status.count("made"), status.count("refused")) == (bake.count - POISON, POISON), "the report's lines")
    expect([line["output"] for line in report] == [f"out/{k % 7}/{k}.glb" for k in range(bake.count)], "the report's order")
    print(f"{bake.count} jobs, {POISON} of them refused and reported: exit code 3")

    two = bake.tree("two")
    bake.run(two, "-j", 2)
    expect(bake.outputs(two) == whole and bake.report(two) == report, "two workers give other bytes than one")
    print("two workers: the same bytes and report")

    shards = bake.tree("shards")
    runs = [subprocess.Popen(bake.arguments(shards, "-j", 1, "--shard", f"{k}/2", "--allow-refused", POISON),
                             stderr=subprocess.DEVNULL) for k in range(2)]
    expect([run.wait() for run in runs] == [0, 0], "shards")
    lines = [line for k in range(2) for line in bake.report(shards, f".{k}-of-2")]
    by_output = lambda line: line["output"]
    expect(bake.outputs(shards) == whole and sorted(lines, key=by_output) == sorted(report, key=by_output),
           "two shards give other bytes than one bake")
    print("two shards at the same time, joined: the same bytes and lines")

    server = subprocess.Popen([bake.program, "serve", "--port", "0", "--admin-port", "0", "--threads", "2", "--drain-delay", "0",
                               "--log-format", "text"], stderr=subprocess.PIPE, text=True)
    try:
        line = next(line for line in server.stderr if " (admin port " in line)
        port = line.split(" (admin port ")[0].rsplit(":", 1)[1]
        remote = bake.tree("remote")
        start = time.monotonic()
        bake.run(remote, "--server", f"http://127.0.0.1:{port}")
        expect(bake.outputs(remote) == whole, "a server gives other bytes")
        expect(bake.report(remote) == report, "a server gives another report")
        print(f"through a server of two threads: the same bytes and report ({time.monotonic() - start:.1f} s)")
    finally:
        server.terminate()
        server.stderr.close()
        server.wait()

    killed = bake.tree("killed")
    run = subprocess.Popen(bake.arguments(killed, "-j", 2), stderr=subprocess.DEVNULL)
    path = killed / "night.ndjson.report"
    while not path.exists() or path.read_bytes().count(b"\n") < bake.count // 2:
        expect(run.poll() is None, "it ended before it was killed")
        time.sleep(0.002)
    run.send_signal(signal.SIGKILL)
    run.wait()
    left = {name: digest for name, digest in bake.outputs(killed).items() if not name.endswith(".part")}
    expect(len(left) < len(whole), "it was done before it was killed")
    expect(all(whole[name] == digest for name, digest in left.items()), "something half-written")
    bake.run(killed, "-j", 2)
    expect(bake.outputs(killed) == whole and bake.report(killed) == report, "the resumed bake gives another tree")
    print(f"killed after {len(left)} outputs and resumed: the same tree, nothing half-written")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=500)
    parser.add_argument("--meshes", help="a folder")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only-times", action="store_true", help="leave the comparisons out")
    parser.add_argument("--only-full", action="store_true", help="exit with 77 unless FRACTURE_TEST_FULL is set")
    options = parser.parse_args()
    if options.only_full and not os.environ.get("FRACTURE_TEST_FULL"):
        print("skipped: FRACTURE_TEST_FULL is not set; server_end_to_end_tests does the same with fewer jobs")
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="fracture-bake-") as folder:
        bake = Bake(options, pathlib.Path(folder))
        if not options.only_times:
            check(bake)
        if options.rounds == 0:
            return
        tree = bake.tree("timed")
        least = {1: (math.inf, math.inf), 2: (math.inf, math.inf)}
        for _ in range(options.rounds):
            for workers in least:
                least[workers] = tuple(map(min, least[workers], times_of(bake, tree, workers)))
        (t1, cpu1), (t2, cpu2) = least[1], least[2]
        print(f"one worker {t1:.2f} s (processor {cpu1:.2f} s), two {t2:.2f} s (processor {cpu2:.2f} s); load of the machine "
              f"{os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
        print(f"parallel efficiency t1 / (2 t2) = {t1 / (2 * t2):.2f} (0.85 is wanted), in processor time {cpu1 / cpu2:.2f}")


if __name__ == "__main__":
    main()
