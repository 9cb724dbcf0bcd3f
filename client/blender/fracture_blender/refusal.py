# SPDX-License-Identifier: GPL-3.0-or-later
"""What a refusal says, and where it points."""
import textwrap

import bmesh
import bpy
from mathutils import Vector

from .frame import Frame

NEAR = 1e-4  # of the object's size: a vertex that is no farther is the one that is meant
LINE = 110  # characters of a line in the popup


def words(error):
    """For people, line by line: all that is wrong, and of what type it is. Blender shows an error that an operator reports as a
    popup, which does not break lines."""
    lines = [error.title] if error.title and error.title != error.detail else []
    lines += [*error.details, f"({error.type}" + (f", HTTP {error.status})" if error.status else ")")]
    return [part for line in lines for part in textwrap.wrap(line, LINE)]


def show_place(context, error, names):
    """Shows the place that a problem names: its edges selected in edit mode, or an empty where the mesh has none there (it came
    of a modifier). `names`: of the objects that were asked for. Returns what it did, "" for nothing."""
    places = [Vector(Frame.of(context.scene).point_back(point)) for point in _points(error.problem)]
    if not places and error.type != "mesh-not-closed":  # of that a program says no place, but there are edges to be shown
        return ""
    for name in names:
        item = context.scene.objects.get(name)
        if item is not None and item.type == "MESH" and _select(context, item, places):
            return f"The open edges of {name} are selected."
    if not places:
        return ""
    mark = bpy.data.objects.new(f"Fracture: {error.title}"[:63], None)
    mark.empty_display_type, mark.location = "SPHERE", places[0]
    mark.empty_display_size = 0.05 * max((max(context.scene.objects[name].dimensions) for name in names
                                          if name in context.scene.objects), default=1.0)
    mark.show_in_front = True
    context.scene.collection.objects.link(mark)
    return f"The empty '{mark.name}' is there."


def _points(problem):
    """Of the members that problem documents have for places, best first."""
    edge, sample = problem.get("edge"), problem.get("sample")
    points = edge if isinstance(edge, list) else [sample]
    return [point for point in points if isinstance(point, list) and len(point) == 3]


def _select(context, item, places):
    """Edit mode with all edges that have not two faces, if one of them has its ends at the places (or one end at the one);
    without places, if there are such edges."""
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
