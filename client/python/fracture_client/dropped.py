"""Things in a source that an answer does not contain."""
from __future__ import annotations

from typing import Any, List, Mapping, NamedTuple


class Dropped(NamedTuple):
    """Something in the source that the answer does not contain. As text: "light Lamp: fragments have no lights"."""

    what: str  # kind: "light", "camera", "animation", "extension", …
    name: str  # name in the source, or the place there; empty if it has none
    reason: str

    def __str__(self) -> str:
        return f"{self.what}{self.name and ' '}{self.name}: {self.reason}"


def read_dropped(report: Mapping[str, Any]) -> List[Dropped]:
    """Returns the list in a report on a mesh or an answer; [] if there is none."""
    return [Dropped(said["what"], said["name"], said["reason"]) for said in report.get("dropped", [])]
