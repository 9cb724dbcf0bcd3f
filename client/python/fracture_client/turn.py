"""The rotation and uniform scale of an unbroken instance's node (parameter instances=keep)."""
from __future__ import annotations

import struct
from typing import Any, Dict, List, Optional, Tuple

from .glb import Array, as_array, numpy_or_none

Quaternion = Tuple[float, float, float, float]


class Turn:
    """Rotates and scales arrays from a node's frame to the scene's axes. The node's translation is not applied."""

    def __init__(self, rotation: Quaternion, scale: float) -> None:
        x, y, z, w = rotation
        self.rotation, self.scale = rotation, scale
        self.rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
                     (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
                     (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))

    def attribute(self, semantic: str, data: memoryview, kind: str, width: int) -> Array:
        """Returns a rotated copy of positions, normals or tangents. Positions are also scaled. Other attributes do not change."""
        if semantic not in ("POSITION", "NORMAL", "TANGENT"):
            return as_array(data, kind, width)
        scale = self.scale if semantic == "POSITION" else 1.0
        rows = [[scale * value for value in row] for row in self.rows]
        numpy = numpy_or_none()
        if numpy is not None:
            turned = numpy.array(as_array(data, kind, width))
            turned[:, :3] = turned[:, :3].astype("f8") @ numpy.array(rows).T
            return turned
        values: List[float] = list(struct.unpack(f"<{len(data) // 4}f", data))
        for at in range(0, len(values), width):
            point = values[at:at + 3]
            values[at:at + 3] = [sum(a * b for a, b in zip(row, point)) for row in rows]
        return as_array(memoryview(struct.pack(f"<{len(values)}f", *values)), kind, width)

    def orientation(self, inner: Quaternion) -> Quaternion:
        """Converts a rotation from the node's frame to the scene's."""
        (x, y, z, w), (a, b, c, d) = self.rotation, inner
        return (w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a,
                w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c)


def turn_of(node: Dict[str, Any]) -> Optional[Turn]:
    """Returns the rotation and scale of a node; None if it has neither."""
    if "rotation" not in node and "scale" not in node:
        return None
    x, y, z, w = (float(value) for value in node.get("rotation", (0, 0, 0, 1)))
    return Turn((x, y, z, w), float(node.get("scale", (1, 1, 1))[0]))
