# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts the 3D cursor and empties to parameters of the interface: hits, kept regions and held regions."""
from itertools import product

from mathutils import Matrix, Vector

from .frame import Frame, turned
from .package import wrong


def places(context, description, given):
    """Returns the parameters that result from the scene's settings for hits and regions. Raises FractureError of type "bad-parameter" if
    the settings use selected empties and none is selected."""
    scene = context.scene
    settings, frame = scene.fracture_settings, Frame.of(scene)
    found = {}
    hits = _hits(context, settings)
    if hits:
        points = [frame.point(point) for point, _ in hits]
        radii = [frame.length(radius) for _, radius in hits]
        if settings.hit_kind == "LOCAL":
            found.update(local_point=points, local_radius=radii)
        else:
            found.update(impacts=points)
            if "radius" in description.of_pattern(_pattern_of_impacts(description, given)):
                found["radius"] = max(radii)  # all impacts share one radius
    if settings.keep is not None:
        found.update(_kept(settings.keep, frame))
    if settings.hold is not None:
        found.update(_held(settings.hold, frame))
    return found


def radius_of(empty):
    """Returns an empty's radius in Blender units: its display size times its scale."""
    return empty.empty_display_size * max(abs(scale) for scale in empty.matrix_world.to_scale())


def box_of(empty):
    """Returns the lowest and highest corner of the box around a cube empty, which may be rotated."""
    size = empty.empty_display_size
    corners = [empty.matrix_world @ Vector(corner) for corner in product((-size, size), repeat=3)]
    return [tuple(end(corner[axis] for corner in corners) for axis in range(3)) for end in (min, max)]


def _hits(context, settings):
    if settings.hits == "CURSOR":
        return [(context.scene.cursor.location, settings.hit_radius)]
    if settings.hits == "EMPTIES":
        regions = (settings.keep, settings.hold)
        empties = [item for item in context.selected_objects if item.type == "EMPTY" and item not in regions]
        if not empties:
            raise wrong("'Hit at' is set to 'Selected empties', but no empty is selected. Select at least one, or choose another "
                        "option for 'Hit at'.", parameter="impacts")
        empties.sort(key=lambda item: item.name)  # the order changes the result, and a selection has no defined order
        return [(item.matrix_world.translation, radius_of(item)) for item in empties]
    return []


def _pattern_of_impacts(description, given):
    """Returns the pattern for a request with impacts: the request's own pattern if it has one; otherwise the material's pattern (or the
    default) if this pattern uses `impacts`; otherwise `impact`."""
    pattern = description.pattern_of(given)
    if "pattern" in given or "impacts" in description.of_pattern(pattern):
        return pattern
    return "impact"


def _kept(empty, frame):
    if empty.empty_display_type == "CUBE":
        return {"keep_box": frame.box(box_of(empty))}
    return {"keep_center": frame.point(empty.matrix_world.translation), "keep_radius": frame.length(radius_of(empty))}


def _held(empty, frame):
    if empty.empty_display_type == "CUBE":
        return {"anchor_box": frame.box(box_of(empty))}
    place: Matrix = empty.matrix_world
    if empty.empty_display_type == "SINGLE_ARROW":  # it points along its z, out of the ground
        normal = (place.to_3x3() @ Vector((0, 0, 1))).normalized()
        return {"anchor_plane": [frame.point(place.translation), turned(normal)]}
    return {"anchor_points": [frame.point(place.translation)]}
