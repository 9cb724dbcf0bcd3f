"""A glTF file for tests of bake: a box, and a camera, which no answer contains."""
import base64
import json
import struct

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def box_with_camera(missing=0):
    """Returns the text of the file. `missing`: number of triangles left out of the 12."""
    triangles = [(face[0], face[k], face[k + 1]) for face in FACES for k in (1, 2)][:12 - missing]
    corners = [corner for triangle in triangles for corner in triangle]
    buffer = struct.pack("<24f", *(c for corner in CORNERS for c in corner)) + struct.pack(f"<{len(corners)}H", *corners)
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "name": "box"}, {"camera": 0, "name": "eye <1>"}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                      {"bufferView": 1, "componentType": 5123, "count": len(corners), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 2 * len(corners)}],
        "buffers": [{"byteLength": len(buffer),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()}]})
