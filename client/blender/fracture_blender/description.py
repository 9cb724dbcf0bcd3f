# SPDX-License-Identifier: GPL-3.0-or-later
"""A server's parameters, patterns and materials, as described by GET /patterns.

The add-on does not contain this list. The description comes from the server in use, or from the program fracture-server, which the
add-on briefly starts as a server. The latest description is stored in Blender's user folder for the next start. A packed add-on can
contain a description for the first start (pack.py --describe).
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
START_SECONDS = 20.0  # s; time that a server may take to start; usually 0.1 s
ASK_SECONDS = 15.0


class Description:
    """The description as dictionaries keyed by name: `patterns`, `materials`, and `parameters` (in the order of the server's table)."""

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
        """Returns the names of a pattern's parameters. Other patterns may share some of them."""
        return [entry["name"] for entry in self.patterns.get(pattern, {}).get("parameters", ())]

    def of_any_pattern(self):
        """Returns the names of all parameters that belong to patterns."""
        return {name for pattern in self.patterns for name in self.of_pattern(pattern)}

    def pattern_of(self, given):
        """Returns the pattern that a request uses: the request's own, otherwise the material's, otherwise the default."""
        preset = self.materials.get(given.get("material"), {}).get("parameters", {})
        default = self.parameters.get("pattern", {}).get("default")
        return given.get("pattern") or preset.get("pattern") or default

    def usual(self, name, given):
        """Returns the value that the parameter `name` has when it is not sent: the material's value or the default. None if both are missing."""
        preset = self.materials.get(given.get("material"), {}).get("parameters", {})
        return preset.get(name, self.parameters.get(name, {}).get("default"))


def of_server(client, cancel=None):
    """Returns a server's description. Raises FractureError."""
    document = client.patterns(timeout=ASK_SECONDS, cancel=cancel)
    if "mesh_parameters" not in document:  # older servers have this list in GET /limits only
        document["mesh_parameters"] = client.limits(timeout=ASK_SECONDS, cancel=cancel).get("parameters", [])
    version = client.version(timeout=ASK_SECONDS, cancel=cancel)
    document["source"] = f"{version.get('name', 'fracture-server')} {version.get('version', '')}"
    return Description(document)


def of_program(program):
    """Starts the program `fracture-server` on a free port and returns its description. Raises FractureError."""
    with serving(program) as url, Client(url, timeout=ASK_SECONDS) as client:
        return of_server(client)


@contextlib.contextmanager
def serving(program):
    """Starts a server on this machine, yields its address, and stops it at the end. Raises FractureError."""
    command = [program, "serve", "--port", "0", "--admin-port", "0", "--threads", "1", "--drain-delay", "0", "--log-format", "text"]
    try:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    except OSError as error:
        raise FractureError("connection", f"The program '{program}' cannot be started: {error.strerror}. Check its path in the "
                                          "panel.") from None
    found = queue.Queue()

    def listen():
        for line in process.stderr:  # read to the end, because a full pipe would stop the server
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
            raise FractureError("connection", f"The program '{program}' did not start a server within {START_SECONDS:g} s. Is it "
                                              "fracture-server?")
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
    """Returns the stored description from the first folder that contains a readable one; None if no folder does."""
    for folder in folders:
        try:
            return Description(json.loads((pathlib.Path(folder) / FILE).read_text(encoding="utf-8")))
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None


def store(description, folder):
    """Stores the description for the next start. Raises OSError."""
    path = pathlib.Path(folder) / FILE
    beside = path.with_suffix(".part")
    beside.write_text(json.dumps(description.document, ensure_ascii=False), encoding="utf-8")
    os.replace(beside, path)
