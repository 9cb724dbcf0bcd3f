# SPDX-License-Identifier: GPL-3.0-or-later
"""A parameter of the interface as a value of Blender, and back. How, is told by its entry in the server's table.

Blender's values are in Blender's frame and units: a length is in Blender units, a vector has z up. What is a length, a place or
a direction, is told by the unit and the shape of the entry, never by its name.
"""
import re
import struct

from .frame import short, turned, turned_back, turned_matrix, turned_matrix_back

MOST_INTEGER = 2 ** 31 - 1  # of Blender
LENGTHS = {"m": 1, "m²": 2, "m³": 3, "m/s²": 1}  # unit: power of a length in it
COLOR = "^#[0-9a-fA-F]{6}$"

# What the add-on itself says, because what comes back would be none of its fragments otherwise.
OWN = {
    "format": "the mesh is sent as GLB",
    "unit": "the scene's units are applied before it is sent",
    "up": "z is turned to y before it is sent",
    "pivot": "the origin of each fragment is its centre of mass",
    "of": "a request says everything, and names no earlier answer",
    "delta": "all fragments come back",
    "local_new": "it goes with delta",
}


class Parameter:
    """`kind`: integer, number, enum, text, color, vector, box, matrix, or list: one of numbers or of vectors, as text."""

    def __init__(self, entry):
        self.name = entry["name"]
        self.entry = entry
        self.description = entry.get("description", "").replace("`", "'")
        self.unit = entry.get("unit", "")
        self.power = LENGTHS.get(self.unit, 0)
        self.kind = _kind(entry)
        self.most = entry.get("maximum")
        self.least = entry.get("minimum")
        self.default = entry.get("default")

    @property
    def is_size(self):
        """A vector of sides, none of which can be negative: turned without a sign."""
        return self.kind == "vector" and self.entry["items"].get("minimum", -1) >= 0

    def to_request(self, value, frame):
        """What is sent for what Blender has."""
        if self.kind == "number":
            return short(frame.length(short(value), self.power))
        if self.kind == "color":
            return "#" + "".join(f"{round(255 * min(1.0, max(0.0, channel))):02x}" for channel in value)
        if self.kind == "vector":
            return self._vector(value, frame)
        if self.kind == "box":
            rows = [value[:3], value[3:]]
            return frame.box([[short(v) for v in row] for row in rows])
        if self.kind == "matrix":
            return [[short(v) for v in row] for row in turned_matrix([value[0:3], value[3:6], value[6:9]])]
        if self.kind == "list":
            return self._list(value, frame)
        if self.kind == "text" and self.entry["type"] == "integer":
            return int(value) if re.fullmatch(r"\d+", value.strip()) else value
        return value

    def to_blender(self, value, frame):
        """What Blender has for a value of the interface: a default, or what a material sets."""
        if self.kind == "number":
            return frame.length_back(value, self.power)
        if self.kind == "integer":
            return min(int(value), MOST_INTEGER)
        if self.kind == "color":
            return [int(value[at:at + 2], 16) / 255 for at in (1, 3, 5)]
        if self.kind == "vector":
            return [frame.length_back(entry, self.power) for entry in self._back(value)]
        if self.kind == "box":
            return [entry for corner in value for entry in frame.point_back(corner)]
        if self.kind == "matrix":
            return [entry for row in turned_matrix_back(value) for entry in row]
        if self.kind == "list":
            return ";".join(_text(self._back(entry) if isinstance(entry, list) else entry) for entry in value) \
                if value and isinstance(value[0], list) else ",".join(map(_text, value))
        return value if self.kind == "enum" else str(value)

    def _vector(self, value, frame):
        x, y, z = (frame.length(short(entry), self.power) for entry in value)
        return [short(entry) for entry in ((x, z, y) if self.is_size else turned((x, y, z)))]

    def _back(self, value):
        x, y, z = value
        return (x, z, y) if self.is_size else turned_back((x, y, z))

    def _list(self, text, frame):
        """Lists and vectors of a text. One that cannot be read is sent as it is: the server says what is wrong with it."""
        try:
            rows = [[float(entry) for entry in row.split(",")] for row in text.strip().strip(";").split(";")]
        except ValueError:
            return text
        if self.entry["items"]["type"] == "array":
            return [self._vector(row, frame) for row in rows] if all(len(row) == 3 for row in rows) else text
        values = [value for row in rows for value in row]
        if self.entry["items"]["type"] == "integer":
            exact = [entry.strip() for entry in text.replace(";", ",").split(",") if entry.strip()]
            return [int(entry) for entry in exact] if all(re.fullmatch(r"-?\d+", entry) for entry in exact) else text
        return [frame.length(value, self.power) for value in values]


def sendable(description):
    """The parameters that have a property, by name."""
    return {name: Parameter(entry) for name, entry in description.parameters.items() if name not in OWN}


def single(value):
    """The nearest number that Blender can keep."""
    largest = 3.4028234663852886e38
    return struct.unpack("f", struct.pack("f", min(largest, max(-largest, value))))[0]


def _kind(entry):
    kind = entry["type"]
    if kind == "array":
        rows, fixed = entry["items"]["type"] == "array", entry.get("minItems") == entry.get("maxItems")
        if rows and fixed and entry["minItems"] == 3:
            return "matrix"
        if rows and fixed and entry["minItems"] == 2 and entry.get("unit") == "m":
            return "box"
        return "vector" if fixed and not rows and entry["minItems"] == 3 else "list"
    if kind == "integer":  # a number without a default is an id, which may have more digits than Blender's integers
        return "text" if entry.get("maximum", 0) > MOST_INTEGER and "default" not in entry else "integer"
    if kind == "string":
        if "enum" in entry:
            return "enum"
        return "color" if entry.get("pattern") == COLOR else "text"
    return "number"


def _text(value):
    return ",".join(map(_text, value)) if isinstance(value, (list, tuple)) else f"{value:g}" if isinstance(value, float) else str(value)
