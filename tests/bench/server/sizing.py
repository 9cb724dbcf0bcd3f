"""sizing.py FRACTURE_SERVER MESH...: prints the resources that a server needs, as the tables of
docker/README.md.

For each mesh it starts a new server with one computing thread and one import worker. The time is the
processor time of server and import worker, so a busy machine changes it little. It is the least of three
rounds, each with different seeds.
"""
import hashlib
import http.client
import json
import os
import re
import subprocess
import sys
import time

SITES = 50
HERTZ = os.sysconf("SC_CLK_TCK")


class Server:
    def __init__(self, *flags):
        begun = time.monotonic()
        self.process = subprocess.Popen(
            [sys.argv[1], "serve", "--port", "0", "--admin-port", "0", "--threads", "1", "--import-workers", "1",
             "--io-threads", "1", "--drain-delay", "0", "--log-format", "text", *flags],
            stderr=subprocess.PIPE, text=True)
        line = next(line for line in self.process.stderr if "(admin port " in line)
        self.started = time.monotonic() - begun
        self.connection = http.client.HTTPConnection("127.0.0.1", int(re.search(r":(\d+) \(admin", line)[1]))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.stderr.read()
        self.process.wait()

    def processes(self):
        with open(f"/proc/{self.process.pid}/task/{self.process.pid}/children", encoding="ascii") as f:
            children = f.read().split()
        for task in os.listdir(f"/proc/{self.process.pid}/task"):
            with open(f"/proc/{self.process.pid}/task/{task}/children", encoding="ascii") as f:
                children += f.read().split()
        return [self.process.pid, *dict.fromkeys(map(int, children))]

    def memory(self, key):
        """Returns MiB of the server and of its import worker: VmRSS for now, VmHWM for the peak."""
        figures = []
        for pid in self.processes():
            with open(f"/proc/{pid}/status", encoding="ascii") as f:
                figures.append(int(re.search(rf"{key}:\s+(\d+) kB", f.read())[1]) / 1024)
        return (figures + [0])[:2]

    def processor_seconds(self):
        """Returns the processor seconds, including workers that ended (a new worker takes over after a
        hundred files). The parents keep their time."""
        ticks = 0
        for pid in self.processes():
            try:
                with open(f"/proc/{pid}/stat", encoding="ascii") as f:
                    fields = f.read().rsplit(")", 1)[1].split()
            except FileNotFoundError:
                continue
            ticks += sum(int(field) for field in fields[11:15])
        return ticks / HERTZ

    def ask(self, method, path, body, kind):
        self.connection.request(method, path, body, {"Content-Type": kind})
        answer = self.connection.getresponse()
        data = answer.read()
        if answer.status not in (200, 201):
            sys.exit(f"{method} {path}: {answer.status} {data[:300]}")
        return data


def least(server, ask, rounds=3, least_seconds=1.0):
    """Returns the processor milliseconds of one request. A round takes at least `least_seconds`, because the
    clock ticks in hundredths of a second."""
    best, seed = float("inf"), 100
    for _ in range(rounds):
        begun, count = server.processor_seconds(), 0
        while (used := server.processor_seconds() - begun) < least_seconds:
            seed += 1
            ask(seed)
            count += 1
        best = min(best, used / count)
    return 1000 * best


starts = []
for _ in range(10):
    with Server() as idle:
        starts.append(idle.started)
        rss = idle.memory("VmRSS")
print(f"from the start until it listens, least of 10: {1000 * min(starts):.0f} ms; idle: server {rss[0]:.0f} MiB, import worker {rss[1]:.0f} MiB\n")
print("| mesh | bytes | triangles | answer | peak: server, import worker | uploaded | stored | cached |")
print("|---|---|---|---|---|---|---|---|")
for path in sys.argv[2:]:
    with open(path, "rb") as f:
        mesh = f.read()
    query = f"format={path.rsplit('.', 1)[1].lower()}&sites={SITES}"
    octets = "application/octet-stream"
    with Server("--result-cache", "0") as server:
        answer = server.ask("POST", f"/fracture?{query}&seed=1", mesh, octets)
        peak = server.memory("VmHWM")
        name = "/meshes/sha256:" + hashlib.sha256(mesh).hexdigest()
        stored_mesh = json.loads(server.ask("PUT", f"{name}?{query.split('&')[0]}", mesh, octets))
        triangles = stored_mesh["report"]["solid"]["source_triangles"]
        stored = least(server, lambda seed: server.ask("POST", f"{name}/fracture", json.dumps({"sites": SITES, "seed": seed}), "application/json"))
    with Server("--result-cache", "0", "--mesh-cache", "0", "--diagram-cache", "0") as server:  # every upload is read and prepared again
        uploaded = least(server, lambda seed: server.ask("POST", f"/fracture?{query}&seed={seed}", mesh, octets))
    with Server() as server:
        cached = least(server, lambda seed: server.ask("POST", f"/fracture?{query}", mesh, octets))
    ms = " | ".join(f"{value:.2g} ms" if value < 1 else f"{value:.1f} ms" for value in (uploaded, stored, cached))
    print(f"| {os.path.basename(path)} | {len(mesh) / 1024:.0f} KiB | {triangles} | {len(answer) / 1024:.0f} KiB | "
          f"{peak[0]:.0f}, {peak[1]:.0f} MiB | {ms} |", flush=True)
