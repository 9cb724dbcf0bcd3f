"""How long a call may take, and how it is taken back."""
from __future__ import annotations

import contextlib
import threading
import time
from typing import Callable, Dict, Iterator, Optional

from .errors import FractureError


class Cancel:
    """Takes back what it was given to: `mesh.fracture(…, cancel=token)`, from any other thread `token.cancel()`.

    The connection is closed at once, which stops the computation unless somebody else waits for the same answer; the call
    raises FractureError of type "cancelled". A token may be given to several calls, and stays cancelled.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._event = threading.Event()
        self._callbacks: Dict[int, Callable[[], None]] = {}
        self._next = 0

    def cancel(self) -> None:
        """From any thread, as often as one likes."""
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
        """Until it is cancelled, or so long; True where it is."""
        return self._event.wait(seconds)

    @contextlib.contextmanager
    def calling(self, callback: Callable[[], None]) -> Iterator[None]:
        """Calls back when it is cancelled, at once where it has been."""
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
    """The time of one exchange is over."""


class Call:
    """One call of the client, with all that is tried again: its deadline, and what it waits for just now."""

    def __init__(self, seconds: Optional[float], what: str) -> None:
        """`seconds`: None for no limit. `what`: for messages, "POST /fracture"."""
        self.what = what
        self.seconds = seconds
        self._end = None if seconds is None else time.monotonic() + max(0.0, seconds)
        self._limit: Optional[float] = None
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._why = "The call was taken back."
        self._wake: Optional[Callable[[], None]] = None

    def cancel(self, why: str = "The call was taken back.") -> None:
        """From any thread. Whatever the call waits for ends now."""
        with self._lock:
            if not self._over.is_set():
                self._why = why
            self._over.set()
            if self._wake is not None:
                self._wake()

    def check(self) -> None:
        """Raises "cancelled"."""
        if self._over.is_set():
            raise FractureError("cancelled", self._why)

    @contextlib.contextmanager
    def waking(self, wake: Callable[[], None]) -> Iterator[None]:
        """While the call waits for something that `wake` ends. Must not wait itself."""
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
        """Within this, left() counts to the end of one exchange where that comes before the end of the call."""
        before = self._limit
        if seconds is not None:
            limit = time.monotonic() + seconds
            self._limit = limit if before is None else min(before, limit)
        try:
            yield
        finally:
            self._limit = before

    def remaining(self) -> Optional[float]:
        """Seconds until the end of the call; None: no limit."""
        return None if self._end is None else self._end - time.monotonic()

    def left(self) -> Optional[float]:
        """Seconds that something may be waited for; None: no limit. Raises OutOfTime, and "cancelled"."""
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
        """Waits. Raises "cancelled"."""
        self._over.wait(seconds)
        self.check()
