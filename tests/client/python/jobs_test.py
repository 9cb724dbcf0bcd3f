#!/usr/bin/env python3
"""Jobs: their events (wherever these are cut), their result, their end."""
import asyncio
import itertools
import json
import unittest

from support import (FRAGMENTS, PATIENCE, Client, FaultServer, Reply, WithServer, answer, box_obj, caught, digest, fragments,
                     main, problem, quick)
from fracture_client import AsyncClient, jobs

ID = "sha256:" + "0" * 64
JOB = "0000000000000000-1111111111111111"


def state(state="running", percent=0, **more):
    return {"id": JOB, "state": state, "stage": "clip", "percent": percent, "created": "2026-11-25T07:10:45.339587Z",
            "durable": False, "links": {}, **more}


DONE = state("done", 100, result="/fractures/sha256:" + "2" * 64)


def event(document, name="progress"):
    return f"id: 7\nevent: {name}\ndata: {json.dumps(document)}\n\n".encode()


def stream(*events, whole=True):
    """Server-sent events in chunks of a size that cuts them anywhere."""
    text = b": nothing new\n\n".join(events)
    chunks = [text[k:k + 37] for k in range(0, len(text), 37)]
    body = b"".join(b"%x\r\n%b\r\n" % (len(chunk), chunk) for chunk in chunks) + (b"0\r\n\r\n" if whole else b"")
    return Reply(b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nTransfer-Encoding: chunked\r\n\r\n" + body, close=True)


def server_of(*streams, error=None):
    """A server that starts a job, then sends the streams in turn, and the result."""
    count = itertools.count()

    def handler(asked):
        if asked.method == "POST":
            return answer(202, json.dumps(state("queued")), f"Location: /jobs/{JOB}\r\n")
        if asked.target.endswith("/events"):
            return streams[min(next(count), len(streams) - 1)]
        if asked.target.startswith("/jobs/"):
            return answer(200, json.dumps(error or DONE))
        return fragments()
    return FaultServer(handler)


class Events(unittest.TestCase):
    def test_each_change_is_told_once(self):
        told = [state(percent=p) for p in (3, 50, 99)] + [DONE]
        with server_of(stream(*map(event, told))) as server, Client(server.url, settings=quick()) as client:
            job = client.mesh(ID).job(sites=5)
            self.assertEqual([s.percent for s in job.progress()], [3, 50, 99, 100])
            self.assertTrue(job.state.is_finished)
            self.assertEqual(job.result().glb, FRAGMENTS)
            self.assertEqual(server.asked[0].field("Prefer"), "respond-async")
            self.assertEqual(server.asked[-1].target, "/fractures/sha256:" + "2" * 64)

    def test_a_stream_that_breaks_is_opened_again(self):
        cut = stream(event(state(percent=3)), event(state(percent=50)), whole=False)
        with server_of(cut, Reply(b"", close=True), stream(event(state(percent=50)), event(DONE))) as server, \
                Client(server.url, settings=quick()) as client:
            job = client.mesh(ID).job()
            self.assertEqual([s.percent for s in job.progress()], [3, 50, 100])

    def test_a_stream_that_is_silent_for_ever_has_a_limit(self):
        with server_of(Reply(silent=True)) as server, Client(server.url, settings=quick()) as client:
            self.assertEqual(caught(list, client.mesh(ID).job().progress(timeout=0.1)).type, "timeout")

    def test_streams_without_a_word_are_counted(self):
        with server_of(Reply(b"", close=True)) as server, Client(server.url, settings=quick(tries=3)) as client:
            self.assertEqual(caught(list, client.mesh(ID).job().progress()).type, "connection")
            self.assertEqual(sum(asked.target.endswith("/events") for asked in server.asked), 3)

    def test_one_that_nobody_knows_is_refused_in_the_servers_words(self):
        with server_of(problem(404, "not-found")) as server, Client(server.url, settings=quick()) as client:
            self.assertEqual(caught(list, client.mesh(ID).job().progress()).type, "not-found")

    def test_events_that_are_none_are_damaged(self):
        for body in (b"data: no JSON\n\n", b"data: []\n\n", b'data: {"id": 5}\n\n', b"data: " + (2 << 20) * b"x"):
            with server_of(stream(body)) as server, Client(server.url, settings=quick()) as client:
                self.assertEqual(caught(list, client.mesh(ID).job().progress()).type, "damaged", body[:30])

    def test_lines_may_end_as_they_like(self):
        text = b'data: {"a":\r\ndata: 1}\r\n\r\n: comment\nid: 5\ndata:{"b": 2}\n\ndata: {"never": "ended"}'
        for size in (1, 2, 7, len(text)):
            blocks = iter([text[k:k + size] for k in range(0, len(text), size)])
            self.assertEqual(list(jobs.events(blocks)), [{"a": 1}, {"b": 2}], size)

    def test_a_job_that_failed_raises_its_problem(self):
        failed = state("failed", 40, error={"type": "/problems/too-complex", "status": 422, "detail": "D", "title": "T"})
        with server_of(error=failed) as server, Client(server.url, settings=quick()) as client:
            error = caught(client.mesh(ID).job().result)
            self.assertEqual((error.type, error.status, error.detail), ("too-complex", 422, "D"))
            self.assertEqual(len(server.asked), 2)

    def test_a_job_that_does_not_end_in_time_goes_on(self):
        with server_of(error=state(percent=40)) as server, Client(server.url, settings=quick()) as client:
            error = caught(client.mesh(ID).job().wait, timeout=0.05)
            self.assertEqual(error.type, "timeout")
            self.assertIn("40 %", error.detail)

    def test_a_result_that_is_cut_is_asked_for_again(self):
        cut = Reply(b"HTTP/1.1 200 OK\r\n" + digest(FRAGMENTS).encode() + b"Content-Length: 999\r\n\r\nabc", close=True)
        count = itertools.count()

        def handler(asked):
            if asked.target.startswith("/fractures/"):
                return cut if next(count) == 0 else fragments()
            return answer(200 if asked.method == "GET" else 202, json.dumps(DONE))
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            self.assertEqual(client.mesh(ID).job().result().glb, FRAGMENTS)


class Real(WithServer):
    def test_a_job_comes_to_the_bytes_that_an_answer_has(self):
        mesh = self.client.put(box_obj(), format="obj")
        job = mesh.job(sites=60, seed=3)
        seen = list(job.progress(timeout=PATIENCE))
        self.assertEqual([s.percent for s in seen], sorted(s.percent for s in seen))
        self.assertEqual((seen[-1].state, seen[-1].percent), ("done", 100))
        made = job.result()
        self.assertEqual(made.glb, mesh.fracture(sites=60, seed=3).glb)
        self.assertIs(made.mesh, mesh)
        self.assertIn(job.id, [other.id for other in self.client.jobs("done")])
        self.assertEqual(self.client.find_job(job.id).result().glb, made.glb)
        self.assertEqual(made.hit([0.5, 0.5, 0.5], 0.2).certificate["open_edges"], 0)

    def test_progress_of_a_finished_job_is_its_end(self):
        job = self.client.put(box_obj(2), format="obj").job(sites=5)
        job.wait(timeout=PATIENCE)
        self.assertEqual([s.state for s in job.progress(timeout=PATIENCE)], ["done"])

    def test_cancelling_is_forgetting_where_it_has_finished(self):
        job = self.client.put(box_obj(3), format="obj").job(sites=5)
        job.wait(timeout=PATIENCE)
        self.assertTrue(job.cancel())
        self.assertFalse(job.cancel())
        self.assertEqual(caught(job.refresh).type, "not-found")

    def test_a_cancelled_job_has_no_result(self):
        job = self.client.put(box_obj(4), format="obj").job(sites=20_000, lloyd=50)  # a minute, if it were not cancelled
        job.cancel()
        self.assertEqual(job.wait(timeout=PATIENCE).state, "cancelled")
        self.assertEqual(caught(job.result).type, "cancelled")

    def test_a_refused_job_raises_where_it_is_asked_for_or_in_its_result(self):
        mesh = self.client.put(box_obj(), format="obj")
        self.assertEqual(caught(mesh.job, sites=-1).parameter, "sites")
        job = mesh.job(fragment=3)
        self.assertEqual(caught(job.result, timeout=PATIENCE).type, "no-such-fragment")

    def test_pages_of_jobs_are_followed(self):
        mesh = self.client.put(box_obj(5), format="obj")
        ids = {mesh.job(sites=1, seed=seed).id for seed in range(103)}  # a page contains a hundred
        self.assertLessEqual(ids, {job.id for job in self.client.jobs()})

    def test_the_same_for_asyncio(self):
        async def run():
            async with AsyncClient(self.server.url) as client:
                mesh = await client.put(box_obj(), format="obj")
                job = await mesh.job(sites=61)
                states = [s.state async for s in job.progress(timeout=PATIENCE)]
                made = await job.result()
                listed = [other.id async for other in client.jobs()]
                self.assertEqual(states[-1], "done")
                self.assertIn(job.id, listed)
                self.assertEqual(made.glb, (await mesh.fracture(sites=61)).glb)
                self.assertEqual((await (await client.find_job(job.id)).refresh()).state, "done")
                self.assertTrue(await job.cancel())
        asyncio.run(run())


if __name__ == "__main__":
    main()
