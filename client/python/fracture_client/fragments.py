"""The fragments and bonds of an answer as plain values."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, Optional, Tuple

from .glb import Array, Glb, as_array, damaged
from .turn import Turn, turn_of

Vector = Tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex collision hull in metres, relative to its fragment's `translation`."""

    points: Array  # (n, 3) float32
    triangles: Array  # (m, 3) uint16: indices into points, counter-clockwise when seen from outside


@dataclass(frozen=True, eq=False)
class Primitive:
    """The triangles of a fragment that share a material."""

    material: str  # name of the material; "" if there is none
    material_index: Optional[int]  # index into the file's materials
    interior: bool  # True for cut faces, which are not part of the mesh's surface
    indices: Array  # (m, 3): indices into the fragment's vertices
    attributes: Dict[str, Array]  # "POSITION", "NORMAL", "TEXCOORD_0", …: one row per vertex of the fragment


@dataclass(frozen=True, eq=False)
class Fragment:
    """A closed fragment. A vertex is at `translation` plus its position (m, y up). With instances=keep, the node of an unbroken instance
    rotates and scales a mesh that other nodes share. The positions here are already rotated and scaled."""

    id: int  # a fragment that a hit does not change keeps its id
    name: str  # name of its node
    node: int  # index of its node
    translation: Vector  # m
    volume: float  # m³
    mass: float  # kg
    area: float  # m², of the whole surface
    exterior_area: float  # m², of the faces that belonged to the mesh's surface
    center_of_mass: Vector  # m, in the frame of the root node (see Answer.offset)
    inertia_diagonal: Optional[Vector]  # kg m², principal moments about the centre of mass; None without physics=khr
    inertia_orientation: Optional[Tuple[float, float, float, float]]  # quaternion x, y, z, w of the principal axes
    anchored: bool  # True if an anchor holds it, so that it does not fall
    part: int  # number of the connected part of the mesh to which its first piece belongs
    parts: Tuple[int, ...]  # numbers of all parts that it has pieces of, ascending
    level: int  # its level in the hierarchy; 0 without a hierarchy
    parent: Optional[int]  # the id of its cluster; None if there is none
    sites: Tuple[int, ...]  # the cells that it consists of
    collision_system: Optional[int]  # 0 to 31; None: it collides with all
    not_collide_with: Tuple[int, ...]  # systems of fragments that it overlaps, so it must not collide with them
    primitives: Tuple[Primitive, ...]
    hulls: Tuple[Hull, ...]  # empty with physics=none
    sheet: Tuple[Primitive, ...]  # the sheets that it carries (panes, leaves), with separate vertices; usually empty
    extras: Dict[str, Any] = field(repr=False)  # the whole `extras.fracture` of its node

    @property
    def positions(self) -> Array:
        """All vertices, including those of the cut faces: (n, 3) float32, m."""
        return self.primitives[0].attributes["POSITION"]

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return sum(len(primitive.indices) for primitive in self.primitives)

    @property
    def materials(self) -> Tuple[str, ...]:
        """The name of each primitive's material; "" if it has none."""
        return tuple(primitive.material for primitive in self.primitives)


@dataclass(frozen=True)
class Bond:
    """Two fragments that are held together by shared cut faces, by contacts between their parts, or by both."""

    a: int  # id of a fragment, or of a cluster in a level
    b: int
    area: float  # m²
    centroid: Vector  # m, in the frame of the root node (see Answer.offset)
    normal: Vector  # from a to b, unit length; zero if the shared faces have no common plane
    strength: float  # N: the tension at which it breaks


@dataclass(frozen=True)
class Delta:
    """The ids of the fragments that a hit created, changed or removed. All other fragments stay the same, bit for bit."""

    new: Tuple[int, ...]
    changed: Tuple[int, ...]
    gone: Tuple[int, ...]


def figures_of(glb: Glb) -> Dict[str, Any]:
    """Returns `extras.fracture` of the root node: parameters, report, certificate, bonds. Raises FractureError of type "damaged" if
    it is missing."""
    for node in glb.list("nodes"):
        own = extras_of(node)
        if "certificate" in own:
            return own
    raise damaged("no node has extras.fracture.certificate, which every answer from a fracture server contains")


def root_offset(glb: Glb) -> "Vector":
    """Returns the root node's translation (m); (0, 0, 0) if it has none."""
    for node in glb.list("nodes"):
        if "certificate" in extras_of(node):
            return _vector(node.get("translation", (0, 0, 0)))
    return (0.0, 0.0, 0.0)


def extras_of(node: Dict[str, Any]) -> Dict[str, Any]:
    """Returns `extras.fracture` of a node; {} if it has none."""
    own = node.get("extras", {}).get("fracture", {}) if isinstance(node.get("extras"), dict) else {}
    return own if isinstance(own, dict) else {}


def read_fragments(glb: Glb) -> List[Fragment]:
    """Returns the fragments in file order. Raises FractureError of type "damaged" if the file contradicts itself."""
    interior = set(figures_of(glb).get("interior_materials", []))
    return [_fragment(glb, index, node, own, interior) for index, node, own in fragment_nodes(glb)]


def fragment_nodes(glb: Glb) -> Iterator[Tuple[int, Dict[str, Any], Dict[str, Any]]]:
    """Yields (index of the node, node, its `extras.fracture`) for each fragment."""
    for index, node in enumerate(glb.list("nodes")):
        own = extras_of(node)
        if "id" in own:
            yield index, node, own


def _fragment(glb: Glb, index: int, node: Dict[str, Any], own: Dict[str, Any], interior: "set[int]") -> Fragment:
    try:
        motion = _body(node).get("motion", {})
        diagonal, orientation = motion.get("inertiaDiagonal"), motion.get("inertiaOrientation")
        turn = turn_of(node)
        if orientation is not None:
            orientation = _quaternion(orientation) if turn is None else turn.orientation(_quaternion(orientation))
        colliders = [node, *(glb.item("nodes", child) for child in node.get("children", []))]
        meshes = list(dict.fromkeys(mesh for collider in colliders for mesh in _hull_meshes(glb, collider)))
        return Fragment(
            id=int(own["id"]), name=str(node.get("name", "")), node=index,
            translation=_vector(node.get("translation", (0, 0, 0))),
            volume=float(own["volume"]), mass=float(own["mass"]), area=float(own["area"]),
            exterior_area=float(own["exterior_area"]), center_of_mass=_vector(own["center_of_mass"]),
            inertia_diagonal=None if diagonal is None else _vector(diagonal),
            inertia_orientation=orientation,
            anchored=bool(own.get("anchored", False)), part=int(own.get("part", 0)),
            parts=tuple(int(part) for part in own.get("parts", (own.get("part", 0),))), level=int(own.get("level", 0)),
            parent=own.get("parent"), sites=tuple(own.get("sites", ())),
            **_collision_filter(glb, colliders),
            primitives=tuple(_primitive(glb, p, interior, turn) for p in glb.item("meshes", node.get("mesh"))["primitives"]),
            hulls=tuple(_hull(glb, mesh, turn) for mesh in meshes),
            sheet=tuple(_primitive(glb, p, interior, turn) for mesh in sheet_meshes(glb, node) for p in glb.item("meshes", mesh)["primitives"]),
            extras=own)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise damaged(f"the fragment nodes[{index}] cannot be read: {error!r}") from None


def _body(node: Dict[str, Any]) -> Dict[str, Any]:
    """Returns a node's rigid body in the KHR or OMI extension; {} if it has none."""
    extensions = node.get("extensions", {})
    return extensions.get("KHR_physics_rigid_bodies") or extensions.get("OMI_physics_body") or {}


def _collision_filter(glb: Glb, nodes: List[Dict[str, Any]]) -> Dict[str, Any]:
    number = next((_body(node)["collider"]["collisionFilter"] for node in nodes
                   if "collisionFilter" in _body(node).get("collider", {})), None)
    if number is None:
        return {"collision_system": None, "not_collide_with": ()}
    chosen = glb.document["extensions"]["KHR_physics_rigid_bodies"]["collisionFilters"][number]
    return {"collision_system": int(chosen["collisionSystems"][0]),
            "not_collide_with": tuple(int(system) for system in chosen.get("notCollideWithSystems", ()))}


def _hull_meshes(glb: Glb, node: Dict[str, Any]) -> Iterator[int]:
    """Yields the mesh of the node's collider, or of the node itself if it is a hull for Unreal (UCX_…)."""
    collider = _body(node).get("collider", {})
    if "geometry" in collider:
        yield collider["geometry"]["mesh"]
    elif "shape" in collider:
        yield glb.document["extensions"]["OMI_physics_shape"]["shapes"][collider["shape"]]["convex"]["mesh"]
    elif str(node.get("name", "")).startswith("UCX_"):
        yield node["mesh"]


def sheet_meshes(glb: Glb, node: Dict[str, Any]) -> List[int]:
    """Returns the meshes of the sheets that a fragment carries. They belong to the child nodes that are not for physics."""
    below = [glb.item("nodes", child) for child in node.get("children", [])]
    return [child["mesh"] for child in below if "mesh" in child and not str(child.get("name", "")).startswith("UCX_")]


def _attribute(glb: Glb, semantic: str, accessor: int, turn: Optional[Turn]) -> Array:
    return glb.array(accessor) if turn is None else turn.attribute(semantic, *glb.elements(accessor))


def _hull(glb: Glb, mesh: int, turn: Optional[Turn]) -> Hull:
    primitive = glb.item("meshes", mesh)["primitives"][0]
    return Hull(_attribute(glb, "POSITION", primitive["attributes"]["POSITION"], turn), _triangles(glb, primitive["indices"]))


def _primitive(glb: Glb, primitive: Dict[str, Any], interior: "set[int]", turn: Optional[Turn]) -> Primitive:
    index = primitive.get("material")
    name = "" if index is None else str(glb.item("materials", index).get("name", ""))
    attributes = {semantic: _attribute(glb, semantic, accessor, turn) for semantic, accessor in primitive["attributes"].items()}
    return Primitive(name, index, index in interior, _triangles(glb, primitive["indices"]), attributes)


def _triangles(glb: Glb, accessor: int) -> Array:
    data, kind, _ = glb.elements(accessor)
    return as_array(data, kind, 3, rows=True)


def _vector(value: Any) -> Vector:
    x, y, z = (float(v) for v in value)
    if not math.isfinite(x + y + z):
        raise ValueError(f"a vector is not finite: {value}")
    return x, y, z


def _quaternion(value: Any) -> Tuple[float, float, float, float]:
    x, y, z, w = (float(v) for v in value)
    return x, y, z, w


def read_bonds(columns: Dict[str, Any]) -> List[Bond]:
    """Reads the bonds from the arrays `a`, `b`, `area`, …. Raises FractureError of type "damaged"."""
    try:
        lists = [columns[key] for key in ("a", "b", "area", "centroid", "normal", "strength")]
        if len({len(values) for values in lists}) != 1:
            raise ValueError("the arrays have different lengths")
        return [Bond(int(a), int(b), float(area), _vector(centroid), _vector(normal), float(strength))
                for a, b, area, centroid, normal, strength in zip(*lists)]
    except (KeyError, TypeError, ValueError) as error:
        raise damaged(f"the bonds cannot be read: {error!r}") from None
