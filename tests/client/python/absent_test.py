#!/usr/bin/env python3
"""Servers that are silent, absent or slow, or die (tests/client/protocol_faults_test.cpp)."""
import threading
import time
import unittest

from support import (FRAGMENTS, PATIENCE, Client, FaultServer, Reply, caught, deserted_url, eventually, fragments, main,
                     problem, quick, stored)

ID = "sha256:" + "0" * 64
SILENT = Reply(silent=True)


class Silent(unittest.TestCase):
    def test_an_exchange_without_an_answer_times_out_and_is_tried_again(self):
        with FaultServer(lambda asked: SILENT if asked.number < 2 else fragments()) as server, \
                Client(server.url, settings=quick(answer_timeout=0.05)) as client:
            self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
            self.assertEqual((len(server.asked), server.connections), (3, 3))

    def test_the_deadline_of_the_call_ends_all_tries(self):
        with FaultServer(lambda asked: SILENT) as server, Client(server.url, settings=quick(answer_timeout=PATIENCE)) as client:
            error = caught(client.mesh(ID).fracture, timeout=0.05)
            self.assertEqual((error.type, error.status), ("timeout", 0))
            self.assertIn("fracture", error.detail)
            eventually("the client to hang up", lambda: server.closed_by_client == len(server.asked))

    def test_a_byte_now_and_then_is_no_reason_to_wait_longer(self):
        for reply in (Reply(b"HTTP/1.1 200 OK\r\nX: ", drip=True), Reply(b"HTTP/1.1 200 OK\r\nContent-Length: 9999\r\n\r\n", drip=True)):
            with FaultServer(lambda asked: reply) as server, \
                    Client(server.url, settings=quick(answer_timeout=0.2, tries=1)) as client:
                self.assertEqual(caught(client.mesh(ID).fracture).type, "timeout")

    def test_no_connection_that_becomes_free_is_a_timeout_too(self):
        with FaultServer(lambda asked: SILENT) as server, Client(server.url, settings=quick(connections=1)) as client:
            first = threading.Thread(target=lambda: caught(client.mesh(ID).fracture))
            first.start()
            eventually("the first request", lambda: len(server.asked) == 1)
            self.assertEqual(caught(client.version, timeout=0.05).type, "timeout")
            client.close()
            first.join(PATIENCE)
            self.assertFalse(first.is_alive())


class Absent(unittest.TestCase):
    def test_it_is_a_failure_when_the_tries_end(self):
        with Client(deserted_url(), settings=quick(tries=3)) as client:
            error = caught(client.mesh(ID).fracture)
        self.assertEqual((error.type, error.status, error.problem), ("connection", 0, {}))
        self.assertIn("asked 3 times", error.detail)

    def test_it_is_a_failure_when_the_time_ends(self):
        with Client(deserted_url(), timeout=0.05, settings=quick(tries=1_000_000)) as client:
            self.assertIn(caught(client.version).type, ("connection", "timeout"))  # the time limit may cut the last attempt short

    def test_a_name_that_does_not_exist_is_said_at_once(self):
        with Client("http://no-such-host.invalid", settings=quick()) as client:  # RFC 2606: never exists
            error = caught(client.version)
        self.assertEqual(error.type, "connection")
        self.assertIn("no-such-host.invalid", error.detail)

    def test_a_call_waits_for_the_server_to_come_back(self):
        url = deserted_url()
        with Client(url, timeout=PATIENCE, settings=quick(tries=1_000_000)) as client:
            made = []
            waiting = threading.Thread(target=lambda: made.append(client.mesh(ID).fracture()))
            waiting.start()
            with FaultServer(lambda asked: fragments(), port=int(url.rsplit(":", 1)[1])):
                waiting.join(PATIENCE)
            self.assertEqual([answer.glb for answer in made], [FRAGMENTS])

    def test_a_server_that_dies_in_mid_flight_and_comes_back_answers(self):
        first = FaultServer(lambda asked: SILENT)
        with Client(first.url, timeout=PATIENCE, settings=quick(tries=1_000_000)) as client:
            made = []
            waiting = threading.Thread(target=lambda: made.append(client.mesh(ID).fracture()))
            waiting.start()
            eventually("the first request", lambda: len(first.asked) == 1)
            first.close()
            with FaultServer(lambda asked: fragments(), port=first.port):
                waiting.join(PATIENCE)
            self.assertEqual([answer.glb for answer in made], [FRAGMENTS])

    def test_a_reset_is_tried_again(self):
        for cut in (b"", FRAGMENTS[:5], fragments().bytes[:-5]):
            with FaultServer(lambda asked: Reply(cut, reset=True) if asked.number == 0 else fragments()) as server, \
                    Client(server.url, settings=quick()) as client:
                self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
                self.assertEqual(len(server.asked), 2)


class Kept(unittest.TestCase):
    def test_a_connection_that_the_server_closed_is_replaced_unseen(self):
        def handler(asked):
            reply = fragments()
            reply.close = asked.number == 0  # without announcing Connection: close
            return reply
        with FaultServer(handler) as server, Client(server.url, settings=quick(tries=1)) as client:
            for _ in range(2):
                self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
            self.assertEqual((server.connections, len(server.asked)), (2, 2))

    def test_one_that_says_so_is_not_used_again(self):
        with FaultServer(lambda asked: fragments("Connection: close\r\n")) as server, \
                Client(server.url, settings=quick()) as client:
            for _ in range(2):
                client.mesh(ID).fracture()
            self.assertEqual(server.connections, 2)

    def test_one_that_was_unused_for_long_is_replaced(self):
        with FaultServer(lambda asked: fragments()) as server, Client(server.url, settings=quick(idle=0.01)) as client:
            client.mesh(ID).fracture()
            time.sleep(0.02)  # pause: the connection must be unused
            client.mesh(ID).fracture()
            self.assertEqual(server.connections, 2)

    def test_a_large_mesh_that_is_refused_before_it_was_read_is_refused_in_the_servers_words(self):
        def handler(asked):
            return problem(404, "not-found") if asked.method == "GET" else problem(413, "body-too-large")
        with FaultServer(handler, early=True) as server, Client(server.url, settings=quick()) as client:
            error = caught(client.put, bytes(20 << 20), format="stl")
            self.assertEqual((error.type, error.status), ("body-too-large", 413))

    def test_a_mesh_of_many_blocks_arrives_as_it_is(self):
        content = bytes(range(256)) * 5000
        with FaultServer(lambda asked: problem(404, "not-found") if asked.method == "GET" else stored()) as server, \
                Client(server.url, settings=quick()) as client:
            client.put(content, format="stl")
            self.assertEqual(server.asked[1].body, content)


if __name__ == "__main__":
    main()
