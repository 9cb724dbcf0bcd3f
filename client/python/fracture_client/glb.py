"""Reads and writes GLB, glTF 2.0's binary container (section 4.4), and reads its accessors as arrays.

Arrays are views of the file's bytes: numpy arrays if numpy is installed, otherwise memoryviews.
"""
from __future__ import annotations

import base64
import importlib
import json
import struct
import sys
from typing import Any, Dict, List, Tuple

from .errors import FractureError

FORMATS = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}  # componentType: type code in struct and array
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
BYTES = {"b": 1, "B": 1, "h": 2, "H": 2, "I": 4, "f": 4}

# A numpy array, or a memoryview of the same shape (.tolist() converts it to lists).
Array = Any


class Glb:
    """A parsed GLB file. All methods raise FractureError of type "damaged" if the file is malformed or refers to missing parts."""

    def __init__(self, content: bytes) -> None:
        self.content = content
        if len(content) < 20 or content[:4] != b"glTF":
            raise damaged("it does not begin with a GLB header")
        version, length = struct.unpack_from("<II", content, 4)
        if version != 2 or length != len(content):
            raise damaged(f"its header says version {version} and {length:,} bytes instead of version 2 and {len(content):,} bytes")
        at = 12
        chunks: Dict[bytes, memoryview] = {}
        while at + 8 <= length:
            size, kind = struct.unpack_from("<I4s", content, at)
            if at + 8 + size > length:
                raise damaged(f"the chunk at byte {at:,} extends past the end of the file")
            chunks.setdefault(kind, memoryview(content)[at + 8:at + 8 + size])
            at += 8 + size
        try:
            self.document: Dict[str, Any] = json.loads(bytes(chunks[b"JSON"]))
        except (KeyError, ValueError, RecursionError) as error:
            raise damaged(f"its JSON cannot be read: {error}") from None
        if not isinstance(self.document, dict):
            raise damaged("its JSON is not an object")
        self.binary: memoryview = chunks.get(b"BIN\0", memoryview(b""))

    def list(self, key: str) -> List[Any]:
        value = self.document.get(key, [])
        if not isinstance(value, list):
            raise damaged(f"'{key}' is not a list")
        return value

    def item(self, key: str, index: Any) -> Dict[str, Any]:
        items = self.list(key)
        if not isinstance(index, int) or not 0 <= index < len(items) or not isinstance(items[index], dict):
            raise damaged(f"it refers to {key}[{index}], which does not exist")
        item: Dict[str, Any] = items[index]
        return item

    def view(self, index: Any) -> memoryview:
        """Returns the bytes of a bufferView."""
        view = self.item("bufferViews", index)
        at, size = int(view.get("byteOffset", 0)), int(view["byteLength"])
        if at < 0 or size < 0 or at + size > len(self.binary):
            raise damaged(f"bufferViews[{index}] extends past the end of the file")
        return self.binary[at:at + size]

    def elements(self, index: Any) -> Tuple[memoryview, str, int]:
        """Returns (an accessor's bytes without gaps, component format, number of components per element). Does not support sparse
        accessors."""
        accessor = self.item("accessors", index)
        try:
            kind, width, count = FORMATS[accessor["componentType"]], WIDTHS[accessor["type"]], int(accessor["count"])
            size = BYTES[kind] * width
            stride = int(self.item("bufferViews", accessor["bufferView"]).get("byteStride", size))
            at = int(accessor.get("byteOffset", 0))
        except (KeyError, TypeError, ValueError) as error:
            raise damaged(f"accessors[{index}] cannot be read: {error}") from None
        view = self.view(accessor["bufferView"])
        if count < 0 or at < 0 or stride < size or (count > 0 and at + stride * (count - 1) + size > len(view)):
            raise damaged(f"accessors[{index}] extends past the end of its bufferView")
        if stride == size:
            return view[at:at + size * count], kind, width
        packed = b"".join(bytes(view[k:k + size]) for k in range(at, at + stride * count, stride))
        return memoryview(packed), kind, width

    def array(self, index: Any) -> Array:
        """Returns an accessor as an array of shape (count,) or (count, width)."""
        return as_array(*self.elements(index))


def as_array(data: memoryview, kind: str, width: int, rows: bool = False) -> Array:
    """Returns the bytes as an array of shape (count,) or (count, width). `rows`: two dimensions even if the width is 1."""
    count = len(data) // (BYTES[kind] * width)
    shape = (count, width) if width > 1 or rows else (count,)
    numpy = numpy_or_none()
    if numpy is not None:
        return numpy.frombuffer(data, dtype=f"<{kind}{BYTES[kind]}" if kind == "f" else f"<{_INTEGERS[kind]}").reshape(shape)
    if sys.byteorder == "big" and BYTES[kind] > 1:  # glTF is little-endian
        data = memoryview(struct.pack(f"={count * width}{kind}", *struct.unpack(f"<{count * width}{kind}", data)))
    if count == 0:
        return memoryview(b"").cast(kind)  # a multidimensional memoryview cannot be empty
    return data.cast(kind, list(shape))


_INTEGERS = {"b": "i1", "B": "u1", "h": "i2", "H": "u2", "I": "u4"}


def numpy_or_none() -> Any:
    """Returns the numpy module, or None if it is not installed. Imports it when the first array is
    needed, because the import is slow."""
    if not _NUMPY:
        try:
            _NUMPY.append(importlib.import_module("numpy"))
        except ImportError:
            _NUMPY.append(None)
    return _NUMPY[0]


_NUMPY: List[Any] = []


def pack(document: Dict[str, Any], binary: bytes) -> bytes:
    """Returns the bytes of a GLB. `document` must have at most one buffer, and this buffer must have no uri."""
    if binary:
        binary += b"\0" * (-len(binary) % 4)
        document = {**document, "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode("utf-8")
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        body += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def to_gltf(glb: Glb) -> bytes:
    """Returns the file as a single JSON document (glTF), with the buffer in a data URI."""
    document = dict(glb.document)
    if len(glb.binary) > 0:
        uri = "data:application/octet-stream;base64," + base64.b64encode(glb.binary).decode("ascii")
        document["buffers"] = [{"byteLength": len(glb.binary), "uri": uri}]
    return json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode("utf-8")


def damaged(what: str) -> FractureError:
    """Returns the error for a GLB that cannot be read."""
    return FractureError("damaged", f"The GLB cannot be used: {what}.")
