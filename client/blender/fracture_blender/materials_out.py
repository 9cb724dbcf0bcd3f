# SPDX-License-Identifier: GPL-3.0-or-later
"""The materials that are sent with the mesh. The server uses them for the colours or textures of the cut faces.

Fragments get the object's own materials with all their nodes. The sent materials only affect the appearance of the cut faces,
so the base colour (or one image), metallic, roughness and opacity of the Principled BSDF are enough.
"""
import os
import tempfile
from array import array

import bpy

MAGIC = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg"}


class Materials:
    """Collects the materials and images of a file that is being written."""

    def __init__(self):
        self.blender = []  # materials in file order
        self.documents = []
        self.images = []  # (bytes, media type) in file order
        self.image_of = {}  # bytes: Blender image
        self._numbers = {}
        self._image_numbers = {}

    def number(self, material):
        """Returns the index of a material in the file; None if the material is None."""
        if material is None:
            return None
        if material.name not in self._numbers:
            self._numbers[material.name] = len(self.blender)
            self.blender.append(material)
            self.documents.append(self._document(material))
        return self._numbers[material.name]

    def _document(self, material):
        principled = _principled(material)
        if principled is None:
            red, green, blue, alpha = material.diffuse_color
            pbr = {"baseColorFactor": _color((red, green, blue, alpha)), "metallicFactor": material.metallic,
                   "roughnessFactor": material.roughness}
        else:
            alpha = _number(principled, "Alpha", 1.0)
            color = principled.inputs["Base Color"]
            pbr = {"baseColorFactor": _color((*color.default_value[:3], alpha)),
                   "metallicFactor": _number(principled, "Metallic", 0.0), "roughnessFactor": _number(principled, "Roughness", 0.5)}
            image = self._image(_image_at(color))
            if image is not None:
                pbr["baseColorFactor"] = [1.0, 1.0, 1.0, pbr["baseColorFactor"][3]]
                pbr["baseColorTexture"] = {"index": image}
        document = {"name": material.name, "pbrMetallicRoughness": pbr}
        if pbr["baseColorFactor"][3] < 1:
            document["alphaMode"] = "BLEND"
        return document

    def _image(self, image):
        """Returns the index of an image in the file; None if the image is None or unreadable."""
        if image is None:
            return None
        if image.name not in self._image_numbers:
            content = image_bytes(image)
            if content is None:
                return None
            self._image_numbers[image.name] = len(self.images)
            self.images.append((content, media_type(content)))
            self.image_of[content] = image
        return self._image_numbers[image.name]


def media_type(content):
    return next((kind for magic, kind in MAGIC.items() if content.startswith(magic)), None)


def image_bytes(image):
    """Returns the image as PNG or JPEG: its packed file, its file on disk, or a PNG written by Blender. None if it has no
    pixels."""
    content = None
    if image.packed_file is not None and not image.is_dirty:
        content = bytes(image.packed_file.data)
    elif image.source == "FILE" and not image.is_dirty:
        try:
            with open(bpy.path.abspath(image.filepath, library=image.library), "rb") as file:
                content = file.read()
        except OSError:
            content = None
    if content is not None and media_type(content):
        return content
    if not image.size[0] or not image.pixels:
        return None
    return _written(image)


def _written(image):
    """Returns the pixels as PNG, including unsaved painting, which Image.copy() would omit. Saves them from a temporary image, so the
    image itself does not change."""
    pixels = array("f", bytes(4 * len(image.pixels)))
    image.pixels.foreach_get(pixels)
    width, height = image.size
    beside = bpy.data.images.new("fracture", width, height, alpha=True, float_buffer=image.is_float)
    try:
        beside.pixels.foreach_set(pixels if image.channels == 4 else _four_channels(pixels, image.channels))
        with tempfile.TemporaryDirectory(prefix="fracture-") as folder:
            path = os.path.join(folder, "image.png")
            beside.filepath_raw, beside.file_format = path, "PNG"
            beside.save()
            with open(path, "rb") as file:
                return file.read()
    except (RuntimeError, OSError):
        return None
    finally:
        bpy.data.images.remove(beside)


def _four_channels(pixels, channels):
    wide = array("f", [1.0]) * (len(pixels) // channels * 4)
    for channel in range(3):
        wide[channel::4] = pixels[min(channel, channels - 1)::channels]
    return wide


def _principled(material):
    if not material.use_nodes or material.node_tree is None:
        return None
    return next((node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"), None)


def _image_at(socket):
    """Returns the image linked to a socket, directly or through the colour inputs of at most three nodes (such as a colour mix or
    ramp)."""
    seen = 0
    while socket is not None and socket.is_linked and seen < 4:
        node = socket.links[0].from_node
        if node.type == "TEX_IMAGE":
            return node.image
        socket = next((entry for entry in node.inputs if entry.type == "RGBA" and entry.is_linked), None)
        seen += 1
    return None


def _number(principled, name, default):
    socket = principled.inputs.get(name)
    return default if socket is None else min(1.0, max(0.0, socket.default_value))


def _color(values):
    return [min(1.0, max(0.0, float(value))) for value in values]
