"""The base class of Client and Admin: connections, deadlines, retries and close()."""
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

STALL = 30.0  # s without a byte, after which an event stream is considered broken; the server sends a comment every 10 s


class Caller:
    """Sends the requests of Client and Admin."""

    def __init__(self, url: str, token: Optional[str], timeout: Optional[float], realtime: bool,
                 tls: Optional[ssl.SSLContext], settings: Settings) -> None:
        self.url = url
        self.timeout = timeout
        self.realtime = realtime
        self.settings = settings
        if token is not None and not re.fullmatch(r"[\x21-\x7e]+", token):
            raise FractureError("bad-parameter", "The token contains characters that HTTP cannot send. Only printable ASCII without "
                                                 "spaces is allowed; check for a line break at its end.", parameter="token")
        self._headers = {"User-Agent": f"fracture-client-python/{VERSION}"}
        if token is not None:
            self._headers["Authorization"] = f"Bearer {token}"
        self._pool = Pool(Address.of(url, tls), settings)
        self._puts = PutOnce()
        self._lock = threading.Lock()
        self._calls: Set[Call] = set()
        self._closed = False

    def close(self) -> None:
        """Cancels the calls of all threads and closes the connections. Later calls raise FractureError of type "cancelled"."""
        with self._lock:
            self._closed = True
            calls = list(self._calls)
        self._pool.close()  # closed before the calls are cancelled, so that no waiting call takes the connection of a cancelled one
        for call in calls:
            call.cancel("The client was closed.")

    @contextlib.contextmanager
    def _call(self, timeout: Optional[float], cancel: Optional[Cancel], what: str, forever: bool = False) -> Iterator[Call]:
        """Opens a call and closes it at the end. `forever`: the client's timeout does not apply, so only `timeout` limits the call."""
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
        """Sends a request and returns the response. `mesh`: the mesh in the path, which is sent again if the server has forgotten it."""
        request = Request(method, path, dict(headers), body)
        with self._call(timeout, cancel, request.what) as call:
            return self._send(call, request, check, None if mesh is None else self._putting(mesh, call))

    def _send(self, call: Call, request: Request, check: asking.Check,
              put: Optional[Callable[[float], bool]] = None) -> Response:
        return asking.ask(self._pool, self.settings, self._complete(request), call, check, put)

    def _complete(self, request: Request) -> Request:
        target = self._pool.address.path + request.target
        if re.search(r"[^\x21-\x7e]", target):
            raise FractureError("bad-parameter", f"The path {target!r} contains spaces or non-ASCII characters. Quote them with "
                                                 "urllib.parse.quote().")
        return Request(request.method, target, {**self._headers, **request.headers}, request.body)

    def _putting(self, mesh: Mesh, call: Call) -> Callable[[float], bool]:
        done = False  # one PUT per call: another 404 after it is an error

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
        """Deletes the resource at a path. Returns False if it does not exist."""
        try:
            self._ask("DELETE", path, b"", {}, asking.check_nothing, timeout, cancel)
        except FractureError as error:
            if error.type != "not-found":
                raise
            return False
        return True

    def _urgency(self, realtime: Optional[bool]) -> Dict[str, str]:
        """Returns the Priority field (RFC 9218). It is always sent, because the server by default treats fractures of stored meshes
        as realtime work."""
        return {"Priority": "u=1" if (self.realtime if realtime is None else realtime) else "u=3"}


def query_of(parameters: Mapping[str, Any]) -> str:
    """Returns the query "?name=value&…". Vectors are written as x,y,z and lists of vectors as x,y,z;x,y,z. Values that are None are
    omitted."""
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
