"""Checks an answer against the guarantees in README.md: by its certificate, and for a GLB also by its edges, seams and volumes.

Returns a list of sentences, one per broken guarantee. An empty list means that the answer is sound.
"""
import array
import json
import struct
import sys

MAX_RELATIVE_ERROR = 1e-9


def judge_figures(figures):
    """Checks the data about an answer. `figures`: the JSON object that `Accept: application/json` returns, which is also in
    extras.fracture of the GLB's root node."""
    broken = []
    certificate, report = figures["certificate"], figures.get("report", {})
    if certificate["open_edges"] != 0:
        broken.append(f"{certificate['open_edges']} open edges")
    if certificate["fragments"] < 1:
        broken.append("no fragments")
    if "barycenter" in report:  # barycenter guarantees closed fragments, but not a partition
        return broken
    if not certificate["relative_error"] <= MAX_RELATIVE_ERROR:
        broken.append(f"relative error {certificate['relative_error']:.3g}: volume {certificate['volume_in']:.9g} in, "
                      f"{certificate['volume_out']:.9g} out")
    solid = report.get("solid", {})
    if "area" in solid and "fragment" not in figures["parameters"]:
        # Invariant I2 of rounding: (h + 2^-24 size) A, where h is at most lattice.step. Pockets are not in the file.
        h = max(figures["lattice"]["step"])
        bound = 2 * (h + h) * (solid["area"] + certificate["pocket_area"]) + 1e-9 * abs(certificate["volume_in"])
        off = abs(certificate["volume_file"] + certificate["pocket_volume"] - certificate["volume_in"])
        if not off <= bound:
            broken.append(f"the volume in the file is off by {off:.3g} m3, {off / bound:.3g} times the rounding error")
    return broken


class Glb:
    """The parts of a binary glTF that the judge needs: nodes and triangle accessors."""

    def __init__(self, data):
        magic, version, length = struct.unpack_from("<4sII", data)
        if magic != b"glTF" or version != 2 or length != len(data):
            raise ValueError("it is not a GLB, or it is truncated")
        json_length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + json_length])
        self.bytes = memoryview(data)[28 + json_length:]

    def accessor(self, index):
        """Returns the accessor's numbers as a flat array."""
        a = self.json["accessors"][index]
        if "sparse" in a:
            raise ValueError("it contains a sparse accessor, which is not expected")
        view = self.json["bufferViews"][a["bufferView"]]
        code = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}[a["componentType"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[a["type"]]
        values = array.array(code)
        begin, size = view.get("byteOffset", 0) + a.get("byteOffset", 0), width * values.itemsize
        stride = view.get("byteStride", size)
        if stride == size:
            values.frombytes(self.bytes[begin:begin + a["count"] * size])
        else:
            for k in range(a["count"]):
                values.frombytes(self.bytes[begin + k * stride:begin + k * stride + size])
        if sys.byteorder == "big":
            values.byteswap()
        return values

    def root_figures(self):
        for node in self.json["nodes"]:
            if "certificate" in node.get("extras", {}).get("fracture", {}):
                return node["extras"]["fracture"]
        raise ValueError("no node contains extras.fracture.certificate")

    def fragments(self):
        """Returns (mesh, translation to the world, node) for each node with extras.fracture.id. The node of a whole instance has a
        rotation and a scale, too."""
        found, stack = [], [(n, (0.0, 0.0, 0.0)) for n in self.json["scenes"][self.json.get("scene", 0)]["nodes"]]
        while stack:
            index, at = stack.pop()
            node = self.json["nodes"][index]
            t = node.get("translation", [0, 0, 0])
            here = (at[0] + t[0], at[1] + t[1], at[2] + t[2])
            if "id" in node.get("extras", {}).get("fracture", {}) and "mesh" in node:
                found.append((self.json["meshes"][node["mesh"]], here, node))
            stack += [(child, here) for child in node.get("children", [])]
        return found

    def box(self):
        """Returns the bounding box of all fragments, from the bounds in the accessors."""
        low, high = [float("inf")] * 3, [-float("inf")] * 3
        for mesh, at, node in self.fragments():
            for primitive in mesh["primitives"]:
                a = self.json["accessors"][primitive["attributes"]["POSITION"]]
                corners = [a["min"], a["max"]]
                if is_turned(node):
                    p = self.accessor(primitive["attributes"]["POSITION"])
                    corners = [turned(p[k:k + 3], node) for k in range(0, len(p), 3)]
                for corner in corners:
                    low = [min(l, m + t) for l, m, t in zip(low, corner, at)]
                    high = [max(h, m + t) for h, m, t in zip(high, corner, at)]
        return low, high


def is_turned(node):
    return "rotation" in node or "scale" in node


def turned(point, node):
    """Returns a point after the node's rotation and scale."""
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    a, b, c = (p * s for p, s in zip(point, node.get("scale", (1, 1, 1))))
    return (a + 2 * (-(y * y + z * z) * a + (x * y - w * z) * b + (x * z + w * y) * c),
            b + 2 * ((x * y + w * z) * a - (x * x + z * z) * b + (y * z - w * x) * c),
            c + 2 * ((x * z - w * y) * a + (y * z + w * x) * b - (x * x + y * y) * c))


def judge_glb(data):
    """Checks that edges are closed after welding, volumes are positive, the two sides of cuts match bit for bit, and the sum is right."""
    try:
        glb = Glb(data)
        figures = glb.root_figures()
    except (ValueError, KeyError, struct.error) as e:
        return [f"the GLB cannot be read: {e}"]
    broken = judge_figures(figures)
    report, certificate = figures.get("report", {}), figures["certificate"]
    if not isinstance(figures.get("interior_materials"), list):
        return broken + ["the list interior_materials is missing"]
    interior = set(figures["interior_materials"])
    seams, volume, unclosed, inverted, inexact = {}, 0.0, 0, 0, 0
    for mesh, at, node in glb.fragments():
        balance, six = {}, 0.0
        for primitive in mesh["primitives"]:
            p = glb.accessor(primitive["attributes"]["POSITION"])
            corner = [(p[3 * k], p[3 * k + 1], p[3 * k + 2]) for k in range(len(p) // 3)]
            if is_turned(node):
                corner = [turned(point, node) for point in corner]
            index = glb.accessor(primitive["indices"])
            cut = primitive.get("material") in interior
            for k in range(0, len(index), 3):
                a, b, c = corner[index[k]], corner[index[k + 1]], corner[index[k + 2]]
                six += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                        + a[2] * (b[0] * c[1] - b[1] * c[0]))
                for u, v in ((a, b), (b, c), (c, a)):
                    if u != v:
                        key = (u, v) if u < v else (v, u)
                        balance[key] = balance.get(key, 0) + (1 if u < v else -1)
                if cut:
                    t = [tuple(x + y for x, y in zip(q, at)) for q in (a, b, c)]
                    k0 = t.index(min(t))
                    key, mirrored = (t[k0], t[k0 - 2], t[k0 - 1]), (t[k0], t[k0 - 1], t[k0 - 2])
                    if seams.get(mirrored, 0) > 0:
                        seams[mirrored] -= 1
                    else:
                        seams[key] = seams.get(key, 0) + 1
        # The sum of a float and a multiple of the lattice's step is exact in double precision. It must fit into a float.
        inexact += any(struct.unpack("<f", struct.pack("<f", c))[0] != c for c in at)
        unclosed += any(balance.values())
        inverted += not six > 0
        volume += six / 6
    if unclosed:
        broken.append(f"{unclosed} fragments have open edges after welding")
    if inverted:
        broken.append(f"{inverted} fragments do not have a positive volume")
    if inexact:
        broken.append(f"{inexact} translations are not exact as floats")
    if "barycenter" in report or "delta" in figures or "fragment" in figures["parameters"]:
        return broken
    solid = report.get("solid", {})
    unpaired = sum(seams.values())
    # Filled holes and the backs of sheets have the cut faces' material, but no mirror image.
    if unpaired and not solid.get("holes_filled") and not solid.get("sheets_thickened"):
        broken.append(f"{unpaired} interior triangles have no mirror image")
    # Vertices of whole instances are up to about eight lattice steps from those that the certificate describes.
    moved = 8 * max(figures["lattice"]["step"]) * certificate["area_out"] if "instances" in report else 0
    if abs(volume - certificate["volume_file"]) > 1e-6 * abs(certificate["volume_file"]) + moved:
        broken.append(f"the file contains {volume:.9g} m3, its certificate says {certificate['volume_file']:.9g}")
    return broken
