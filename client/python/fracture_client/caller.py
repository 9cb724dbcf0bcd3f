"""What all requests of a client share: its connections, its deadlines, its end."""
from __future__ import annotations

import contextlib
import re
import ssl
import threading
import urllib.parse
from typing import Any, Callable, Dict, Iterator, Mapping, Optional, Set

from . import asking
from .calls import Call, Cancel
from .errors import FractureError
from .http1 import Request, Response
from .mesh import Mesh
from .pool import Address, Pool, Settings
from .puts import PutOnce
from .version import VERSION

STALL = 30.0  # s without a byte after which a stream of events is taken for dead: the server says something every 10 s


class Caller:
    """Of Client, which says what is asked."""

    def __init__(self, url: str, token: Optional[str], timeout: Optional[float], realtime: bool,
                 tls: Optional[ssl.SSLContext], settings: Settings) -> None:
        self.url = url
        self.timeout = timeout
        self.realtime = realtime
        self.settings = settings
        if token is not None and not re.fullmatch(r"[\x21-\x7e]+", token):
            raise FractureError("bad-parameter", "The token has characters that cannot be sent: is there a line break in it?",
                                parameter="token")
        self._headers = {"User-Agent": f"fracture-client-python/{VERSION}"}
        if token is not None:
            self._headers["Authorization"] = f"Bearer {token}"
        self._pool = Pool(Address.of(url, tls), settings)
        self._puts = PutOnce()
        self._lock = threading.Lock()
        self._calls: Set[Call] = set()
        self._closed = False

    def close(self) -> None:
        """Takes back what is open, in whatever thread, and closes the connections. A closed client raises "cancelled"."""
        with self._lock:
            self._closed = True
            calls = list(self._calls)
        self._pool.close()  # first: a seat that the first call leaves is not for one that is about to be taken back
        for call in calls:
            call.cancel("The client was closed.")

    @contextlib.contextmanager
    def _call(self, timeout: Optional[float], cancel: Optional[Cancel], what: str, forever: bool = False) -> Iterator[Call]:
        """`forever`: where there is no timeout, there is none of the client either."""
        call = Call(self.timeout if timeout is None and not forever else timeout, what)
        with self._lock:
            if self._closed:
                raise FractureError("cancelled", "The client is closed.")
            self._calls.add(call)
        try:
            with contextlib.ExitStack() as stack:
                if cancel is not None:
                    stack.enter_context(cancel.calling(call.cancel))
                call.check()
                yield call
        finally:
            with self._lock:
                self._calls.discard(call)

    def _ask(self, method: str, path: str, body: bytes, headers: Mapping[str, str], check: asking.Check,
             timeout: Optional[float], cancel: Optional[Cancel], mesh: Optional[Mesh] = None) -> Response:
        """`mesh`: what the path is about, which is sent where the server has forgotten it."""
        request = Request(method, path, dict(headers), body)
        with self._call(timeout, cancel, request.what) as call:
            return self._send(call, request, check, None if mesh is None else self._putting(mesh, call))

    def _send(self, call: Call, request: Request, check: asking.Check,
              put: Optional[Callable[[float], bool]] = None) -> Response:
        return asking.ask(self._pool, self.settings, self._complete(request), call, check, put)

    def _complete(self, request: Request) -> Request:
        target = self._pool.address.path + request.target
        if re.search(r"[^\x21-\x7e]", target):
            raise FractureError("bad-parameter", f"{target!r} cannot be a path: quote what is not ASCII (urllib.parse.quote).")
        return Request(request.method, target, {**self._headers, **request.headers}, request.body)

    def _putting(self, mesh: Mesh, call: Call) -> Callable[[float], bool]:
        done = False  # a 404 after a PUT is the server's own no

        def put(sent: float) -> bool:
            nonlocal done
            if done or mesh.upload is None:
                return False
            done = self._puts.put(mesh.id, sent, call, lambda: self._put(mesh, call))
            return True
        return put

    def _put(self, mesh: Mesh, call: Call) -> None:
        assert mesh.upload is not None
        kind, body = mesh.upload.body()
        target = f"/meshes/{mesh.id}" + query_of({**mesh.upload.query, **mesh.preparation})
        response = self._send(call, Request("PUT", target, {"Content-Type": kind}, body), asking.check_json)
        mesh.stored = asking.json_object(response.body) or {}

    def _json(self, method: str, path: str, timeout: Optional[float], cancel: Optional[Cancel],
              headers: Optional[Mapping[str, str]] = None) -> Dict[str, Any]:
        response = self._ask(method, path, b"", {"Accept": "application/json", **(headers or {})}, asking.check_json, timeout,
                             cancel)
        return asking.json_object(response.body) or {}

    def _delete(self, path: str, timeout: Optional[float], cancel: Optional[Cancel]) -> bool:
        """False where nothing was there (any more)."""
        try:
            self._ask("DELETE", path, b"", {}, asking.check_nothing, timeout, cancel)
        except FractureError as error:
            if error.type != "not-found":
                raise
            return False
        return True

    def _urgency(self, realtime: Optional[bool]) -> Dict[str, str]:
        """RFC 9218: what is asked of a stored mesh is realtime work unless it says otherwise."""
        return {"Priority": "u=1" if (self.realtime if realtime is None else realtime) else "u=3"}


def query_of(parameters: Mapping[str, Any]) -> str:
    """"?name=value&…", as a query of the interface has it: vectors as x,y,z and lists of them as x,y,z;x,y,z."""
    pairs = [(name, query_value(value)) for name, value in parameters.items() if value is not None]
    return "?" + urllib.parse.urlencode(pairs, quote_via=urllib.parse.quote, safe=",;:") if pairs else ""


def query_value(value: Any) -> str:
    if hasattr(value, "tolist"):  # numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        rows = any(isinstance(entry, (list, tuple)) for entry in value)
        return (";" if rows else ",").join(query_value(entry) for entry in value)
    return str(value)
