#!/usr/bin/env python3
"""Answers are either read unchanged or refused: digests, cuts, limits, framing
(tests/client/protocol_answers_test.cpp)."""
import unittest

from support import FRAGMENTS, Client, FaultServer, Reply, answer, caught, digest, fragments, main, quick

ID = "sha256:" + "0" * 64
WHOLE = fragments().bytes


class Damage(unittest.TestCase):
    def test_a_bit_that_flipped_is_noticed_and_asked_for_again(self):
        flipped = bytearray(WHOLE)
        flipped[-1] ^= 4
        with FaultServer(lambda asked: Reply(bytes(flipped)) if asked.number == 0 else fragments()) as server, \
                Client(server.url, settings=quick()) as client:
            self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
            self.assertEqual(len(server.asked), 2)

    def test_answers_that_stay_damaged_fail_as_damaged(self):
        with FaultServer(lambda asked: answer(200, "other bytes", digest(FRAGMENTS))) as server, \
                Client(server.url, settings=quick()) as client:
            self.assertEqual(caught(client.mesh(ID).fracture).type, "damaged")
            self.assertEqual(len(server.asked), 3)

    def test_an_answer_without_digest_is_damaged(self):
        with FaultServer(lambda asked: answer(200, FRAGMENTS)) as server, Client(server.url, settings=quick()) as client:
            error = caught(client.mesh(ID).fracture)
            self.assertEqual((error.type, error.status), ("damaged", 200))
            self.assertIn("Repr-Digest", error.detail)

    def test_every_truncation_of_an_answer_is_survived(self):
        for length in range(1, len(WHOLE)):
            with self.subTest(length), FaultServer(
                    lambda asked: Reply(WHOLE[:length], close=True) if asked.number == 0 else fragments()) as server, \
                    Client(server.url, settings=quick()) as client:
                self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
                self.assertEqual(len(server.asked), 2)

    def test_every_flipped_byte_of_an_answer_is_survived(self):
        state = {}

        def handler(asked):
            if "at" not in state:
                return fragments()
            flipped = bytearray(WHOLE)
            flipped[state.pop("at")] ^= 0x12
            return Reply(bytes(flipped), close=True)  # so that the client does not wait for a longer body
        with FaultServer(handler) as server, Client(server.url, settings=quick()) as client:
            mesh = client.mesh(ID)
            for state["at"] in range(len(WHOLE)):
                at = state["at"]
                self.assertEqual(mesh.fracture().glb, FRAGMENTS, at)

    def test_what_is_no_glb_is_damaged_whatever_its_digest_says(self):
        for content in (b"", b"glTF", b"no GLB at all, but long enough for a header", FRAGMENTS[:-4], FRAGMENTS + b"\0\0\0\0"):
            with self.subTest(content[:20]), FaultServer(lambda asked: fragments(content=content)) as server, \
                    Client(server.url, settings=quick()) as client:
                self.assertEqual(caught(client.mesh(ID).fracture).type, "damaged")


class Framing(unittest.TestCase):
    def ask(self, *replies):
        """Returns the answer or the error, and how many requests it took. The last reply is repeated forever."""
        with FaultServer(lambda asked: replies[min(asked.number, len(replies) - 1)]) as server, \
                Client(server.url, settings=quick(max_answer_bytes=10_000)) as client:
            try:
                return client.mesh(ID).fracture(), len(server.asked)
            except Exception as error:
                return error, len(server.asked)

    def test_an_answer_over_the_limit_is_refused_unread(self):
        error, count = self.ask(Reply(b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\nabc"))
        self.assertEqual((error.type, count), ("answer-too-large", 1))
        self.assertIn("10,000", error.detail)

    def test_an_endless_answer_is_refused_at_the_limit(self):
        for head in (b"Transfer-Encoding: chunked\r\n\r\n" + 9 * (b"7d0\r\n" + 2000 * b"x" + b"\r\n"), b"\r\n" + 20_000 * b"x"):
            error, count = self.ask(Reply(b"HTTP/1.1 200 OK\r\n" + head))
            self.assertEqual((error.type, count), ("answer-too-large", 1))

    def test_chunks_and_answers_that_end_with_the_stream_are_read(self):
        head = b"HTTP/1.1 200 OK\r\n" + digest(FRAGMENTS).encode()
        half = len(FRAGMENTS) // 2
        chunked = b"".join(b"%x;note=1\r\n%b\r\n" % (len(part), part) for part in (FRAGMENTS[:half], FRAGMENTS[half:]))
        for reply in (Reply(head + b"Transfer-Encoding: chunked\r\n\r\n" + chunked + b"0\r\nTrailer: x\r\n\r\n"),
                      Reply(head + b"\r\n" + FRAGMENTS, close=True), Reply(head + b"Connection: close\r\n\r\n" + FRAGMENTS, close=True),
                      Reply(b"HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 103 Early\r\nLink: </x>\r\n\r\n" + WHOLE)):
            got, count = self.ask(reply)
            self.assertEqual((getattr(got, "glb", got), count), (FRAGMENTS, 1))

    def test_bytes_behind_an_answer_are_no_answer_to_the_next_request(self):
        with FaultServer(lambda asked: Reply(WHOLE + WHOLE)) as server, Client(server.url, settings=quick()) as client:
            for count in (1, 2):
                self.assertEqual(client.mesh(ID).fracture().glb, FRAGMENTS)
                self.assertEqual((server.connections, len(server.asked)), (count, count))

    def test_what_is_no_http_is_damaged(self):
        bodies = (b"SSH-2.0-OpenSSH_9\r\n\r\n", b"HTTP/2 200\r\n\r\n", b"HTTP/1.1 200 OK\r\nno colon\r\n\r\n",
                  b"HTTP/1.1 200 OK\r\nContent-Length: 1x\r\n\r\n", b"HTTP/1.1 200 OK\r\n folded: x\r\n\r\n",
                  b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\nContent-Length: 6\r\n\r\nabcdef",
                  b"HTTP/1.1 200 OK\r\nTransfer-Encoding: gzip\r\n\r\n", b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nxyz\r\n",
                  b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nabc\r\n", b"HTTP/1.1 200 OK\r\nX: " + 70_000 * b"x")
        for body in bodies:
            error, count = self.ask(Reply(body, close=True))
            self.assertEqual((error.type, count), ("damaged", 3), body[:60])


if __name__ == "__main__":
    main()
