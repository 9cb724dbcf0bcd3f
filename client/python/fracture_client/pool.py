"""Where the server is, and a few connections to it that are kept."""
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
    """Of a server: http://host:port, https://host, http://host/below/a/path."""

    host: str
    port: int
    tls: Optional[ssl.SSLContext]
    path: str = ""  # before that of each request; no slash at its end

    @property
    def authority(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @classmethod
    def of(cls, url: str, tls: Optional[ssl.SSLContext] = None) -> "Address":
        """Raises FractureError of type "bad-url"."""
        if "://" not in url:
            raise FractureError("bad-url", f"'{url}' does not say how to get there: did you mean 'http://{url}'?")
        try:
            parts = urllib.parse.urlsplit(url)
            port = parts.port
        except ValueError as error:
            raise FractureError("bad-url", f"'{url}' is no address of a server: {error}.") from None
        if parts.scheme not in ("http", "https"):
            raise FractureError("bad-url", f"'{url}' begins with '{parts.scheme}'; a server is at http://… or https://….")
        if not parts.hostname:
            raise FractureError("bad-url", f"'{url}' names no host.")
        if parts.username is not None:
            raise FractureError("bad-url", "A name and password in the address are not sent; give the token as `token`.")
        if parts.query or parts.fragment:
            raise FractureError("bad-url", f"'{url}' goes on behind the path; parameters are given to each call.")
        if parts.scheme == "https":
            context = tls or ssl.create_default_context()
            return cls(parts.hostname, port or 443, context, parts.path.rstrip("/"))
        return cls(parts.hostname, port or 80, None, parts.path.rstrip("/"))


@dataclass(frozen=True)
class Settings:
    """How long the server is waited for, and how often it is asked. The values are those of the game's client where a
    script waits as a game does."""

    connect_timeout: float = 5.0  # s
    answer_timeout: float = 120.0  # s, of one exchange: first byte sent to last byte received
    connections: int = 4  # kept, and at most; further calls wait for one of them
    idle: float = 10.0  # s; a connection unused for longer is replaced (the server's own limit is 15 s)
    max_answer_bytes: int = 1 << 30
    tries: int = 10  # requests that one call may send
    damaged_answers: int = 3  # so many damaged answers to one call, and it has failed
    first_pause: float = 0.05  # s before asking again where nobody listens; doubles …
    longest_pause: float = 1.0  # … up to this


class Pool:
    """Thread-safe."""

    def __init__(self, address: Address, settings: Settings) -> None:
        self.address = address
        self._settings = settings
        self._idle: List[Connection] = []  # the last used one at the end
        self._busy = 0
        self._closed = False
        self._free = threading.Condition()

    def exchange(self, request: Request, call: Call) -> Response:
        """Raises Trouble, and "cancelled". A kept connection that the server had closed in the meantime is replaced once,
        unseen: RFC 9112, section 9.3.1 lets it, and that says nothing of the request."""
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
                        self.close_idle()  # the others are as old
                return self._ask(self._connect(call), request, call)
        finally:
            with self._free:
                self._busy -= 1
                self._free.notify()

    @contextlib.contextmanager
    def stream(self, request: Request, call: Call, stall: float) -> Iterator[Iterator[Response]]:
        """As Connection.stream(), over a connection of its own: a stream may be open for hours."""
        connection = self._connect(call)
        stream = connection.stream(request, self.address.authority, call, stall)
        try:
            yield stream
        finally:
            stream.close()
            connection.close()

    def close(self) -> None:
        """Nobody gets a connection any more."""
        with self._free:
            self._closed = True
            self._free.notify_all()
        self.close_idle()

    def close_idle(self) -> None:
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
                    raise Trouble("timeout", "No connection of this client became free in time.") from None
                self._free.wait(0.1 if left is None else min(left, 0.1))  # a call that is taken back looks up
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
    """Raises Trouble, and "cancelled"."""
    try:
        found = socket.getaddrinfo(to.host, to.port, type=socket.SOCK_STREAM)
    except OSError as error:
        again = error.errno == socket.EAI_AGAIN  # the name server had no time; any other answer is one
        raise Trouble("connection", f"The name {to.host} cannot be resolved: {error.strerror}.", again=again) from None
    except UnicodeError:
        raise Trouble("connection", f"The name {to.host} is no name of a host.", again=False) from None
    trouble: Optional[Trouble] = None
    for family, kind, protocol, _, address in found:
        connection = Connection(socket.socket(family, kind, protocol))
        try:
            with call.at_most(seconds), call.waking(connection.wake):
                _connect(connection, to, address, call)
            return connection
        except ssl.SSLCertVerificationError as error:
            trouble = Trouble("connection", f"The certificate of {to.authority} is not accepted: {error.verify_message}.",
                              again=False)
        except ssl.SSLError as error:
            trouble = Trouble("connection", f"{to.authority} does not speak TLS as it should: {error.reason}.", again=False)
        except (socket.timeout, OutOfTime):
            trouble = Trouble("timeout", f"{to.authority} did not take the connection in {seconds:g} s.")
        except OSError as error:
            trouble = Trouble("connection", f"{to.authority} does not answer: {error.strerror or error}.")
        except BaseException:
            connection.close()
            raise
        connection.close()
        call.check()
    assert trouble is not None  # getaddrinfo() finds at least one address, or raises
    raise trouble


def _connect(connection: Connection, to: Address, address: object, call: Call) -> None:
    connection.socket.settimeout(call.left())
    connection.socket.connect(address)  # type: ignore[arg-type]
    connection.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if to.tls is None:
        return
    # The new object first, the handshake then: who takes the call back has to find it.
    tls = to.tls.wrap_socket(connection.socket, server_hostname=to.host, do_handshake_on_connect=False)
    connection.socket = tls
    tls.settimeout(call.left())
    tls.do_handshake()
