"""Random requests for scripts/sweep, drawn from a seed within the ranges of GET /limits and /patterns, to suit a given mesh."""
import hashlib
import json
import math
import os
import random
import re
import shlex
import urllib.parse

# Parameters that refer to a particular answer, or that the file name determines.
NOT_DRAWN = {"format", "of", "broken", "fragment", "fragment_sites", "fragment_seed", "delta", "local_new"}
# Parameters that must be given together or not at all.
TOGETHER = {"local_point": "local_radius", "local_radius": "local_point",
            "keep_center": "keep_radius", "keep_radius": "keep_center"}
CONTENT_TYPES = {"glb": "model/gltf-binary", "gltf": "model/gltf+json", "obj": "model/obj", "stl": "model/stl"}


class MeshFile:
    """A mesh file, the files that it refers to, and the data that a first request returned about the mesh."""

    def __init__(self, folder, path):
        self.path = path
        self.name = os.path.relpath(path, folder)
        self.siblings = _siblings(path)
        self.low, self.high = [-0.5] * 3, [0.5] * 3  # bounding box of the fragments, in metres
        self.volume = 1.0  # m³
        self.nodes, self.materials = [], []
        self.usable = False  # True if it can be fractured without further parameters

    def size(self):
        return max(h - l for l, h in zip(self.low, self.high)) or 1.0

    def parts(self):
        """Yields (field, file name, path) for each part of a form."""
        yield "mesh", os.path.basename(self.path), self.path
        for name, path in self.siblings:
            yield "file", name, path


def _siblings(path):
    """Returns (name as written in the glTF or OBJ, path) for each existing file that the glTF or OBJ refers to."""
    folder, found = os.path.dirname(path), []
    if path.endswith(".gltf"):
        with open(path, encoding="utf-8") as f:
            document = json.load(f)
        found = [e["uri"] for kind in ("buffers", "images") for e in document.get(kind, []) if "uri" in e]
    elif path.endswith(".obj"):
        with open(path, encoding="utf-8", errors="replace") as f:
            found = re.findall(r"^mtllib\s+(\S+)", f.read(), re.M)
    pairs = {}
    for name in found:
        name = urllib.parse.unquote(name)
        if not name.startswith("data:") and os.path.isfile(os.path.join(folder, name)):
            pairs[name] = os.path.join(folder, name)
    return sorted(pairs.items())


def mesh_files(folders, extensions):
    """Returns all files with these extensions, in a fixed order. Folders are separated by ':'."""
    files = []
    for folder in folders.split(":"):
        for root, _, names in sorted(os.walk(folder)):
            files += [MeshFile(folder, os.path.join(root, name)) for name in sorted(names)
                      if name.rsplit(".", 1)[-1].lower() in extensions]
    return files


class Request:
    """A mesh and parameters. form() and the curl command send the same request."""

    def __init__(self, mesh, parameters):
        self.mesh, self.parameters = mesh, parameters

    def form(self):
        """Returns (body, content type) of the multipart form."""
        boundary = "sweep" + hashlib.sha256(self.mesh.name.encode()).hexdigest()[:24]
        pieces = []
        for field, name, path in self.mesh.parts():
            with open(path, "rb") as f:
                pieces.append((f'name="{field}"; filename="{name}"', "application/octet-stream", f.read()))
        if self.parameters is not None:
            pieces.append(('name="params"', "application/json", json.dumps(self.parameters).encode()))
        body = b"".join(f"--{boundary}\r\nContent-Disposition: form-data; {head}\r\nContent-Type: {kind}\r\n\r\n".encode()
                        + data + b"\r\n" for head, kind, data in pieces) + f"--{boundary}--\r\n".encode()
        return body, f"multipart/form-data; boundary={boundary}"

    def curl(self, server, accept):
        words = ["curl", "--fail-with-body", "-sS"]
        for field, name, path in self.mesh.parts():
            words += ["-F", f"{field}=@{os.path.abspath(path)};filename={name}"]
        words += ["-F", f"params={json.dumps(self.parameters)};type=application/json"]
        words += ["-H", f"Accept: {accept}", f"{server}/fracture"]
        return " ".join(map(shlex.quote, words))


class Generator:
    """Draws requests. Request k depends only on seed, k, the server's parameters and the meshes."""

    def __init__(self, patterns, limits, seed, max_sites):
        self.seed, self.max_sites = seed, max_sites
        self.of_pattern = {p["name"]: {q["name"]: q for q in p["parameters"]} for p in patterns["patterns"]}
        not_everywhere = NOT_DRAWN.union(*self.of_pattern.values())
        self.everywhere = {p["name"]: p for p in limits["parameters"] if p["name"] not in not_everywhere}
        self.materials = {m["name"]: m["parameters"] for m in patterns["materials"]}

    def draw(self, k, meshes):
        rng = random.Random(f"{self.seed}:{k}")
        mesh = meshes[rng.randrange(len(meshes))]
        given = {}
        if rng.random() < 0.6:
            given["material"] = rng.choice(sorted(self.materials))
        pattern = self.materials.get(given.get("material"), {}).get("pattern", "uniform")
        if rng.random() < 0.4:
            given["pattern"] = pattern = rng.choice(sorted(self.of_pattern))
        given["seed"] = rng.randrange(2 ** 53)
        own = self.of_pattern[pattern]
        if "sites" in own:
            given["sites"] = min(int(math.exp(rng.uniform(0, math.log(self.max_sites + 1)))), self.max_sites)
        if pattern == "points":
            given["points"] = self._value(rng, own["points"], mesh)
        # Some requests get one or two further parameters, others many.
        share = rng.choice([0.0, 0.03, 0.08, 0.2])
        for name, spec in sorted({**self.everywhere, **own}.items()):
            if name in given or name in ("material", "pattern") or rng.random() >= share:
                continue
            value = self._value(rng, spec, mesh)
            if value is not None:
                given[name] = value
        for name, other in TOGETHER.items():
            if name in given and other not in given:
                given[other] = self._value(rng, {**self.everywhere, **own}[other], mesh)
        if "levels" in given:  # `levels` replaces `sites`
            given.pop("sites", None)
        if "local_point" in given and rng.random() < 0.4:
            given["delta"] = rng.choice(["stated", "only"])
        if not mesh.usable and "thickness" not in given and rng.random() < 0.5:
            given["thickness"] = self._value(rng, self.everywhere["thickness"], mesh)
        if given.get("thickness") and "sheets" in given:  # other sheets have no thickness
            given["sheets"] = "solid"
        return Request(mesh, given)

    def _value(self, rng, spec, mesh):
        name = spec["name"]
        if name in ("nodes", "materials", "interior_material"):
            known = mesh.nodes if name == "nodes" else mesh.materials
            if not known:
                return None
            one = str(rng.randrange(len(known)))
            return one if name == "interior_material" else [one]
        if "enum" in spec:
            return rng.choice(spec["enum"])
        if spec["type"] == "integer":
            return _whole(rng, spec, self.max_sites)
        if spec["type"] == "number":
            return _number(rng, spec, mesh)
        if spec["type"] == "array":
            return self._list(rng, spec, mesh)
        if "pattern" in spec:  # a colour
            return f"#{rng.randrange(1 << 24):06x}"
        return "sweep"

    def _list(self, rng, spec, mesh):
        items, least, most = spec["items"], spec.get("minItems", 1), spec.get("maxItems", 1)
        if items["type"] != "array" and least == most == 3:  # one vector
            return _vector(rng, items, mesh, spec.get("unit") == "m")
        if items["type"] == "integer":
            values = [_whole(rng, items, self.max_sites) for _ in range(min(rng.randint(1, 4), most))]
            return sorted(set(values)) if spec["name"] == "levels" else values[:1]
        if items["type"] == "number":
            return [_number(rng, {**items, "unit": spec.get("unit")}, mesh)]
        if items["type"] != "array":
            return None
        if least == most == 3:  # a matrix near the identity, so that it is invertible
            return [[(1.0 if r == c else 0.0) + rng.uniform(-0.3, 0.3) for c in range(3)] for r in range(3)]
        count = least if least == most else rng.randint(least, min(most, max(least, 60 if most > 1000 else 4)))
        places = spec.get("unit") == "m" or "point" in spec["name"]
        vectors = [_vector(rng, items["items"], mesh, places) for _ in range(count)]
        if spec["name"].endswith("_box"):
            vectors = [[min(p) for p in zip(*vectors)], [max(p) for p in zip(*vectors)]]
        if spec["name"].endswith("_plane"):
            vectors = [_vector(rng, items["items"], mesh, True), _vector(rng, items["items"], mesh, False)]
        return vectors


def _clip(value, spec):
    return max(spec.get("minimum", -math.inf), min(spec.get("maximum", math.inf), value))


def _whole(rng, spec, cap):
    low, high = spec["minimum"], spec["maximum"]
    if high > 2 ** 40:  # a seed
        return rng.randrange(low, high + 1)
    if rng.random() < 0.1:
        return low
    low_log, high_log = math.log(max(low, 1)), math.log(max(min(high, max(cap, 2)), 1))
    return int(_clip(round(math.exp(rng.uniform(low_log, max(high_log, low_log)))), spec))


def _number(rng, spec, mesh):
    if rng.random() < 0.05:
        return float(rng.choice([spec["minimum"], spec.get("default", spec["minimum"])]))
    unit, maximum = spec.get("unit"), spec["maximum"]
    if unit == "m":
        value = mesh.size() * 10 ** rng.uniform(-3, 0.3)
    elif unit == "m³":
        value = mesh.volume * 10 ** rng.uniform(-3.5, 0.3)
    elif isinstance(spec.get("default"), (int, float)) and spec["default"] > 0:
        value = spec["default"] * 10 ** rng.uniform(-1.3, 1.3)
    elif maximum <= 1:
        value = maximum * rng.random() ** 2
    else:
        value = maximum * rng.random()
    return float(_clip(value, spec))


def _vector(rng, item, mesh, place):
    if place:  # in the box, or slightly outside it
        grow = rng.choice([0.0, 0.0, 0.2])
        v = [l - grow * (h - l) + rng.random() * (1 + 2 * grow) * (h - l) for l, h in zip(mesh.low, mesh.high)]
    elif rng.random() < 0.4:
        v = [0.0, 0.0, 0.0]
        v[rng.randrange(3)] = rng.choice([-1.0, 1.0])
    else:
        v = [rng.uniform(-1, 1) for _ in range(3)]
    if item.get("minimum", -1) > 0:  # lengths
        v = [mesh.size() * 10 ** rng.uniform(-1.3, 0) for _ in range(3)]
    return [float(_clip(c, item)) for c in v]
