"""Copies meshes from several GLB files into the buffers of a single file."""
from __future__ import annotations

import copy
from typing import Any, Dict, Iterator, List, Tuple

from .glb import BYTES, FORMATS, WIDTHS, Glb, damaged

Json = Dict[str, Any]
_SHORT = (5120, 5121, 5122, 5123)  # component types with less than four bytes


class Buffers:
    """The bufferViews and accessors of a new file: one view for each use ("POSITION", indices, …), as in the server's files."""

    def __init__(self) -> None:
        self._views: Dict[str, Tuple[Json, bytearray]] = {}  # in order of first use
        self._accessors: List[Json] = []

    def add_mesh(self, glb: Glb, index: int) -> Json:
        """Returns a copy of the mesh with accessors that refer to these buffers. Raises FractureError of type "damaged"."""
        mesh: Json = copy.deepcopy(glb.item("meshes", index))
        spans = _Spans(glb)
        uses = list(_uses(glb, mesh))
        for holder, key, use in uses:
            spans.take(holder[key], use)
        moved = {view: self._append(glb, view, span) for view, span in spans.of_view.items()}
        numbers: Dict[int, int] = {}
        for holder, key, _ in uses:
            old = holder[key]
            if old not in numbers:
                numbers[old] = len(self._accessors)
                self._accessors.append(_moved(glb.item("accessors", old), moved))
            holder[key] = numbers[old]
        return mesh

    def add_image(self, glb: Glb, image: Json) -> Json:
        """Returns a copy of the image whose bytes are in these buffers. Raises FractureError of type "damaged"."""
        if "bufferView" not in image:
            return image
        name = f"image {len(self._views)}"
        self._views[name] = ({}, bytearray(glb.view(image["bufferView"])))
        return {**image, "bufferView": len(self._views) - 1}

    def finish(self, document: Json) -> bytes:
        """Writes the document's members `accessors` and `bufferViews`, and returns the buffer."""
        binary, views = bytearray(), []
        for properties, content in self._views.values():
            at = {"byteOffset": len(binary)} if binary else {}
            views.append({"buffer": 0, **at, "byteLength": len(content), **properties})
            binary += content + b"\0" * (-len(content) % 4)
        if self._accessors:
            document["accessors"] = self._accessors
        if views:
            document["bufferViews"] = views
        return bytes(binary)

    def _append(self, glb: Glb, view: int, span: "_Span") -> Tuple[int, int]:
        """Appends part of a bufferView. Returns (index of the new view, number of bytes by which the content moved)."""
        source = glb.item("bufferViews", view)
        properties = {key: source[key] for key in ("byteStride", "target") if key in source}
        _, content = self._views.setdefault(span.use, (properties, bytearray()))
        content += b"\0" * (-len(content) % 4)
        moved = len(content) - span.first
        content += glb.view(view)[span.first:span.last]
        return list(self._views).index(span.use), moved


class _Span:
    def __init__(self, use: str, first: int, last: int) -> None:
        self.use, self.first, self.last = use, first, last


class _Spans:
    """The range of bytes that a mesh uses in each bufferView. No other mesh uses bytes in this range."""

    def __init__(self, glb: Glb) -> None:
        self._glb = glb
        self.of_view: Dict[int, _Span] = {}

    def take(self, index: int, use: str) -> None:
        accessor = self._glb.item("accessors", index)
        try:
            size = BYTES[FORMATS[accessor["componentType"]]] * WIDTHS[accessor["type"]]
            stride = self._glb.item("bufferViews", accessor["bufferView"]).get("byteStride", size)
            self._take(accessor["bufferView"], accessor.get("byteOffset", 0), stride * (accessor["count"] - 1) + size, use)
            sparse = accessor.get("sparse")
            if sparse is not None:
                of_index = BYTES[FORMATS[sparse["indices"]["componentType"]]]
                for part, of_one in ((sparse["indices"], of_index), (sparse["values"], size)):
                    self._take(part["bufferView"], part.get("byteOffset", 0), of_one * sparse["count"], "merges")
        except (KeyError, TypeError) as error:
            raise damaged(f"accessors[{index}] cannot be read: {error!r}") from None

    def _take(self, view: int, at: int, size: int, use: str) -> None:
        span = self.of_view.setdefault(view, _Span(use, at, at + size))
        span.first, span.last = min(span.first, at), max(span.last, at + size)
        if span.first < 0 or span.last > len(self._glb.view(view)):
            raise damaged(f"bufferViews[{view}] is too short for its accessors")


def _uses(glb: Glb, mesh: Json) -> Iterator[Tuple[Json, str, str]]:
    """Yields (object, key, use) for each accessor that the mesh refers to, in the order in which the server writes them."""
    def of_indices(holder: Json) -> str:
        return "indices16" if glb.item("accessors", holder["indices"])["componentType"] in _SHORT else "indices32"

    for primitive in mesh["primitives"]:
        for semantic in primitive["attributes"]:
            yield primitive["attributes"], semantic, semantic
        if "indices" in primitive:
            yield primitive, "indices", of_indices(primitive)
    manifold = mesh.get("extensions", {}).get("EXT_mesh_manifold")
    if manifold is not None:
        merged = manifold["manifoldPrimitive"]
        for semantic in merged["attributes"]:
            yield merged["attributes"], semantic, semantic
        yield merged, "indices", of_indices(merged)
        for key in ("mergeIndices", "mergeValues"):
            if key in manifold:
                yield manifold, key, "merges"


def _moved(accessor: Json, moved: Dict[int, Tuple[int, int]]) -> Json:
    accessor = copy.deepcopy(accessor)
    sparse = accessor.get("sparse", {})
    for part in (accessor, *(sparse[key] for key in ("indices", "values") if key in sparse)):
        view, by = moved[part["bufferView"]]
        at = part.get("byteOffset", 0) + by
        part["bufferView"] = view
        if at or part is not accessor:
            part["byteOffset"] = at
        else:
            part.pop("byteOffset", None)
    return accessor
