# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators behind the buttons."""
import bpy

from . import preferences, properties, refusal, run, slots
from .package import FractureError

LOOK = 0.1  # s between two polls of the thread
# Events that are allowed while the operator works. Other events could change the scene to which the answer belongs.
PASSED = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEMOVE", "TIMER"}
MOST_SENTENCES = 5  # maximum number of warnings shown, of notes, and of dropped items


def counted(count, thing):
    return f"{count:,} {thing}{'' if count == 1 else 's'}"


class OBJECT_OT_fracture_exact(bpy.types.Operator):
    """Break the selected objects into exact, watertight fragments. Esc cancels"""

    bl_idname = "object.fracture_exact"
    bl_label = "Fracture (exact)"
    bl_options = {"REGISTER", "UNDO"}

    current = None  # the operator that is working in a window; there is one at a time

    @classmethod
    def poll(cls, context):
        return cls.current is None and context.mode == "OBJECT"

    def execute(self, context):
        """Waits for the result. Scripts call this, and so does Blender when it has no window."""
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
        """Stops the work. Blender calls this when the file is closed or another file is opened."""
        self._work.asking.cancel()
        self._end(context)

    def _end(self, context):
        OBJECT_OT_fracture_exact.current = None
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)

    def _finish(self, context, work):
        try:
            made, warnings, notes, dropped = work.finish(context)
        except FractureError as error:
            return self._refuse(context, error, work.failed_names)
        self._tell("INFO", notes, "note")
        self._tell("INFO", dropped, "dropped thing")
        self._tell("WARNING", warnings, "warning")
        count = sum(len(entry.objects) for entry in made)
        self.report({"INFO"}, counted(count, "fragment"))
        return {"FINISHED"}

    def _tell(self, kind, sentences, name):
        for sentence in sentences[:MOST_SENTENCES]:
            self.report({kind}, sentence)
        if len(sentences) > MOST_SENTENCES:
            more = len(sentences) - MOST_SENTENCES
            self.report({kind}, f"{counted(more, f'more {name}')} {'is' if more == 1 else 'are'} not shown")

    def _refuse(self, context, error, names):
        if error.type == "cancelled":
            self.report({"INFO"}, "Fracture: cancelled")
            return {"CANCELLED"}
        shown = refusal.show_place(context, error, names)
        lines = refusal.words(error) + ([shown] if shown else [])
        # With a window, this shows a popup. In a script, the reported error becomes an exception.
        self.report({"ERROR"}, "\n".join(lines))
        return {"FINISHED"} if shown else {"CANCELLED"}  # with FINISHED, the user can undo the selection or the empty


class FRACTURE_OT_describe(bpy.types.Operator):
    """Load the current materials, patterns and parameters from the server or program"""

    bl_idname = "fracture.describe"
    bl_label = "Update parameters"
    bl_options = {"INTERNAL"}

    def execute(self, context):
        try:
            found = preferences.ask_description(context)
        except FractureError as error:
            self.report({"ERROR"}, "\n".join(refusal.words(error)))
            return {"CANCELLED"}
        properties.use(found)
        slots.use()
        self.report({"INFO"}, f"{len(properties.Known.parameters)} parameters from {found.source}")
        return {"FINISHED"}


CLASSES = (OBJECT_OT_fracture_exact, FRACTURE_OT_describe)
