"""The fragments that the server returns, with methods to save them or hit them again."""
from __future__ import annotations

import contextlib
import copy
import json
import os
import pathlib
import secrets
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Union

from . import glb as glb_file
from .calls import Cancel
from .choices import Choice, read_choices
from .dropped import Dropped, read_dropped
from .errors import FractureError
from .fragments import Bond, Delta, Fragment, Vector, figures_of, read_bonds, read_fragments, root_offset
from .problems import Reaction, reaction_to
from .upload import Path, json_text

if TYPE_CHECKING:
    from .mesh import Mesh

Point = Sequence[float]  # x, y, z in metres, y up


class Answer:
    """A GLB with fragments, and the data about them. Immutable: hit() returns a new answer."""

    def __init__(self, content: bytes, mesh: Optional["Mesh"] = None, headers: Optional[Mapping[str, str]] = None) -> None:
        """content  the bytes of a GLB
        mesh     the mesh that was fractured; hit() needs it
        headers  the header fields of the HTTP response, with lower-case names
        Raises FractureError of type "damaged" if `content` is not a GLB from a fracture server.
        """
        self._file = glb_file.Glb(content)
        self._figures = figures_of(self._file)
        self._mesh = mesh
        self._headers = dict(headers or {})
        self._fragments: Optional[List[Fragment]] = None
        self._bonds: Optional[List[Bond]] = None

    @classmethod
    def load(cls, path: Path) -> "Answer":
        """Reads a GLB file from a fracture server. hit() does not work on such an answer, because its mesh is unknown.
        Raises OSError, and FractureError of type "damaged"."""
        return cls(pathlib.Path(path).read_bytes())

    @property
    def glb(self) -> bytes:
        """The bytes of the GLB."""
        return self._file.content

    @property
    def figures(self) -> Dict[str, Any]:
        """Everything except the geometry: `extras.fracture` of the root node."""
        return self._figures

    @property
    def parameters(self) -> Dict[str, Any]:
        """The parameters as the server understood them. The same mesh with these parameters gives the same answer."""
        return self._figures.get("parameters", {})

    @property
    def report(self) -> Dict[str, Any]:
        """The report: mesh repairs, fragment sizes, warnings, notes, and a list of dropped items."""
        return self._figures.get("report", {})

    @property
    def warnings(self) -> List[str]:
        """The report's warnings. Each says what happened, how it affects the result, and what to do. [] if there are none."""
        return list(self.report.get("warnings", []))

    @property
    def notes(self) -> List[str]:
        """The report's notes about what the server did. They need no action. [] if there are none. Servers with algorithm 22 or
        older put notes among the warnings."""
        return list(self.report.get("notes", []))

    @property
    def dropped(self) -> List[Dropped]:
        """Things in the source that the answer does not contain, such as lights and animations. [] if there is nothing."""
        return read_dropped(self.report)

    @property
    def choices(self) -> List[Choice]:
        """Changes that the server offers but did not make: another unit, walls for a room, … [] if there are none."""
        return read_choices(self.report)

    @property
    def certificate(self) -> Dict[str, Any]:
        """The numbers that prove the answer correct: open edges (0), volumes in and out (m³), number of fragments, …"""
        return self._figures["certificate"]  # type: ignore[no-any-return]

    @property
    def offset(self) -> Vector:
        """The position of the root node (m). To get a position in the mesh's file, add this to a position in the answer. (0, 0, 0) unless
        the mesh is far from its origin."""
        return root_offset(self._file)

    @property
    def fragments(self) -> List[Fragment]:
        """The fragments in file order. They are read on first use. Raises FractureError of type "damaged"."""
        if self._fragments is None:
            self._fragments = read_fragments(self._file)
        return self._fragments

    @property
    def bonds(self) -> List[Bond]:
        """The connections between fragments. They are read on first use. Raises FractureError of type "damaged"."""
        if self._bonds is None:
            self._bonds = read_bonds(self._figures.get("bonds", {}))
        return self._bonds

    @property
    def levels(self) -> List[Dict[str, Any]]:
        """The levels of the hierarchy, coarsest first, as the server writes them. [] if the request had no `levels`."""
        return list(self._figures.get("levels", []))

    @property
    def delta(self) -> Optional[Delta]:
        """The changes made by the last hit. None without a hit, or after a hit with delta="none"."""
        said = self._figures.get("delta")
        return None if said is None else Delta(*(tuple(said[key]) for key in ("new", "changed", "gone")))

    @property
    def location(self) -> str:
        """The address for Client.answer(): "/fractures/sha256:…". It is valid while the answer is in the server's cache. After a hit,
        it is the address of the changes alone. "" for an answer that was read from a file."""
        return self._headers.get("content-location", "")

    @property
    def etag(self) -> str:
        """The ETag of the HTTP response. Pass it to Client.answer() as `unless`."""
        return self._headers.get("etag", "")

    @property
    def algorithm(self) -> int:
        """The version of the algorithm. Identical requests give identical bytes as long as this version stays the same."""
        return int(self._figures.get("algorithm", 0))

    @property
    def timing(self) -> Dict[str, float]:
        """The time in milliseconds for each step on the server, by name (Server-Timing). Unreadable entries are omitted."""
        times: Dict[str, float] = {}
        for entry in self._headers.get("server-timing", "").split(","):
            name, *parameters = (part.strip() for part in entry.split(";"))
            for parameter in parameters:
                try:
                    if name and parameter.startswith("dur=") and 0 <= float(parameter[4:]) < float("inf"):
                        times[name] = float(parameter[4:])
                except ValueError:
                    pass
        return times

    @property
    def headers(self) -> Dict[str, str]:
        """All header fields of the HTTP response, with lower-case names."""
        return dict(self._headers)

    @property
    def mesh(self) -> Optional["Mesh"]:
        """The mesh that was fractured; None for an answer that was read from a file."""
        return self._mesh

    def of_mesh(self, mesh: "Mesh") -> "Answer":
        """Returns a copy of this answer that knows its mesh, so that hit() works."""
        same = copy.copy(self)
        same._mesh = mesh
        return same

    def save(self, path: Path) -> pathlib.Path:
        """Writes the answer in the format that the file extension names, and returns the path.

        .glb or no extension  GLB
        .gltf                 glTF as a single JSON document
        .json                 only the data, without geometry
        Replaces an existing file. If writing fails, the existing file is unchanged.
        Raises OSError, and FractureError of type "bad-parameter" for any other extension.
        """
        path = pathlib.Path(path)
        kind = kind_of_file(path)
        content = self.glb
        if kind == ".gltf":
            content = glb_file.to_gltf(self._file)
        elif kind == ".json":
            content = json.dumps(self._figures, indent=1, ensure_ascii=False).encode("utf-8") + b"\n"
        write_whole(path, content)
        return path

    def hit(self, point: Union[Point, Sequence[Point]], radius: Union[float, Sequence[float]],
            sites: Union[int, Sequence[int], None] = None, *, timeout: Optional[float] = None,
            cancel: Optional[Cancel] = None, realtime: Optional[bool] = None, **parameters: Any) -> "Answer":
        """Hits this answer one or more times. Returns an answer with all fragments; its `delta` lists the changes.

        point       centre of the hit in the answer's frame (m, y up): (x, y, z), or a list of such points for several hits
        radius      radius of the hit (m); nothing is cut beyond 1.25 times the radius. One number for all hits, or a list with one per hit
        sites       number of cells that cut the fragments there (server default: 30): one number for all hits, or a list with one per hit
        timeout     seconds for everything, retries included; None: the client's
        realtime    True: computed before batch work, with the server's short deadline (2 s by default); None: the client's setting
        parameters  `gravity` and `broken`; with delta="none" also parameters that affect neither the mesh nor the cells

        The server sends only the changes, and the client merges them into this answer. If the server has forgotten this answer,
        the client requests the same result with the answer's parameters.
        Raises FractureError, of type "bad-parameter" for an answer that load() read from a file.
        """
        if self._mesh is None:
            raise FractureError("bad-parameter", "This answer was read from a file, so its mesh is unknown and it cannot be hit. Call "
                                                 "fracture() with the mesh and this answer's `parameters`, and hit that answer.")
        if any(self.offset):  # parameters have the origin of the file
            point = _moved(point, self.offset)
        hits: Dict[str, Any] = {"local_point": point, "local_radius": radius, "local_sites": sites}
        wanted = {"delta": "only" if self._can_be_merged() else "stated", **hits, **parameters}
        options: Dict[str, Any] = {"timeout": timeout, "cancel": cancel, "realtime": realtime}
        try:
            if not self.location:
                raise FractureError("no-such-answer", "The answer has no address.")
            after = self._mesh.fracture({**wanted, "of": self.location}, **options)
        except FractureError as error:
            if reaction_to(error.type, error.status) is not Reaction.REMAKE:
                raise
            after = self._mesh.fracture(self._spelt_out(wanted), **options)
        if after.parameters.get("delta") != "only":
            return after
        from .merge import merge
        return Answer(merge(self._file, after._file), self._mesh, after._headers)

    def _can_be_merged(self) -> bool:
        """Returns whether delta="only" works. It fails with levels or anchors, because a hit can change these in all fragments. It also
        fails with interior detail, because the server sends the cut faces' relief only with the whole answer."""
        about_all = ("levels", "anchor_plane", "anchor_box", "anchor_points")
        return not any(name in self.parameters for name in about_all) and \
            self.parameters.get("interior_detail", "none") == "none"

    def _spelt_out(self, wanted: Mapping[str, Any]) -> Dict[str, Any]:
        """Returns the same request without `of`: this answer's parameters, with the new hits appended to its own hits."""
        given: Dict[str, Any] = json.loads(json_text(wanted))
        before = {name: value for name, value in self.parameters.items() if name not in ("delta", "local_new", "format")}
        points = given.pop("local_point")
        points = [points] if points and not isinstance(points[0], list) else points
        parameters: Dict[str, Any] = {**before, "local_point": before.get("local_point", []) + points}
        for name, default in (("local_radius", None), ("local_sites", 30)):
            value = given.pop(name, default)
            parameters[name] = before.get(name, []) + (value if isinstance(value, list) else [value] * len(points))
        parameters.setdefault("local_rest", "fractured")
        if given.get("delta") != "none":
            parameters["local_new"] = len(points)
        return {**parameters, **given}

    def __repr__(self) -> str:
        return f"<Answer of {self.certificate.get('fragments')} fragments, {len(self.glb)} bytes>"


def _moved(point: Union[Point, Sequence[Point]], offset: Vector) -> Any:
    """Adds the offset to a point or to each point of a list."""
    if len(point) > 0 and hasattr(point[0], "__len__"):
        return [_moved(each, offset) for each in point]  # type: ignore[arg-type]
    return [float(value) + by for value, by in zip(point, offset)]  # type: ignore[arg-type]


def kind_of_file(path: pathlib.Path) -> str:
    """Returns the format that save() writes to a path: ".glb", ".gltf" or ".json". Raises FractureError of type "bad-parameter" for
    any other extension, because a GLB saved as .obj would fail only later, when another program reads it."""
    kind = path.suffix.lower() or ".glb"
    if kind not in (".glb", ".gltf", ".json"):
        raise FractureError("bad-parameter", f"'{path}': the format '{path.suffix}' cannot be written. Use the extension .glb, .gltf "
                                             "(a single JSON document) or .json (data without geometry), or no extension (GLB). "
                                             "`fracture-server bake` writes .obj, .ply and .stl.")
    return kind


def write_whole(path: pathlib.Path, content: bytes) -> None:
    """Writes a temporary file in the same folder and renames it, so no program reads an incomplete file. Raises OSError."""
    beside = path.with_name(f"{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        with open(beside, "xb") as file:
            file.write(content)
        os.replace(beside, path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            os.unlink(beside)
        if isinstance(error, OSError):
            error.filename, error.filename2 = str(path), None  # the name that the caller knows, not the temporary one
        raise
