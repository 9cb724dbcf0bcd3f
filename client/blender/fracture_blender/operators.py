# SPDX-License-Identifier: GPL-3.0-or-later
"""What the buttons do."""
import bpy

from . import preferences, properties, refusal, run
from .package import FractureError

LOOK = 0.1  # s between two looks at the thread
# What a view may still do while it works. All else would change the scene that the answer is for.
PASSED = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEMOVE", "TIMER"}
MOST_WARNINGS = 5


class OBJECT_OT_fracture_exact(bpy.types.Operator):
    """Break the selected objects into exact, watertight fragments. Esc takes it back"""

    bl_idname = "object.fracture_exact"
    bl_label = "Fracture (exact)"
    bl_options = {"REGISTER", "UNDO"}

    current = None  # the operator at work in a window: there is one at a time

    @classmethod
    def poll(cls, context):
        return cls.current is None and context.mode == "OBJECT"

    def execute(self, context):
        """Of a script, or without a window: waits."""
        try:
            work = run.begin(context)
        except FractureError as error:
            return self._refuse(context, error, [])
        try:
            work.asking.wait()
        except KeyboardInterrupt:
            work.asking.cancel()
            work.asking.wait()
        return self._finish(context, work)

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self._work = run.begin(context)
        except FractureError as error:
            return self._refuse(context, error, [])
        self._timer = context.window_manager.event_timer_add(LOOK, window=context.window)
        context.window_manager.modal_handler_add(self)
        OBJECT_OT_fracture_exact.current = self
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self._work.asking.cancel()
        if event.type == "TIMER" and self._work.asking.is_done:
            self._end(context)
            return self._finish(context, self._work)
        state = self._work.asking.state
        context.workspace.status_text_set(f"Fracture: {state.words}, {state.percent} %    Esc: cancel")
        return {"PASS_THROUGH"} if event.type in PASSED else {"RUNNING_MODAL"}

    def cancel(self, context):
        """Blender takes it back: the file is closed, or another one opened."""
        self._work.asking.cancel()
        self._end(context)

    def _end(self, context):
        OBJECT_OT_fracture_exact.current = None
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)

    def _finish(self, context, work):
        try:
            made, warnings = work.finish(context)
        except FractureError as error:
            return self._refuse(context, error, work.failed_names)
        for warning in warnings[:MOST_WARNINGS]:
            self.report({"WARNING"}, warning)
        if len(warnings) > MOST_WARNINGS:
            self.report({"WARNING"}, f"{len(warnings) - MOST_WARNINGS} more warnings")
        count = sum(len(entry.objects) for entry in made)
        self.report({"INFO"}, f"{count} fragments")
        return {"FINISHED"}

    def _refuse(self, context, error, names):
        if error.type == "cancelled":
            self.report({"INFO"}, "Fracture: cancelled")
            return {"CANCELLED"}
        shown = refusal.show_place(context, error, names)
        lines = refusal.words(error) + ([shown] if shown else [])
        # With a window it is a popup; a script gets it as the exception of an operator that reports an error.
        self.report({"ERROR"}, "\n".join(lines))
        return {"FINISHED"} if shown else {"CANCELLED"}  # what was shown can be undone


class FRACTURE_OT_describe(bpy.types.Operator):
    """Ask the server or the program in use for its materials, patterns and parameters"""

    bl_idname = "fracture.describe"
    bl_label = "Ask for parameters"
    bl_options = {"INTERNAL"}

    def execute(self, context):
        try:
            found = preferences.ask_description(context)
        except FractureError as error:
            self.report({"ERROR"}, "\n".join(refusal.words(error)))
            return {"CANCELLED"}
        properties.use(found)
        self.report({"INFO"}, f"{len(properties.Known.parameters)} parameters of {found.source}")
        return {"FINISHED"}


CLASSES = (OBJECT_OT_fracture_exact, FRACTURE_OT_describe)
