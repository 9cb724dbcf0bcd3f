# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties of a scene: one for each parameter that the server describes, and those of the add-on.

`scene.fracture_parameters` is made anew whenever a description comes. Each parameter has two properties: its value, and
`use_<name>`, whether it is sent. A script that sets a value need not set the other one: setting it means to send it. What is
not sent is as the material has it.
"""
import zlib

import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty,
                       StringProperty)

from .frame import Frame
from .parameters import MOST_INTEGER, sendable, single

# What a new scene asks for, where the server knows it: a thing that breaks into forty ragged chunks.
FIRST = {"material": "stone", "fragments": 40}


class Known:
    """The description in use, and its parameters by name; empty until there is one."""

    description = None
    parameters = {}
    group = None  # the class of scene.fracture_parameters


def use(description):
    """Makes the properties anew. Values that a scene has already stay."""
    forget()
    Known.description = description
    Known.parameters = {} if description is None else sendable(description)
    annotations = {}
    for parameter in Known.parameters.values():
        annotations[parameter.name] = _property(parameter)
        annotations["use_" + parameter.name] = BoolProperty(
            name="Send", description=f"Send '{parameter.name}'. Otherwise it is as the material has it, or as usual",
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
    """The parameters of the panel, as they are sent."""
    group, frame = scene.fracture_parameters, Frame.of(scene)
    return {name: parameter.to_request(getattr(group, name), frame) for name, parameter in Known.parameters.items()
            if getattr(group, "use_" + name)}


def usual(scene, parameter):
    """What holds while it is not sent, as Blender has it; None where nothing says it."""
    group = scene.fracture_parameters
    material = getattr(group, "material", "") if getattr(group, "use_material", False) else ""
    value = Known.description.usual(parameter.name, {"material": material})
    return None if value is None else parameter.to_blender(value, Frame.of(scene))


def _filling(parameter):
    """When a parameter is switched on, it begins with what held until then."""
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
        items = [(name, name.replace("_", " ").capitalize(), _about(parameter, name), "NONE", _number(name)) for name in names]
        return EnumProperty(items=items, default=default if default in names else names[0], **words)
    if parameter.kind == "integer":
        return IntProperty(default=default or 0, min=max(-MOST_INTEGER, int(parameter.least or 0)),
                           max=min(MOST_INTEGER, int(parameter.most or MOST_INTEGER)), **words)
    if parameter.kind == "number":
        unit = {1: "LENGTH", 3: "VOLUME"}.get(parameter.power, "NONE")
        # A scene may have any scale: what is a length has the server's range only there.
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


def _number(name):
    """What a .blend file keeps of an enumeration: of the name, so that a server with one more material changes no scene."""
    return zlib.crc32(name.encode("utf-8")) & MOST_INTEGER


def _about(parameter, name):
    """A pattern or a material has a description of its own."""
    for table in (Known.description.patterns, Known.description.materials):
        if name in table and parameter.name in ("pattern", "material"):
            return table[name].get("description", "").rstrip(".")
    return ""


def _tooltip(parameter):
    text = parameter.description.rstrip(".")
    if parameter.kind == "list":
        text += f". As text: {parameter.entry.get('text', 'a,b,c')}"
    unit = parameter.unit if not parameter.power else ""
    return text + (f". In {unit}" if unit else "")


class FractureSettings(bpy.types.PropertyGroup):
    """What is no parameter: where it is hit, held and painted, and what is made of the answer."""

    # As a dictionary: with colons, checkers take their words for types.
    __annotations__ = {
        "together": BoolProperty(
            name="Together", description="All selected objects are one: they share the number of fragments. "
            "Otherwise each is broken by itself", default=False),
        "hits": EnumProperty(name="Hit at", default="NONE", items=[
            ("NONE", "Nothing", "As the pattern has it, or as the parameters below say"),
            ("CURSOR", "3D cursor", "One hit at the 3D cursor"),
            ("EMPTIES", "Selected empties", "A hit at each selected empty; its display size is the radius")]),
        "hit_kind": EnumProperty(name="Breaks", default="IMPACT", items=[
            ("IMPACT", "Everything", "The whole object breaks, around the hits (impacts)"),
            ("LOCAL", "What is near", "Only what is within the radius of a hit breaks (local_point)")]),
        "hit_radius": FloatProperty(name="Radius", description="Of a hit at the 3D cursor", default=0.25, min=1e-6, unit="LENGTH"),
        "keep": PointerProperty(name="Keep", type=bpy.types.Object, poll=lambda self, item: item.type == "EMPTY",
                                description="Nothing is cut in this empty: of a cube in the box around it, of any other in the sphere"),
        "hold": PointerProperty(name="Hold", type=bpy.types.Object, poll=lambda self, item: item.type == "EMPTY",
                                description="Fragments that this empty touches are held: a cube a box, a single arrow the plane "
                                "it stands on, any other the point"),
        "paint": EnumProperty(name="Painted by", default="NONE", items=[
            ("NONE", "Nothing", "Fragments are as fine everywhere as the pattern makes them"),
            ("GROUP", "Vertex group", "Weight 1 gets most fragments, weight 0 fewest"),
            ("COLOR", "Colour attribute", "White gets most fragments, black fewest")]),
        "paint_name": StringProperty(name="Name", description="Of the vertex group or the colour attribute"),
        "bodies": BoolProperty(name="Rigid bodies", default=True, description="Each fragment is a rigid body"),
        "shape": EnumProperty(name="Shape", default="CONVEX_HULL", items=[
            ("CONVEX_HULL", "Convex hull", "Fast; of ragged chunks it is larger than they are"),
            ("MESH", "Mesh", "As it is; slow")]),
        "constraints": BoolProperty(name="Breakable constraints", default=True,
                                    description="A fixed constraint for each bond, that breaks when it carries too much"),
        "strength": FloatProperty(name="Strength", default=1.0, min=0.0, soft_max=10.0, precision=4,
                                  description="Bonds break at so many times the strength that their material and area give them"),
        "hide": BoolProperty(name="Hide the original", default=True, description="In the viewport and in renders; it is never deleted"),
        "search": StringProperty(name="Search", description="Show the parameters that have this in their name or description",
                                 options={"TEXTEDIT_UPDATE", "SKIP_SAVE"}),
    }


def register():
    bpy.utils.register_class(FractureSettings)
    bpy.types.Scene.fracture_settings = PointerProperty(type=FractureSettings)


def unregister():
    forget()
    del bpy.types.Scene.fracture_settings
    bpy.utils.unregister_class(FractureSettings)
