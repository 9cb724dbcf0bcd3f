"""Fragments as the server answers, and what is made of them."""
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
from .errors import FractureError
from .fragments import Bond, Delta, Fragment, figures_of, read_bonds, read_fragments
from .problems import Reaction, reaction_to
from .upload import Path, json_text

if TYPE_CHECKING:
    from .mesh import Mesh

Point = Sequence[float]  # x, y, z in metres, y up


class Answer:
    """One GLB with its figures. Immutable: a hit gives another answer."""

    def __init__(self, content: bytes, mesh: Optional["Mesh"] = None, headers: Optional[Mapping[str, str]] = None) -> None:
        """`headers`: of the HTTP answer, names in lower case. Raises FractureError of type "damaged" for what is no GLB
        of a fracture server."""
        self._file = glb_file.Glb(content)
        self._figures = figures_of(self._file)
        self._mesh = mesh
        self._headers = dict(headers or {})
        self._fragments: Optional[List[Fragment]] = None
        self._bonds: Optional[List[Bond]] = None

    @classmethod
    def load(cls, path: Path) -> "Answer":
        """Of a file that save() or anybody else wrote. Such an answer can be looked at, and not be hit. Raises OSError."""
        return cls(pathlib.Path(path).read_bytes())

    @property
    def glb(self) -> bytes:
        return self._file.content

    @property
    def figures(self) -> Dict[str, Any]:
        """All that the server says beside the geometry: `extras.fracture` of the root node."""
        return self._figures

    @property
    def parameters(self) -> Dict[str, Any]:
        """The request as the server understood it. Together with the mesh they give the same answer again."""
        return self._figures.get("parameters", {})

    @property
    def report(self) -> Dict[str, Any]:
        """What was repaired, what sizes the fragments have, what was not as it was asked for."""
        return self._figures.get("report", {})

    @property
    def warnings(self) -> List[str]:
        return list(self.report.get("warnings", []))

    @property
    def certificate(self) -> Dict[str, Any]:
        """What proves the answer: open edges (0), volumes in and out (m³), fragments, …"""
        return self._figures["certificate"]  # type: ignore[no-any-return]

    @property
    def fragments(self) -> List[Fragment]:
        """Read from the file when they are asked for the first time."""
        if self._fragments is None:
            self._fragments = read_fragments(self._file)
        return self._fragments

    @property
    def bonds(self) -> List[Bond]:
        """Which fragments hold together. Read when they are asked for the first time."""
        if self._bonds is None:
            self._bonds = read_bonds(self._figures.get("bonds", {}))
        return self._bonds

    @property
    def levels(self) -> List[Dict[str, Any]]:
        """The hierarchy above the fragments, coarsest first, as the server writes it; empty without `levels`."""
        return list(self._figures.get("levels", []))

    @property
    def delta(self) -> Optional[Delta]:
        """What the last hit changed; None where there was none, or nobody asked."""
        said = self._figures.get("delta")
        return None if said is None else Delta(*(tuple(said[key]) for key in ("new", "changed", "gone")))

    @property
    def location(self) -> str:
        """The answer's address, "/fractures/sha256:…", good for Client.answer() while the server has it cached; after a hit
        it is the address of what changed. "" for a file."""
        return self._headers.get("content-location", "")

    @property
    def etag(self) -> str:
        """Of what came over the wire, for `unless` of Client.answer()."""
        return self._headers.get("etag", "")

    @property
    def algorithm(self) -> int:
        """The version of the algorithm: equal requests give equal bytes as long as it is the same."""
        return int(self._figures.get("algorithm", 0))

    @property
    def timing(self) -> Dict[str, float]:
        """Milliseconds that the server took for each step (Server-Timing). What is not understood is left out."""
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
        """All of the HTTP answer, names in lower case."""
        return dict(self._headers)

    @property
    def mesh(self) -> Optional["Mesh"]:
        """What was fractured; None for a file."""
        return self._mesh

    def of_mesh(self, mesh: "Mesh") -> "Answer":
        """The same answer, whose mesh is known."""
        same = copy.copy(self)
        same._mesh = mesh
        return same

    def save(self, path: Path) -> pathlib.Path:
        """Writes a GLB if the path ends in .glb or has no ending, glTF as one JSON text for .gltf, the figures alone for .json.
        Whole or not at all. Raises FractureError of type "bad-parameter" for any other ending, and OSError."""
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
        """The answer after one more hit (or several): a whole one, with `delta`.

        point       where it is hit, metres, y up, in the frame of the answer; a list of points for several hits
        radius      how far it reaches, metres; one for all, or one for each
        sites       how many cells it adds (the server's default: 30); one for all, or one for each
        parameters  `gravity` and `broken`; with delta="none" whatever decides neither mesh nor cells

        Only what changed is sent; it is put together with this answer here. A server that has forgotten this answer is asked
        for the same by its parameters. Raises FractureError.
        """
        if self._mesh is None:
            raise FractureError("bad-parameter", "An answer that was read from a file cannot be hit: ask for it with its "
                                                 "parameters, then hit that.")
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
        """Hierarchies and anchors are about all fragments, and the relief of cuts is not sent twice: then all comes again."""
        about_all = ("levels", "anchor_plane", "anchor_box", "anchor_points")
        return not any(name in self.parameters for name in about_all) and \
            self.parameters.get("interior_detail", "none") == "none"

    def _spelt_out(self, wanted: Mapping[str, Any]) -> Dict[str, Any]:
        """The request that names no earlier answer: its parameters, with the hits behind its own."""
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


def kind_of_file(path: pathlib.Path) -> str:
    """What save() writes: ".glb", ".gltf" or ".json". Raises FractureError of type "bad-parameter" for another ending, because
    a GLB in a file called .obj is found only when it is read."""
    kind = path.suffix.lower() or ".glb"
    if kind not in (".glb", ".gltf", ".json"):
        raise FractureError("bad-parameter", f"'{path.suffix}' is not written: the file '{path}' must end in .glb, .gltf (one JSON "
                                             "text) or .json (the figures), or have no ending (GLB). `fracture-server bake` "
                                             "writes .obj, .ply and .stl.")
    return kind


def write_whole(path: pathlib.Path, content: bytes) -> None:
    """Into a file beside it first, so that nobody reads half of it. Raises OSError."""
    beside = path.with_name(f"{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        with open(beside, "xb") as file:
            file.write(content)
        os.replace(beside, path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            os.unlink(beside)
        if isinstance(error, OSError):
            error.filename, error.filename2 = str(path), None  # the file that the caller knows of
        raise
