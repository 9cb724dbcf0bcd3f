# SPDX-License-Identifier: GPL-3.0-or-later
"""Cancelling stops the work of the server or the program, and leaves the scene unchanged."""
import os
import pathlib
import sys
import types

import bpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402
from support import InBlender, add_cube, eventually  # noqa: E402

LONG = {"sites": 100_000, "lloyd": 50}  # takes minutes


def scene():
    return sorted(bpy.data.objects.keys()), sorted(bpy.data.collections.keys()), bpy.context.object.hide_get()


class Cancelled(InBlender):
    def begin(self):
        add_cube()
        support.give(**LONG)
        work = support.part("run").begin(bpy.context)
        self.addCleanup(work.asking.cancel)
        return work

    def end(self, work, before):
        work.asking.cancel()
        self.assertTrue(work.asking.wait(support.PATIENCE))
        error = support.part("package").FractureError
        with self.assertRaises(error) as raised:
            work.finish(bpy.context)
        self.assertEqual(raised.exception.type, "cancelled")
        self.assertEqual(scene(), before)

    def test_a_server_stops(self):
        work = self.begin()
        before = scene()
        with support.part("package").Client(self.server.url) as client:
            eventually("a job runs", lambda: any(job.state.state == "running" for job in client.jobs()))
            self.assertFalse(work.asking.is_done)
            self.end(work, before)
            eventually("no job runs", lambda: not any(job.state.state in ("running", "queued") for job in client.jobs()))

    def test_a_program_stops(self):
        support.preferences().ask, support.preferences().program = "PROGRAM", os.environ["FRACTURE_TEST_SERVER"]
        work = self.begin()
        eventually("it computes", lambda: "computing" in work.asking.state.words)
        self.end(work, scene())

    def test_before_it_was_sent(self):
        work = self.begin()
        self.end(work, scene())

    def test_esc_takes_it_back_and_other_keys_do_nothing(self):
        """Calls the operator as Blender does. Only the window is a stand-in, because a background run has none."""
        operators = support.part("operators")
        kind = operators.OBJECT_OT_fracture_exact
        said = []
        operator = types.SimpleNamespace(_work=self.begin(), _end=lambda context: None, report=lambda kind, words: said.append(words))
        operator._finish = lambda context, work: kind._finish(operator, context, work)
        operator._refuse = lambda context, error, names: kind._refuse(operator, context, error, names)
        status = []
        context = types.SimpleNamespace(workspace=types.SimpleNamespace(status_text_set=status.append), scene=bpy.context.scene)
        before = scene()

        def event(type, value="PRESS"):
            return kind.modal(operator, context, types.SimpleNamespace(type=type, value=value))
        self.assertEqual(event("TIMER"), {"PASS_THROUGH"})
        self.assertEqual(event("X"), {"RUNNING_MODAL"})
        self.assertIn("Esc: cancel", status[-1])
        self.assertFalse(operator._work.asking.is_done)
        self.assertEqual(event("ESC"), {"RUNNING_MODAL"})
        eventually("it has ended", lambda: operator._work.asking.is_done)
        self.assertEqual(event("TIMER"), {"CANCELLED"})
        self.assertEqual(said, ["Fracture: cancelled"])
        self.assertEqual(scene(), before)


if __name__ == "__main__":
    support.main()
