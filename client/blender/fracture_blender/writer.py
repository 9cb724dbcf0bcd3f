# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes objects to the GLB that is sent.

There are four reasons not to use Blender's own exporter. It needs numpy, which some Blender packages lack. Its bytes change between
releases, so a mesh that the server already has would be sent again. It ignores a scene's unit scale. It changes materials, but
fragments need the object's own materials. This writer keeps vertices unchanged in single precision and puts the whole transform into the
node, so nothing is rounded.
"""
from array import array

from .frame import Frame
from .materials_out import Materials
from .package import glb, wrong

MESH_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
FLOAT, UNSIGNED_INT = 5126, 5125
PAINT = "COLOR_0"  # the attribute that density_from refers to


class Written:
    """A written file, and the names of objects, materials and layers that are needed to create the fragments."""

    def __init__(self, content, objects, materials, uv_names, color_names):
        self.glb = content
        self.objects = [item.name for item in objects]
        self.materials = materials
        self.uv_names = uv_names  # the layers' names for TEXCOORD_0, 1, …
        self.color_names = color_names  # the layers' names for COLOR_0, 1, …; None for a layer that was written only for the paint


def write(context, objects, paint="NONE", paint_name=""):
    """Returns a file (Written) with the objects and their modifiers, in the interface's frame. Raises FractureError if the objects have
    no faces, or if none has the vertex group or colour attribute named in 'Painted by'."""
    file = _File(Frame.of(context.scene))
    graph = context.evaluated_depsgraph_get()
    painted = False
    for item in objects:
        evaluated = item.evaluated_get(graph)
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=graph)
        try:
            if mesh is not None and len(mesh.polygons) > 0:
                painted = file.add(item, evaluated, mesh, paint, paint_name) or painted
        finally:
            evaluated.to_mesh_clear()
    if not file.nodes:
        raise wrong("The selected objects have no faces, so there is nothing to break. Select objects with a surface.")
    if paint != "NONE" and not painted:
        what = "vertex group" if paint == "GROUP" else "colour attribute"
        raise wrong(f"'Painted by' uses the {what} '{paint_name}', which no selected object has. Choose another name, or 'Nothing'.",
                    parameter="density_from")
    return Written(file.finish(), objects, file.materials, file.uv_names, file.color_names)


class _File:
    def __init__(self, frame):
        self.frame = frame
        self.nodes, self.meshes, self.accessors, self.views = [], [], [], []
        self.binary = bytearray()
        self.materials = Materials()
        self.uv_names, self.color_names = [], []

    def add(self, item, evaluated, mesh, paint, paint_name):
        """Adds an object. Returns whether the object has the vertex group or colour attribute named in 'Painted by'."""
        mesh.calc_loop_triangles()
        corners = len(mesh.loops)
        vertices = array("i", bytes(4 * corners))
        mesh.loops.foreach_get("vertex_index", vertices)
        positions = _turned(_get(mesh.vertices, "co", 3 * len(mesh.vertices)))
        columns = {"NORMAL": (3, _turned(_normals(mesh, corners)))}
        uv_names = [layer.name for layer in mesh.uv_layers]
        for number, layer in enumerate(mesh.uv_layers):
            columns[f"TEXCOORD_{number}"] = (2, _flipped(_get(layer.data, "uv", 2 * corners)))
        colors, color_names, painted = _colors(mesh, evaluated, vertices, paint, paint_name)
        for number, values in enumerate(colors):
            columns[f"COLOR_{number}"] = (4, values)
        self.uv_names += uv_names[len(self.uv_names):]
        self.color_names += color_names[len(self.color_names):]

        chunks = [_chunks(values, width) for width, values in columns.values()]
        numbers, order = {}, []
        vertex_of = array("I", bytes(4 * corners))
        for corner, key in enumerate(zip(vertices, *chunks)):
            number = numbers.get(key)
            if number is None:
                number = numbers[key] = len(order)
                order.append(corner)
            vertex_of[corner] = number
        attributes = {"POSITION": self._attribute(3, _picked(positions, 3, [vertices[corner] for corner in order]), True)}
        for name, (width, values) in columns.items():
            attributes[name] = self._attribute(width, _picked(values, width, order))
        primitives = []
        for material, indices in self._triangles(item, evaluated, mesh, vertex_of).items():
            view = self._view(indices.tobytes(), ELEMENT_ARRAY_BUFFER)
            accessor = self._accessor({"bufferView": view, "componentType": UNSIGNED_INT, "count": len(indices), "type": "SCALAR"})
            primitives.append({"attributes": attributes, "indices": accessor, **({} if material is None else {"material": material})})
        self.nodes.append({"name": item.name, "mesh": len(self.meshes), "matrix": self.frame.node_matrix(item.matrix_world)})
        self.meshes.append({"name": item.name, "primitives": primitives})
        return painted

    def _triangles(self, item, evaluated, mesh, vertex_of):
        """Returns the triangle indices, grouped by material index, in slot order."""
        count = len(mesh.loop_triangles)
        corners, slots = array("i", bytes(12 * count)), array("i", bytes(4 * count))
        mesh.loop_triangles.foreach_get("loops", corners)
        mesh.loop_triangles.foreach_get("material_index", slots)
        materials = _materials(item, mesh)
        by_slot = {}
        for triangle, slot in enumerate(slots):
            by_slot.setdefault(slot, array("I")).extend([vertex_of[corner] for corner in corners[3 * triangle:3 * triangle + 3]])
        found = {}
        for slot in sorted(by_slot):
            material = materials[slot] if slot < len(materials) else None
            found.setdefault(self.materials.number(material), array("I")).extend(by_slot[slot])
        return found

    def _attribute(self, width, values, ends=False):
        view = self._view(values.tobytes(), ARRAY_BUFFER)
        accessor = {"bufferView": view, "componentType": FLOAT, "count": len(values) // width, "type": f"VEC{width}"}
        if ends:
            accessor["min"] = [min(values[axis::width]) for axis in range(width)]
            accessor["max"] = [max(values[axis::width]) for axis in range(width)]
        return self._accessor(accessor)

    def _accessor(self, accessor):
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def _view(self, content, target=None):
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(content), **({"target": target} if target else {})}
        self.binary += content
        self.views.append(view)
        return len(self.views) - 1

    def finish(self):
        document = {"asset": {"version": "2.0", "generator": "fracture_blender"}, "scene": 0,
                    "scenes": [{"nodes": list(range(len(self.nodes)))}], "nodes": self.nodes, "meshes": self.meshes}
        if self.materials.documents:
            document["materials"] = self.materials.documents
        if self.materials.images:
            document["images"] = [{"bufferView": self._view(content), "mimeType": kind} for content, kind in self.materials.images]
            document["textures"] = [{"source": number} for number in range(len(self.materials.images))]
        document.update(accessors=self.accessors, bufferViews=self.views)
        return glb.pack(document, bytes(self.binary))


def _get(items, name, count):
    values = array("f", bytes(4 * count))
    items.foreach_get(name, values)
    return values


def _normals(mesh, corners):
    if hasattr(mesh, "corner_normals"):  # from 4.1
        values = _get(mesh.corner_normals, "vector", 3 * corners)
    else:
        mesh.calc_normals_split()
        values = _get(mesh.loops, "normal", 3 * corners)
    for at in range(0, len(values), 3):  # a face without area has no normal, but glTF needs one
        if values[at] == values[at + 1] == values[at + 2] == 0:
            values[at + 2] = 1.0
    return values


def _materials(item, mesh):
    """Returns the materials of the object's slots. Materials that are linked to the object come from the slots, because the mesh does not
    have them. All others come from the mesh, because only it has the materials that modifiers add."""
    materials = [None if material is None else material.original for material in mesh.materials]
    for number, slot in enumerate(item.material_slots):
        if slot.link == "OBJECT" or number >= len(materials):
            materials[number:number + 1] = [slot.material]
    return materials


def _colors(mesh, evaluated, vertices, paint, paint_name):
    """Returns (the colour layers' values per corner, the layers' names, whether the first layer is the paint)."""
    columns, names = [], []
    layers = [layer for layer in mesh.color_attributes if layer.data]
    if paint == "GROUP":
        group = evaluated.vertex_groups.get(paint_name)
        if group is not None:
            weights = [next((entry.weight for entry in vertex.groups if entry.group == group.index), 0.0) for vertex in mesh.vertices]
            columns.append(array("f", [value for vertex in vertices for value in (*(weights[vertex],) * 3, 1.0)]))
            names.append(None)
    elif paint == "COLOR":
        layers.sort(key=lambda layer: layer.name != paint_name)
    painted = bool(columns) or (paint == "COLOR" and any(layer.name == paint_name for layer in layers))
    if paint != "NONE" and not painted:  # an object without the paint gets black, because other objects may have the paint
        columns.append(array("f", (0.0, 0.0, 0.0, 1.0)) * len(vertices))
        names.append(None)
    for layer in layers:
        values = _get(layer.data, "color", 4 * len(layer.data))
        columns.append(_picked(values, 4, vertices) if layer.domain == "POINT" else values)
        names.append(layer.name)
    return columns, names, painted


def _turned(values):
    """Converts positions or normals from z-up to y-up: (x, y, z) becomes (x, z, -y)."""
    turned = array("f", values)
    turned[1::3] = values[2::3]
    turned[2::3] = array("f", [0.0 - value for value in values[1::3]])
    return turned


def _flipped(values):
    """Returns the UVs with v flipped, because v points up in Blender and down in glTF."""
    values[1::2] = array("f", [1.0 - value for value in values[1::2]])
    return values


def _chunks(values, width):
    content, size = values.tobytes(), 4 * width
    return [content[at:at + size] for at in range(0, len(content), size)]


def _picked(values, width, order):
    """Returns the rows with these indices, in that order."""
    content, size = values.tobytes(), 4 * width
    picked = array("f")
    picked.frombytes(b"".join([content[size * row:size * row + size] for row in order]))
    return picked
