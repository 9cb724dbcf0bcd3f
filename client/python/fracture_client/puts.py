"""Sends a missing mesh only once. If several calls find the same mesh missing, one call sends it; the others wait and then retry."""
from __future__ import annotations

import threading
import time
from typing import Callable, Dict, Set

from .calls import Call, OutOfTime
from .errors import FractureError


class PutOnce:
    """Coordinates a client's PUT requests. Thread-safe."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._pending: Set[str] = set()
        self._stored: Dict[str, float] = {}  # time of a mesh's last successful PUT (time.monotonic())

    def put(self, mesh: str, sent: float, call: Call, send: Callable[[], None]) -> bool:
        """Call this if a request, sent at the time `sent`, found the mesh missing. Returns True if this call sent the mesh, False if
        another call sent it in the meantime. Raises the errors of `send`, and FractureError of type "timeout" or "cancelled"."""
        with self._changed:
            while True:
                if self._stored.get(mesh, sent - 1) >= sent:
                    return False
                if mesh not in self._pending:
                    self._pending.add(mesh)
                    break
                try:
                    left = call.left()
                except OutOfTime:
                    raise FractureError("timeout", f"{call.what}: the server does not have the mesh, and another call of this client "
                                                   "did not finish sending it in time.") from None
                self._changed.wait(0.05 if left is None else min(left, 0.05))  # short turns, to notice a cancelled call
        stored = False
        try:
            send()
            stored = True
        finally:
            with self._changed:
                self._pending.discard(mesh)
                if stored:
                    self._stored[mesh] = time.monotonic()
                self._changed.notify_all()
        return True
