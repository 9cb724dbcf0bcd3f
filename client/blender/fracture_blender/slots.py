# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials by slot: a Blender material can make its parts break like one of the server's materials (parameter `assign`)."""
import json

import bpy
from bpy.props import EnumProperty

from . import properties
from .properties import Known

OBJECT = "NONE"  # these parts break like the object


def use():
    """Adds the property 'Breaks as' to Blender's materials. It lists the materials of the current description. Existing values are kept."""
    forget()
    if Known.description is None or "assign" not in Known.parameters:
        return
    items = [(OBJECT, "Like the object", "These parts break like the rest of the object", "NONE", 0)]
    items += [(name, name.replace("_", " ").capitalize(), entry.get("description", "").rstrip("."), "NONE", properties.item_number(name))
              for name, entry in Known.description.materials.items()]
    bpy.types.Material.fracture_material = EnumProperty(
        name="Breaks as", items=items, default=OBJECT,
        description="How parts break if this material covers most of their surface")


def forget():
    if hasattr(bpy.types.Material, "fracture_material"):
        del bpy.types.Material.fracture_material


def with_slots(parameters, materials):
    """Returns the parameters with an entry of `assign` for each of these Blender materials that breaks in its own way. Entries that
    the panel sets come first, so they decide."""
    found = [{"slot": material.name, "material": material.fracture_material} for material in materials
             if getattr(material, "fracture_material", OBJECT) not in ("", OBJECT)]
    if not found:
        return parameters
    return {**parameters, "assign": entries_of(parameters.get("assign", "")) + found}


def entries_of(text):
    """Reads the text of `assign`: JSON, or selector:material;selector:material. Raises ValueError."""
    text = text.strip()
    if text.startswith("["):
        return json.loads(text)
    entries = []
    for one in filter(None, (part.strip() for part in text.split(";"))):
        selector, colon, material = one.rpartition(":")
        if not colon or not selector or not material:
            raise ValueError(f"'{one}' must have the form selector:material, such as Wall_*:brick.")
        kind, equals, name = selector.partition("=")
        if not equals or kind not in ("node", "slot", "part"):
            kind, name = "node", selector
        entries.append({kind: int(name) if kind == "part" else name, "material": material})
    return entries
