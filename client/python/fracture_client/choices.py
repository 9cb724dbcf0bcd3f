"""Changes that the server offers, but makes only on request."""
from __future__ import annotations

from typing import Any, Dict, List, Mapping, NamedTuple, Union


class Choice(NamedTuple):
    """A change that the server only offers, because it changes what the mesh is. To get it, fracture with its parameters:

        mesh.fracture({**parameters, **choice.parameters})
    """

    kind: str  # "unit", "room", "lid" or "crack"
    parameters: Dict[str, Union[float, str]]  # values by the name of the parameter
    text: str  # what was found, and what the parameters do


def read_choices(report: Mapping[str, Any]) -> List[Choice]:
    """Returns the choices in a report on a mesh or an answer; [] if there are none."""
    return [Choice(said["kind"], dict(said["parameters"]), said["text"]) for said in report.get("choices", [])]
