"""Code that the tests of the Python package share: a server with raw sockets that answers as a test says, including
badly; the real server as a process; small meshes; and patience.

Each test file runs by itself: python3 tests/client/python/asking_test.py. FRACTURE_TEST_SERVER names the program
fracture-server; without it the tests that need it are skipped.
"""
import base64
import hashlib
import itertools
import json
import os
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request
import zlib
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[3]
PACKAGE = ROOT / "client" / "python"
sys.dont_write_bytecode = True  # tests leave no files behind in the checkout
sys.path.insert(0, str(PACKAGE))
from fracture_client import Client, FractureError, Settings, glb  # noqa: E402

PATIENCE = 60.0  # seconds, after which an expected event counts as missing: hundreds of times what it takes
SKIPPED = 77  # exit code if all tests of a file were skipped, which CTest knows


def main():
    """Runs a test file."""
    program = unittest.main(exit=False, verbosity=2)
    result = program.result
    if not result.wasSuccessful():
        sys.exit(1)
    if result.skipped and len(result.skipped) >= result.testsRun:
        sys.exit(SKIPPED)


def eventually(what, condition):
    """Waits until the condition holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"not within {PATIENCE:g} s: {what}")
        time.sleep(0.002)  # pause: between two checks, up to the limit


def quick(**settings):
    """Settings without pauses for which a test would wait."""
    return Settings(**{"first_pause": 0.001, "longest_pause": 0.01, **settings})


def caught(call, *arguments, **options):
    """Returns the FractureError that the call raises."""
    try:
        call(*arguments, **options)
    except FractureError as error:
        return error
    raise AssertionError("no FractureError was raised")


# -- a server that answers as a test says

@dataclass
class Asked:
    """A request that arrived."""
    method: str
    target: str
    head: str
    body: bytes
    number: int  # among all requests, from 0
    connection: int  # from 0

    def field(self, name):
        found = re.search(rf"^{name}: (.*?)\r$", self.head, re.MULTILINE | re.IGNORECASE)
        return found.group(1) if found else None


@dataclass
class Reply:
    bytes: bytes = b""  # sent unchanged
    close: bool = False  # then the connection is closed
    silent: bool = False  # sends nothing; the connection stays open until the client closes it
    reset: bool = False  # then the connection is reset
    drip: bool = False  # a byte at a time, and more bytes forever after the last


def answer(status, body=b"", headers="", close=False):
    body = body.encode() if isinstance(body, str) else body
    return Reply(f"HTTP/1.1 {status} Reason\r\n{headers}Content-Length: {len(body)}\r\n\r\n".encode() + body, close)


def digest(content):
    return f"Repr-Digest: sha-256=:{base64.b64encode(hashlib.sha256(content).digest()).decode()}:\r\n"


def problem(status, slug, headers=""):
    return answer(status, json.dumps({"type": f"/problems/{slug}", "title": "Title", "status": status, "detail": "Because."}),
                  "Content-Type: application/problem+json\r\n" + headers)


def stored(status=201, report=None):
    return answer(status, json.dumps({"id": "sha256:0", "report": {"verdict": "closed", **(report or {})}}))


def figures(**more):
    return {"version": 1, "algorithm": 14, "mesh": "sha256:" + "0" * 64, "parameters": {}, "report": {},
            "interior_materials": [1], "certificate": {"fragments": 0, "open_edges": 0, "volume_out": 0},
            "bonds": {"a": [], "b": [], "area": [], "centroid": [], "normal": [], "strength": []}, **more}


def small_glb(**more):
    """A GLB as the server writes it, without fragments."""
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                "nodes": [{"name": "Fracture", "extras": {"fracture": figures(**more)}}]}
    return glb.pack(document, b"")


FRAGMENTS = small_glb()


def fragments(headers="", content=FRAGMENTS):
    return answer(200, content, digest(content) + headers)


class FaultServer:
    """Listens on 127.0.0.1. `handler(Asked)` returns the Reply."""

    def __init__(self, handler, port=0, early=False):
        """`early`: answers once the head has arrived, without reading the body, and closes."""
        self._handler = handler
        self._early = early
        self._lock = threading.Lock()
        self._asked = []
        self._sockets = []
        self._threads = []
        self.closed_by_client = 0  # connections that ended while the server was silent or sending
        self._stopping = False
        self._listener = socket.socket()
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._listener.bind(("127.0.0.1", port))
        self._listener.listen(64)
        self.port = self._listener.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self._acceptor = threading.Thread(target=self._accept, daemon=True)
        self._acceptor.start()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()

    def close(self):
        self._stopping = True
        for end in (self._listener, *self._sockets):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        self._listener.close()
        for thread in (self._acceptor, *self._threads):
            thread.join(PATIENCE)

    @property
    def asked(self):
        with self._lock:
            return list(self._asked)

    @property
    def connections(self):
        with self._lock:
            return len(self._sockets)

    def _accept(self):
        for number in itertools.count():
            try:
                end, _ = self._listener.accept()
            except OSError:
                return
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            thread = threading.Thread(target=self._serve, args=(end, number), daemon=True)
            with self._lock:
                self._sockets.append(end)
                self._threads.append(thread)
            thread.start()

    def _serve(self, end, connection):
        with end:
            try:
                self._converse(end, connection)
            except OSError:
                with self._lock:
                    self.closed_by_client += not self._stopping

    def _converse(self, end, connection):
        received = b""
        while not self._stopping:
            while b"\r\n\r\n" not in received:
                block = end.recv(65536)
                if not block:
                    return
                received += block
            head, received = received.split(b"\r\n\r\n", 1)
            asked = Asked(*head.decode().split(" ", 2)[:2], head.decode() + "\r\n", b"", 0, connection)
            length = int(asked.field("Content-Length") or 0)
            early = self._early and self._handler(asked)
            while not early and len(received) < length:
                block = end.recv(65536)
                if not block:
                    return
                received += block
            asked.body, received = received[:length], received[length:]
            with self._lock:
                asked.number = len(self._asked)
                self._asked.append(asked)
            reply = early or self._handler(asked)
            if reply.silent:
                while end.recv(65536):
                    pass
                raise OSError("the client has left")
            if reply.drip:
                for byte in itertools.chain(reply.bytes, itertools.repeat(32)):
                    end.sendall(bytes([byte]))
                    time.sleep(0.005)  # pause: a server that sends a byte at a time is the test
            end.sendall(reply.bytes)
            if reply.reset:
                end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            if reply.reset or reply.close:
                return
            if early:
                end.shutdown(socket.SHUT_WR)  # as a lingering server does: later bytes are not read
                return


def deserted_url():
    """An address on which nobody listens: its port belonged to a server that no longer exists."""
    with FaultServer(lambda asked: answer(200)) as server:
        return server.url


# -- the real one

def server_program():
    program = os.environ.get("FRACTURE_TEST_SERVER", "")
    if not program:
        raise unittest.SkipTest("FRACTURE_TEST_SERVER does not name the program fracture-server")
    if not os.access(program, os.X_OK):
        raise unittest.SkipTest(f"FRACTURE_TEST_SERVER is {program}, which is no program")
    return program


class Server:
    """`fracture-server serve` on free ports, which it names in its log."""

    def __init__(self, *flags, port=0):
        self.process = subprocess.Popen(
            [server_program(), "serve", "--port", str(port), "--admin-port", "0", "--threads", "1", "--drain-delay", "0", "--log-format",
             "text", *flags], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        self.lines = []
        for line in self.process.stderr:
            self.lines.append(line)
            found = re.search(r"serving on http://127\.0\.0\.1:(\d+) \(admin port (\d+)\)", line)
            if found:
                break
        else:
            self.process.wait(PATIENCE)
            raise RuntimeError("the server ended before it listened: " + "".join(self.lines[-3:]))
        self.port, admin = map(int, found.groups())
        self.url, self.admin_url = f"http://127.0.0.1:{self.port}", f"http://127.0.0.1:{admin}"
        self._reader = threading.Thread(target=lambda: self.lines.extend(self.process.stderr), daemon=True)
        self._reader.start()  # a pipe that nobody reads would fill up

    def stop(self):
        self.process.terminate()
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)
        self.process.stderr.close()


class Haproxy:
    """HAProxy with the repository's configuration in front of one server. Only addresses and the number of connections
    differ. `HAProxy is not installed` skips the test."""

    def __init__(self, server):
        program = shutil.which("haproxy", path=os.environ.get("PATH", "") + ":/usr/sbin:/usr/local/sbin")
        if program is None:
            raise unittest.SkipTest("HAProxy is not installed")
        admin = server.admin_url.rsplit(":", 1)[1]
        listeners = [socket.create_server(("127.0.0.1", 0)) for _ in range(2)]  # inherited, so that nobody else takes the ports
        public, statistics = (listener.fileno() for listener in listeners)
        text = (ROOT / "docker" / "haproxy" / "haproxy.cfg").read_text(encoding="utf-8")
        for old, new in ((r"bind :8080", f"bind fd@{public}"), (r"bind :8404", f"bind fd@{statistics}"), (r"maxconn 4000", "maxconn 200"),
                         (r"(?m)^    server fracture[23] .*\n", ""), (r"fracture1:8080 track", f"127.0.0.1:{server.port} track"),
                         (r"fracture1:8080\n", f"127.0.0.1:{server.port} port {admin}\n")):
            text, count = re.subn(old, new, text)
            if count == 0:
                raise AssertionError(f"haproxy.cfg: where is {old}?")
        self._folder = tempfile.TemporaryDirectory()
        path = pathlib.Path(self._folder.name, "haproxy.cfg")
        path.write_text(text, encoding="utf-8")
        self.log = open(pathlib.Path(self._folder.name, "log"), "w+", encoding="utf-8")
        self.process = subprocess.Popen([program, "-db", "-f", str(path)], stdout=self.log, stderr=self.log,
                                        pass_fds=(public, statistics))
        self.port = listeners[0].getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        for listener in listeners:
            listener.close()
        eventually("HAProxy to pass on what it is asked", self._answers)

    def _answers(self):
        if self.process.poll() is not None:
            self.log.seek(0)
            raise RuntimeError("HAProxy ended: " + self.log.read())
        try:
            with urllib.request.urlopen(self.url + "/version", timeout=PATIENCE):
                return True
        except urllib.error.HTTPError as error:
            return error.code == 401  # from the server; HAProxy's own error would be 503
        except OSError:
            return False

    def stop(self):
        self.process.kill()
        self.process.wait(PATIENCE)
        self.log.close()
        self._folder.cleanup()


class WithServer(unittest.TestCase):
    """A test case with one server and one client for the class."""

    flags = ()

    @classmethod
    def setUpClass(cls):
        cls.server = Server(*cls.flags)
        cls.addClassCleanup(cls.server.stop)
        cls.client = Client(cls.server.url, timeout=120)
        cls.addClassCleanup(cls.client.close)


# -- meshes

def box_obj(x=1.0, y=1.0, z=1.0, extra=""):
    """A closed box from the origin, with volume x y z, as OBJ."""
    corners = [(i, j, k) for i in (0, x) for j in (0, y) for k in (0, z)]
    quads = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [extra, *(f"v {a} {b} {c}" for a, b, c in corners), *("f " + " ".join(map(str, q)) for q in quads)]
    return ("\n".join(line for line in lines if line) + "\n").encode()


def box_gltf(uri):
    """The unit box as glTF whose buffer has this uri. Returns the JSON text and the buffer."""
    positions = struct.pack("<24f", *(float(c) for i in (0, 1) for j in (0, 1) for k in (0, 1) for c in (i, j, k)))
    triangles = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
                 (1, 5, 7), (1, 7, 3)]
    indices = struct.pack("<36H", *(v for triangle in triangles for v in triangle))
    views = [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                 {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}]
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "box", "mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "buffers": [{"uri": uri, "byteLength": 168}], "bufferViews": views, "accessors": accessors}
    return json.dumps(document, ensure_ascii=False).encode("utf-8"), positions + indices


def pixel_png():
    """One white pixel (PNG, ISO/IEC 15948)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"".join([b"\x89PNG\r\n\x1a\n", chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)),
                     chunk(b"IDAT", zlib.compress(b"\0\xff\xff\xff")), chunk(b"IEND", b"")])
