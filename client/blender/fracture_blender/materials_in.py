# SPDX-License-Identifier: GPL-3.0-or-later
"""An answer's materials: the objects' own materials, and new ones for the cut faces."""
import os
import tempfile

import bpy

from .materials_out import media_type


class AnswerMaterials:
    """The Blender material for each material in the file."""

    def __init__(self, file, figures, written):
        """`file`: the answer's Glb. `written`: the file that was sent (writer.Written)."""
        self._file = file
        self._own = written.materials
        self.interior = set(figures.get("interior_materials", ()))
        self._made = {}  # index in the file: material
        self._images = {}

    def of(self, index):
        """Returns the material with this index; None if the index is None. The server keeps the mesh's materials in order, and
        appends the materials of the cut faces."""
        if index is None:
            return None
        if index < len(self._own.blender) and index not in self.interior:
            return self._own.blender[index]
        if index not in self._made:
            self._made[index] = self._new(self._file.item("materials", index))
        return self._made[index]

    def _new(self, document):
        material = bpy.data.materials.new(document.get("name", "Interior"))
        pbr = document.get("pbrMetallicRoughness", {})
        color = list(pbr.get("baseColorFactor", (1, 1, 1, 1)))
        metallic, roughness = pbr.get("metallicFactor", 1.0), pbr.get("roughnessFactor", 1.0)
        material.use_nodes = True
        nodes = material.node_tree.nodes
        principled = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
        principled.inputs["Base Color"].default_value = (*color[:3], 1.0)
        principled.inputs["Metallic"].default_value = metallic
        principled.inputs["Roughness"].default_value = roughness
        if document.get("alphaMode") == "BLEND":
            principled.inputs["Alpha"].default_value = color[3]
            if hasattr(material, "blend_method"):
                material.blend_method = "BLEND"
        material.use_backface_culling = not document.get("doubleSided", False)
        material.diffuse_color, material.metallic, material.roughness = color, metallic, roughness  # for the solid view
        self._link_textures(material.node_tree, principled, document, color)
        return material

    def _link_textures(self, tree, principled, document, color):
        base = self._texture(tree, document.get("pbrMetallicRoughness", {}).get("baseColorTexture"), "sRGB", 300)
        if base is not None:
            shade = tree.nodes.new("ShaderNodeVectorMath")
            shade.operation, shade.location = "MULTIPLY", (-250, 300)
            shade.inputs[1].default_value = color[:3]
            tree.links.new(base.outputs["Color"], shade.inputs[0])
            tree.links.new(shade.outputs["Vector"], principled.inputs["Base Color"])
        rough = self._texture(tree, document.get("pbrMetallicRoughness", {}).get("metallicRoughnessTexture"), "Non-Color", 0)
        if rough is not None:
            channels = tree.nodes.new("ShaderNodeSeparateColor")
            channels.location = (-250, 0)
            factor = tree.nodes.new("ShaderNodeMath")
            factor.operation, factor.location = "MULTIPLY", (-100, 0)
            factor.inputs[1].default_value = principled.inputs["Roughness"].default_value
            tree.links.new(rough.outputs["Color"], channels.inputs[0])
            tree.links.new(channels.outputs["Green"], factor.inputs[0])
            tree.links.new(factor.outputs[0], principled.inputs["Roughness"])
        relief = self._texture(tree, document.get("normalTexture"), "Non-Color", -300)
        if relief is not None:
            normal = tree.nodes.new("ShaderNodeNormalMap")
            normal.location = (-250, -300)
            normal.inputs["Strength"].default_value = document["normalTexture"].get("scale", 1.0)
            tree.links.new(relief.outputs["Color"], normal.inputs["Color"])
            tree.links.new(normal.outputs["Normal"], principled.inputs["Normal"])

    def _texture(self, tree, info, space, height):
        """Returns a new shader node that shows the texture, or None if the material has no such texture."""
        if info is None:
            return None
        image = self._image(self._file.item("textures", info["index"]).get("source"), space)
        if image is None:
            return None
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image, node.location = image, (-600, height)
        return node

    def _image(self, index, space):
        """Returns the Blender image for an image in the file. The server returns images unchanged, so the result for an image that the
        add-on sent is the object's own image."""
        if index is None:
            return None
        document = self._file.item("images", index)
        content = bytes(self._file.view(document["bufferView"]))
        if content in self._own.image_of:
            return self._own.image_of[content]
        if index not in self._images:
            self._images[index] = _loaded(content, document.get("name", "Interior"), space)
        return self._images[index]


def _loaded(content, name, space):
    """Creates an image and packs it into the .blend file."""
    end = ".jpg" if media_type(content) == "image/jpeg" else ".png"
    with tempfile.TemporaryDirectory(prefix="fracture-") as folder:
        path = os.path.join(folder, "image" + end)
        with open(path, "wb") as file:
            file.write(content)
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = space  # before pack(), because this loads the image again
        image.pack()
    image.name = name
    image.filepath_raw = ""
    return image
