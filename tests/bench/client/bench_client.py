#!/usr/bin/env python3
"""Measures the cost of a frame of the game, and what waiting for the server adds to it.

    bench_client.py BUILD [--runs 5]      BUILD: a build folder with fracture-server and fracture-client

No pixel is rasterized (Mesa's GALLIUM_NOOP accepts every call and draws nothing), so a frame consists of
simulation and submission. The times are wall-clock. On a busy machine the least of several runs is closest to
the truth, so that is judged.

1. Waiting: a proxy holds each answer back for two seconds. The worst frame while a request is open may take
   at most 1.5 times the median frame of the run, which lasts until the pieces rest. For comparison, the same
   frames of a run without requests show the cost of waiting itself (the motion is the same until the answer
   arrives).
2. The frame that adopts about 200 fragments and the one after it may take at most 2 times the median frame,
   both of the run and of the following three seconds, in which the pieces move.
3. Submission, in every scene: fragments, draw calls (at most 20), and milliseconds to submit a frame (at most
   2).
"""
import argparse
import json
import os
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

HELD = 2.0  # seconds
FALL = ("--seconds", "8", "--no-throws")


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
    """Passes bytes between client and server. The answer to a fracture request is held back."""
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
        # Until the answer arrives, every run moves alike frame by frame, so the least time of each frame is
        # its cost.
        waits, controls, swaps, medians, moving = [], [], [], [], []
        for _ in range(options.runs):
            run = play(options.build, slow, "monkey", *FALL)
            frames, first = run["frames"]["each_ms"], run["waiting_frames"]["first"]
            waits.append(frames[first : first + run["waiting_frames"]["count"]])
            controls.append(play(options.build, slow, "monkey", *FALL, "--no-requests")["frames"]["each_ms"][first:])
            adopted = run["swap_frames"]["first"]
            swaps.append((frames[adopted], frames[adopted + 1]))
            medians.append(run["frames"]["median_ms"])
            moving.append(statistics.median(frames[adopted : adopted + 180]))
        waiting, control = (sorted(map(min, zip(*runs))) for runs in (waits, [c[: len(w)] for c, w in zip(controls, waits)]))
        of_run = min(medians)
        for what, times in (("waiting", waiting), ("the same frames, nothing asked", control)):
            print(f"{what}: {len(times)} frames, median {statistics.median(times):.2f}, worst {times[-1]:.2f}:"
                  f" {times[-1] / of_run:.2f} times the run's median of {of_run:.2f} (bar 1.5)")
        for what, least in zip(("the swap", "the frame after it"), map(min, zip(*swaps))):
            print(f"{what}, {run['bodies']['fragments']} fragments: {least:.2f}: {least / of_run:.2f} times the run's median,"
                  f" {least / min(moving):.2f} times that of moving pieces, {min(moving):.2f} (bar 2)")
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
