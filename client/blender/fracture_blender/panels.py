# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels in the 3D view's sidebar."""
import bpy

from . import preferences
from .operators import OBJECT_OT_fracture_exact
from .presets import FRACTURE_PT_presets
from .properties import Known, usual

FRONT = ("material", "pattern", "fragments", "seed")  # parameters in the first panel, if the server has them


class Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Fracture"


class Below(Sidebar):
    """Base class of the subpanels of the main panel."""
    bl_parent_id = "FRACTURE_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return Known.description is not None


class FRACTURE_PT_main(Sidebar, bpy.types.Panel):
    bl_label = "Fracture (exact)"

    def draw_header_preset(self, context):
        FRACTURE_PT_presets.draw_panel_header(self.layout)

    def draw(self, context):
        layout, own = self.layout, preferences.of(context)
        row = layout.row(align=True)
        row.prop(own, "ask", text="")
        row.prop(own, "url" if own.ask == "SERVER" else "program", text="")
        row.operator("fracture.describe", text="", icon="FILE_REFRESH")
        if Known.description is None:
            layout.label(text="No parameters yet: click the arrows above.", icon="INFO")
            layout.operator("fracture.describe")
            return
        draw_parameters(layout, context.scene, FRONT)
        working = OBJECT_OT_fracture_exact.current is not None
        column = layout.column()
        column.scale_y = 1.4
        column.operator("object.fracture_exact", text="Working (Esc cancels)" if working else "Fracture", icon="MOD_EXPLODE")


class FRACTURE_PT_places(Below, bpy.types.Panel):
    bl_label = "Hits and regions"

    def draw(self, context):
        layout, settings = self.layout, context.scene.fracture_settings
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.prop(settings, "hits")
        if settings.hits != "NONE":
            layout.prop(settings, "hit_kind", expand=True)
        if settings.hits == "CURSOR":
            layout.prop(settings, "hit_radius")
        layout.prop(settings, "keep")
        layout.prop(settings, "hold")
        layout.prop(settings, "paint")
        item = context.object
        if settings.paint == "GROUP" and item is not None:
            layout.prop_search(settings, "paint_name", item, "vertex_groups")
        elif settings.paint == "COLOR" and item is not None and item.type == "MESH":
            layout.prop_search(settings, "paint_name", item.data, "color_attributes")


class FRACTURE_PT_slots(Below, bpy.types.Panel):
    bl_label = "Material slots"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        materials = {slot.material.name: slot.material for item in context.selected_objects for slot in item.material_slots
                     if slot.material is not None}
        if not materials or not hasattr(bpy.types.Material, "fracture_material"):
            layout.label(text="The selected objects have no materials." if not materials else "The server does not support slots.", icon="INFO")
            return
        for name in sorted(materials):
            layout.prop(materials[name], "fracture_material", text=name)


class FRACTURE_PT_pattern(Below, bpy.types.Panel):
    bl_label = "Pattern"

    def draw(self, context):
        names = Known.description.of_pattern(_pattern(context.scene))
        draw_parameters(self.layout, context.scene, [name for name in names if name not in FRONT])


class FRACTURE_PT_all(Below, bpy.types.Panel):
    bl_label = "All parameters"

    def draw(self, context):
        search = context.scene.fracture_settings.search.lower()
        self.layout.prop(context.scene.fracture_settings, "search", text="", icon="VIEWZOOM")
        of_patterns = Known.description.of_any_pattern()
        names = [name for name, parameter in Known.parameters.items()
                 if search in f"{name} {name.replace('_', ' ')} {parameter.description}".lower()
                 and (search or name not in of_patterns) and (search or name not in FRONT)]
        draw_parameters(self.layout, context.scene, names)


class FRACTURE_PT_result(Below, bpy.types.Panel):
    bl_label = "Result"

    def draw(self, context):
        layout, settings = self.layout, context.scene.fracture_settings
        layout.use_property_split, layout.use_property_decorate = True, False
        for name in ("together", "hide", "bodies"):
            layout.prop(settings, name)
        column = layout.column()
        column.active = settings.bodies
        for name in ("shape", "constraints", "strength"):
            column.prop(settings, name)


def draw_parameters(layout, scene, names):
    """Draws parameters with their checkboxes. If a checkbox is off, the effective value is shown greyed out."""
    group = scene.fracture_parameters
    for name in names:
        parameter = Known.parameters.get(name)
        if parameter is None:
            continue
        on = getattr(group, "use_" + name)
        row = layout.row(align=True)
        row.prop(group, "use_" + name, text="")
        if on and parameter.kind in ("vector", "box", "matrix"):
            column = row.column(align=True)
            column.label(text=group.bl_rna.properties[name].name)
            grid = column.grid_flow(row_major=True, columns=3, align=True)
            for number in range(group.bl_rna.properties[name].array_length):
                grid.prop(group, name, index=number, text="")
        elif on:
            row.prop(group, name)
        else:
            value = usual(scene, parameter)
            shown = "" if value is None else f": {_text(value)}"
            inactive = row.row()
            inactive.active = False
            inactive.label(text=group.bl_rna.properties[name].name + shown)


def _pattern(scene):
    group = scene.fracture_parameters
    given = {name: getattr(group, name) for name in ("material", "pattern") if getattr(group, "use_" + name, False)}
    return Known.description.pattern_of(given)


def _text(value):
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value))
    return f"{value:.4g}" if isinstance(value, float) else str(value)


CLASSES = (FRACTURE_PT_main, FRACTURE_PT_places, FRACTURE_PT_slots, FRACTURE_PT_pattern, FRACTURE_PT_all, FRACTURE_PT_result)
