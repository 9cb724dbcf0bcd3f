#!/usr/bin/env python3
"""Meshes are stored once, fractures requested, refusals understood: the behaviour of tests/client/protocol_test.cpp."""
import json
import socket
import threading
import unittest
from unittest import mock

from support import (FRAGMENTS, PATIENCE, Client, FaultServer, answer, box_obj, caught, eventually, fragments, main, problem,
                     quick, stored)
from fracture_client import Mesh, asking
from fracture_client.calls import Call
from fracture_client.http1 import TURN, Connection, Request, Response, Trouble
from fracture_client.upload import mesh_id

ID = "sha256:" + "0" * 64


def known(asked):
    """Answers GET, PUT and POST as a server that has the mesh."""
    return fragments() if asked.method == "POST" else stored(200)


class Storing(unittest.TestCase):
    def test_a_mesh_is_stored_by_its_digest_then_fractured(self):
        def handler(asked):
            if asked.method == "GET":
                return problem(404, "not-found")
            return stored() if asked.method == "PUT" else fragments("Server-Timing: queue;dur=0.5, odd, work;dur=3.5\r\n")
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            mesh = client.put(b"glTFmesh", material="glass")
            broken = mesh.fracture(sites=7, impacts=[(0, 0.5, 0)])
            get, put, post = server.asked
        self.assertEqual(mesh.id, mesh_id(b"glTFmesh"))
        self.assertEqual(broken.glb, FRAGMENTS)
        self.assertEqual(broken.timing, {"queue": 0.5, "work": 3.5})
        self.assertEqual((get.method, get.target), ("GET", f"/meshes/{mesh.id}"))
        self.assertEqual((put.method, put.target, put.body), ("PUT", f"/meshes/{mesh.id}?material=glass", b"glTFmesh"))
        self.assertEqual(put.field("Content-Type"), "model/gltf-binary")
        self.assertEqual((post.method, post.target), ("POST", f"/meshes/{mesh.id}/fracture"))
        self.assertEqual(json.loads(post.body), {"material": "glass", "sites": 7, "impacts": [[0, 0.5, 0]]})
        self.assertEqual(post.field("Content-Type"), "application/json")

    def test_a_mesh_that_the_server_has_is_not_sent_again(self):
        with FaultServer(known) as server, Client(server.url, settings=quick()) as client:
            mesh = client.put(box_obj(), format="obj")
            self.assertEqual([a.method for a in server.asked], ["GET"])
            self.assertEqual(mesh.report, {"verdict": "closed"})

    def test_requests_one_after_another_share_a_connection(self):
        with FaultServer(known) as server, Client(server.url, settings=quick()) as client:
            mesh = client.mesh(ID)
            for seed in range(5):
                mesh.fracture(seed=seed)
            self.assertEqual(server.connections, 1)

    def test_at_most_so_many_connections_at_once(self):
        with FaultServer(known) as server, Client(server.url, settings=quick(connections=2)) as client:
            mesh = client.mesh(ID)
            made = []
            threads = [threading.Thread(target=lambda seed=seed: made.append(mesh.fracture(seed=seed))) for seed in range(20)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join(PATIENCE)
            self.assertEqual(len(made), 20)
            self.assertEqual(sorted(json.loads(a.body)["seed"] for a in server.asked), list(range(20)))
            self.assertLessEqual(server.connections, 2)

    def test_a_forgotten_mesh_is_put_and_asked_for_again(self):
        state = {"known": False}

        def handler(asked):
            state["known"] |= asked.method == "PUT"
            if asked.method != "POST":
                return stored() if state["known"] else problem(404, "not-found")
            return fragments() if state["known"] else problem(404, "not-found")
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            mesh = client.put(b"mesh", format="obj")
            state["known"] = False  # as after a restart of the server
            self.assertEqual(mesh.fracture().glb, FRAGMENTS)
            self.assertEqual([a.method for a in server.asked], ["GET", "PUT", "POST", "PUT", "POST"])
            self.assertEqual(server.asked[3].body, b"mesh")

    def test_many_who_miss_a_mesh_put_it_once(self):
        refused, state = threading.Semaphore(0), {"known": False}

        def handler(asked):
            if asked.method == "PUT":
                for _ in range(4):  # the PUT comes when all four have been refused
                    self.assertTrue(refused.acquire(timeout=PATIENCE))
                state["known"] = True
                return stored()
            if asked.method == "GET" or state["known"]:
                return known(asked)
            refused.release()
            return problem(404, "not-found")
        with FaultServer(handler) as server, Client(server.url, settings=quick(connections=8)) as client:
            mesh = client.put(b"mesh", format="obj")
            made = []
            threads = [threading.Thread(target=lambda seed=seed: made.append(mesh.fracture(seed=seed))) for seed in range(4)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join(PATIENCE)
            self.assertEqual(len(made), 4)
            self.assertEqual([a.method for a in server.asked].count("PUT"), 1)

    def test_a_mesh_that_is_missing_after_its_put_is_the_servers_own_no(self):
        def handler(asked):
            return stored() if asked.method != "POST" else problem(404, "not-found")
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            error = caught(client.put(b"mesh", format="obj").fracture)
            self.assertEqual((error.type, error.status), ("not-found", 404))
            self.assertEqual([a.method for a in server.asked], ["GET", "POST", "PUT", "POST"])

    def test_a_fragment_that_does_not_exist_is_no_forgotten_mesh(self):
        def handler(asked):
            return stored(200) if asked.method == "GET" else problem(404, "no-such-fragment")
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            self.assertEqual(caught(client.put(b"mesh", format="obj").fracture, fragment=3).type, "no-such-fragment")
            self.assertEqual(len(server.asked), 2)

    def test_an_unknown_mesh_that_is_not_here_is_refused_once(self):
        with FaultServer(lambda asked: problem(404, "not-found")) as server, Client(server.url, settings=quick()) as client:
            self.assertEqual(caught(client.mesh(ID).fracture).type, "not-found")
            self.assertEqual(len(server.asked), 1)

    def test_a_proxys_own_404_is_no_forgotten_mesh(self):
        page = answer(404, "<html><title>No</title><p>nothing here</p>", "Content-Type: text/html\r\n")
        with FaultServer(lambda asked: stored(200) if asked.method == "GET" else page) as server, \
                Client(server.url, settings=quick()) as client:
            error = caught(client.put(b"mesh", format="obj").fracture)
            self.assertEqual((error.type, error.status, error.problem), ("http-404", 404, {}))
            self.assertIn("nothing here", error.detail)
            self.assertEqual(len(server.asked), 2)


class Refusals(unittest.TestCase):
    def test_they_carry_the_servers_words(self):
        document = {"type": "/problems/bad-parameter", "title": "T", "status": 400, "detail": "D1", "parameter": "sites",
                    "request_id": "7", "errors": [{"detail": "D1", "parameter": "sites"}, {"detail": "D2"}], "more_errors": 3}
        reply = answer(400, json.dumps(document), "Content-Type: application/problem+json\r\n")
        with FaultServer(lambda asked: reply) as server, Client(server.url, settings=quick()) as client:
            error = caught(client.mesh(ID).fracture, sites=-1)
            self.assertEqual(len(server.asked), 1)
        self.assertEqual((error.type, error.status, error.title, error.detail, error.parameter),
                         ("bad-parameter", 400, "T", "D1", "sites"))
        self.assertEqual(error.problem, document)
        self.assertEqual(str(error), "D1\nD2\n3 more errors are not listed. [bad-parameter, HTTP 400]")

    def test_a_busy_server_is_asked_again_after_its_retry_after(self):
        for status, slug in ((503, "overloaded"), (429, "over-share"), (503, "a-type-of-tomorrow")):
            def handler(asked):
                return problem(status, slug, "Retry-After: 7\r\n") if asked.number < 6 else fragments()
            with self.subTest(slug), FaultServer(handler) as server, Client(server.url, settings=quick()) as client, \
                    mock.patch.object(Call, "pause") as pause:
                self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
                self.assertEqual(len(server.asked), 7)
                self.assertEqual([call.args for call in pause.mock_calls], 6 * [(7.0,)])
                self.assertEqual(server.connections, 1)

    def test_without_a_retry_after_the_pauses_grow(self):
        def handler(asked):
            return problem(503, "overloaded") if asked.number < 5 else fragments()
        with FaultServer(handler) as server, \
                Client(server.url, settings=quick(first_pause=0.25, longest_pause=1.0)) as client, \
                mock.patch.object(Call, "pause") as pause:
            client.mesh(ID).fracture()
            self.assertEqual([call.args[0] for call in pause.mock_calls], [0.25, 0.5, 1.0, 1.0, 1.0])

    def test_a_retry_after_beyond_the_deadline_is_an_answer_at_once(self):
        with FaultServer(lambda asked: problem(503, "overloaded", "Retry-After: 3600\r\n")) as server, \
                Client(server.url, timeout=PATIENCE, settings=quick()) as client:
            error = caught(client.mesh(ID).fracture)
            self.assertEqual((error.type, error.status), ("overloaded", 503))
            self.assertEqual(len(server.asked), 1)

    def test_tries_are_counted(self):
        with FaultServer(lambda asked: problem(503, "overloaded", "Retry-After: 0\r\n")) as server, \
                Client(server.url, settings=quick(tries=4)) as client:
            self.assertIn("asked 4 times", caught(client.mesh(ID).fracture).detail)
            self.assertEqual(len(server.asked), 4)

    def test_a_storm_of_refusals_loses_no_request(self):
        def handler(asked):
            return problem(503, "overloaded", "Retry-After: 0\r\n") if asked.number % 3 != 2 else fragments()
        with FaultServer(handler) as server, Client(server.url, settings=quick(tries=1000)) as client:
            made = []
            threads = [threading.Thread(target=lambda seed=seed: made.append(client.mesh(ID).fracture(seed=seed)))
                       for seed in range(50)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join(PATIENCE)
            self.assertEqual(len(made), 50)
            self.assertEqual(len(server.asked), 150)

    def test_what_leads_elsewhere_is_not_followed(self):
        with FaultServer(lambda asked: answer(301, "", "Location: https://elsewhere.example/\r\n")) as server, \
                Client(server.url, settings=quick()) as client:
            error = caught(client.version)
            self.assertEqual(error.type, "http-301")
            self.assertIn("https://elsewhere.example/", error.detail)


class Sending(unittest.TestCase):
    def test_the_token_is_sent(self):
        with FaultServer(lambda asked: answer(200, "{}")) as server, Client(server.url, "secret", settings=quick()) as client:
            client.patterns()
            self.assertEqual(server.asked[0].field("Authorization"), "Bearer secret")

    def test_a_token_with_a_line_break_is_refused_here(self):
        for token in ("secret\n", "a b", "", "geheim\u00e4"):
            self.assertEqual(caught(Client, "http://127.0.0.1:1", token).parameter, "token", repr(token))

    def test_fractures_are_batch_work_unless_they_are_asked_for_as_realtime(self):
        with FaultServer(known) as server, Client(server.url, settings=quick()) as batch, \
                Client(server.url, realtime=True, settings=quick()) as game:
            for client, options in ((batch, {}), (game, {}), (batch, {"realtime": True}), (game, {"realtime": False})):
                client.mesh(ID).fracture(**options)
            self.assertEqual([a.field("Priority") for a in server.asked], ["u=3", "u=1", "u=1", "u=3"])

    def test_parameters_beyond_the_paths_limit_go_with_the_mesh_as_a_form(self):
        points = [[k / 7, 0, 0] for k in range(5000)]
        with FaultServer(known) as server, Client(server.url, settings=quick()) as client:
            client.put(b"glTFmesh").fracture(pattern="points", points=points)
            form = server.asked[1]
        self.assertEqual(form.target, "/fracture")
        boundary = form.field("Content-Type").split("boundary=")[1].encode()
        parts = dict(part.split(b"\r\n\r\n", 1) for part in form.body.split(b"--" + boundary) if b"\r\n\r\n" in part)
        params = next(body for head, body in parts.items() if b'name="params"' in head)
        self.assertEqual(json.loads(params), {"pattern": "points", "points": points})
        self.assertIn(b"glTFmesh\r\n", parts.values())

    def test_a_query_is_sent_as_it_is(self):
        with FaultServer(known) as server, Client(server.url, settings=quick()) as client:
            client.mesh(ID).fracture("material=stone&nodes=12")
            self.assertEqual(server.asked[0].target, f"/meshes/{ID}/fracture?material=stone&nodes=12")

    def test_what_cannot_be_sent_names_the_parameter(self):
        mesh = Mesh(Client("http://127.0.0.1:1"), ID)
        for value in (float("nan"), {1, 2}, object()):
            error = caught(mesh.fracture, sites=5, radius=value)
            self.assertEqual((error.type, error.parameter), ("bad-parameter", "radius"))

    def test_addresses_are_judged_before_anybody_is_asked(self):
        for url in ("127.0.0.1:8080", "ftp://host", "http://", "http://host:port", "http://user:secret@host", "http://h/?a=b"):
            self.assertEqual(caught(Client, url).type, "bad-url", url)

    def test_a_path_in_the_address_stands_before_every_other(self):
        with FaultServer(lambda asked: answer(200, "{}")) as server, \
                Client(server.url + "/farm/", settings=quick()) as client:
            client.version()
            self.assertEqual(server.asked[0].target, "/farm/version")


class Fields(unittest.TestCase):
    def test_retry_after_is_seconds_within_a_day(self):
        def seconds(text):
            return asking.retry_after(Response(503, {"retry-after": text}))
        self.assertEqual([seconds("2"), seconds(" 0 "), seconds("86400")], [2, 0, 86400])
        for text in ("", "-1", "1.5", "Fri, 31 Dec 1999 23:59:59 GMT", "99999999999999999999", "86401"):
            self.assertIsNone(seconds(text), text)

    def test_a_digest_is_that_of_the_bytes(self):
        # The digest of empty data is known from FIPS 180-4's examples; its base64 comes from coreutils.
        of_nothing = "sha-256=:47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=:"
        self.assertTrue(asking.digest_matches(of_nothing, b""))
        self.assertTrue(asking.digest_matches("md5=:x:, " + of_nothing, b""))
        self.assertFalse(asking.digest_matches(of_nothing, b"x"))
        self.assertFalse(asking.digest_matches("md5=:x:", b""))
        self.assertEqual(mesh_id(b""), "sha256:e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855")

    def test_patterns_are_json_or_damaged(self):
        def handler(asked):
            return answer(200, '{"patterns": [' if asked.number == 0 else '{"patterns": []}')
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            self.assertEqual(client.patterns(), {"patterns": []})
            eventually("two requests", lambda: len(server.asked) == 2)


class Turns(unittest.TestCase):
    def test_no_wait_for_an_answer_is_long(self):
        """An interrupt just before a wait is noticed only at the end of the wait."""
        waits = []

        class Watched(socket.socket):
            def settimeout(self, seconds):
                waits.append(seconds)
                super().settimeout(seconds)

        for limit in (0.5, None):
            here, there = socket.socketpair()
            connection = Connection(Watched(fileno=here.detach()))
            call = Call(limit, "GET /")
            try:
                if limit is None:  # ends because the other side hangs up
                    threading.Timer(0.5, there.close).start()
                with self.assertRaises(Trouble) as raised:
                    connection.exchange(Request("GET", "/"), "host", call, 100)
                self.assertEqual(raised.exception.type, "timeout" if limit else "connection")
                self.assertGreater(len(waits), 3)
                self.assertLessEqual(max(waits[1:]), TURN)  # the first is for sending
            finally:
                waits.clear()
                connection.close()
                there.close()


if __name__ == "__main__":
    main()
