"""Helpers for the tests of docker/: reading its files, running programs, and a server to ask."""
import contextlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import urllib.request

import yaml

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DOCKER = os.path.join(ROOT, "docker")
SERVER = sys.argv[-1]
PATIENCE = 60  # seconds: at least ten times what any program takes here
os.environ["PATH"] += ":/usr/sbin:/usr/local/sbin"


def read(*path):
    with open(os.path.join(DOCKER, *path), encoding="utf-8") as f:
        return f.read()


def documents(*path):
    return [d for d in yaml.safe_load_all(read(*path)) if d]


def expect(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def run(*command, **variables):
    """Returns the standard output. Ends the program if the command fails."""
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **variables}, timeout=PATIENCE)
    expect(done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def ask_program(name):
    if not shutil.which(name):
        print(f"skipped: {name} is not installed; what needs no program was checked")
        sys.exit(77)
    return name


@contextlib.contextmanager
def serving(*flags, **variables):
    """Runs a server with every tier until the end of the block. Yields its port and its admin port."""
    with tempfile.TemporaryDirectory() as folder:
        command = [SERVER, "serve", "--port", "0", "--admin-port", "0", "--drain-delay", "0", "--log-format", "text",
                   "--cache-dir", folder, *flags]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env={**os.environ, **variables}) as server:
            too_late = threading.Timer(PATIENCE, server.kill)  # the kill ends every wait for the server
            too_late.start()
            try:
                log = []
                for line in server.stderr:
                    log.append(line)
                    if "(admin port " in line:
                        break
                found = re.search(r":(\d+) \(admin port (\d+)\)", log[-1] if log else "")
                expect(found, f"{' '.join(command)} with {variables}: {''.join(log)}")
                yield found.groups()
            finally:
                server.terminate()
                server.stderr.read()
                too_late.cancel()


def get(port, path, body=None, **fields):
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", data=body, headers=fields)
    return urllib.request.urlopen(request, timeout=PATIENCE).read().decode(errors="replace")


def fracture_a_cube(port, sites):
    corners = "".join(f"v {i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8))
    faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    get(port, f"/fracture?sites={sites}", (corners + faces).encode(), **{"Content-Type": "model/obj"})


def samples(admin):
    return {name: float(value) for name, value in re.findall(r"^([a-z_]+(?:{[^}]*})?) (\S+)$", get(admin, "/metrics"), re.M)}
