"""neighbours.py FRACTURE_SERVER MESH [SECONDS [ROUNDS]]: measures how much a name over its share slows
another name.

Two names use one server with two computing threads. `quiet` fractures a stored mesh five times a second, as a
game does on collisions. `greedy` sends requests at ten times its share (ten requests a second, two
computations at the same time), half of them realtime, half of them batch with four times the sites. Rounds of
`quiet` alone and of both alternate, so that other work on the machine affects both. Prints the latencies of
`quiet` (p50, p99, worst), the ratio of the p99s and the number of failures.
"""
import hashlib
import http.client
import json
import multiprocessing
import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time

RATE, SHARE = 5, 10  # requests a second


def tenant(name, **shares):
    return {"name": name, "tokens": [{"sha256": hashlib.sha256(token(name).encode()).hexdigest()}],
            "scopes": ["read", "fracture", "bake"], **shares}


def token(name):
    return name + "-0123456789abcdef"


class Client:
    def __init__(self, port, name):
        self.port, self.name, self.connection = port, name, None

    def ask(self, method, target, body, **fields):
        if not self.connection:
            self.connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        fields["Authorization"] = "Bearer " + token(self.name)
        self.connection.request(method, target, body, fields)
        answer = self.connection.getresponse()
        answer.read()
        if answer.will_close:
            self.connection = None
        return answer.status


def fracture(client, mesh, sites, seed, urgency):
    body = json.dumps({"sites": sites, "seed": seed})
    return client.ask("POST", f"/meshes/{mesh}/fracture", body, **{"Content-Type": "application/json",
                                                                  "Priority": f"u={urgency}"})


def quiet_round(port, mesh, seconds, seeds):
    client, times, failures = Client(port, "quiet"), [], 0
    begun = time.monotonic()
    for k in range(int(seconds * RATE)):
        time.sleep(max(0, begun + k / RATE - time.monotonic()))
        start = time.monotonic()
        failures += fracture(client, mesh, 50, next(seeds), 0) != 200
        times.append(1000 * (time.monotonic() - start))
    return times, failures


def greedy_loop(port, mesh, stop, first_seed, answers):
    """Runs in its own process, so that `quiet` does not wait for the interpreter's lock."""
    client, seed, counts = Client(port, "greedy"), first_seed, {}
    pause = 4 / (10 * SHARE)  # There are four such loops.
    following = time.monotonic()
    while not stop.is_set():
        following += pause
        time.sleep(max(0, following - time.monotonic()))
        seed += 1
        batch = seed % 2
        status = fracture(client, mesh, 200 if batch else 50, seed, 5 if batch else 0)
        counts[status] = counts.get(status, 0) + 1
    answers.put(counts)


def main():
    seconds, rounds = float(sys.argv[3]) if len(sys.argv) > 3 else 20, int(sys.argv[4]) if len(sys.argv) > 4 else 3
    with tempfile.NamedTemporaryFile("w", suffix=".json") as tokens:
        json.dump({"tenants": [tenant("quiet"), tenant("greedy", requests_per_second=SHARE, computations=2)]}, tokens)
        tokens.flush()
        server = subprocess.Popen([sys.argv[1], "serve", "--port", "0", "--admin-port", "0", "--threads", "2",
                                   "--drain-delay", "0", "--log-format", "text", "--token-file", tokens.name],
                                  stderr=subprocess.PIPE, text=True)
        line = next(line for line in server.stderr if "(admin port " in line)
        port = int(re.search(r":(\d+) \(admin", line)[1])
        threading.Thread(target=lambda: [None for _ in server.stderr], daemon=True).start()
    with open(sys.argv[2], "rb") as f:
        data = f.read()
    mesh = "sha256:" + hashlib.sha256(data).hexdigest()
    kind = {".glb": "model/gltf-binary", ".obj": "model/obj", ".stl": "model/stl"}[os.path.splitext(sys.argv[2])[1]]
    for name in ("quiet", "greedy"):
        assert Client(port, name).ask("PUT", "/meshes/" + mesh, data, **{"Content-Type": kind}) == 201

    seeds = iter(range(1, 10**6))
    alone, beside, counts = [], [], {}
    failures = [0, 0]
    quiet_round(port, mesh, 2, seeds)  # warm-up
    for r in range(rounds):
        times, failed = quiet_round(port, mesh, seconds, seeds)
        alone += times
        failures[0] += failed
        stop, answers = multiprocessing.Event(), multiprocessing.Queue()
        loops = [multiprocessing.Process(target=greedy_loop, args=(port, mesh, stop, 10**7 * (4 * r + k + 1), answers))
                 for k in range(4)]
        for loop in loops:
            loop.start()
        times, failed = quiet_round(port, mesh, seconds, seeds)
        beside += times
        failures[1] += failed
        stop.set()
        for loop in loops:
            for status, n in answers.get().items():
                counts[status] = counts.get(status, 0) + n
            loop.join()
    server.terminate()
    server.wait()

    p99 = []
    for what, times, failed in (("alone", alone, failures[0]), ("beside greedy", beside, failures[1])):
        p99.append(statistics.quantiles(times, n=100, method="inclusive")[98])
        print(f"quiet, {what}: {len(times)} requests, {failed} failed; p50 {statistics.median(times):.1f} ms, "
              f"p99 {p99[-1]:.1f} ms, worst {max(times):.1f} ms")
    print(f"p99 beside / alone: {p99[1] / p99[0]:.2f}; greedy was answered {dict(sorted(counts.items()))}")


if __name__ == "__main__":
    main()
