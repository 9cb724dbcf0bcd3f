# SPDX-License-Identifier: GPL-3.0-or-later
"""Requests fragments from a server or `fracture-server bake` in a separate thread, which another thread can cancel.

This module does not touch Blender's data, which only the main thread may use. The main thread polls `state`.
"""
import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import threading
from dataclasses import dataclass

from .package import Answer, Cancel, Client, FractureError

PATIENCE = 10.0  # s; time that a cancelled job may take to stop
# `bake` checks the parameters in a manifest before the first job, so a refusal is not in the report.
REFUSED_LINE = re.compile(r"fracture-server bake: Line \d+ of '[^\n]*?': (.*)", re.DOTALL)


@dataclass(frozen=True)
class Target:
    """The program or server in use: `program`, or the server at `url` if `program` is empty."""
    url: str = ""
    token: str = ""
    program: str = ""
    timeout: float = 300.0  # s; longest time that a server may be unreachable or busy


@dataclass(frozen=True)
class Request:
    """A file to break."""
    name: str
    glb: bytes
    parameters: dict


@dataclass(frozen=True)
class State:
    """The progress, as a text for users and a percentage."""
    words: str
    percent: int


class Asking:
    """Sends the requests one by one. `answers` and `error` are complete when `is_done` is true."""

    def __init__(self, target, requests):
        self._target = target
        self._requests = requests
        self._cancel = Cancel()
        self._thread = threading.Thread(target=self._run, name="fracture", daemon=True)
        self.state = State("asking", 0)
        self.answers = []
        self.error = None  # a FractureError
        self.failed = None  # the index of the request that failed

    def start(self):
        self._thread.start()

    @property
    def is_done(self):
        return not self._thread.is_alive()

    def cancel(self):
        """Stops the work and returns at once. `error` then gets the type "cancelled", unless all answers have already arrived."""
        self._cancel.cancel()

    def wait(self, seconds=None):
        """Waits until the work is done or this many seconds have passed. Returns whether it is done."""
        self._thread.join(seconds)
        return self.is_done

    def _run(self):
        try:
            ask = self._ask_program if self._target.program else self._ask_server
            ask()
        except FractureError as error:
            self.error = error
        except Exception as error:  # otherwise the thread would end with neither an answer nor an error
            self.error = FractureError("damaged", f"{type(error).__name__}: {error}")
        if self.error is not None:
            self.failed = len(self.answers)

    def _say(self, words, percent=0):
        """Sets the state that users see. `percent`: progress of the current request."""
        done = len(self.answers)
        of = f" ({done + 1} of {len(self._requests)})" if len(self._requests) > 1 else ""
        name = self._requests[min(done, len(self._requests) - 1)].name
        self.state = State(f"{name}{of}: {words}", (100 * done + percent) // len(self._requests))

    # -- a server

    def _ask_server(self):
        target = self._target
        with Client(target.url, target.token or None, target.timeout) as client:
            for request in self._requests:
                self._say("sending")
                job = client.put(request.glb, cancel=self._cancel).job(request.parameters, cancel=self._cancel)
                try:
                    for state in job.progress(cancel=self._cancel):
                        self._say(_words(state), state.percent)
                    self._say("fetching", 100)
                    self.answers.append(job.result(cancel=self._cancel))
                except FractureError as error:
                    if error.type == "cancelled" and self._cancel.cancelled:
                        with contextlib.suppress(FractureError):  # a job would continue without a listener
                            job.cancel(timeout=PATIENCE)
                    raise

    # -- a program

    def _ask_program(self):
        with tempfile.TemporaryDirectory(prefix="fracture-") as folder:
            for number, request in enumerate(self._requests):
                self._say("computing on this machine")
                self.answers.append(self._bake(pathlib.Path(folder), number, request))

    def _bake(self, folder, number, request):
        """Runs `bake` with a manifest that contains the request's parameters as JSON. Raises FractureError."""
        mesh, output, manifest = (folder / f"{number}.{end}" for end in ("mesh.glb", "glb", "ndjson"))
        mesh.write_bytes(request.glb)
        job = {"input": mesh.name, "output": output.name, "parameters": request.parameters}
        manifest.write_text(json.dumps(job) + "\n", encoding="utf-8")
        report = folder / f"{number}.report"
        command = [self._target.program, "bake", "--manifest", str(manifest), "--report", str(report), "--quiet"]
        try:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        except OSError as error:
            raise FractureError("connection", f"The program '{command[0]}' cannot be started: {error.strerror}. Check its path in the "
                                              "panel.") from None
        with self._cancel.calling(lambda: _interrupt(process)):
            _, words = process.communicate()
        if self._cancel.cancelled:
            raise FractureError("cancelled", "The fracture was cancelled.")
        line = _last_line(report)
        if line.get("status") == "made":
            return Answer.load(output)
        if isinstance(line.get("problem"), dict):
            raise FractureError.of_problem(line["problem"])
        if refused := REFUSED_LINE.match(words):
            raise FractureError.of_problem({"type": "/problems/bad-parameter", "detail": refused[1].strip(),
                                            "title": "A parameter is missing, malformed or out of range"})
        raise FractureError("connection", words.strip() or f"The program '{command[0]}' ended with exit code {process.returncode} and "
                                                           "wrote no fragments. Is it fracture-server?")


def _words(state):
    if state.state == "queued":
        ahead = state.queue_position
        return f"waiting, {ahead} ahead in the queue" if ahead else "waiting"
    return state.stage or state.state


def _interrupt(process):
    with contextlib.suppress(OSError):
        if os.name == "nt":
            process.terminate()
        else:
            process.send_signal(signal.SIGINT)


def _last_line(report):
    """Returns the last line of a `bake` report; {} if there is none."""
    try:
        lines = [json.loads(line) for line in report.read_text(encoding="utf-8").splitlines() if line.strip()]
    except (OSError, ValueError):
        return {}
    return lines[-1] if lines and isinstance(lines[-1], dict) else {}
