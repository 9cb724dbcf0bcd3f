# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts between the coordinate frames (axes and units) of Blender and the interface.

Blender: z is up, and a Blender unit is `scale_length` metres. The interface (like glTF): y is up, and lengths are in metres.

    x = s X        X = x / s
    y = s Z        Y = -z / s
    z = -s Y       Z = y / s

This is a rotation, so a right-handed frame stays right-handed and triangles keep their winding.
"""
import math


class Frame:
    """Converts values between the two frames. `scale`: metres per Blender unit (scene.unit_settings.scale_length)."""

    def __init__(self, scale=1.0):
        self.scale = short(scale)

    @classmethod
    def of(cls, scene):
        """Returns a scene's coordinate frame. If the scene's unit system is None, a Blender unit is a metre, and `scale_length` is
        ignored."""
        units = scene.unit_settings
        return cls(1.0 if units.system == "NONE" else units.scale_length)

    def length(self, value, power=1):
        """Converts a length from Blender units to metres. `power`: 2 for an area, 3 for a volume."""
        return value * self.scale ** power

    def length_back(self, value, power=1):
        return value / self.scale ** power

    def point(self, value):
        x, y, z = value
        return [x * self.scale, z * self.scale, 0.0 - y * self.scale]  # 0 - y: never -0

    def point_back(self, value):
        x, y, z = value
        return (x / self.scale, 0.0 - z / self.scale, y / self.scale)

    def box(self, corners):
        """Converts a box, given by two corners. Returns the lowest and highest corner. They are computed again, because the rotation
        reverses one axis."""
        a, b = (self.point(corner) for corner in corners)
        return [[min(p, q) for p, q in zip(a, b)], [max(p, q) for p, q in zip(a, b)]]

    def node_matrix(self, world):
        """Returns a matrix_world as the 16 numbers (column-major) of a glTF node. The matrix applies to positions converted by
        turned()."""
        across, depth, height, _ = ([float(value) for value in row] for row in world)
        rows = [across, height, [-value for value in depth]]  # rows: the matrix's results, in the interface's frame
        columns = zip(*((row[0], row[2], -row[1], row[3]) for row in rows))  # columns: its arguments, in the interface's frame too
        return [value for number, column in enumerate(columns)
                for value in (*(0.0 + entry * self.scale for entry in column), 1.0 if number == 3 else 0.0)]


def turned(vector):
    """Converts a Blender direction to the interface's axes (y up). Its length is unchanged."""
    x, y, z = vector
    return [x, z, 0.0 - y]


def turned_back(vector):
    x, y, z = vector
    return (x, 0.0 - z, y)


def turned_matrix(rows):
    """Converts a linear map M from Blender's frame to the interface's: returns C M C^T, where C is the rotation between the frames."""
    columns = list(zip(*[turned(column) for column in zip(*rows)]))  # C M
    return [turned(row) for row in columns]  # (C M) C^T: each row times C^T is the row turned


def turned_matrix_back(rows):
    columns = list(zip(*[turned_back(column) for column in zip(*rows)]))
    return [list(turned_back(row)) for row in columns]


def short(value):
    """Returns a single-precision number from Blender as the user typed it: 0.3, not 0.30000001192092896."""
    if not math.isfinite(value):
        return value
    return float(f"{value:.7g}")
