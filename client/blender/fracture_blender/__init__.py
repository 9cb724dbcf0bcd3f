# SPDX-License-Identifier: GPL-3.0-or-later
"""Fracture (exact): uses a fracture server to break objects into watertight fragments with rigid bodies and bonds.

    run.py            one fracture, from the selection to the collections; start here
    operators.py      the buttons, Esc and undo        panels.py, presets.py, preferences.py   the user interface
    description.py    the server's parameters          parameters.py, properties.py            the same as properties
    frame.py          axes and units                   places.py                               hits and regions from empties
    writer.py         objects as GLB                   materials_out.py                        their materials
    asking.py         the thread with the requests     refusal.py                              errors and their locations
    fragments.py      the answer as objects            materials_in.py, bodies.py              their materials and physics
    slots.py          materials of parts, by slot
"""
import bpy

from . import operators, panels, preferences, presets, properties, slots

bl_info = {
    "name": "Fracture (exact)",
    "author": "The fracture contributors",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "3D view > Sidebar > Fracture",
    "description": "Exact, watertight fragments from a fracture server",
    "category": "Object",
}

CLASSES = (preferences.FracturePreferences, *operators.CLASSES, *presets.CLASSES, *panels.CLASSES)


def register():
    properties.register()
    properties.use(preferences.kept_description())
    slots.use()
    for entry in CLASSES:
        bpy.utils.register_class(entry)


def unregister():
    for entry in reversed(CLASSES):
        bpy.utils.unregister_class(entry)
    slots.forget()
    properties.unregister()
