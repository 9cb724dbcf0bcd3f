"""Entries of the parameter `assign`, which sets the materials of individual parts of a mesh."""
from __future__ import annotations

from typing import Any, Dict, Optional, Sequence, Union


def assignment(material: Optional[str] = None, *, node: Union[str, Sequence[str], None] = None,
               slot: Union[str, Sequence[str], None] = None, part: Union[int, Sequence[int], None] = None,
               **parameters: Any) -> Dict[str, Any]:
    """Returns an entry of `assign`. Raises ValueError if no selector is given, or neither a material nor a parameter.

        mesh.fracture(material="brick", fragments=200,
                      assign=[assignment("glass", node="Window*"), assignment("wood", slot=["Oak", "Pine*"], stretch=6)])

    `node`: names or indices of nodes, or patterns such as Wall_*; a node includes all nodes below it. `slot`: names or indices of the
    mesh's materials, or patterns; the material that covers most of a part's surface counts. `part`: numbers of parts, as in Fragment.part. If
    several are given, all must match. `parameters`: those that a material sets; GET /limits marks them as `assignable`. The first
    entry that matches a part applies. Parts without an entry use the parameters of the request.
    """
    entry: Dict[str, Any] = {}
    for name, value in (("node", node), ("slot", slot), ("part", part)):
        if value is not None:
            entry[name] = value if isinstance(value, (str, int)) else list(value)
    if not entry:
        raise ValueError("An entry of assign needs a selector: give node, slot or part.")
    if material is None and not parameters:
        raise ValueError("An entry of assign needs a material or another parameter.")
    if material is not None:
        entry["material"] = material
    entry.update(parameters)
    return entry
