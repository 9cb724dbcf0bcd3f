"""A server's admin port, with health probes and metrics. It is a separate port and requires no token."""
from __future__ import annotations

from typing import Optional

from . import asking
from .caller import Caller
from .calls import Cancel
from .errors import FractureError
from .http1 import Request
from .pool import Settings


class Admin(Caller):
    """A client for the admin port. `with Admin("http://127.0.0.1:8081") as admin: admin.is_ready()`"""

    def __init__(self, url: str, timeout: Optional[float] = 10.0, *, settings: Settings = Settings()) -> None:
        """`timeout`: seconds for each call; None: no limit. Raises FractureError of type "bad-url"."""
        super().__init__(url, None, timeout, False, None, settings)

    def __enter__(self) -> "Admin":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def is_alive(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> bool:
        """Returns whether the server process answers GET /livez in time. Raises FractureError."""
        return self._probe("/livez", timeout, cancel)

    def is_ready(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> bool:
        """Returns whether the server accepts requests (GET /readyz). It is False if the server is shutting down or does not answer.
        Raises FractureError."""
        return self._probe("/readyz", timeout, cancel)

    def metrics(self, *, timeout: Optional[float] = None, cancel: Optional[Cancel] = None) -> str:
        """Returns the server's metrics in Prometheus text format. Raises FractureError."""
        response = self._ask("GET", "/metrics", b"", {}, asking.check_nothing, timeout, cancel)
        return response.body.decode("utf-8", "replace")

    def _probe(self, path: str, timeout: Optional[float], cancel: Optional[Cancel]) -> bool:
        """Sends a single request without retries, because a probe reports the current state. Returns whether it succeeded."""
        try:
            with self._call(timeout, cancel, f"GET {path}") as call:
                once = Settings(**{**vars(self.settings), "tries": 1})
                asking.ask(self._pool, once, self._complete(Request("GET", path)), call, asking.check_nothing)
        except FractureError as error:
            if error.type in ("connection", "timeout") or error.status == 503:
                return False
            raise
        return True
