"""The groups of an answer. A group is a node that contains the fragments of one node of the source mesh."""
from __future__ import annotations

import copy
from typing import Dict, List, Optional, Set, Tuple

from .buffers import Json
from .fragments import extras_of
from .glb import Glb

MOST_NAME = 63  # bytes; common tools cut longer names
SUFFIX = "_group"  # of the name of a group if another node has that name


def cut(text: str, size: int) -> str:
    """Cuts a text to at most `size` bytes of UTF-8, without splitting a character."""
    return text.encode("utf-8", "replace")[:size].decode("utf-8", "ignore")


class Groups:
    """The groups of some answers to one mesh. Equal groups have the same index in all answers, and parents have lower indices than their
    children."""

    def __init__(self, *answers: Glb) -> None:
        self._node: Dict[int, Json] = {}  # by index of the group
        self._parent: Dict[int, Optional[int]] = {}
        self._above: Dict[int, int] = {}  # by id() of a node in one of the answers: index of the group that contains it
        for answer in answers:
            for node in answer.list("nodes"):
                index = index_of(node)
                if index is None:
                    continue
                self._node.setdefault(index, node)
                for child in node.get("children", []):
                    self._above[id(answer.item("nodes", child))] = index
        for answer in answers:
            for node in answer.list("nodes"):
                index = index_of(node)
                if index is not None:
                    self._parent.setdefault(index, self._above.get(id(node)))

    def above(self, node: Json) -> Optional[int]:
        """Returns the index of the group that contains this node of an answer; None if no group does."""
        return self._above.get(id(node))

    def append_to(self, nodes: List[Json], held: List[Tuple[Optional[int], int]], taken: Set[str]) -> List[int]:
        """Appends the groups to the nodes of a file, as the server writes them. `held`: (group or None, index of a node in the file), in the
        order of the file. Groups that contain nothing are left out. `taken`: names of nodes and meshes. Returns the root's children."""
        below: Dict[Optional[int], List[int]] = {None: []}
        for group, node in held:
            below.setdefault(group, []).append(node)
            while group is not None and self._parent[group] not in below:
                group = self._parent[group]
                below.setdefault(group, [])
        for index in sorted(group for group in below if group is not None):
            below[self._parent[index]].append(len(nodes))
            source = self._node[index]
            nodes.append({**copy.deepcopy(source), "name": _free_name(source, taken), "children": below[index]})
        return below[None]


def index_of(node: Json) -> Optional[int]:
    """Returns the index of a group; None for other nodes. With levels, fragments have a `source`, too."""
    own = extras_of(node)
    source = own.get("source")
    index = source.get("index") if isinstance(source, dict) and "id" not in own else None
    return index if isinstance(index, int) else None


def _free_name(group: Json, taken: Set[str]) -> str:
    """Returns the name that the server gives to a group if the names in `taken` are in use. Adds this name to `taken`."""
    name, stated = str(group["name"]), str(extras_of(group)["source"].get("name", ""))
    if name.endswith(SUFFIX) and (not stated.endswith(SUFFIX) or name.endswith(2 * SUFFIX)):
        name = name[:-len(SUFFIX)]
    wanted, number = name, 1
    while name in taken:
        end = SUFFIX if number == 1 else f"_{number}{SUFFIX}"
        name, number = cut(wanted, MOST_NAME - len(end)) + end, number + 1
    taken.add(name)
    return name
