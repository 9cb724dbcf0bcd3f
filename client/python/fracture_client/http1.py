"""HTTP/1.1 (RFC 9112) over one socket, read strictly and within the time of a call.

The standard library's client is lenient where it should not be here (a header line that is none, bytes behind an answer),
and can neither be stopped from another thread nor kept from waiting for ever on a server that sends a byte a minute.
"""
from __future__ import annotations

import re
import socket
import time
from dataclasses import dataclass, field
from typing import Dict, Generator, Iterator, Tuple, Union

from .calls import Call, OutOfTime

MOST_HEAD_BYTES = 64 << 10  # of an answer's header; the server's have less than one KiB
BLOCK = 1 << 18  # bytes of one read: enough that the system calls do not count
TURN = 0.2  # s; an interrupt is never noticed later than this

_STATUS = re.compile(rb"HTTP/1\.[01] ([1-5][0-9][0-9])(?: [^\r\n]*)?")
_FIELD = re.compile(rb"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([^\r\n]*?)[ \t]*")


class Trouble(Exception):
    """An exchange that ended without an answer. The caller of the package never sees it."""

    def __init__(self, type: str, detail: str, *, began: bool = False, again: bool = True) -> None:
        super().__init__(detail)
        self.type = type  # of problems.LOCAL
        self.detail = detail
        self.began = began  # some of the answer had come
        self.again = again  # another try may end better


@dataclass
class Request:
    method: str
    target: str
    headers: Dict[str, str] = field(default_factory=dict)
    body: bytes = b""

    @property
    def what(self) -> str:
        """For messages: without the parameters, and a digest no longer than one knows it by."""
        path = re.sub(r"(sha256:[0-9a-f]{8})[0-9a-f]+", r"\1…", self.target.split("?")[0])
        return f"{self.method} {path}"


@dataclass
class Response:
    """An answer. Names of header fields are in lower case; fields of one name are joined by commas."""

    status: int
    headers: Dict[str, str]
    body: bytes = b""


class Connection:
    """One connection, for one request after the other. Not thread-safe but for what Call does."""

    def __init__(self, sock: socket.socket) -> None:
        self.socket = sock
        self._buffer = bytearray()
        self._began = False  # something of the present answer has come
        self.used = time.monotonic()
        self.reusable = True

    def close(self) -> None:
        self.socket.close()

    def wake(self) -> None:
        """From another thread: whatever is waited for ends, as if the other side had hung up."""
        try:  # of the base class: the one of TLS forgets its state while another thread reads
            socket.socket.shutdown(self.socket, socket.SHUT_RDWR)
        except OSError:
            pass  # the other side was faster

    def exchange(self, request: Request, authority: str, call: Call, most: int) -> Response:
        """Raises Trouble, and "cancelled". `most`: bytes of a body that are taken."""
        with call.waking(self.wake):
            head = self._ask(request, authority, call)
            body = bytearray()
            for block in self._blocks(head, request.method, call, most):
                body += block
            head.body = bytes(body)
            self.used = time.monotonic()
            self.reusable = self.reusable and not self._buffer
            return head

    def stream(self, request: Request, authority: str, call: Call, stall: float) -> Generator[Response, None, None]:
        """The head, then a Response for each block of the body as it comes; Trouble where nothing comes for `stall`
        seconds. The connection is of no use afterwards."""
        with call.waking(self.wake):
            self.reusable = False
            with call.at_most(stall):
                head = self._ask(request, authority, call)
            yield head
            blocks = self._blocks(head, request.method, call, most=1 << 62)
            while True:
                with call.at_most(stall):
                    block = next(blocks, None)
                if block is None:
                    return
                yield Response(head.status, head.headers, block)

    def _ask(self, request: Request, authority: str, call: Call) -> Response:
        self._began = False
        fields = {"Host": authority, **request.headers}
        if request.body or request.method in ("POST", "PUT"):
            fields["Content-Length"] = str(len(request.body))
        lines = [f"{request.method} {request.target} HTTP/1.1", *(f"{name}: {value}" for name, value in fields.items())]
        head = "\r\n".join([*lines, "", ""]).encode("latin-1")
        going = self._send(head + request.body[:BLOCK], call)
        for at in range(BLOCK, len(request.body), BLOCK):
            going = going and self._send(memoryview(request.body)[at:at + BLOCK], call)
        status = 100
        while status < 200:  # 1xx are no answers yet
            text = self._until(b"\r\n\r\n", MOST_HEAD_BYTES, call)
            status, headers = self._parse(text)
        if "close" in headers.get("connection", "").lower() or text.startswith(b"HTTP/1.0"):
            self.reusable = False
        return Response(status, headers)

    def _send(self, data: Union[bytes, memoryview], call: Call) -> bool:
        """False where the other side does not read on: a server that refuses a large body answers before it has it."""
        try:
            self.socket.settimeout(call.left())
            self.socket.sendall(data)
            return True
        except (socket.timeout, OutOfTime):
            raise Trouble("timeout", "The request could not be sent in time.") from None
        except OSError:
            call.check()
            self.reusable = False
            return False

    def _receive(self, call: Call) -> bool:
        """More into the buffer; False at the end of the stream."""
        try:
            block = self._next_block(call)
        except OutOfTime:
            raise Trouble("timeout", "There was no whole answer in time.", began=self._began) from None
        except (OSError, ValueError) as error:  # ValueError: a TLS socket that has lost its connection
            call.check()
            raise Trouble("connection", f"The connection broke: {error}.", began=self._began) from None
        if block:
            self._began = True
            self._buffer += block
            return True
        call.check()
        return False

    def _next_block(self, call: Call) -> bytes:
        """What has come, waited for in short turns: an interrupt that comes just before the thread begins to wait is kept by
        Python until the wait is over."""
        while True:
            left = call.left()
            self.socket.settimeout(TURN if left is None else min(left, TURN))
            try:
                return self.socket.recv(BLOCK)
            except socket.timeout:
                pass  # the turn is over; left() knows whether the time is

    def _until(self, mark: bytes, most: int, call: Call) -> bytes:
        """What stands before the mark, which is dropped."""
        searched = 0
        while True:
            at = self._buffer.find(mark, searched)
            if at >= 0:
                text = bytes(self._buffer[:at])
                del self._buffer[:at + len(mark)]
                return text
            searched = max(0, len(self._buffer) - len(mark) + 1)
            if len(self._buffer) > most:
                raise self._no_http(f"a line or header of more than {most} bytes")
            if not self._receive(call):
                raise self._cut()

    def _cut(self) -> Trouble:
        return Trouble("connection", "The connection was closed before the answer was whole.", began=self._began)

    def _no_http(self, what: str) -> Trouble:
        return Trouble("damaged", f"What came is no HTTP: {what}.", began=True)

    def _parse(self, text: bytes) -> Tuple[int, Dict[str, str]]:
        lines = text.split(b"\r\n")
        status = _STATUS.fullmatch(lines[0])
        if status is None:
            raise self._no_http(f"it begins with {lines[0][:40]!r}")
        headers: Dict[str, str] = {}
        for line in lines[1:]:
            parts = _FIELD.fullmatch(line)
            if parts is None:
                raise self._no_http(f"{line[:40]!r} in a header")
            name, value = parts.group(1).decode("ascii").lower(), parts.group(2).decode("latin-1")
            headers[name] = f"{headers[name]}, {value}" if name in headers else value
        return int(status.group(1)), headers

    def _blocks(self, head: Response, method: str, call: Call, most: int) -> Iterator[bytes]:
        if method == "HEAD" or head.status in (204, 304):
            return
        if "transfer-encoding" in head.headers:
            if head.headers["transfer-encoding"].lower() != "chunked":
                raise self._no_http("a transfer coding that was not asked for")
            yield from self._chunks(call, most)
            return
        length = head.headers.get("content-length")
        if length is None:
            yield from self._rest(call, most)
            return
        if not re.fullmatch(r"[0-9]{1,18}", length):
            raise self._no_http(f"a Content-Length of {length[:40]!r}")
        if int(length) > most:
            raise self._too_large(most)
        yield from self._exactly(int(length), call)

    def _exactly(self, count: int, call: Call) -> Iterator[bytes]:
        while count > 0:
            if not self._buffer and not self._receive(call):
                raise self._cut()
            block = bytes(self._buffer[:count])
            del self._buffer[:count]
            count -= len(block)
            yield block

    def _chunks(self, call: Call, most: int) -> Iterator[bytes]:
        """RFC 9112, section 7.1."""
        total = 0
        while True:
            size = self._until(b"\r\n", MOST_HEAD_BYTES, call).split(b";")[0].strip()
            if not re.fullmatch(rb"[0-9a-fA-F]{1,15}", size):
                raise self._no_http(f"{size[:40]!r} for the size of a chunk")
            count = int(size, 16)
            if count == 0:
                while self._until(b"\r\n", MOST_HEAD_BYTES, call):
                    pass  # trailers
                return
            total += count
            if total > most:
                raise self._too_large(most)
            yield from self._exactly(count, call)
            if self._until(b"\r\n", 2, call):
                raise self._no_http("a chunk of another size than it says")

    def _rest(self, call: Call, most: int) -> Iterator[bytes]:
        """To the end of the stream: whether that is all only a digest can tell."""
        self.reusable = False
        total = 0
        while self._buffer or self._receive(call):
            block = bytes(self._buffer)
            self._buffer.clear()
            total += len(block)
            if total > most:
                raise self._too_large(most)
            yield block

    def _too_large(self, most: int) -> Trouble:
        return Trouble("answer-too-large", f"The answer is larger than {most} bytes.", began=True, again=False)
