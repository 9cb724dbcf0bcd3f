#!/usr/bin/env python3
"""Calls that are cancelled, by a token, by closing the client, or by a cancelled task: the connection is closed."""
import asyncio
import threading
import unittest

from support import (FRAGMENTS, PATIENCE, Client, FaultServer, FractureError, Reply, caught, eventually, fragments, main,
                     problem, quick, stored)
from fracture_client import AsyncClient, Cancel

ID = "sha256:" + "0" * 64
SILENT = Reply(silent=True)


class InThread:
    """A call in a separate thread, and its result."""

    def __init__(self, call, *arguments, **options):
        self.result = self.error = None

        def run():
            try:
                self.result = call(*arguments, **options)
            except FractureError as error:
                self.error = error
        self.thread = threading.Thread(target=run)
        self.thread.start()

    def join(self):
        self.thread.join(PATIENCE)
        if self.thread.is_alive():
            raise AssertionError("the call has not ended")
        return self


class Tokens(unittest.TestCase):
    def test_a_call_that_waits_for_its_answer_ends_and_its_connection_too(self):
        with FaultServer(lambda asked: SILENT) as server, Client(server.url, settings=quick()) as client:
            token = Cancel()
            call = InThread(client.mesh(ID).fracture, cancel=token)
            eventually("the request", lambda: len(server.asked) == 1)
            token.cancel()
            self.assertEqual(call.join().error.type, "cancelled")
            eventually("the server to see it", lambda: server.closed_by_client == 1)
            self.assertEqual(len(server.asked), 1)

    def test_a_call_in_the_middle_of_an_answer_ends(self):
        with FaultServer(lambda asked: Reply(b"HTTP/1.1 200 OK\r\nContent-Length: 100000\r\n\r\nab", drip=True)) as server, \
                Client(server.url, settings=quick()) as client:
            token = Cancel()
            call = InThread(client.mesh(ID).fracture, cancel=token)
            eventually("the request", lambda: len(server.asked) == 1)
            token.cancel()
            self.assertEqual(call.join().error.type, "cancelled")
            eventually("the server to see it", lambda: server.closed_by_client == 1)

    def test_a_call_that_pauses_before_its_next_try_ends(self):
        with FaultServer(lambda asked: problem(503, "overloaded", "Retry-After: 3000\r\n")) as server, \
                Client(server.url, timeout=None, settings=quick()) as client:
            token = Cancel()
            call = InThread(client.mesh(ID).fracture, cancel=token)
            eventually("the request", lambda: len(server.asked) == 1)
            token.cancel()
            self.assertEqual(call.join().error.type, "cancelled")

    def test_a_call_that_waits_for_a_connection_ends_and_the_other_goes_on(self):
        release = threading.Event()

        def handler(asked):
            release.wait(PATIENCE)
            return fragments()
        with FaultServer(handler) as server, Client(server.url, settings=quick(connections=1)) as client:
            first = InThread(client.mesh(ID).fracture)
            eventually("the first request", lambda: len(server.asked) == 1)
            token = Cancel()
            second = InThread(client.mesh(ID).fracture, cancel=token)
            token.cancel()
            self.assertEqual(second.join().error.type, "cancelled")
            release.set()
            self.assertEqual(first.join().result.glb, FRAGMENTS)
            self.assertEqual(len(server.asked), 1)

    def test_a_call_that_waits_for_anothers_put_ends(self):
        release = threading.Event()

        def handler(asked):
            if asked.method == "PUT":
                release.wait(PATIENCE)
                return stored()
            return stored(200) if asked.method == "GET" else problem(404, "not-found")
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            mesh = client.put(b"mesh", format="obj")
            first = InThread(mesh.fracture)
            eventually("the PUT", lambda: [a.method for a in server.asked].count("PUT") == 1)
            token = Cancel()
            second = InThread(mesh.fracture, cancel=token)
            eventually("the second refusal", lambda: [a.method for a in server.asked].count("POST") == 2)
            token.cancel()
            self.assertEqual(second.join().error.type, "cancelled")
            release.set()
            self.assertEqual(first.join().error.type, "not-found")

    def test_a_token_that_was_used_takes_back_what_comes_later(self):
        with FaultServer(lambda asked: fragments()) as server, Client(server.url, settings=quick()) as client:
            token = Cancel()
            token.cancel()
            self.assertTrue(token.cancelled)
            self.assertEqual(caught(client.mesh(ID).fracture, cancel=token).type, "cancelled")
            self.assertEqual(server.asked, [])
            self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)


class Closing(unittest.TestCase):
    def test_it_ends_what_other_threads_wait_for(self):
        with FaultServer(lambda asked: SILENT) as server:
            client = Client(server.url, settings=quick(connections=2))
            calls = [InThread(client.mesh(ID).fracture, seed=seed) for seed in range(10)]
            eventually("two requests", lambda: len(server.asked) == 2)
            client.close()
            self.assertEqual({call.join().error.type for call in calls}, {"cancelled"})
            self.assertEqual(len(server.asked), 2)
            self.assertEqual(caught(client.version).detail, "The client is closed.")

    def test_no_connection_is_left(self):
        with FaultServer(lambda asked: fragments()) as server:
            with Client(server.url, settings=quick()) as client:
                client.mesh(ID).fracture()
                pool = client._pool
                self.assertEqual(len(pool._idle), 1)
            self.assertEqual(pool._idle, [])


class Tasks(unittest.TestCase):
    def test_a_cancelled_task_closes_its_connection(self):
        async def run(server):
            async with AsyncClient(server.url, settings=quick()) as client:
                task = asyncio.ensure_future(client.mesh(ID).fracture())
                await asyncio.get_running_loop().run_in_executor(
                    None, eventually, "the request", lambda: len(server.asked) == 1)
                task.cancel()
                with self.assertRaises(asyncio.CancelledError):
                    await task
                await asyncio.get_running_loop().run_in_executor(
                    None, eventually, "the server to see it", lambda: server.closed_by_client == 1)
        with FaultServer(lambda asked: SILENT) as server:
            asyncio.run(run(server))
            self.assertEqual(len(server.asked), 1)

    def test_a_task_that_has_not_begun_asks_nobody(self):
        async def run(server):
            async with AsyncClient(server.url, settings=quick(connections=1)) as client:
                tasks = [asyncio.ensure_future(client.mesh(ID).fracture(seed=seed)) for seed in range(8)]
                await asyncio.get_running_loop().run_in_executor(
                    None, eventually, "the first request", lambda: len(server.asked) == 1)
                for some in (tasks[1:], tasks[:1]):  # first those that wait for the connection, then the one that has it
                    for task in some:
                        task.cancel()
                    results = await asyncio.gather(*some, return_exceptions=True)
                    self.assertEqual({type(result) for result in results}, {asyncio.CancelledError})
        with FaultServer(lambda asked: SILENT) as server:
            asyncio.run(run(server))
            self.assertEqual(len(server.asked), 1)

    def test_wait_for_is_a_deadline(self):
        async def run(server):
            async with AsyncClient(server.url, settings=quick()) as client:
                with self.assertRaises(asyncio.TimeoutError):
                    await asyncio.wait_for(client.mesh(ID).fracture(), 0.05)
        with FaultServer(lambda asked: SILENT) as server:
            asyncio.run(run(server))
            eventually("the server to see it", lambda: server.closed_by_client == len(server.asked))  # 0 on a busy machine

    def test_many_at_once(self):
        async def run(server):
            async with AsyncClient(server.url, settings=quick()) as client:
                answers = await asyncio.gather(*(client.mesh(ID).fracture(seed=seed) for seed in range(30)))
                self.assertEqual([answer.glb for answer in answers], 30 * [FRAGMENTS])
        with FaultServer(lambda asked: fragments()) as server:
            asyncio.run(run(server))
            self.assertLessEqual(server.connections, 4)
            self.assertEqual(len(server.asked), 30)

    def test_errors_are_the_same(self):
        async def run(server):
            async with AsyncClient(server.url, settings=quick()) as client:
                with self.assertRaises(FractureError) as raised:
                    await client.version()
                self.assertEqual(raised.exception.type, "unauthorized")
        with FaultServer(lambda asked: problem(401, "unauthorized")) as server:
            asyncio.run(run(server))


if __name__ == "__main__":
    main()
