#!/usr/bin/env python3
"""What a frame of the game costs, and what waiting for the server adds to that.

    bench_client.py BUILD [--runs 5]      BUILD: a build folder with fracture-server and fracture-client

No pixel is rasterized (Mesa's GALLIUM_NOOP takes every call and draws nothing), so a frame is simulation and submission.
Wall-clock: on a machine with other work the least of several runs is nearest to the truth, and that is what is judged.

1. Waiting: a proxy holds each answer back for two seconds. The worst frame while a request is open, divided by the
   median of those frames: at most 1.5. The frame that adopts about 200 fragments: at most 2 times the median of all.
2. Submission: every scene; fragments, draw calls (at most 20), milliseconds to submit a frame (at most 2).
"""
import argparse
import json
import os
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time

HELD = 2.0  # seconds


def pump(source, sink, hold):
    try:
        while chunk := source.recv(1 << 16):
            if hold is not None and hold["asked"]:
                hold["asked"] = False
                time.sleep(HELD)
            sink.sendall(chunk)
    except OSError:
        pass
    for end in (source, sink):
        try:
            end.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass


def watch(source, sink, hold):
    """Client to server; the answer to a fracture is held."""
    try:
        while chunk := source.recv(1 << 16):
            if b"/fracture HTTP" in chunk:
                hold["asked"] = True
            sink.sendall(chunk)
    except OSError:
        pass
    sink.close()


def proxy(server_port):
    listener = socket.create_server(("127.0.0.1", 0))

    def serve():
        while True:
            client, _ = listener.accept()
            server = socket.create_connection(("127.0.0.1", server_port))
            hold = {"asked": False}
            threading.Thread(target=watch, args=(client, server, hold), daemon=True).start()
            threading.Thread(target=pump, args=(server, client, hold), daemon=True).start()

    threading.Thread(target=serve, daemon=True).start()
    return listener.getsockname()[1]


def play(build, port, scene, *more):
    with tempfile.TemporaryDirectory() as out:
        command = [f"{build}/client/app/fracture-client", "--headless", "--json", "--draw", "--scene", scene, "--port",
                   str(port), "--out", out, *more]
        environment = dict(os.environ, GALLIUM_NOOP="1")
        return json.loads(subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE).stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    server = subprocess.Popen([f"{options.build}/server/fracture-server", "serve", "--port", "0", "--admin-port", "0",
                               "--drain-delay", "0"], stderr=subprocess.PIPE, text=True)
    try:
        ports = None
        for line in server.stderr:
            if ports := re.search(r":(\d+) \(admin port", line):
                break
        if not ports:
            sys.exit("the server did not start")
        threading.Thread(target=server.stderr.read, daemon=True).start()
        port = int(ports.group(1))
        slow = proxy(port)
        print(f"load of the machine {os.getloadavg()[0]:.1f}; times in ms")
        # Until the answer comes every run moves alike, frame by frame: the least of each frame is what it takes.
        waits, swaps, medians = [], [], []
        for _ in range(options.runs):
            run = play(options.build, slow, "monkey", "--seconds", "4.5", "--no-throws")
            waits.append(run["waiting_frames"]["each_ms"])
            swaps.append(run["swap_frames"]["worst_ms"])
            medians.append(run["frames"]["median_ms"])
        waiting = sorted(map(min, zip(*waits)))
        middle = waiting[len(waiting) // 2]
        print(f"waiting: {len(waiting)} frames, median {middle:.2f}, worst {waiting[-1]:.2f}: {waiting[-1] / middle:.2f} times (bar 1.5)")
        print(f"the swap of {run['bodies']['fragments']} fragments: {min(swaps):.2f}, median of all frames {min(medians):.2f}:"
              f" {min(swaps) / min(medians):.1f} times (bar 2)")
        for scene in ("monkey", "panes", "wall", "temple", "crates"):
            run = play(options.build, port, scene, "--seconds", "4", "--fixed-step")
            submit = run["submit"]
            print(f"{scene:7} {run['bodies']['fragments']:4} fragments, {submit['most_draw_calls']:2} draw calls (bar 20), submit"
                  f" median {submit['median_ms']:.2f}, p99 {submit['p99_ms']:.2f} (bar 2)")
    finally:
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main()
