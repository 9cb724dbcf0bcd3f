# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene's properties: one pair for each parameter that the server describes, and the add-on's own settings.

`scene.fracture_parameters` is rebuilt for each new description. Each parameter has two properties: its value, and `use_<name>`,
which decides whether the value is sent. Setting a value turns `use_<name>` on. If a parameter is not sent, the material's value or
the default applies.
"""
import zlib

import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty,
                       StringProperty)

from .frame import Frame
from .parameters import MOST_INTEGER, sendable, single

# The parameters that are set in a new scene, if the server has them. They give 40 ragged chunks.
FIRST = {"material": "stone", "fragments": 40}


class Known:
    """The current description, and its parameters by name. Empty until a description is loaded."""

    description = None
    parameters = {}
    group = None  # the class of scene.fracture_parameters


def use(description):
    """Rebuilds the properties from a description. Scenes keep their values."""
    forget()
    Known.description = description
    Known.parameters = {} if description is None else sendable(description)
    annotations = {}
    for parameter in Known.parameters.values():
        annotations[parameter.name] = _property(parameter)
        annotations["use_" + parameter.name] = BoolProperty(
            name="Send", description=f"Send '{parameter.name}'. If this is off, the material's value or the default applies",
            default=parameter.name in FIRST, update=_filling(parameter))
    Known.group = type("FractureParameters", (bpy.types.PropertyGroup,), {"__annotations__": annotations})
    bpy.utils.register_class(Known.group)
    bpy.types.Scene.fracture_parameters = PointerProperty(type=Known.group)


def forget():
    if Known.group is not None:
        del bpy.types.Scene.fracture_parameters
        bpy.utils.unregister_class(Known.group)
        Known.group = None


def given(scene):
    """Returns the parameters ticked in the panel, with the values to send."""
    group, frame = scene.fracture_parameters, Frame.of(scene)
    return {name: parameter.to_request(getattr(group, name), frame) for name, parameter in Known.parameters.items()
            if getattr(group, "use_" + name)}


def usual(scene, parameter):
    """Returns the effective value of a parameter that is not sent, as a Blender value; None if it has no default."""
    group = scene.fracture_parameters
    material = getattr(group, "material", "") if getattr(group, "use_material", False) else ""
    value = Known.description.usual(parameter.name, {"material": material})
    return None if value is None else parameter.to_blender(value, Frame.of(scene))


def _filling(parameter):
    """Returns the function that runs when a parameter is switched on. It sets the parameter to the value that was effective
    before."""
    def update(group, context):
        if getattr(group, "use_" + parameter.name) and not group.is_property_set(parameter.name):
            value = usual(group.id_data, parameter)
            if value is not None:
                setattr(group, parameter.name, value)
    return update


def _sending(parameter):
    def update(group, context):
        if not getattr(group, "use_" + parameter.name):
            setattr(group, "use_" + parameter.name, True)
    return update


def _property(parameter):
    words = {"name": parameter.name.replace("_", " ").capitalize(), "description": _tooltip(parameter),
             "update": _sending(parameter)}
    default = FIRST.get(parameter.name, parameter.default)
    frame = Frame()
    default = None if default is None else parameter.to_blender(default, frame)
    if parameter.kind == "enum":
        names = parameter.entry["enum"]
        items = [(name, name.replace("_", " ").capitalize(), _about(parameter, name), "NONE", item_number(name)) for name in names]
        return EnumProperty(items=items, default=default if default in names else names[0], **words)
    if parameter.kind == "integer":
        return IntProperty(default=default or 0, min=max(-MOST_INTEGER, int(parameter.least or 0)),
                           max=min(MOST_INTEGER, int(parameter.most or MOST_INTEGER)), **words)
    if parameter.kind == "number":
        unit = {1: "LENGTH", 3: "VOLUME"}.get(parameter.power, "NONE")
        # A length has no range here, because the range depends on the scene's scale. The server checks the length.
        ends = {} if parameter.power else {key: single(end) for key, end in (("min", parameter.least), ("max", parameter.most))
                                           if end is not None}
        return FloatProperty(default=default or 0.0, unit=unit, precision=3, **ends, **words)
    if parameter.kind == "color":
        return FloatVectorProperty(size=3, subtype="COLOR_GAMMA", min=0.0, max=1.0, default=default or (0.5, 0.5, 0.5), **words)
    if parameter.kind in ("vector", "box", "matrix"):
        size = {"vector": 3, "box": 6, "matrix": 9}[parameter.kind]
        return FloatVectorProperty(size=size, default=default or (0.0,) * size, precision=3,
                                   subtype="XYZ" if size == 3 else "NONE", **words)
    return StringProperty(default=default or "", **words)


def item_number(name):
    """Returns the number of an enumeration's item in a .blend file. It depends only on the name, so new materials on the server do not
    change old scenes."""
    return zlib.crc32(name.encode("utf-8")) & MOST_INTEGER


def _about(parameter, name):
    """Returns the description of a pattern or material; "" for other items."""
    for table in (Known.description.patterns, Known.description.materials):
        if name in table and parameter.name in ("pattern", "material"):
            return table[name].get("description", "").rstrip(".")
    return ""


def _tooltip(parameter):
    text = parameter.description.rstrip(".")
    if parameter.kind == "list":
        text += f". Format: {parameter.entry.get('text', 'a,b,c')}"
    unit = parameter.unit if not parameter.power else ""
    return text + (f". In {unit}" if unit else "")


class FractureSettings(bpy.types.PropertyGroup):
    """The add-on's settings that are not parameters: hits, regions, paint, and the result."""

    # A dictionary instead of annotations, because checkers would read strings in annotations as types.
    __annotations__ = {
        "together": BoolProperty(
            name="Together", description="Break all selected objects as one, with a shared number of fragments. If this is off, each "
            "object breaks separately", default=False),
        "hits": EnumProperty(name="Hit at", default="NONE", items=[
            ("NONE", "Nothing", "No hits, unless a parameter sets them"),
            ("CURSOR", "3D cursor", "One hit at the 3D cursor"),
            ("EMPTIES", "Selected empties", "A hit at each selected empty. The radius is its display size times its scale")]),
        "hit_kind": EnumProperty(name="Breaks", default="IMPACT", items=[
            ("IMPACT", "Everything", "The whole object breaks, with smaller pieces near the hits (impacts)"),
            ("LOCAL", "Near the hits", "The object breaks only within the radius of a hit (local_point)")]),
        "hit_radius": FloatProperty(name="Radius", description="Radius of a hit at the 3D cursor", default=0.25, min=1e-6,
                                    unit="LENGTH"),
        "keep": PointerProperty(name="Keep", type=bpy.types.Object, poll=lambda self, item: item.type == "EMPTY",
                                description="An empty; nothing inside it is cut. A cube protects the box around it, any other type a sphere"),
        "hold": PointerProperty(name="Hold", type=bpy.types.Object, poll=lambda self, item: item.type == "EMPTY",
                                description="An empty that keeps fragments from falling. A cube holds the fragments in its box, a single "
                                "arrow holds those on its plane, and any other type holds the fragment at its point"),
        "paint": EnumProperty(name="Painted by", default="NONE", items=[
            ("NONE", "Nothing", "Only the pattern determines the sizes of the fragments"),
            ("GROUP", "Vertex group", "Fragments are smallest at weight 1 and largest at weight 0"),
            ("COLOR", "Colour attribute", "Fragments are smallest in white areas and largest in black areas")]),
        "paint_name": StringProperty(name="Name", description="Name of the vertex group or colour attribute"),
        "bodies": BoolProperty(name="Rigid bodies", default=True, description="Turn each fragment into a rigid body"),
        "shape": EnumProperty(name="Shape", default="CONVEX_HULL", items=[
            ("CONVEX_HULL", "Convex hull", "Fast; larger than the fragment if the fragment is ragged"),
            ("MESH", "Mesh", "The exact shape of the fragment; slow")]),
        "constraints": BoolProperty(name="Breakable constraints", default=True,
                                    description="Add a fixed constraint for each bond. Each constraint breaks under too much load"),
        "strength": FloatProperty(name="Strength", default=1.0, min=0.0, soft_max=10.0, precision=4,
                                  description="Factor applied to each bond's strength, which depends on material and area"),
        "hide": BoolProperty(name="Hide the original", default=True,
                             description="Hide the original in the viewport and in renders. The original is never deleted"),
        "search": StringProperty(name="Search", description="Show parameters whose name or description contains this text",
                                 options={"TEXTEDIT_UPDATE", "SKIP_SAVE"}),
    }


def register():
    bpy.utils.register_class(FractureSettings)
    bpy.types.Scene.fracture_settings = PointerProperty(type=FractureSettings)


def unregister():
    forget()
    del bpy.types.Scene.fracture_settings
    bpy.utils.unregister_class(FractureSettings)
