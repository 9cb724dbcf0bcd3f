# SPDX-License-Identifier: GPL-3.0-or-later
"""An error's text, and the location of the error in the mesh."""
import textwrap

import bmesh
import bpy
from mathutils import Vector

from .frame import Frame

NEAR = 1e-4  # fraction of the object's size; an error refers to a vertex within this distance of the reported location
LINE = 110  # characters per line in the popup


def words(error):
    """Returns an error as lines of text: title, details and type. Blender's popup does not wrap lines, so this function does."""
    lines = [error.title] if error.title and error.title != error.detail else []
    lines += [*error.details, f"({error.type}" + (f", HTTP {error.status})" if error.status else ")")]
    return [part for line in lines for part in textwrap.wrap(line, LINE)]


def show_place(context, error, names):
    """Shows the location of an error: selects the open edges in edit mode, or adds an empty if the mesh has no such edge (because a
    modifier created it). `names`: the objects of the request. Returns a sentence about what is shown; "" if nothing is."""
    places = [Vector(Frame.of(context.scene).point_back(point)) for point in _points(error.problem)]
    if not places and error.type != "mesh-not-closed":  # for open edges, `bake` gives no location, but the edges can be shown
        return ""
    for name in names:
        item = context.scene.objects.get(name)
        if item is not None and item.type == "MESH" and _select(context, item, places):
            return f"The open edges of '{name}' are selected. Close them, or undo."
    if not places:
        return ""
    mark = bpy.data.objects.new(f"Fracture: {error.title}"[:63], None)
    mark.empty_display_type, mark.location = "SPHERE", places[0]
    mark.empty_display_size = 0.05 * max((max(context.scene.objects[name].dimensions) for name in names
                                          if name in context.scene.objects), default=1.0)
    mark.show_in_front = True
    context.scene.collection.objects.link(mark)
    return f"The empty '{mark.name}' marks the location."


def _points(problem):
    """Returns the points in a problem document: its `edge`, or its `sample` if it has no edge."""
    edge, sample = problem.get("edge"), problem.get("sample")
    points = edge if isinstance(edge, list) else [sample]
    return [point for point in points if isinstance(point, list) and len(point) == 3]


def _select(context, item, places):
    """Selects, in edit mode, all edges that do not have exactly two faces. With `places`, one of these edges must have an end at each
    place; otherwise, nothing is selected. Returns whether edges were selected."""
    near = NEAR * max(*item.dimensions, 1e-9)
    world = item.matrix_world
    mesh = bmesh.new()
    try:
        mesh.from_mesh(item.data)
        open_edges = [edge for edge in mesh.edges if len(edge.link_faces) != 2]
        if not any(_lies_at(edge, world, places, near) for edge in open_edges):
            return False
        chosen = {edge.index for edge in open_edges}
    finally:
        mesh.free()
    bpy.ops.object.select_all(action="DESELECT")
    context.view_layer.objects.active = item
    item.select_set(True)
    for vertex in item.data.vertices:
        vertex.select = False
    for face in item.data.polygons:
        face.select = False
    for edge in item.data.edges:
        edge.select = edge.index in chosen
    for edge in item.data.edges:
        for vertex in edge.vertices if edge.select else ():
            item.data.vertices[vertex].select = True
    context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.object.mode_set(mode="EDIT")
    return True


def _lies_at(edge, world, places, near):
    ends = [world @ vertex.co for vertex in edge.verts]
    return all(any((end - place).length <= near for end in ends) for place in places)
