"""Small meshes made in code, and one request for every pattern, material and kind of answer: the requests that
golden_bytes.py hashes.

Coordinates are decimals of at most six digits, so that they do not depend on the sine function of a C library.
"""
import json
import math
import struct


def quads_of_box(low, high):
    """Returns the six faces of a box, each as four corners that are counter-clockwise if seen from outside."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return [
        [(x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)],
        [(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)],
        [(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)],
        [(x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)],
        [(x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)],
        [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
    ]


def obj_of_boxes(*boxes):
    """Returns an OBJ with an object, UVs and two materials for each box."""
    lines, corners = [], 0
    for number, (low, high) in enumerate(boxes):
        lines.append(f"o box_{number}")
        for side, quad in enumerate(quads_of_box(low, high)):
            lines.append(f"usemtl {'side' if side < 4 else 'front'}_{number}")
            lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in quad]
            lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
            a, b, c, d = (corners + k for k in (1, 2, 3, 4))
            lines.append(f"f {a}/{a} {b}/{b} {c}/{c} {d}/{d}")
            corners += 4
    return "\n".join(lines) + "\n"


def obj_of_sphere(slices=16, stacks=10):
    """Returns a sphere of radius 1 around (3, 0.5, -2). That is far enough from the origin for positions to be rounded.
    """
    lines = ["o sphere", "v 3 1.5 -2"]
    for stack in range(1, stacks):
        for column in range(slices):
            polar, turn = math.pi * stack / stacks, 2 * math.pi * column / slices
            x, y, z = math.sin(polar) * math.cos(turn), math.cos(polar), -math.sin(polar) * math.sin(turn)
            lines.append(f"v {3 + x:.6f} {0.5 + y:.6f} {-2 + z:.6f}")
    lines.append("v 3 -0.5 -2")
    last = (stacks - 1) * slices + 2
    for column in range(slices):
        following = (column + 1) % slices
        lines.append(f"f 1 {2 + column} {2 + following}")
        for stack in range(stacks - 2):
            above, below = 2 + stack * slices, 2 + (stack + 1) * slices
            lines.append(f"f {above + column} {below + column} {below + following} {above + following}")
        lines.append(f"f {last} {2 + (stacks - 2) * slices + following} {2 + (stacks - 2) * slices + column}")
    return "\n".join(lines) + "\n"


def glb_of_box():
    """Returns a box with normals, tangents, UVs and vertex colours."""
    attributes = {"POSITION": (3, []), "NORMAL": (3, []), "TANGENT": (4, []), "TEXCOORD_0": (2, []), "COLOR_0": (4, [])}
    indices = []
    for quad in quads_of_box((-0.5, 0, -0.25), (0.5, 1, 0.25)):
        along = [q - p for p, q in zip(quad[0], quad[1])]
        up = [q - p for p, q in zip(quad[0], quad[3])]
        normal = [along[1] * up[2] - along[2] * up[1], along[2] * up[0] - along[0] * up[2], along[0] * up[1] - along[1] * up[0]]

        def unit(vector):
            # Each edge of a box is parallel to an axis, so one component is its whole length.
            return [0.0 if not c else math.copysign(1.0, c) for c in vector]

        first = len(attributes["POSITION"][1])
        for corner, uv in zip(quad, [(0, 0), (1, 0), (1, 1), (0, 1)]):
            attributes["POSITION"][1].append(corner)
            attributes["NORMAL"][1].append(unit(normal))
            attributes["TANGENT"][1].append(unit(along) + [1.0])
            attributes["TEXCOORD_0"][1].append(uv)
            attributes["COLOR_0"][1].append((uv[0], uv[1], 0.5, 1.0))
        indices += [first + k for k in (0, 1, 2, 0, 2, 3)]
    binary, views, accessors, names = b"", [], [], {}
    for name, (width, rows) in attributes.items():
        data = b"".join(struct.pack(f"<{width}f", *row) for row in rows)
        names[name] = len(accessors)
        accessor = {"bufferView": len(views), "componentType": 5126, "count": len(rows), "type": "SCALAR VEC2 VEC3 VEC4".split()[width - 1]}
        if name == "POSITION":
            accessor |= {"min": [min(r[k] for r in rows) for k in range(3)], "max": [max(r[k] for r in rows) for k in range(3)]}
        accessors.append(accessor)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data
    data = struct.pack(f"<{len(indices)}H", *indices)
    accessors.append({"bufferView": len(views), "componentType": 5123, "count": len(indices), "type": "SCALAR"})
    views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
    binary += data
    primitive = {"attributes": names, "indices": len(accessors) - 1, "material": 0}
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "box"}],
        "meshes": [{"primitives": [primitive]}], "materials": [{"name": "paint"}],
        "buffers": [{"byteLength": len(binary)}], "bufferViews": views, "accessors": accessors}).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


MESHES = {
    "box.obj": obj_of_boxes(((0, 0, 0), (1, 1, 1))),
    "pane.obj": obj_of_boxes(((-1, 0, 0), (1, 1.5, 0.02))),
    "wall.obj": obj_of_boxes(((0, 0, 0), (3, 2, 0.3))),
    "table.obj": obj_of_boxes(((-1, 0.7, -0.5), (1, 0.75, 0.5)), *[
        ((x, 0, z), (x + 0.06, 0.72, z + 0.06)) for x in (-0.95, 0.89) for z in (-0.45, 0.39)]),
    "sphere.obj": obj_of_sphere(),
    "sheet.obj": "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0.2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n",
    "painted.glb": glb_of_box(),
}

HITS = {"local_point": [[3, 1.5, -2], [3.9, 0.5, -2]], "local_radius": [0.5, 0.4], "local_sites": [12, 9], "local_rest": "fractured"}

# Maps the name of the output without .glb (or with the ending of another format) to the mesh and the parameters.
REQUESTS = {
    "uniform": ("sphere.obj", {"sites": 40}),
    "uniform_lloyd_grain": ("box.obj", {"sites": 30, "lloyd": 3, "stretch": 3, "grain": [1, 2, -0.5]}),
    "points": ("box.obj", {"pattern": "points", "points": [[0.2, 0.2, 0.2], [0.8, 0.2, 0.3], [0.5, 0.9, 0.5], [0.5, 0.5, 0.5]]}),
    "impact": ("sphere.obj", {"pattern": "impact", "sites": 40, "impacts": [[3, 1.5, -2]]}),
    "radial": ("pane.obj", {"pattern": "radial", "sites": 40, "impacts": [[0.1, 0.8, 0.01]]}),
    "grid": ("box.obj", {"pattern": "grid", "sites": 27, "jitter": 0.3}),
    "brick": ("wall.obj", {"pattern": "brick", "sites": 40, "impacts": [[1.5, 1, 0.3]], "mortar": "#b9b4a8"}),
    "slice": ("sphere.obj", {"pattern": "slice", "sites": 20, "normals": [[1, 0.3, 0], [0, 1, 0.2]]}),
    "clustered": ("sphere.obj", {"pattern": "clustered", "sites": 60}),
    "glass": ("pane.obj", {"material": "glass", "fragments": 30, "impacts": [[0, 0.5, 0]]}),
    "wood": ("table.obj", {"material": "wood", "fragments": 20}),
    "concrete": ("wall.obj", {"material": "concrete", "fragments": 20}),
    "stone": ("sphere.obj", {"material": "stone", "fragments": 20}),
    "brick_wall": ("wall.obj", {"material": "brick", "fragments": 25}),
    "ceramic": ("sphere.obj", {"material": "ceramic", "fragments": 20}),
    "metal": ("box.obj", {"material": "metal", "fragments": 15}),
    "cast_iron": ("table.obj", {"material": "cast_iron", "fragments": 20}),
    "ice": ("sphere.obj", {"material": "ice", "fragments": 25, "impacts": [[3, 1.5, -2]]}),
    "plaster": ("wall.obj", {"material": "plaster", "fragments": 20}),
    "terracotta": ("sphere.obj", {"material": "terracotta", "fragments": 20}),
    "sandstone": ("box.obj", {"material": "sandstone", "fragments": 20}),
    "crystal": ("box.obj", {"material": "crystal", "fragments": 20}),
    "shell": ("sphere.obj", {"shell": 0.1, "sites": 30}),
    "thickness": ("sheet.obj", {"thickness": 0.05, "sites": 12}),
    "rough": ("sphere.obj", {"sites": 25, "rough_amplitude": 0.04, "rough_octaves": 3}),
    "aggregates": ("box.obj", {"sites": 10, "cells_per_fragment": 6}),
    "limits": ("sphere.obj", {"sites": 60, "min_of_mean": 0.5, "max_fragments": 30, "max_volume": 0.4}),
    "keep": ("box.obj", {"sites": 50, "keep_box": [[0, 0, 0], [0.4, 0.4, 0.4]]}),
    "hits": ("sphere.obj", {"sites": 25, **HITS}),
    "delta": ("sphere.obj", {"sites": 25, **HITS, "delta": "only", "mass": 12}),
    "levels": ("box.obj", {"levels": [3, 10, 30], "anchor_plane": [[0, 0.05, 0], [0, 1, 0]]}),
    "barycenter": ("box.obj", {"dual": "barycenter", "sites": 25}),
    "detail": ("painted.glb", {"sites": 15, "interior_detail": "stone", "interior_color": "#806040"}),
    "painted": ("painted.glb", {"sites": 20, "density_from": "COLOR_0", "pivot": "source"}),
    "omi_and_ucx": ("box.obj", {"sites": 12, "physics": "omi", "ue_collision": "ucx"}),
    "json.gltf": ("box.obj", {"sites": 12, "interior": "plain"}),
    "objects.obj": ("table.obj", {"sites": 12}),
    "faces.ply": ("painted.glb", {"sites": 12}),
    "solid.stl": ("sphere.obj", {"sites": 12}),
}
