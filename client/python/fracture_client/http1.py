"""HTTP/1.1 (RFC 9112) over one socket, parsed strictly and within a call's deadline.

There are three reasons not to use http.client. It accepts malformed headers and bytes after a response. Another thread cannot
stop it. It has no time limit for a whole response, so a server that sends one byte a minute could block it forever.
"""
from __future__ import annotations

import re
import socket
import time
from dataclasses import dataclass, field
from typing import Dict, Generator, Iterator, Tuple, Union

from .calls import Call, OutOfTime

MOST_HEAD_BYTES = 64 << 10  # maximum size of a response's header; the server sends less than 1 KiB
BLOCK = 1 << 18  # bytes per read; large enough that the cost of system calls does not matter
TURN = 0.2  # s; an interrupt is noticed within this time

_STATUS = re.compile(rb"HTTP/1\.[01] ([1-5][0-9][0-9])(?: [^\r\n]*)?")
_FIELD = re.compile(rb"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([^\r\n]*?)[ \t]*")


class Trouble(Exception):
    """An exchange that ended without a valid response. Internal: users of the package get FractureError."""

    def __init__(self, type: str, detail: str, *, began: bool = False, again: bool = True) -> None:
        super().__init__(detail)
        self.type = type  # a key of problems.LOCAL
        self.detail = detail
        self.began = began  # whether part of the response had arrived
        self.again = again  # whether another try may succeed


@dataclass
class Request:
    method: str
    target: str
    headers: Dict[str, str] = field(default_factory=dict)
    body: bytes = b""

    @property
    def what(self) -> str:
        """The request as it appears in messages: without parameters, and with digests shortened to 8 digits."""
        path = re.sub(r"(sha256:[0-9a-f]{8})[0-9a-f]+", r"\1…", self.target.split("?")[0])
        return f"{self.method} {path}"


@dataclass
class Response:
    """An HTTP response. Header names are in lower case, and the values of repeated fields are joined by commas."""

    status: int
    headers: Dict[str, str]
    body: bytes = b""


class Connection:
    """A connection that sends one request at a time. Not thread-safe, except that a Call in another thread may call wake()."""

    def __init__(self, sock: socket.socket) -> None:
        self.socket = sock
        self._buffer = bytearray()
        self._began = False  # whether part of the current response has arrived
        self.used = time.monotonic()
        self.reusable = True

    def close(self) -> None:
        self.socket.close()

    def wake(self) -> None:
        """Ends the current wait as if the server had closed the connection. Called by another thread."""
        try:  # the base class's method, because the TLS socket's method would drop the state that another thread reads
            socket.socket.shutdown(self.socket, socket.SHUT_RDWR)
        except OSError:
            pass  # the connection is closed already

    def exchange(self, request: Request, authority: str, call: Call, most: int) -> Response:
        """Sends the request and returns the response. `most`: maximum size of the response body in bytes. Raises Trouble, and FractureError of
        type "cancelled"."""
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
        """Yields the head, then a Response for each block of the body as it arrives. Raises Trouble if nothing arrives for `stall`
        seconds, and FractureError of type "cancelled". The connection cannot be reused."""
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
        while status < 200:  # a 1xx status precedes the response
            text = self._until(b"\r\n\r\n", MOST_HEAD_BYTES, call)
            status, headers = self._parse(text)
        if "close" in headers.get("connection", "").lower() or text.startswith(b"HTTP/1.0"):
            self.reusable = False
        return Response(status, headers)

    def _send(self, data: Union[bytes, memoryview], call: Call) -> bool:
        """Sends the data. Returns False if the server stopped reading: a server that refuses a large body responds before it
        has received the whole body."""
        try:
            self.socket.settimeout(call.left())
            self.socket.sendall(data)
            return True
        except (socket.timeout, OutOfTime):
            raise Trouble("timeout", "The server did not receive the complete request in time.") from None
        except OSError:
            call.check()
            self.reusable = False
            return False

    def _receive(self, call: Call) -> bool:
        """Reads more bytes into the buffer. Returns False at the end of the stream."""
        try:
            block = self._next_block(call)
        except OutOfTime:
            raise Trouble("timeout", "The response did not arrive completely in time.", began=self._began) from None
        except (OSError, ValueError) as error:  # ValueError: a TLS socket without its connection
            call.check()
            raise Trouble("connection", f"The connection broke: {error}.", began=self._began) from None
        if block:
            self._began = True
            self._buffer += block
            return True
        call.check()
        return False

    def _next_block(self, call: Call) -> bytes:
        """Returns the next bytes. Waits in short turns, because an interrupt that arrives just before a wait may not be handled until the
        wait ends."""
        while True:
            left = call.left()
            self.socket.settimeout(TURN if left is None else min(left, TURN))
            try:
                return self.socket.recv(BLOCK)
            except socket.timeout:
                pass  # the turn is over; left() raises OutOfTime at the deadline

    def _until(self, mark: bytes, most: int, call: Call) -> bytes:
        """Removes the bytes up to the mark and the mark itself. Returns the bytes before the mark."""
        searched = 0
        while True:
            at = self._buffer.find(mark, searched)
            if at >= 0:
                text = bytes(self._buffer[:at])
                del self._buffer[:at + len(mark)]
                return text
            searched = max(0, len(self._buffer) - len(mark) + 1)
            if len(self._buffer) > most:
                raise self._no_http(f"a line or the header has more than {most:,} bytes")
            if not self._receive(call):
                raise self._cut()

    def _cut(self) -> Trouble:
        return Trouble("connection", "The connection was closed before the whole response had arrived.", began=self._began)

    def _no_http(self, what: str) -> Trouble:
        return Trouble("damaged", f"The response is not valid HTTP: {what}.", began=True)

    def _parse(self, text: bytes) -> Tuple[int, Dict[str, str]]:
        lines = text.split(b"\r\n")
        status = _STATUS.fullmatch(lines[0])
        if status is None:
            raise self._no_http(f"it begins with {lines[0][:40]!r}")
        headers: Dict[str, str] = {}
        for line in lines[1:]:
            parts = _FIELD.fullmatch(line)
            if parts is None:
                raise self._no_http(f"its header contains the malformed line {line[:40]!r}")
            name, value = parts.group(1).decode("ascii").lower(), parts.group(2).decode("latin-1")
            headers[name] = f"{headers[name]}, {value}" if name in headers else value
        return int(status.group(1)), headers

    def _blocks(self, head: Response, method: str, call: Call, most: int) -> Iterator[bytes]:
        if method == "HEAD" or head.status in (204, 304):
            return
        if "transfer-encoding" in head.headers:
            if head.headers["transfer-encoding"].lower() != "chunked":
                raise self._no_http(f"its transfer coding is {head.headers['transfer-encoding'][:40]!r}, not 'chunked'")
            yield from self._chunks(call, most)
            return
        length = head.headers.get("content-length")
        if length is None:
            yield from self._rest(call, most)
            return
        if not re.fullmatch(r"[0-9]{1,18}", length):
            raise self._no_http(f"its Content-Length is {length[:40]!r}, not 1 to 18 digits")
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
        """Yields the chunks of a body in chunked coding (RFC 9112, section 7.1)."""
        total = 0
        while True:
            size = self._until(b"\r\n", MOST_HEAD_BYTES, call).split(b";")[0].strip()
            if not re.fullmatch(rb"[0-9a-fA-F]{1,15}", size):
                raise self._no_http(f"the size of a chunk is {size[:40]!r}, not 1 to 15 hexadecimal digits")
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
                raise self._no_http(f"a chunk does not have the announced {count:,} bytes")

    def _rest(self, call: Call, most: int) -> Iterator[bytes]:
        """Yields all bytes up to the end of the stream. Only a digest can show whether the response is complete."""
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
        return Trouble("answer-too-large", f"The answer exceeds this client's limit of {most:,} bytes. Request fewer "
                                           "fragments, or raise Settings.max_answer_bytes.", began=True, again=False)
