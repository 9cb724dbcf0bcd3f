# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts a parameter of the interface to a Blender value and back, according to its entry in the server's table.

Blender values use Blender's axes and units: a length is in Blender units, and a vector has z up. The entry's unit and shape, never
its name, show whether the value is a length, a point or a direction.
"""
import re
import struct

from .frame import short, turned, turned_back, turned_matrix, turned_matrix_back

MOST_INTEGER = 2 ** 31 - 1  # Blender's largest integer
LENGTHS = {"m": 1, "m²": 2, "m³": 3, "m/s²": 1}  # unit: exponent of the length in it
COLOR = "^#[0-9a-fA-F]{6}$"

# Parameters that users cannot set, because the add-on could not read the answer with other values.
OWN = {
    "format": "the mesh is always sent as GLB",
    "unit": "the scene's units are applied before sending",
    "up": "z up is converted to y up before sending",
    "pivot": "the origin of each fragment is its centre of mass",
    "intact": "the unbroken mesh is in the scene already",
    "of": "each request is complete and refers to no earlier answer",
    "delta": "the add-on needs all fragments",
    "local_new": "this parameter is used only with delta",
}


class Parameter:
    """A parameter. `kind`: integer, number, enum, text, color, vector, box, matrix or list. Users edit lists as text."""

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
        """True for a vector of side lengths. Side lengths cannot be negative, so axes are swapped without changing signs."""
        return self.kind == "vector" and self.entry["items"].get("minimum", -1) >= 0

    def to_request(self, value, frame):
        """Converts a Blender value to the value that is sent."""
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
        """Converts a value of the interface, such as a default or a material's value, to a Blender value."""
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
        """Reads a list of numbers or vectors. Text that cannot be read is sent as is, and the server reports the error."""
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
    """Returns a dictionary, by name, of the parameters that become properties of the scene."""
    return {name: Parameter(entry) for name, entry in description.parameters.items() if name not in OWN}


def single(value):
    """Returns the nearest number in single precision, the precision that Blender uses."""
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
    if kind == "integer":  # a large integer without a default is an id, and may exceed Blender's integers
        return "text" if entry.get("maximum", 0) > MOST_INTEGER and "default" not in entry else "integer"
    if kind == "string":
        if "enum" in entry:
            return "enum"
        return "color" if entry.get("pattern") == COLOR else "text"
    return "number"


def _text(value):
    return ",".join(map(_text, value)) if isinstance(value, (list, tuple)) else f"{value:g}" if isinstance(value, float) else str(value)
