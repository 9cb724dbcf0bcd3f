"""Fragments and bonds of an answer as plain values."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, Optional, Tuple

from .glb import Array, Glb, as_array, damaged

Vector = Tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex collision hull, in the frame of its fragment's node, metres."""

    points: Array  # (n, 3) float32
    triangles: Array  # (m, 3) uint16: indices of points, counter-clockwise seen from outside


@dataclass(frozen=True, eq=False)
class Primitive:
    """The triangles of a fragment that have one material."""

    material: str  # its name; "" where it has none
    material_index: Optional[int]  # into the file's materials
    interior: bool  # cut faces, which the mesh did not have
    indices: Array  # (m, 3): of the fragment's vertices
    attributes: Dict[str, Array]  # "POSITION", "NORMAL", "TEXCOORD_0", …: one row for each vertex of the fragment


@dataclass(frozen=True, eq=False)
class Fragment:
    """A closed piece. Geometry is in the frame of its node; a vertex is at `translation` + position, metres, y up."""

    id: int  # the same piece has the same id in the answer to the next hit
    name: str  # of its node
    node: int  # index of its node
    translation: Vector  # m
    volume: float  # m³
    mass: float  # kg
    area: float  # m², of the whole surface
    exterior_area: float  # m², of what was the surface of the mesh
    center_of_mass: Vector  # m, in the frame of the scene
    inertia_diagonal: Optional[Vector]  # kg m², about the centre of mass; None without physics=khr
    inertia_orientation: Optional[Tuple[float, float, float, float]]  # quaternion x, y, z, w of the principal axes
    anchored: bool  # held: it does not fall
    part: int  # which connected part of the mesh it is of
    level: int  # of the hierarchy; 0 without one
    parent: Optional[int]  # the id of its cluster
    sites: Tuple[int, ...]  # the cells that it is made of
    collision_system: Optional[int]  # fragments of the same one overlap and do not collide with one another
    primitives: Tuple[Primitive, ...]
    hulls: Tuple[Hull, ...]  # empty with physics=none
    extras: Dict[str, Any] = field(repr=False)  # `extras.fracture` of its node, all of it

    @property
    def positions(self) -> Array:
        """(n, 3) float32, m: all vertices, those of the cut faces too."""
        return self.primitives[0].attributes["POSITION"]

    @property
    def triangles(self) -> int:
        return sum(len(primitive.indices) for primitive in self.primitives)

    @property
    def materials(self) -> Tuple[str, ...]:
        return tuple(primitive.material for primitive in self.primitives)


@dataclass(frozen=True)
class Bond:
    """What two fragments share, and how strongly that holds them together."""

    a: int  # fragment ids, or those of clusters in a level
    b: int
    area: float  # m²
    centroid: Vector  # m, in the frame of the scene
    normal: Vector  # from a to b, unit length; zero where they share no plane
    strength: float  # N: the tension that it withstands


@dataclass(frozen=True)
class Delta:
    """What a hit changed, as ids of fragments. All others are what they were, to the bit."""

    new: Tuple[int, ...]
    changed: Tuple[int, ...]
    gone: Tuple[int, ...]


def figures_of(glb: Glb) -> Dict[str, Any]:
    """`extras.fracture` of the root: parameters, report, certificate, bonds. Raises "damaged" where there is none."""
    for node in glb.list("nodes"):
        own = extras_of(node)
        if "certificate" in own:
            return own
    raise damaged("no node has extras.fracture.certificate")


def extras_of(node: Dict[str, Any]) -> Dict[str, Any]:
    own = node.get("extras", {}).get("fracture", {}) if isinstance(node.get("extras"), dict) else {}
    return own if isinstance(own, dict) else {}


def read_fragments(glb: Glb) -> List[Fragment]:
    """In the order of the file. Raises "damaged" for what contradicts itself."""
    interior = set(figures_of(glb).get("interior_materials", []))
    return [_fragment(glb, index, node, own, interior) for index, node, own in fragment_nodes(glb)]


def fragment_nodes(glb: Glb) -> Iterator[Tuple[int, Dict[str, Any], Dict[str, Any]]]:
    """Index, node and its `extras.fracture` of each fragment."""
    for index, node in enumerate(glb.list("nodes")):
        own = extras_of(node)
        if "id" in own:
            yield index, node, own


def _fragment(glb: Glb, index: int, node: Dict[str, Any], own: Dict[str, Any], interior: "set[int]") -> Fragment:
    try:
        motion = _body(node).get("motion", {})
        diagonal, orientation = motion.get("inertiaDiagonal"), motion.get("inertiaOrientation")
        colliders = [node, *(glb.item("nodes", child) for child in node.get("children", []))]
        meshes = list(dict.fromkeys(mesh for collider in colliders for mesh in _hull_meshes(glb, collider)))
        return Fragment(
            id=int(own["id"]), name=str(node.get("name", "")), node=index,
            translation=_vector(node.get("translation", (0, 0, 0))),
            volume=float(own["volume"]), mass=float(own["mass"]), area=float(own["area"]),
            exterior_area=float(own["exterior_area"]), center_of_mass=_vector(own["center_of_mass"]),
            inertia_diagonal=None if diagonal is None else _vector(diagonal),
            inertia_orientation=None if orientation is None else _quaternion(orientation),
            anchored=bool(own.get("anchored", False)), part=int(own.get("part", 0)), level=int(own.get("level", 0)),
            parent=own.get("parent"), sites=tuple(own.get("sites", ())),
            collision_system=next((system for collider in colliders for system in _systems(collider)), None),
            primitives=tuple(_primitive(glb, p, interior) for p in glb.item("meshes", node.get("mesh"))["primitives"]),
            hulls=tuple(_hull(glb, mesh) for mesh in meshes), extras=own)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise damaged(f"nodes[{index}] is a fragment that cannot be read: {error!r}") from None


def _body(node: Dict[str, Any]) -> Dict[str, Any]:
    """Its rigid body, of either extension."""
    extensions = node.get("extensions", {})
    return extensions.get("KHR_physics_rigid_bodies") or extensions.get("OMI_physics_body") or {}


def _systems(node: Dict[str, Any]) -> Iterator[int]:
    collider = _body(node).get("collider", {})
    if "collisionFilter" in collider:
        yield int(collider["collisionFilter"])


def _hull_meshes(glb: Glb, node: Dict[str, Any]) -> Iterator[int]:
    """Of its collider, and of itself where it is a hull for Unreal."""
    collider = _body(node).get("collider", {})
    if "geometry" in collider:
        yield collider["geometry"]["mesh"]
    elif "shape" in collider:
        yield glb.document["extensions"]["OMI_physics_shape"]["shapes"][collider["shape"]]["convex"]["mesh"]
    elif str(node.get("name", "")).startswith("UCX_"):
        yield node["mesh"]


def _hull(glb: Glb, mesh: int) -> Hull:
    primitive = glb.item("meshes", mesh)["primitives"][0]
    return Hull(glb.array(primitive["attributes"]["POSITION"]), _triangles(glb, primitive["indices"]))


def _primitive(glb: Glb, primitive: Dict[str, Any], interior: "set[int]") -> Primitive:
    index = primitive.get("material")
    name = "" if index is None else str(glb.item("materials", index).get("name", ""))
    attributes = {semantic: glb.array(accessor) for semantic, accessor in primitive["attributes"].items()}
    return Primitive(name, index, index in interior, _triangles(glb, primitive["indices"]), attributes)


def _triangles(glb: Glb, accessor: int) -> Array:
    data, kind, _ = glb.elements(accessor)
    return as_array(data, kind, 3, rows=True)


def _vector(value: Any) -> Vector:
    x, y, z = (float(v) for v in value)
    if not math.isfinite(x + y + z):
        raise ValueError("a vector that is not finite")
    return x, y, z


def _quaternion(value: Any) -> Tuple[float, float, float, float]:
    x, y, z, w = (float(v) for v in value)
    return x, y, z, w


def read_bonds(columns: Dict[str, Any]) -> List[Bond]:
    """Of the arrays `a`, `b`, `area`, … in which they stand. Raises "damaged"."""
    try:
        lists = [columns[key] for key in ("a", "b", "area", "centroid", "normal", "strength")]
        if len({len(values) for values in lists}) != 1:
            raise ValueError("columns of several lengths")
        return [Bond(int(a), int(b), float(area), _vector(centroid), _vector(normal), float(strength))
                for a, b, area, centroid, normal, strength in zip(*lists)]
    except (KeyError, TypeError, ValueError) as error:
        raise damaged(f"its bonds cannot be read: {error!r}") from None
