# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a fracture without a user interface, from the selected objects to the new collections: begin(), wait or poll, finish()."""
from . import bodies, fragments, places, preferences, properties, slots, writer
from .asking import Asking, Request
from .package import wrong


class Run:
    """A fracture in progress; begin() starts its thread, `asking`. Only the main thread may call these methods."""

    def __init__(self, asking, written):
        self.asking = asking
        self._written = written  # the files that were sent, one per answer

    @property
    def failed_names(self):
        """The names of the objects in the request that failed."""
        number = self.asking.failed
        return self._written[number].objects if number is not None and number < len(self._written) else []

    def finish(self, context):
        """Creates the fragments of all answers and hides the originals. Returns a list of fragments.Made, the warnings, the
        notes, and what was dropped. If the run failed, raises its FractureError and creates nothing."""
        if self.asking.error is not None:
            raise self.asking.error
        for answer in self.asking.answers:
            fragments.check(answer)
        made, warnings, notes, dropped = [], [], [], []
        for answer, written in zip(self.asking.answers, self._written):
            made.append(_build(context, answer, written))
            warnings += [f"{written.objects[0]}: {warning}" for warning in answer.warnings]
            notes += [f"{written.objects[0]}: {note}" for note in answer.notes]
            dropped += [f"{written.objects[0]}: dropped: {entry}" for entry in answer.dropped]
        _select(context, made)
        return made, warnings, notes, dropped


def begin(context):
    """Writes the selected objects and starts the requests. Raises FractureError."""
    chosen = [item for item in context.selected_objects if item.type in writer.MESH_TYPES]
    if not chosen:
        raise wrong("No object with a surface is selected. Select the objects to break.")
    if context.mode != "OBJECT":
        raise wrong("The object is in edit mode, so its latest changes are not applied yet. Leave edit mode first (Tab).")
    chosen.sort(key=lambda item: item.name)
    if properties.Known.description is None:
        properties.use(preferences.ask_description(context))
        slots.use()
    scene = context.scene
    settings, parameters = scene.fracture_settings, properties.given(scene)
    parameters.update(places.places(context, properties.Known.description, parameters))
    if settings.paint != "NONE":
        parameters["density_from"] = writer.PAINT
    groups = [chosen] if settings.together else [[item] for item in chosen]
    written = [writer.write(context, group, settings.paint, settings.paint_name) for group in groups]
    try:
        requests = [Request(group[0].name, file.glb, slots.with_slots(parameters, file.materials.blender))
                    for group, file in zip(groups, written)]
    except ValueError as error:
        raise wrong(f"The parameter 'assign' cannot be read: {error}") from None
    asking = Asking(preferences.target(context), requests)
    asking.start()
    return Run(asking, written)


def _build(context, answer, written):
    scene = context.scene
    settings = scene.fracture_settings
    originals = [scene.objects[name] for name in written.objects if name in scene.objects]
    inside = originals[0].users_collection if originals else ()
    parent = inside[0] if inside else scene.collection
    made = fragments.build(context, answer, written, parent, written.objects[0])
    context.view_layer.update()  # updates dimensions and linked objects
    if settings.bodies:
        bodies.add_bodies(scene, answer, made.objects, settings.shape)
        if settings.constraints:
            bodies.add_constraints(scene, answer, made.objects, made.collection, settings.strength)
    for item in originals:
        if settings.bodies:
            bodies.remove_from_simulation(scene, item)
        if settings.hide:
            item.hide_set(True)
            item.hide_render = True
    return made


def _select(context, made):
    for item in context.selected_objects:
        item.select_set(False)
    for item in (item for entry in made for item in entry.objects.values()):
        if item.visible_get():  # the original's collection may be hidden
            item.select_set(True)
            context.view_layer.objects.active = item
