"""Of all who miss a mesh at the same time one sends it; the others wait for that, then ask again."""
from __future__ import annotations

import threading
import time
from typing import Callable, Dict, Set

from .calls import Call, OutOfTime
from .errors import FractureError


class PutOnce:
    """Thread-safe."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._pending: Set[str] = set()
        self._stored: Dict[str, float] = {}  # when the last PUT of a mesh had ended well

    def put(self, mesh: str, sent: float, call: Call, send: Callable[[], None]) -> bool:
        """For who asked at `sent` and was told that the mesh is missing: True where it was sent by this call, False where
        somebody else has sent it since. Raises what `send` does, "timeout" and "cancelled"."""
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
                    raise FractureError("timeout", f"{call.what}: another call did not store the mesh in time.") from None
                self._changed.wait(0.05 if left is None else min(left, 0.05))  # a call that is taken back looks up
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
