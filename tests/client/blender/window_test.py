# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests with a window: the panel is drawn, the operator runs while the user works, Esc ends it, and the results are saved
as pictures.

Blender calls back between events, so the test is a generator: it does a step, yields, and continues a moment later.
FRACTURE_TEST_PICTURES names a folder in which the pictures are kept, to be looked at.
"""
import os
import pathlib
import sys
import tempfile
import time
import traceback

import bpy
from mathutils import Vector

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import support  # noqa: E402

MOMENT = 0.05  # seconds between steps


def pictures():
    folder = pathlib.Path(os.environ.get("FRACTURE_TEST_PICTURES") or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def window():
    return bpy.context.window_manager.windows[0]


def view():
    """Returns area, region and space of the 3D view."""
    area = next(area for area in window().screen.areas if area.type == "VIEW_3D")
    return area, next(region for region in area.regions if region.type == "WINDOW"), area.spaces.active


def override():
    area, region, _ = view()
    return bpy.context.temp_override(window=window(), area=area, region=region)


def until(what, condition):
    """Lets Blender run until the condition holds."""
    end = time.monotonic() + support.PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"not within {support.PATIENCE:g} s: {what}")
        yield


def press(key):
    area, region, _ = view()
    x, y = region.x + region.width // 2, region.y + region.height // 2
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, x=x, y=y)


def fracture():
    with override():
        return bpy.ops.object.fracture_exact("INVOKE_DEFAULT", True)


def colored(path):
    """Returns how many different colours a picture has; an empty picture has only a few."""
    image = bpy.data.images.load(str(path))
    pixels = image.pixels[:]
    bpy.data.images.remove(image)
    return len({tuple(round(value, 2) for value in pixels[at:at + 3]) for at in range(0, len(pixels), 4 * 37)})


def open_panels():
    """Puts all panels into the open tab, none of them closed, and watches how they are drawn. Returns the names of the
    panels that were drawn, and the exceptions that were raised."""
    drawn, raised = set(), []

    def watched(panel):
        draw = panel.draw

        def note(self, context):
            try:
                draw(self, context)
                drawn.add(panel.__name__)
            except Exception:
                raised.append(traceback.format_exc())
        return note
    panels = support.part("panels").CLASSES
    for panel in reversed(panels):
        bpy.utils.unregister_class(panel)
    for panel in panels:
        panel.draw, panel.bl_category, panel.bl_options = watched(panel), "Item", set()
        panel.bl_order = -1
        bpy.utils.register_class(panel)
    return drawn, raised


def screenshot(name):
    path = pictures() / name
    with bpy.context.temp_override(window=window(), screen=window().screen):
        bpy.ops.screen.screenshot(filepath=str(path))
    assert colored(path) > 50


def steps(server):
    kind = support.part("operators").OBJECT_OT_fracture_exact
    support.preferences().url = server.url
    yield from until("a window", lambda: view()[1].width > 100)

    # Esc, in the middle of work that takes minutes.
    cube = support.add_cube()
    support.give(sites=100_000, lloyd=50)
    before = sorted(bpy.data.objects.keys())
    assert fracture() == {"RUNNING_MODAL"}
    assert not kind.poll(bpy.context)  # one at a time
    with support.part("package").Client(server.url) as client:
        yield from until("it runs", lambda: any(job.state.state == "running" for job in client.jobs()))
        press("G")  # would move the cube
        yield
        press("ESC")
        yield from until("it has ended", lambda: kind.current is None)
        yield from until("the server is idle", lambda: not any(job.state.state == "running" for job in client.jobs()))
    assert sorted(bpy.data.objects.keys()) == before
    assert tuple(cube.location) == (0, 0, 0)

    # An artist's three clicks, with every panel open.
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    bpy.ops.mesh.primitive_monkey_add()
    item = bpy.context.object
    item.modifiers.new("", "SUBSURF").levels = 1
    bpy.ops.object.shade_smooth()
    material = bpy.data.materials.new("Clay")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.3, 0.45, 0.6, 1)
    material.diffuse_color = (0.3, 0.45, 0.6, 1)
    item.data.materials.append(material)
    support.select(item)
    support.give(material="stone", fragments=30, seed=4)
    area, region, space = view()
    space.show_region_ui = True
    space.shading.color_type = "MATERIAL"
    drawn, raised = open_panels()
    bpy.context.scene.fracture_parameters.use_stretch_matrix = True
    bpy.context.scene.fracture_parameters.use_stretch_matrix = False
    yield from until("the panels are drawn", lambda: raised or len(drawn) == len(support.part("panels").CLASSES))
    support.settings().search = "grain"
    bpy.context.scene.fracture_parameters.use_grain = True
    drawn.clear()
    area.tag_redraw()
    yield from until("they are drawn again", lambda: raised or len(drawn) > 3)
    bpy.context.scene.fracture_parameters.use_grain = False
    assert not raised, raised[0]
    support.settings().search = "interior"
    with override():
        bpy.ops.ed.undo_push(message="before")
    assert fracture() == {"RUNNING_MODAL"}
    yield from until("fragments", lambda: kind.current is None and len(bpy.data.collections) > 1)
    pieces = [item for item in bpy.data.objects if "fracture_id" in item]
    assert abs(len(pieces) - 30) <= 3, len(pieces)
    assert bpy.data.objects["Suzanne"].hide_get()
    with override():
        bpy.ops.view3d.view_all()
    for _ in range(10):
        yield
    screenshot("window.png")

    # Undo, then redo.
    with override():
        bpy.ops.ed.undo()
    yield
    assert not [item for item in bpy.data.objects if "fracture_id" in item]
    assert not bpy.data.objects["Suzanne"].hide_get()
    with override():
        bpy.ops.ed.redo()
    yield

    # The pieces, moved apart and rendered by Workbench.
    pieces = [item for item in bpy.data.objects if "fracture_id" in item]
    for item in pieces:
        item.location *= 1.5
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.location = (2.4, -5, 1.2)
    camera.rotation_euler = (Vector((0, 0, 0)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.camera = camera
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.display.shading.light, scene.display.shading.color_type = "STUDIO", "MATERIAL"
    scene.display.shading.show_cavity = True
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 640, 480, 100
    scene.render.film_transparent = False
    scene.render.filepath = str(pictures() / "apart.png")
    bpy.ops.render.render(write_still=True)
    assert colored(scene.render.filepath) > 50

    # A mesh that cannot be used: the popup, and the mesh's open edges.
    bpy.ops.mesh.primitive_plane_add()
    support.select(bpy.context.object)
    for item in pieces:
        item.hide_set(True)
    fracture()
    yield from until("the refusal", lambda: kind.current is None)
    for _ in range(10):
        yield
    assert bpy.context.mode == "EDIT_MESH"
    screenshot("refused.png")


def main():
    bpy.context.preferences.view.show_splash = False
    support.install()
    server = support.Server()
    running = steps(server)

    def step():
        try:
            next(running)
            return MOMENT
        except StopIteration:
            print("ok")
            code = 0
        except BaseException:
            traceback.print_exc()
            code = 1
        server.stop()
        support.leave(code)
        return None
    bpy.app.timers.register(step, first_interval=MOMENT)


main()
