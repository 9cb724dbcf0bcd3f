# SPDX-License-Identifier: GPL-3.0-or-later
"""A single undo restores everything, and redo makes it again."""
import pathlib
import sys

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, add_cube  # noqa: E402

KINDS = ("objects", "meshes", "collections", "materials", "images")


def everything():
    """Everything that the operator changes, as plain values, because references to Blender's data are invalid after an
    undo."""
    scene = bpy.context.scene
    world = scene.rigidbody_world
    return {
        **{kind: sorted(item.name for item in getattr(bpy.data, kind) if item.users) for kind in KINDS},
        "hidden": sorted(item.name for item in scene.objects if item.hide_get() or item.hide_render),
        "selected": sorted(item.name for item in bpy.context.selected_objects),
        "active": bpy.context.object and bpy.context.object.name,
        "bodies": None if world is None else sorted(item.name for item in world.collection.objects),
        "constraints": None if world is None or world.constraints is None else len(world.constraints.objects),
        "mode": bpy.context.mode,
    }


class Undo(InBlender):
    def test_one_step_restores_everything(self):
        add_cube()
        bpy.ops.rigidbody.object_add()
        mass = bpy.context.object.rigid_body.mass = 7.5
        support.give(material="wood", levels="3,20")
        bpy.ops.ed.undo_push(message="before")
        before = everything()
        self.assertEqual(bpy.ops.object.fracture_exact("EXEC_DEFAULT", True), {"FINISHED"})
        after = everything()
        self.assertEqual(len([name for name in after["collections"] if " level 0 " in name]), 3)
        self.assertIn("Box", after["hidden"])
        bpy.ops.ed.undo()
        self.assertEqual(everything(), before)
        self.assertEqual(bpy.context.scene.objects["Box"].rigid_body.mass, mass)
        bpy.ops.ed.redo()
        self.assertEqual(everything(), after)
        bpy.ops.ed.undo()
        self.assertEqual(everything(), before)
        self.assertEqual(bpy.ops.object.fracture_exact("EXEC_DEFAULT", True), {"FINISHED"})
        self.assertEqual(everything(), after)

    def test_a_scene_without_physics_has_none_again(self):
        add_cube()
        bpy.ops.ed.undo_push(message="before")
        before = everything()
        bpy.ops.object.fracture_exact("EXEC_DEFAULT", True)
        self.assertIsNotNone(everything()["bodies"])
        bpy.ops.ed.undo()
        self.assertEqual(everything(), before)


if __name__ == "__main__":
    support.main()
