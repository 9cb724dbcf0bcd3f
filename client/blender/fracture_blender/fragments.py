# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns an answer into a collection with one object per fragment. With levels, each cluster becomes a collection, too."""
import json
from array import array

import bpy

from .frame import Frame
from .materials_in import AnswerMaterials
from .package import FractureError, glb

MOST_OBJECTS = 20_000  # with more objects, Blender freezes for minutes


class Made:
    """The collection and the objects of an answer."""

    def __init__(self, collection, objects):
        self.collection = collection
        self.objects = objects  # by fragment id


def check(answer):
    """Raises FractureError if the answer has too many fragments for Blender. Call it before any object is created."""
    if len(answer.fragments) > MOST_OBJECTS:
        raise FractureError("answer-too-large", f"The answer has {len(answer.fragments):,} fragments, but the add-on creates at most "
                                                f"{MOST_OBJECTS:,} objects. Request fewer fragments.")


def build(context, answer, written, parent, name):
    """Creates an answer's objects in a collection inside `parent`. The objects use the scene's materials, but have their own meshes."""
    frame = Frame.of(context.scene)
    materials = AnswerMaterials(glb.Glb(answer.glb), answer.figures, written)
    root = bpy.data.collections.new(f"{name} fragments")
    parent.children.link(root)
    root["fracture_parameters"] = json.dumps(answer.parameters)
    root["fracture_algorithm"] = answer.algorithm
    root["fracture_volume"] = answer.certificate["volume_in"]
    if answer.location:
        root["fracture_answer"] = answer.location
    clusters = _clusters(answer, root, name)
    objects = {}
    for fragment in answer.fragments:
        item = bpy.data.objects.new(fragment.name, _mesh(fragment.name, fragment.primitives, frame, materials, written))
        item.location = frame.point_back([own + root for own, root in zip(fragment.translation, answer.offset)])
        for key, value in (("id", str(fragment.id)), ("volume", fragment.volume), ("mass", fragment.mass), ("area", fragment.area),
                           ("anchored", fragment.anchored), ("part", fragment.part), ("level", fragment.level)):
            item[f"fracture_{key}"] = value  # the id is text, because it does not fit into Blender's integers
        clusters.get(fragment.parent, root).objects.link(item)
        objects[fragment.id] = item
        if fragment.sheet:
            _add_sheet(fragment, item, clusters.get(fragment.parent, root), frame, materials, written)
    return Made(root, objects)


def _clusters(answer, root, name):
    """Creates a collection for each cluster, inside the collection of the parent cluster. Returns the collections by cluster id, coarsest
    level first."""
    found = {}
    for level in answer.levels:
        parents = level.get("parent", [None] * len(level["id"]))
        for number, (id, parent) in enumerate(zip(level["id"], parents)):
            cluster = bpy.data.collections.new(f"{name} level {level['level']} {number:03d}")
            cluster["fracture_id"], cluster["fracture_level"] = str(id), level["level"]
            cluster["fracture_volume"], cluster["fracture_mass"] = level["volume"][number], level["mass"][number]
            found.get(parent, root).children.link(cluster)
            found[id] = cluster
    return found


def _add_sheet(fragment, item, collection, frame, materials, written):
    """Creates an object for the sheets that a fragment carries. It is a child of the fragment's object and moves with it."""
    sheet = bpy.data.objects.new(f"{fragment.name}_sheet", _mesh(f"{fragment.name}_sheet", fragment.sheet, frame, materials, written))
    sheet.parent = item
    collection.objects.link(sheet)


def _mesh(name, primitives, frame, materials, written):
    """Returns the mesh of a fragment or of its sheets. Vertices at the same position are merged, because the file has a separate
    vertex for each normal and UV."""
    attributes = primitives[0].attributes
    positions = _floats(attributes["POSITION"])
    points = [frame.point_back(point) for point in zip(positions[0::3], positions[1::3], positions[2::3])]
    numbers = {}
    vertex_of = [numbers.setdefault(point, len(numbers)) for point in points]
    faces, corners, slots = [], [], []
    mesh = bpy.data.meshes.new(name)
    for slot, primitive in enumerate(sorted(primitives, key=lambda primitive: primitive.interior)):
        mesh.materials.append(materials.of(primitive.material_index))
        indices = _integers(primitive.indices)
        for a, b, c in zip(indices[0::3], indices[1::3], indices[2::3]):
            face = (vertex_of[a], vertex_of[b], vertex_of[c])
            if len(set(face)) == 3:  # in single precision, a sliver can collapse into an edge
                faces.append(face)
                corners += (a, b, c)
                slots.append(slot)
    mesh.from_pydata(list(numbers), [], faces)
    mesh.polygons.foreach_set("material_index", slots)
    for number, name in enumerate(written.uv_names):
        if f"TEXCOORD_{number}" in attributes:
            values = _floats(attributes[f"TEXCOORD_{number}"])
            values[1::2] = array("f", [1.0 - value for value in values[1::2]])
            layer = mesh.uv_layers.new(name=name)
            layer.data.foreach_set("uv", _rows(values, 2, corners))
    for number, name in enumerate(written.color_names):
        if name is not None and f"COLOR_{number}" in attributes:
            width = attributes[f"COLOR_{number}"].shape[1]
            values = _colors(attributes[f"COLOR_{number}"])
            layer = mesh.color_attributes.new(name, "FLOAT_COLOR", "CORNER")
            layer.data.foreach_set("color", _opaque(_rows(values, width, corners), width))
    mesh.update(calc_edges=True)
    if "NORMAL" in attributes:
        _shade(mesh, _rows(_floats(attributes["NORMAL"]), 3, corners))
    return mesh


def _shade(mesh, normals):
    """Applies the normals from the file, so that the outside is shaded as before and cut faces have hard edges."""
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.normals_split_custom_set([(x, 0.0 - z, y) for x, y, z in zip(normals[0::3], normals[1::3], normals[2::3])])
    if hasattr(mesh, "use_auto_smooth"):  # until 4.0
        mesh.use_auto_smooth = True


def _rows(values, width, corners):
    picked = array("f", bytes(4 * width * len(corners)))
    for part in range(width):
        column = values[part::width]
        picked[part::width] = array("f", [column[corner] for corner in corners])
    return picked


def _floats(values):
    """Returns all values of a numpy array or memoryview as a flat sequence."""
    flat = array("f")
    flat.frombytes(values.tobytes())
    return flat


def _integers(values):
    kind = {1: "B", 2: "H", 4: "I"}[values.itemsize]
    flat = array(kind)
    flat.frombytes(values.tobytes())
    return flat


def _colors(values):
    """Returns colours as floats. The file may store them as fractions of 255 or 65535 (glTF 2.0, section 3.7.2.1)."""
    if values.itemsize == 4:
        return _floats(values)
    most = 255.0 if values.itemsize == 1 else 65535.0
    return array("f", [value / most for value in _integers(values)])


def _opaque(values, width):
    """Returns the colours with four channels each. Colours without alpha get alpha 1."""
    if width == 4:
        return values
    count = len(values) // width
    wide = array("f", [1.0]) * (4 * count)
    for part in range(3):
        wide[part::4] = values[part::width]
    return wide
