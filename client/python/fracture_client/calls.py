"""A call's deadline, and its cancellation by another thread."""
from __future__ import annotations

import contextlib
import threading
import time
from typing import Callable, Dict, Iterator, Optional

from .errors import FractureError


class Cancel:
    """Cancels calls from another thread: `mesh.fracture(…, cancel=token)`, then `token.cancel()`.

    The connection closes at once, so the server stops computing unless another client is waiting for the same answer. The call
    raises FractureError of type "cancelled". Several calls can share a token. A cancelled token stays cancelled.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._event = threading.Event()
        self._callbacks: Dict[int, Callable[[], None]] = {}
        self._next = 0

    def cancel(self) -> None:
        """Cancels the calls that use this token. Any thread may call this, even more than once."""
        with self._lock:
            self._event.set()
            callbacks = list(self._callbacks.values())
        for callback in callbacks:
            callback()

    @property
    def cancelled(self) -> bool:
        """Whether cancel() was called."""
        return self._event.is_set()

    def wait(self, seconds: float) -> bool:
        """Waits until cancel() is called, but for at most this many seconds. Returns whether cancel() was called."""
        return self._event.wait(seconds)

    @contextlib.contextmanager
    def calling(self, callback: Callable[[], None]) -> Iterator[None]:
        """While this context is active, cancel() calls `callback`. If the token is already cancelled, the callback is called at once."""
        with self._lock:
            key, self._next = self._next, self._next + 1
            self._callbacks[key] = callback
            already = self._event.is_set()
        if already:
            callback()
        try:
            yield
        finally:
            with self._lock:
                del self._callbacks[key]


class OutOfTime(Exception):
    """Raised if an exchange takes too long."""


class Call:
    """A call of the client with all its retries. It knows its deadline and how to interrupt the current wait."""

    def __init__(self, seconds: Optional[float], what: str) -> None:
        """Starts the clock. `seconds`: time limit; None: no limit. `what`: the request as it appears in messages, such as "POST
        /fracture"."""
        self.what = what
        self.seconds = seconds
        self._end = None if seconds is None else time.monotonic() + max(0.0, seconds)
        self._limit: Optional[float] = None
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._why = "The call was cancelled."
        self._wake: Optional[Callable[[], None]] = None

    def cancel(self, why: str = "The call was cancelled.") -> None:
        """Ends the call and interrupts its current wait. Any thread may call this."""
        with self._lock:
            if not self._over.is_set():
                self._why = why
            self._over.set()
            if self._wake is not None:
                self._wake()

    def check(self) -> None:
        """Raises FractureError of type "cancelled" if the call was cancelled."""
        if self._over.is_set():
            raise FractureError("cancelled", self._why)

    @contextlib.contextmanager
    def waking(self, wake: Callable[[], None]) -> Iterator[None]:
        """While this context is active, cancel() calls `wake` to interrupt the current wait. `wake` must not block."""
        with self._lock:
            before, self._wake = self._wake, wake
        try:
            self.check()
            yield
        finally:
            with self._lock:
                self._wake = before

    @contextlib.contextmanager
    def at_most(self, seconds: Optional[float]) -> Iterator[None]:
        """While this context is active, left() also respects a deadline for one exchange: `seconds` from now; None: no deadline."""
        before = self._limit
        if seconds is not None:
            limit = time.monotonic() + seconds
            self._limit = limit if before is None else min(before, limit)
        try:
            yield
        finally:
            self._limit = before

    def remaining(self) -> Optional[float]:
        """Returns the seconds until the end of the call; None: no limit."""
        return None if self._end is None else self._end - time.monotonic()

    def left(self) -> Optional[float]:
        """Returns the seconds until the nearest deadline; None: no limit. Raises OutOfTime, and FractureError of type
        "cancelled"."""
        self.check()
        now = time.monotonic()
        ends = [end for end in (self._end, self._limit) if end is not None]
        if not ends:
            return None
        left = min(ends) - now
        if left <= 0:
            raise OutOfTime
        return left

    def pause(self, seconds: float) -> None:
        """Waits for `seconds`. Raises FractureError of type "cancelled"."""
        self._over.wait(seconds)
        self.check()
