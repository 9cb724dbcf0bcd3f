"""Walks the JSON of a glTF file, and names everything in it that its fractured answer neither contains, applies nor lists.

lost(source, answer) compares the paths of two files, GLB or glTF.
"""
import base64
import json
import pathlib
import struct
import unicodedata
import urllib.parse

# Extensions that the reader applies to triangles, so that the answer does not need them (common/import/gltf_extensions.cpp).
APPLIED = {"KHR_mesh_quantization", "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression",
           "EXT_mesh_gpu_instancing", "EXT_mesh_manifold", "KHR_node_visibility", "CESIUM_RTC"}
RESULTS = {"fracture", "intact", "whole"}  # members of extras that answers write themselves
CUT = 63  # bytes of a name in the list
# Members of each kind of object, other than extensions and extras, that this program looks at, that are applied to the triangles,
# or that only describe how the file stores its numbers. Any other member is reported, because a reader may have missed it.
MEMBERS = {
    "": {"asset", "scene", "scenes", "nodes", "meshes", "materials", "textures", "samplers", "images", "cameras", "animations",
         "skins", "accessors", "bufferViews", "buffers", "extensionsUsed", "extensionsRequired"},
    "asset": {"version", "minVersion", "generator", "copyright"},
    "scenes": {"name", "nodes"},
    "nodes": {"name", "mesh", "children", "camera", "skin", "weights", "matrix", "translation", "rotation", "scale"},
    "meshes": {"name", "primitives", "weights"},
    "primitives": {"attributes", "indices", "material", "mode", "targets"},
    "skins": {"name", "joints", "skeleton", "inverseBindMatrices"},
    "images": {"name", "uri", "mimeType", "bufferView"},
    "accessors": {"name", "bufferView", "byteOffset", "componentType", "normalized", "count", "type", "max", "min", "sparse"},
    "bufferViews": {"name", "buffer", "byteOffset", "byteLength", "byteStride", "target"},
    "buffers": {"name", "uri", "byteLength"},
}


def without_ignored(data):
    """Removes chunks of a PNG that readers of glTF have to ignore (common/gltf/image_bytes.hpp)."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        return data
    at, kept = 8, data[:8]
    while at + 12 <= len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind not in (b"iCCP", b"gAMA", b"cHRM", b"pHYs"):
            kept += data[at:at + 12 + size]
        at += 12 + size
    return kept


class Gltf:
    """The JSON of a file, and the bytes of its images."""

    def __init__(self, path):
        self.path, data = pathlib.Path(path), pathlib.Path(path).read_bytes()
        self.binary = b""
        if data[:4] == b"glTF":
            size = struct.unpack_from("<I", data, 12)[0]
            self.binary, data = data[20 + size + 8:], data[20:20 + size]
        self.json = json.loads(data)

    def file(self, uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        path = self.path.parent / urllib.parse.unquote(uri)
        return path.read_bytes() if path.is_file() else None

    def image(self, index):
        """Returns the bytes as an answer has them, or None if a file is missing."""
        data = self.stored_image(index)
        return data if data is None else without_ignored(data)

    def stored_image(self, index):
        image = self.json["images"][index]
        if "uri" in image:
            return self.file(image["uri"])
        view = self.json["bufferViews"][image["bufferView"]]
        buffer = self.json["buffers"][view["buffer"]]
        data = self.file(buffer["uri"]) if "uri" in buffer else self.binary
        at = view.get("byteOffset", 0)
        return data[at:at + view["byteLength"]]


def is_of_materials(extension):
    """Whether materials and textures keep the extension."""
    return extension != "KHR_materials_variants" and extension.startswith(
        ("KHR_materials_", "EXT_materials_", "KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp",
         "EXT_texture_avif", "MSFT_texture_dds"))


def entry(name, pointer):
    """The name of something in the list: its own or its place, cut at a character."""
    return ((name if isinstance(name, str) and name else pointer).encode()[:CUT]).decode(errors="ignore")


def kept_name(name):
    """A name as common/gltf/names.hpp describes it, but not cut: _ for what tools do not keep."""
    def keep(c):
        return c in "_-" or c.isalnum() if ord(c) < 128 else unicodedata.category(c) not in ("Cc", "Zs", "Zl", "Zp") and \
            c not in "\u200b\u200e\u200f\u202a\u202b\u202c\u202d\u202e\ufeff\uffff"
    return "".join(c if keep(c) else "_" for c in name)


class Walk:
    def __init__(self, source, answer):
        self.source, self.answer = Gltf(source), Gltf(answer)
        self.losses = []
        root = next(n for n in self.answer.json["nodes"] if n.get("extras", {}).get("fracture", {}).get("report"))
        self.report = root["extras"]["fracture"]["report"]
        self.listed = {(e["what"], e["name"]) for e in self.report.get("dropped", [])}
        self.limited = {e["what"] for e in self.report.get("dropped", []) if e["reason"].endswith(" not listed")}
        nodes = self.answer.json["nodes"]
        self.names = [n["name"] for n in nodes if "name" in n]
        self.extras = [n["extras"] for n in nodes if "extras" in n]
        self.attributes = {a for m in self.answer.json.get("meshes", []) for p in m["primitives"] for a in p["attributes"]}

    def is_listed(self, what, name):
        return what in self.limited or (what, name) in self.listed

    def must(self, fine, what, name):
        if not fine and not self.is_listed(what, name):
            self.losses.append(f"{what} {name}")

    def members(self, kind, value, pointer):
        for member in value:
            if member not in MEMBERS[kind] | {"extensions", "extras"}:
                self.losses.append(f"member {pointer}/{member}")

    def each(self, kind):
        for k, value in enumerate(self.source.json.get(kind, [])):
            if kind in MEMBERS:
                self.members(kind, value, f"/{kind}/{k}")
            yield k, value, entry(value.get("name"), f"/{kind}/{k}")

    def extras_of(self, value, name):
        self.must(value.get("extras") is None, "extras", name)

    def extension_names(self, value):
        if isinstance(value, list):
            return set().union(*map(self.extension_names, value))
        if not isinstance(value, dict):
            return set()
        found = set(value["extensions"]) if isinstance(value.get("extensions"), dict) else set()
        return found.union(*(self.extension_names(v) for k, v in value.items() if k != "extras"))

    def document(self):
        source, answer = self.source.json, self.answer.json
        self.members("", source, "")
        self.members("asset", source["asset"], "/asset")
        self.extras_of(source, "/extras")
        self.extras_of(source["asset"], "/asset/extras")
        self.must(source["asset"].get("copyright") == answer["asset"].get("copyright"), "copyright", "")
        used = set(answer.get("extensionsUsed", []))
        declared = self.extension_names(source) | set(source.get("extensionsUsed", []) + source.get("extensionsRequired", []))
        for name in sorted(declared - APPLIED - used):
            if not is_of_materials(name):  # looks() compares the others with their contents
                self.must(False, "extension", name)
        lights = source.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
        for what, entries, pointer in (("light", lights, "/extensions/KHR_lights_punctual/lights"),
                                       ("camera", source.get("cameras", []), "/cameras")):
            for k, value in enumerate(entries):
                holders = [n.get("name") for n in source["nodes"] if n.get("name") and k == (
                    n.get("camera") if what == "camera" else
                    n.get("extensions", {}).get("KHR_lights_punctual", {}).get("light"))]
                self.must(False, what, entry(value.get("name") or next(iter(holders), ""), f"{pointer}/{k}"))
        for what, kind in (("animation", "animations"), ("skin", "skins")):
            for _, _, name in self.each(kind):
                self.must(False, what, name)
        variants = source.get("extensions", {}).get("KHR_materials_variants", {}).get("variants", [])
        kept = answer.get("extensions", {}).get("KHR_materials_variants", {}).get("variants", [])
        for k, variant in enumerate(variants):
            self.must(variant in kept, "material variant",
                      entry(variant.get("name"), f"/extensions/KHR_materials_variants/variants/{k}"))
        for kind in ("scenes", "skins", "accessors", "bufferViews", "buffers", "images"):
            for _, value, name in self.each(kind):
                self.extras_of(value, name)
        for k, _, name in self.each("scenes"):
            self.must(k == source.get("scene", 0), "scene", name)

    def nodes(self):
        for k, node, name in self.each("nodes"):
            mesh = self.source.json["meshes"][node["mesh"]].get("name", "mesh") if "mesh" in node else "empty"
            called = node.get("name") or mesh
            shown = kept_name(called)[:20].lstrip("_")
            in_answer = any(n.lstrip("_").startswith(shown) for n in self.names)
            other = any(self.is_listed(what, name) for what in ("bone", "level of detail", "collision geometry"))
            self.must(in_answer or other or self.is_listed("node", entry(called, "")), "node", name)
            extras = node.get("extras")
            if isinstance(extras, dict):
                own = {key: value for key, value in extras.items() if key not in RESULTS}
                self.must(any(own.items() <= e.items() for e in self.extras) if self.hashable(own) else
                          any(all(e.get(k) == v for k, v in own.items()) for e in self.extras), "extras", name)
            elif extras is not None:
                self.must(False, "extras", name)
            instances = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
            for attribute in set(instances) - {"TRANSLATION", "ROTATION", "SCALE"}:
                self.must(False, "attribute", entry(f"{attribute} of {name}", ""))

    @staticmethod
    def hashable(value):
        return not any(isinstance(v, (dict, list)) for v in value.values())

    def meshes(self):
        shown = {n["mesh"] for n in self.source.json.get("nodes", []) if "mesh" in n}
        for k, mesh, name in self.each("meshes"):
            self.extras_of(mesh, name)
            self.must(k in shown, "mesh", name)
            for n, primitive in enumerate(mesh["primitives"]):
                self.members("primitives", primitive, f"/meshes/{k}/primitives/{n}")
                self.extras_of(primitive, entry(f"a primitive of {name}", ""))
                mode = primitive.get("mode", 4)
                if mode < 4 or "POSITION" not in primitive["attributes"]:
                    self.must(False, "points" if mode == 0 else "lines" if mode < 4 else "primitive", name)
                    continue
                for attribute in primitive["attributes"]:
                    if not attribute.startswith(("JOINTS_", "WEIGHTS_")):
                        self.must(attribute in self.attributes or k not in shown, "attribute",
                                  entry(f"{attribute} of {name}", ""))
                self.must(not primitive.get("targets"), "morph targets", name)

    def resolved(self, file, value, pointer=""):
        """Returns the value with the texture, sampler and image in the place of each index; without extensions that are listed."""
        if isinstance(value, list):
            return [self.resolved(file, v, pointer) for v in value]
        if not isinstance(value, dict):
            return value
        result = {}
        for key, child in value.items():
            if key == "extras":
                result[key] = child
            elif key == "extensions":
                kept = {n: self.resolved(file, e, pointer) for n, e in child.items() if not self.is_listed("extension", n)}
                if kept:
                    result[key] = kept
            elif key.lower().endswith("texture") and isinstance(child, dict) and "index" in child:
                texture = self.texture(file, child["index"])
                if texture is not None:
                    result[key] = {**self.resolved(file, child, pointer), "index": texture}
            else:
                result[key] = self.resolved(file, child, pointer)
        return result

    def texture(self, file, index):
        """Returns the resolved texture, or None if the list has all of its images."""
        texture = self.resolved(file, file.json["textures"][index])
        shows = False
        for holder in [texture, *texture.get("extensions", {}).values()]:
            if "source" not in holder:
                continue
            number = holder["source"]
            data = file.image(number)
            image = entry(file.json["images"][number].get("name") or file.json["images"][number].get("uri"), f"/images/{number}")
            if data is None or self.is_listed("image", image):
                self.must(False, "image", image)
                del holder["source"]
            else:
                holder["source"], shows = data, True
        if "sampler" in texture:
            texture["sampler"] = file.json["samplers"][texture["sampler"]]
        return texture if shows else None

    def looks(self):
        answer = self.answer.json
        made = [self.resolved(self.answer, m) for m in answer.get("materials", [])]
        for k, material, name in self.each("materials"):
            self.must(self.resolved(self.source, material) == (made[k] if k < len(made) else None), "material", name)
        textures = [self.texture(self.answer, k) for k in range(len(answer.get("textures", [])))]
        for k, _, name in self.each("textures"):
            wanted = self.texture(self.source, k)
            self.must(wanted is None or wanted in textures, "texture", name)
        images = [self.answer.image(k) for k in range(len(answer.get("images", [])))]
        names = [image.get("name") for image in answer.get("images", [])]
        for k, image, _ in self.each("images"):
            name = entry(image.get("name") or image.get("uri"), f"/images/{k}")
            self.must(self.source.image(k) in images and ("name" not in image or image["name"] in names), "image", name)
        for _, sampler, name in self.each("samplers"):
            self.must(sampler in answer.get("samplers", []), "sampler", name)


def lost(source, answer):
    """Returns one text for everything in the source that is lost without a word."""
    walk = Walk(source, answer)
    walk.document()
    walk.nodes()
    walk.meshes()
    walk.looks()
    return sorted(set(walk.losses))
