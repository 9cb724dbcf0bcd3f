"""Merges an answer with the changes from a hit (`delta=only`) into a single answer with all fragments.

The result is the server's answer to `delta=stated`. Fragments are ordered by their first site, then by their part of the mesh, then
by their id.
"""
from __future__ import annotations

import copy
import re
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Set, Tuple

from .buffers import Buffers, Json
from .filters import Filter, collision_filters
from .fragments import extras_of, figures_of, fragment_nodes, sheet_meshes
from .glb import Glb, damaged, pack
from .groups import MOST_NAME, Groups, cut, index_of

KHR, OMI, OMI_SHAPE = "KHR_physics_rigid_bodies", "OMI_physics_body", "OMI_physics_shape"


@dataclass
class _Piece:
    glb: Glb
    node: Json
    own: Json  # its extras.fracture
    name: str = ""  # its name in the merged file
    digits: int = 2  # of the numbers of hulls in names there

    @property
    def id(self) -> int:
        return int(self.own["id"])

    @property
    def shape(self) -> Optional[int]:
        """The number of the shape that this fragment shares with other instances of a mesh; None if it has its own mesh."""
        return self.own.get("shape")


def merge(whole: Glb, delta: Glb) -> bytes:
    """Returns the GLB with all fragments. Raises FractureError of type "damaged" if `delta` does not belong to `whole`."""
    figures = figures_of(delta)
    pieces = _pieces(whole, delta, figures)
    _rename(pieces)
    # Materials, textures and uncut nodes come from `whole`, because a delta may omit textures.
    document: Json = {key: copy.deepcopy(value) for key, value in whole.document.items()
                      if key not in ("nodes", "meshes", "accessors", "bufferViews", "buffers", "images", "extensions")}
    if [m.get("name") for m in whole.list("materials")] != [m.get("name") for m in delta.list("materials")]:
        raise damaged("its materials differ from those of the answer that was hit")
    document["asset"] = _stated(delta.document["asset"], "extras")
    document["scenes"] = document["scenes"][:1]  # without the unbroken mesh: its nodes and meshes are not copied
    pairs = _filtered(whole, figures, pieces)
    figures = {**_stated(figures, None), "bonds": _bonds(whole, figures, pieces)}
    figures.pop("filtered", None)
    held = _whole_bonds(whole, figures, pieces)
    figures.pop("whole_bonds", None)
    if held is not None:
        figures["whole_bonds"] = held
    if pairs:
        figures["filtered"] = {"a": [pieces[a].id for a, _ in pairs], "b": [pieces[b].id for _, b in pairs]}
    buffers = Buffers()
    _write_scene(document, whole, pieces, figures, collision_filters(len(pieces), pairs), buffers)
    if "images" in whole.document:
        document["images"] = [buffers.add_image(whole, image) for image in whole.list("images")]
    binary = buffers.finish(document)
    return pack(document, binary)


def _stated(holder: Json, below: Any) -> Json:
    """Returns a copy whose parameters say delta=stated, as in an answer with all fragments."""
    holder = copy.deepcopy(holder)
    inner = holder if below is None else holder.get(below, {})
    if inner.get("parameters", {}).get("delta") == "only":
        inner["parameters"]["delta"] = "stated"
    return holder


def _pieces(whole: Glb, delta: Glb, figures: Json) -> List[_Piece]:
    said = figures.get("delta")
    if not isinstance(said, dict):
        raise damaged("it does not list the changes made by the hit")
    new, changed, gone = ({int(id) for id in said.get(key, ())} for key in ("new", "changed", "gone"))
    before = [_Piece(whole, node, own) for _, node, own in fragment_nodes(whole)]
    after = [_Piece(delta, node, own) for _, node, own in fragment_nodes(delta)]
    known = {piece.id for piece in before}
    if not changed | gone <= known or new & known or {piece.id for piece in after} != new | changed:
        raise damaged("its changes do not fit the answer that was hit")
    stay = [piece for piece in before if piece.id not in changed | gone]
    if len(stay) + len(after) != figures["certificate"]["fragments"]:
        raise damaged(f"its certificate states {figures['certificate']['fragments']} fragments, but the merged answer has "
                      f"{len(stay) + len(after)}")
    return _in_order(stay, after)


def _in_order(stay: List[_Piece], after: List[_Piece]) -> List[_Piece]:
    """Returns all fragments in the server's order: by first site, then by part, then by id."""
    return sorted(stay + after, key=lambda piece: (int((piece.own["sites"] or [-1])[0]), int(piece.own.get("part", 0)), piece.id))


def _rename(pieces: List[_Piece]) -> None:
    """Names each fragment "<node of the mesh>_007". The number makes the name unique; all numbers have the same number of digits."""
    width = len(str(len(pieces) - 1))
    sheets = [sheet_meshes(piece.glb, piece.node) for piece in pieces]
    most = max((len(_hull_meshes(piece)) for piece in pieces), default=0)
    digits = max(2, len(str(most - 1)))  # of the numbers of hulls
    # The names of hulls, colliders and sheets need the rest.
    room = MOST_NAME - (digits + len("__collider") if most > 0 else len("_sheet") if any(sheets) else 0)
    for number, piece in enumerate(pieces):
        base = str(piece.node["name"]).rpartition("_")[0]
        piece.name = f"{cut(base, room - 1 - width)}_{number:0{width}}"
        piece.digits = digits


def _unique(name: str, taken: Set[str]) -> str:
    """Returns the name, or the name with _2, _3, ... if it is taken. A fragment may have the name, because its number got more digits."""
    unique, number = name, 1
    while unique in taken:
        number += 1
        unique = f"{cut(name, MOST_NAME - 1 - len(str(number)))}_{number}"
    taken.add(unique)
    return unique


def _bonds(whole: Glb, figures: Json, pieces: List[_Piece]) -> Json:
    """Returns the bonds between unchanged fragments, and the bonds in the delta. They are sorted, and each goes from the earlier fragment
    to the later one."""
    place = {piece.id: k for k, piece in enumerate(pieces)}
    stay = {piece.id for piece in pieces if piece.glb is whole}
    columns = list(figures["bonds"])
    rows = [row for row in _rows(figures_of(whole)["bonds"], columns) if row["a"] in stay and row["b"] in stay]
    rows += _rows(figures["bonds"], columns)
    for row in rows:
        if row["a"] not in place or row["b"] not in place:
            raise damaged(f"the bond between fragments {row['a']} and {row['b']} refers to a fragment that does not exist")
        if place[row["a"]] > place[row["b"]]:
            row["a"], row["b"] = row["b"], row["a"]
            row["normal"] = [-x if x else 0 for x in row["normal"]]
    rows.sort(key=lambda row: (place[row["a"]], place[row["b"]]))
    return {column: [row[column] for row in rows] for column in columns}


def _whole_bonds(whole: Glb, figures: Json, pieces: List[_Piece]) -> Optional[Json]:
    """Returns the bonds with uncut nodes: those of unchanged fragments, and those in the delta. None if there are none."""
    place = {piece.id: k for k, piece in enumerate(pieces)}
    stay = {piece.id for piece in pieces if piece.glb is whole}
    before, after = figures_of(whole).get("whole_bonds"), figures.get("whole_bonds")
    columns = list(after or before or {})
    rows = [row for row in _rows(before, columns) if row["a"] in stay] if before else []
    rows += _rows(after, columns) if after else []
    if any(row["a"] not in place for row in rows):
        raise damaged("a bond with an uncut node refers to a fragment that does not exist")
    rows.sort(key=lambda row: (place[row["a"]], row["node"]))
    return {column: [row[column] for row in rows] for column in columns} if rows else None


def _rows(bonds: Json, columns: List[str]) -> List[Json]:
    return [dict(zip(columns, values)) for values in zip(*(bonds[column] for column in columns))]


def _write_scene(document: Json, whole: Glb, pieces: List[_Piece], figures: Json, filters: List[Optional[Filter]],
                 buffers: Buffers) -> None:
    """Writes nodes and meshes in the server's order: the root, the fragments, their child nodes, the uncut nodes, the groups."""
    meshes: List[Json] = []
    # Instances of a mesh share its shape and hulls, which follow those of the other fragments. The first instance names them.
    alone = [piece for piece in pieces if piece.shape is None]
    first = {piece.shape: piece for piece in reversed(pieces) if piece.shape is not None}
    shapes = [piece for piece in pieces if first.get(piece.shape) is piece]
    mesh_of: Dict[int, int] = {}  # by the id of a fragment: index of its mesh
    for piece in (*alone, *shapes):
        mesh_of[piece.id] = len(meshes)
        meshes.append({**buffers.add_mesh(piece.glb, piece.node["mesh"]), "name": piece.name})
    first_hull = len(meshes)
    hulls_of: Dict[int, List[int]] = {}  # by the id of a fragment: indices of its hulls
    for piece in (*alone, *shapes):
        holder_name = str(piece.glb.item("meshes", piece.node["mesh"]).get("name", ""))  # another instance may have named the hulls
        for mesh in _hull_meshes(piece):
            hulls_of.setdefault(piece.id, []).append(len(meshes))
            copied = buffers.add_mesh(piece.glb, mesh)
            meshes.append({**copied, "name": _renamed(copied.get("name", ""), piece, holder_name)})
    hull_number: List[Dict[int, int]] = []  # for each piece: mesh index in its file -> index in the merged file
    for piece in pieces:
        holder = piece if piece.shape is None else first[piece.shape]
        mesh_of[piece.id] = mesh_of[holder.id]
        hull_number.append(dict(zip(_hull_meshes(piece), hulls_of.get(holder.id, []))))
    hull_count = len(meshes) - first_hull
    sheet_number: List[Dict[int, int]] = []  # the same for the sheets, which follow all hulls
    for piece in pieces:
        sheet_number.append({})
        for mesh in sheet_meshes(piece.glb, piece.node):
            sheet_number[-1][mesh] = len(meshes)
            copied = buffers.add_mesh(piece.glb, mesh)
            meshes.append({**copied, "name": _renamed(copied.get("name", ""), piece, str(piece.node["name"]))})
    numbers: Dict[Filter, int] = {}  # in the order of their first fragments
    filter_of = [None if each is None else numbers.setdefault(each, len(numbers)) for each in filters]
    nodes: List[Json] = [{}]
    children: List[Json] = []
    for k, piece in enumerate(pieces):
        node = {**copy.deepcopy(piece.node), "name": piece.name, "mesh": mesh_of[piece.id]}
        below = [copy.deepcopy(piece.glb.item("nodes", child)) for child in piece.node.get("children", [])]
        if below:
            node["children"] = [1 + len(pieces) + len(children) + n for n in range(len(below))]
        for changed in (node, *below):
            _refer(changed, piece, {**hull_number[k], **sheet_number[k]}, filter_of[k], first_hull=first_hull)
        nodes.append(node)
        children += [{**child, "name": _renamed(child.get("name", ""), piece, str(piece.node["name"]))} for child in below]
    nodes += children
    groups = Groups(whole, *{id(piece.glb): piece.glb for piece in pieces}.values())
    held = [(groups.above(piece.node), 1 + k) for k, piece in enumerate(pieces)]
    taken = {str(each.get("name", "")) for each in (*nodes[1:], *meshes, _root(whole))}
    taken |= {f"{piece.name}_{hull:0{piece.digits}}_collider" for piece in pieces for hull in range(len(_hull_meshes(piece)))}
    for kept in _passing_through(whole):
        held.append((groups.above(kept), len(nodes)))
        kept = {**copy.deepcopy(kept), "name": _unique(str(kept.get("name", "")), taken)}
        if "mesh" in kept:
            copied = buffers.add_mesh(whole, kept["mesh"])
            kept["mesh"] = len(meshes)
            meshes.append({**copied, "name": kept["name"]})
        nodes.append(kept)
    of_root = groups.append_to(nodes, held, taken)
    nodes[0] = {**_root(whole), "children": of_root, "extras": {"fracture": figures}}
    extensions = _document_extensions(whole, pieces, list(numbers), list(range(first_hull, first_hull + hull_count)))
    if extensions:
        document["extensions"] = extensions
    document["nodes"], document["meshes"] = nodes, meshes


def _root(whole: Glb) -> Json:
    return next(node for node in whole.list("nodes") if "certificate" in extras_of(node))


def _passing_through(whole: Glb) -> List[Json]:
    """Returns the nodes of the mesh that no cut reaches, in file order: children of the root or of groups that are neither fragments nor
    clusters."""
    above = [_root(whole), *(node for node in whole.list("nodes") if index_of(node) is not None)]
    found = sorted(child for node in above for child in node.get("children", []))
    return [node for node in (whole.item("nodes", child) for child in found) if not extras_of(node)]


def _body(node: Json) -> Json:
    extensions = node.get("extensions", {})
    return extensions.get(KHR) or extensions.get(OMI) or {}


def _hull_meshes(piece: _Piece) -> List[int]:
    """Returns the collider hulls of the fragment's node and its child nodes, in order and without duplicates. Unreal's nodes (UCX_…)
    can refer to the same hulls."""
    meshes: List[int] = []
    for node in (piece.node, *(piece.glb.item("nodes", child) for child in piece.node.get("children", []))):
        collider = _body(node).get("collider", {})
        if "geometry" in collider:
            meshes.append(collider["geometry"]["mesh"])
        elif "shape" in collider:
            meshes.append(_shapes(piece.glb)[collider["shape"]]["convex"]["mesh"])
        elif node is not piece.node and "mesh" in node:
            meshes.append(node["mesh"])
    sheets = sheet_meshes(piece.glb, piece.node)
    return [mesh for mesh in dict.fromkeys(meshes) if mesh not in sheets]


def _shapes(glb: Glb) -> List[Json]:
    return glb.document["extensions"][OMI_SHAPE]["shapes"]  # type: ignore[no-any-return]


def _refer(node: Json, piece: _Piece, number: Dict[int, int], filter_number: Optional[int], first_hull: int) -> None:
    """Makes a node refer to the hulls, sheets and collision filters of the merged file."""
    collider = _body(node).get("collider", {})
    if "geometry" in collider:
        collider["geometry"]["mesh"] = number[collider["geometry"]["mesh"]]
        collider.pop("collisionFilter", None)
        if filter_number is not None:
            collider["collisionFilter"] = filter_number
    elif "shape" in collider:
        mesh = _shapes(piece.glb)[collider["shape"]]["convex"]["mesh"]
        collider["shape"] = number[mesh] - first_hull
    if not extras_of(node) and "mesh" in node:
        node["mesh"] = number[node["mesh"]]


def _renamed(name: str, piece: _Piece, old: str) -> str:
    """Returns the new name of a hull, collider or sheet. Its old name contains `old`, the fragment's old name, and a number."""
    begin, found, end = name.partition(old)
    return begin + piece.name + re.sub(r"^_(\d+)", lambda number: f"_{int(number[1]):0{piece.digits}}", end) if found else name


def _filtered(whole: Glb, figures: Json, pieces: List[_Piece]) -> List[Tuple[int, int]]:
    """Returns the pairs of fragments that must not collide, as indices: those of unchanged fragments, and those in the delta."""
    place = {piece.id: k for k, piece in enumerate(pieces)}
    stay = {piece.id for piece in pieces if piece.glb is whole}
    pairs = [(a, b) for a, b in _id_pairs(figures_of(whole)) if a in stay and b in stay] + _id_pairs(figures)
    for pair in pairs:
        if not place.keys() >= set(pair):
            raise damaged(f"its collision filters refer to a fragment that does not exist (fragments {pair[0]} and {pair[1]})")
    return sorted((min(place[a], place[b]), max(place[a], place[b])) for a, b in pairs)


def _id_pairs(figures: Json) -> List[Tuple[int, int]]:
    filtered = figures.get("filtered", {})
    return list(zip(filtered.get("a", ()), filtered.get("b", ())))


def _document_extensions(whole: Glb, pieces: List[_Piece], filters: List[Filter], hulls: List[int]) -> Json:
    extensions: Json = copy.deepcopy(whole.document.get("extensions", {}))
    if KHR in extensions:
        extensions[KHR].pop("collisionFilters", None)
        if filters and hulls:
            extensions[KHR]["collisionFilters"] = [
                {"collisionSystems": [str(system)], **({"notCollideWithSystems": [str(n) for n in excluded]} if excluded else {})}
                for system, excluded in filters]
    if OMI_SHAPE in extensions:
        extensions[OMI_SHAPE]["shapes"] = [{"type": "convex", "convex": {"mesh": mesh}} for mesh in hulls]
    return extensions
