# SPDX-License-Identifier: GPL-3.0-or-later
"""A server that forgets, is busy, cuts connections, sends wrong data or falls silent. The add-on must behave as the
Python package does. A faulty relay sits between the real server and Blender."""
import http.client
import importlib.util
import itertools
import pathlib
import re
import sys
import time
import urllib.parse

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, add_cube, eventually, fragments_of, preferences  # noqa: E402


def servers_that_lie():
    """Loads the fault server from the tests of the Python package."""
    path = support.ROOT / "tests" / "client" / "python" / "support.py"
    spec = importlib.util.spec_from_file_location("python_support", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


lies = servers_that_lie()
SEEDS = itertools.count(1)  # new seeds, because a known answer has no events


class Between:
    """Passes every request on, except the first `times` requests of a kind. Those are answered by `fault`, which
    receives a function that asks the server."""

    def __init__(self, url, method, path, fault, times=1, port=0):
        self._address = urllib.parse.urlsplit(url).netloc
        self._kind, self._fault, self._left = (method, path), fault, times
        self.asked = []
        self.server = lies.FaultServer(self._answer, port)

    def _answer(self, asked):
        self.asked.append(f"{asked.method} {asked.target.split('?')[0]}")
        hit = self._left > 0 and asked.method == self._kind[0] and self._kind[1] in asked.target
        self._left -= hit
        return self._fault(lambda: self._pass_on(asked)) if hit else self._pass_on(asked)

    def _pass_on(self, asked):
        connection = http.client.HTTPConnection(self._address, timeout=support.PATIENCE)
        fields = dict(line.split(": ", 1) for line in asked.head.split("\r\n")[1:] if ": " in line)
        fields.pop("Host", None)
        connection.request(asked.method, asked.target, asked.body, fields)
        answer = connection.getresponse()
        body = answer.read()
        head = "".join(f"{name}: {value}\r\n" for name, value in answer.getheaders()
                       if name.lower() not in ("content-length", "transfer-encoding", "connection"))
        connection.close()
        return lies.answer(answer.status, body, head)


def cut(reply):
    return lies.Reply(reply.bytes[:len(reply.bytes) // 2], close=True)


def held_back(reply):
    """The reply without its second half, which never arrives."""
    return lies.Reply(reply.bytes[:len(reply.bytes) // 2])


def without_digest(reply):
    return lies.Reply(re.sub(rb"(?i)\r\nrepr-digest:[^\r]*", b"", reply.bytes))


def flipped(reply):
    return lies.Reply(reply.bytes[:-9] + bytes([reply.bytes[-9] ^ 1]) + reply.bytes[-8:])


class Faults(InBlender):
    def between(self, *arguments, **options):
        between = Between(self.server.url, *arguments, **options)
        self.addCleanup(between.server.close)
        preferences().url = between.server.url
        return between

    def check_survives(self, method, path, fault, again, **parameters):
        """`again`: how often a request of that kind must then be made."""
        support.empty_scene()
        add_cube()
        between = self.between(method, path, fault)
        made, = self.fracture(pattern="uniform", sites=12, seed=next(SEEDS), **parameters)
        self.assertEqual(len(fragments_of(made)), 12)
        kind = [line for line in between.asked if line.startswith(method) and path in line]
        self.assertEqual(len(kind), again, between.asked)
        return between.asked

    def test_a_mesh_that_is_forgotten_is_sent_again(self):
        asked = self.check_survives("POST", "/fracture", lambda real: lies.problem(404, "not-found"), 2)
        self.assertTrue(any(line.startswith("PUT") for line in asked))

    def test_a_mesh_that_the_server_has_is_not_sent_again(self):
        add_cube(size=2 + next(SEEDS) / 8)
        between = self.between("", "nothing", None)
        for _ in range(3):
            support.select(bpy.data.objects["Box"])
            self.fracture(sites=3, seed=next(SEEDS))
            bpy.data.objects["Box"].hide_set(False)
        self.assertEqual(sum(line.startswith("PUT") for line in between.asked), 1)

    def test_a_busy_server_is_asked_again(self):
        for status, name in ((503, "overloaded"), (429, "too-many-connections")):
            with self.subTest(status):
                self.check_survives("POST", "/fracture", lambda real: lies.problem(status, name, "Retry-After: 0\r\n"), 2)

    def test_answers_that_are_cut_or_flipped_are_asked_for_again(self):
        for spoil in (cut, flipped):
            with self.subTest(spoil.__name__):
                self.check_survives("GET", "/fractures/", lambda real: spoil(real()), 2)

    def test_a_connection_that_breaks_is_made_again(self):
        self.check_survives("GET", "/fractures/", lambda real: lies.Reply(reset=True), 2)

    def test_progress_goes_on_when_its_connection_breaks(self):
        """The cuts are so fine that the job works long enough for its events to be requested twice."""
        self.check_survives("GET", "/events", lambda real: lies.Reply(reset=True), 2, rough_amplitude=0.02, rough_frequency=30, rough_octaves=2)

    def check_error(self, method, path, fault, words, timeout=60):
        """Checks the error if the fault does not end. Returns how often a request of that kind was made."""
        support.empty_scene()
        add_cube()
        support.give(sites=5, seed=next(SEEDS))
        between = self.between(method, path, fault, times=999)
        preferences().timeout = timeout
        self.assertIn(words, self.refused())
        self.assertEqual([item.name for item in bpy.data.objects], ["Box"])
        return sum(line.startswith(method) and path in line for line in between.asked)

    def test_answers_that_stay_wrong_are_an_error(self):
        for spoil in (flipped, cut, without_digest):
            with self.subTest(spoil.__name__):
                self.assertEqual(self.check_error("GET", "/fractures/", lambda real: spoil(real()), "(damaged"), 3)

    def test_a_mesh_that_is_missing_after_its_put_is_the_servers_own_no(self):
        self.assertEqual(self.check_error("POST", "/fracture", lambda real: lies.problem(404, "not-found"), "(not-found"), 2)

    def test_a_refusal_is_an_error_at_once(self):
        self.assertEqual(self.check_error("POST", "/fracture", lambda real: lies.problem(422, "too-complex"), "(too-complex"), 1)

    def test_a_pause_beyond_the_patience_is_an_error_at_once(self):
        for status, name in ((503, "overloaded"), (429, "over-share")):
            with self.subTest(status):
                busy = lies.problem(status, name, "Retry-After: 3600\r\n")
                self.assertEqual(self.check_error("POST", "/fracture", lambda real: busy, f"({name}"), 1)

    def test_a_pause_that_the_server_asks_for_is_kept(self):
        times = []

        def busy(real):
            times.append(time.monotonic())
            return lies.problem(503, "overloaded", "Retry-After: 1\r\n")
        self.check_survives("POST", "/fracture", busy, 2)
        self.assertGreaterEqual(time.monotonic() - times[0], 1)

    def test_a_silent_server_is_an_error_when_patience_ends(self):
        self.check_error("GET", "/meshes/", lambda real: lies.Reply(silent=True), "(timeout", timeout=1)

    def test_so_is_one_that_falls_silent_in_the_middle_of_its_answer(self):
        self.check_error("GET", "/fractures/", lambda real: held_back(real()), "(timeout", timeout=2)

    def begin(self, *arguments, **options):
        """Begins a fracture that meets a lasting fault. Returns the work and the relay."""
        support.empty_scene()
        add_cube()
        support.give(pattern="uniform", sites=12, seed=next(SEEDS))
        between = self.between(*arguments, **options)
        work = support.part("run").begin(bpy.context)
        self.addCleanup(work.asking.cancel)
        eventually("it is asked", lambda: any(arguments[0] in line and arguments[1] in line for line in between.asked))
        return work, between

    def test_a_server_that_dies_in_mid_flight_and_comes_back_answers(self):
        for method, path in (("GET", "/meshes/"), ("POST", "/fracture")):
            with self.subTest(path):
                work, between = self.begin(method, path, lambda real: lies.Reply(silent=True), times=999)
                between.server.close()
                again = Between(self.server.url, "", "nothing", None, port=between.server.port)
                self.addCleanup(again.server.close)
                self.assertTrue(work.asking.wait(support.PATIENCE))
                work.finish(bpy.context)
                self.assertEqual(sum("fracture_volume" in item for item in bpy.data.objects), 12)
                self.assertTrue(again.asked)

    def test_esc_leaves_whatever_it_waits_for(self):
        for name, method, path, fault in (
                ("silence", "GET", "/meshes/", lambda real: lies.Reply(silent=True)),
                ("a pause", "POST", "/fracture", lambda real: lies.problem(503, "overloaded", "Retry-After: 50\r\n")),
                ("the rest of an answer", "GET", "/fractures/", lambda real: held_back(real()))):
            with self.subTest(name):
                work, between = self.begin(method, path, fault, times=999)
                work.asking.cancel()
                self.assertTrue(work.asking.wait(30))  # less than the pause between attempts
                self.assertEqual(work.asking.error.type, "cancelled")
                if name == "silence":
                    eventually("the connection is closed", lambda: between.server.closed_by_client == 1)


if __name__ == "__main__":
    support.main()
