# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets for the panel. They use Blender's own preset system, which stores files in the user folder."""
import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .properties import FractureSettings, Known

FOLDER = "object.fracture_exact"
SCENE_ONLY = {"keep", "hold", "search"}  # not saved, because objects belong to one .blend file


class FRACTURE_PT_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Fracture presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "fracture.preset_add"


class FRACTURE_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Add or remove a fracture preset"""

    bl_idname = "fracture.preset_add"
    bl_label = "Fracture preset"
    preset_menu = "FRACTURE_PT_presets"
    preset_subdir = FOLDER
    preset_defines = ["parameters = bpy.context.scene.fracture_parameters", "settings = bpy.context.scene.fracture_settings"]

    @property
    def preset_values(self):
        """Lists the properties to save. Each value comes before its `use_…` switch, because setting the value turns the switch on."""
        parameters = [f"parameters.{part}{name}" for name in Known.parameters for part in ("", "use_")]
        return parameters + [f"settings.{name}" for name in FractureSettings.__annotations__ if name not in SCENE_ONLY]


CLASSES = (FRACTURE_PT_presets, FRACTURE_OT_preset_add)
