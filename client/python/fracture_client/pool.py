"""A server's address, and a pool of connections to it."""
from __future__ import annotations

import contextlib
import socket
import ssl
import threading
import time
import urllib.parse
from dataclasses import dataclass
from typing import Iterator, List, Optional

from .calls import Call, OutOfTime
from .errors import FractureError
from .http1 import Connection, Request, Response, Trouble


@dataclass(frozen=True)
class Address:
    """A server's address: http://host:port, https://host or http://host/below/a/path."""

    host: str
    port: int
    tls: Optional[ssl.SSLContext]
    path: str = ""  # prefix for the path of each request, without a trailing slash

    @property
    def authority(self) -> str:
        """Host and port as they appear in the Host field and in messages."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @classmethod
    def of(cls, url: str, tls: Optional[ssl.SSLContext] = None) -> "Address":
        """Parses a URL. Raises FractureError of type "bad-url"."""
        if "://" not in url:
            raise FractureError("bad-url", f"The address '{url}' must begin with http:// or https://. Did you mean 'http://{url}'?")
        try:
            parts = urllib.parse.urlsplit(url)
            port = parts.port
        except ValueError as error:
            raise FractureError("bad-url", f"The address '{url}' is malformed: {error}. Write it like http://127.0.0.1:8080.") from None
        if parts.scheme not in ("http", "https"):
            raise FractureError("bad-url", f"The address '{url}' begins with '{parts.scheme}'; it must begin with http:// or https://.")
        if not parts.hostname:
            raise FractureError("bad-url", f"The address '{url}' has no host. Write it like http://127.0.0.1:8080.")
        if parts.username is not None:
            raise FractureError("bad-url", "The address contains a user name or password, which is not sent. Use the argument `token`.")
        if parts.query or parts.fragment:
            raise FractureError("bad-url", f"The address '{url}' has a query or fragment after its path. Remove this part, and pass "
                                           "parameters to each call instead.")
        if parts.scheme == "https":
            context = tls or ssl.create_default_context()
            return cls(parts.hostname, port or 443, context, parts.path.rstrip("/"))
        return cls(parts.hostname, port or 80, None, parts.path.rstrip("/"))


@dataclass(frozen=True)
class Settings:
    """The timeouts and limits of a client."""

    connect_timeout: float = 5.0  # s to open a connection
    answer_timeout: float = 120.0  # s for one request and its response, from the first byte sent to the last byte received
    connections: int = 4  # maximum number of open connections; further calls wait until one is free
    idle: float = 10.0  # s; a connection that was unused for longer is replaced (the server closes unused connections after 15 s)
    max_answer_bytes: int = 1 << 30  # a larger answer is an error of type "answer-too-large"
    tries: int = 10  # maximum number of requests per call
    damaged_answers: int = 3  # a call fails after this many damaged answers
    first_pause: float = 0.05  # s before the first retry if the server is unreachable or busy; the pause doubles with each retry
    longest_pause: float = 1.0  # s; maximum length of that pause


class Pool:
    """A client's connections. Thread-safe."""

    def __init__(self, address: Address, settings: Settings) -> None:
        self.address = address
        self._settings = settings
        self._idle: List[Connection] = []  # the most recently used connection is last
        self._busy = 0
        self._closed = False
        self._free = threading.Condition()

    def exchange(self, request: Request, call: Call) -> Response:
        """Sends the request over a free connection and returns the response. If the server has closed a keep-alive connection (RFC
        9112, section 9.3.1), opens a new one, once, and does not count this as a try. Raises Trouble, and FractureError of type
        "cancelled"."""
        self._take_seat(call)
        try:
            with call.at_most(self._settings.answer_timeout):
                connection = self._kept()
                if connection is not None:
                    try:
                        return self._ask(connection, request, call)
                    except Trouble as trouble:
                        call.check()
                        if trouble.type != "connection" or trouble.began:
                            raise
                        self.close_idle()  # the others are just as old
                return self._ask(self._connect(call), request, call)
        finally:
            with self._free:
                self._busy -= 1
                self._free.notify()

    @contextlib.contextmanager
    def stream(self, request: Request, call: Call, stall: float) -> Iterator[Iterator[Response]]:
        """Streams over a connection of its own (Connection.stream()), because a stream can stay open for hours."""
        connection = self._connect(call)
        stream = connection.stream(request, self.address.authority, call, stall)
        try:
            yield stream
        finally:
            stream.close()
            connection.close()

    def close(self) -> None:
        """Closes the free connections. Waiting and later calls raise FractureError of type "cancelled"."""
        with self._free:
            self._closed = True
            self._free.notify_all()
        self.close_idle()

    def close_idle(self) -> None:
        """Closes the free connections."""
        with self._free:
            idle, self._idle = self._idle, []
        for connection in idle:
            connection.close()

    def _ask(self, connection: Connection, request: Request, call: Call) -> Response:
        try:
            response = connection.exchange(request, self.address.authority, call, self._settings.max_answer_bytes)
        except BaseException:
            connection.close()
            raise
        with self._free:
            keep = connection.reusable and not self._closed
            if keep:
                self._idle.append(connection)
        if not keep:
            connection.close()
        return response

    def _take_seat(self, call: Call) -> None:
        with self._free:
            while self._busy >= self._settings.connections and not self._closed:
                try:
                    left = call.left()
                except OutOfTime:
                    raise Trouble("timeout", f"All {self._settings.connections} connections of this client were busy for too long. Raise the "
                                             "timeout or Settings.connections.") from None
                self._free.wait(0.1 if left is None else min(left, 0.1))  # short turns, to notice a cancelled call
            if self._closed:
                raise FractureError("cancelled", "The client was closed.")
            self._busy += 1

    def _kept(self) -> Optional[Connection]:
        oldest = time.monotonic() - self._settings.idle
        with self._free:
            old = [connection for connection in self._idle if connection.used < oldest]
            self._idle = [connection for connection in self._idle if connection.used >= oldest]
            kept = self._idle.pop() if self._idle else None
        for connection in old:
            connection.close()
        return kept

    def _connect(self, call: Call) -> Connection:
        return connect(self.address, call, self._settings.connect_timeout)


def connect(to: Address, call: Call, seconds: float) -> Connection:
    """Opens a connection within this many seconds, and returns it. Raises Trouble, and FractureError of type "cancelled"."""
    try:
        found = socket.getaddrinfo(to.host, to.port, type=socket.SOCK_STREAM)
    except OSError as error:
        again = error.errno == socket.EAI_AGAIN  # a temporary name server failure; all others are final
        raise Trouble("connection", f"The host name {to.host} cannot be resolved: {error.strerror}.", again=again) from None
    except UnicodeError:
        raise Trouble("connection", f"{to.host} is not a valid host name.", again=False) from None
    trouble: Optional[Trouble] = None
    for family, kind, protocol, _, address in found:
        connection = Connection(socket.socket(family, kind, protocol))
        try:
            with call.at_most(seconds), call.waking(connection.wake):
                _connect(connection, to, address, call)
            return connection
        except ssl.SSLCertVerificationError as error:
            trouble = Trouble("connection", f"The certificate of {to.authority} is not trusted: {error.verify_message}. To trust it, "
                                            "pass an ssl.SSLContext as `tls`.", again=False)
        except ssl.SSLError as error:
            trouble = Trouble("connection", f"The TLS handshake with {to.authority} failed: {error.reason}. Is it an http:// address?",
                              again=False)
        except (socket.timeout, OutOfTime):
            trouble = Trouble("timeout", f"{to.authority} did not accept the connection within {seconds:g} s.")
        except OSError as error:
            trouble = Trouble("connection", f"{to.authority} does not answer: {error.strerror or error}.")
        except BaseException:
            connection.close()
            raise
        connection.close()
        call.check()
    assert trouble is not None  # getaddrinfo() returns at least one address, or raises
    raise trouble


def _connect(connection: Connection, to: Address, address: object, call: Call) -> None:
    connection.socket.settimeout(call.left())
    connection.socket.connect(address)  # type: ignore[arg-type]
    connection.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if to.tls is None:
        return
    # The connection holds the TLS socket before the handshake, so that another thread can interrupt it.
    tls = to.tls.wrap_socket(connection.socket, server_hostname=to.host, do_handshake_on_connect=False)
    connection.socket = tls
    tls.settimeout(call.left())
    tls.do_handshake()
