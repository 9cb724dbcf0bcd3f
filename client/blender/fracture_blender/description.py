# SPDX-License-Identifier: GPL-3.0-or-later
"""What may be asked: the parameters, patterns and materials, as a server describes them at GET /patterns.

Nothing of it stands in this add-on. It comes from the server in use, or from the program fracture-server, which is started as a
server for that moment; the last description is kept in Blender's folder of the user, for the next start. A packed add-on may
hold one from the day on which it was packed (pack.py --describe), for the first start.
"""
import contextlib
import json
import os
import pathlib
import queue
import re
import subprocess
import threading

from .package import Client, FractureError

FILE = "description.json"
START_SECONDS = 20.0  # that a server may take to listen; it takes a tenth of a second
ASK_SECONDS = 15.0


class Description:
    """Of the parsed JSON. `parameters` is a dictionary by name, in the order of the server's table."""

    def __init__(self, document):
        self.document = document
        self.patterns = {pattern["name"]: pattern for pattern in document["patterns"]}
        self.materials = {material["name"]: material for material in document["materials"]}
        self.parameters = {}
        of_pattern = [entry for pattern in document["patterns"] for entry in pattern["parameters"]]
        for entry in (*document["parameters"], *of_pattern, *document.get("mesh_parameters", ())):
            self.parameters.setdefault(entry["name"], entry)
        self.source = str(document.get("source", ""))

    def of_pattern(self, pattern):
        """The names of what belongs to the pattern, and to some others maybe."""
        return [entry["name"] for entry in self.patterns.get(pattern, {}).get("parameters", ())]

    def of_any_pattern(self):
        return {name for pattern in self.patterns for name in self.of_pattern(pattern)}

    def pattern_of(self, given):
        """The pattern that a request has: its own, its material's, or else the first one."""
        preset = self.materials.get(given.get("material"), {}).get("parameters", {})
        default = self.parameters.get("pattern", {}).get("default")
        return given.get("pattern") or preset.get("pattern") or default

    def usual(self, name, given):
        """The value that holds where none is given, or None."""
        preset = self.materials.get(given.get("material"), {}).get("parameters", {})
        return preset.get(name, self.parameters.get(name, {}).get("default"))


def of_server(client, cancel=None):
    """Asks a server. Raises FractureError."""
    document = client.patterns(timeout=ASK_SECONDS, cancel=cancel)
    if "mesh_parameters" not in document:  # a server from before it said so
        document["mesh_parameters"] = client.limits(timeout=ASK_SECONDS, cancel=cancel).get("parameters", [])
    version = client.version(timeout=ASK_SECONDS, cancel=cancel)
    document["source"] = f"{version.get('name', 'fracture-server')} {version.get('version', '')}"
    return Description(document)


def of_program(program):
    """Of `fracture-server` on this machine, started on a free port. Raises FractureError."""
    with serving(program) as url, Client(url, timeout=ASK_SECONDS) as client:
        return of_server(client)


@contextlib.contextmanager
def serving(program):
    """A server on this machine, as long as it is needed; its address. Raises FractureError."""
    command = [program, "serve", "--port", "0", "--admin-port", "0", "--threads", "1", "--drain-delay", "0", "--log-format", "text"]
    try:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    except OSError as error:
        raise FractureError("connection", f"'{program}' cannot be started: {error.strerror}.") from None
    found = queue.Queue()

    def listen():
        for line in process.stderr:  # to its end: a pipe that nobody reads would fill up
            match = re.search(r"serving on (http://\S+)", line)
            if match:
                found.put(match.group(1))
        found.put("")

    reader = threading.Thread(target=listen, daemon=True)
    reader.start()
    try:
        try:
            url = found.get(timeout=START_SECONDS)
        except queue.Empty:
            url = ""
        if not url:
            raise FractureError("connection", f"'{program}' did not begin to serve. Is it fracture-server?")
        yield url
    finally:
        process.terminate()
        try:
            process.wait(START_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        reader.join(START_SECONDS)
        process.stderr.close()


def load(folders):
    """The one that is kept in the first of these folders that has one; None where there is none that can be read."""
    for folder in folders:
        try:
            return Description(json.loads((pathlib.Path(folder) / FILE).read_text(encoding="utf-8")))
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None


def store(description, folder):
    """For the next start. Raises OSError."""
    path = pathlib.Path(folder) / FILE
    beside = path.with_suffix(".part")
    beside.write_text(json.dumps(description.document, ensure_ascii=False), encoding="utf-8")
    os.replace(beside, path)
