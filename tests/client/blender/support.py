# SPDX-License-Identifier: GPL-3.0-or-later
"""Code that the tests inside Blender share: the installed add-on, the server, scenes, and sums over meshes in double
precision."""
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import threading
import time
import traceback
import unittest
from array import array

import bpy

ROOT = pathlib.Path(__file__).resolve().parents[3]
NAME = "fracture_blender"
PATIENCE = 120.0  # seconds, after which an expected event counts as missing
SKIPPED = 77


def install():
    """Installs the zip file as a user does. Returns the module."""
    if NAME not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_install(filepath=os.environ["FRACTURE_TEST_ZIP"])
        bpy.ops.preferences.addon_enable(module=NAME)
    return sys.modules[NAME]


def preferences():
    return bpy.context.preferences.addons[NAME].preferences


def part(name):
    """Returns a module of the add-on."""
    return importlib.import_module(f"{NAME}.{name}")


def main():
    """Runs a test file."""
    try:
        names = [name for name in sys.argv[sys.argv.index("--") + 1:]] if "--" in sys.argv else []
        program = unittest.main(module="__main__", argv=["test", *names], exit=False, verbosity=2)
    except BaseException:  # otherwise Blender would silently go on
        traceback.print_exc()
        leave(1)
    result = program.result
    leave(1 if not result.wasSuccessful() else SKIPPED if result.skipped and len(result.skipped) >= result.testsRun else 0)


def leave(code):
    """Ends without Blender's own shutdown, which may wait for a display that no longer exists."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def eventually(what, condition):
    """Waits until the condition holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"not within {PATIENCE:g} s: {what}")
        time.sleep(0.005)  # pause: between two checks, up to the limit


class Server:
    """`fracture-server serve` on free ports, which it names in its log."""

    def __init__(self, *flags):
        self.process = subprocess.Popen(
            [os.environ["FRACTURE_TEST_SERVER"], "serve", "--port", "0", "--admin-port", "0", "--threads", "1", "--drain-delay", "0",
             "--log-format", "text", *flags], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        for line in self.process.stderr:
            found = re.search(r"serving on (http://127\.0\.0\.1:\d+)", line)
            if found:
                break
        else:
            raise RuntimeError("the server ended before it listened")
        self.url = found.group(1)
        self._reader = threading.Thread(target=self.process.stderr.read, daemon=True)
        self._reader.start()  # a pipe that nobody reads would fill up

    def stop(self):
        self.process.terminate()
        self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)


class InBlender(unittest.TestCase):
    """A test case with the add-on, an empty scene for each test, and one server for the class."""

    @classmethod
    def setUpClass(cls):
        install()
        cls.server = Server()
        cls.addClassCleanup(cls.server.stop)

    def setUp(self):
        empty_scene()
        preferences().ask = "SERVER"
        preferences().url = self.server.url
        preferences().timeout = 60

    def fracture(self, **parameters):
        """Fractures the selection with the operator. Returns the new collections. Parameters are those of the panel."""
        before = set(bpy.data.collections.keys())
        give(**parameters)
        self.assertEqual(bpy.ops.object.fracture_exact(), {"FINISHED"})
        new = [item for item in bpy.data.collections if item.name not in before and "fracture_parameters" in item]
        self.assertTrue(new)
        return new

    def refused(self):
        """Returns the operator's error message as one line."""
        with self.assertRaises(RuntimeError) as raised:
            bpy.ops.object.fracture_exact()
        return " ".join(str(raised.exception).split())


def empty_scene():
    if bpy.context.object is not None and bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    own = preferences()
    kept = own.url, own.ask, own.program
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    own = preferences()
    own.url, own.ask, own.program = kept


def give(**parameters):
    """Sets these parameters and switches all others off."""
    group = bpy.context.scene.fracture_parameters
    for name in part("properties").Known.parameters:
        setattr(group, "use_" + name, False)
    for name, value in parameters.items():
        setattr(group, name, value)


def settings():
    return bpy.context.scene.fracture_settings


def mesh_file(name):
    """Returns a path from the folders of real meshes; skips the test if there is none."""
    for folder in os.environ.get("FRACTURE_TEST_MESHES", "").split(os.pathsep):
        path = pathlib.Path(folder) / name
        if folder and path.is_file():
            return str(path)
    raise unittest.SkipTest(f"FRACTURE_TEST_MESHES names no folder with {name}")


def load(name):
    """Imports a mesh file with Blender and selects its objects. Returns the objects with meshes."""
    path = mesh_file(name)
    before = set(bpy.data.objects.keys())
    if name.endswith(".obj"):
        bpy.ops.wm.obj_import(filepath=path)
    else:
        if importlib.util.find_spec("numpy") is None:
            raise unittest.SkipTest("Blender's importer of glTF needs numpy (Debian: python3-numpy)")
        numpy = importlib.import_module("numpy")
        if not hasattr(numpy, "bool"):  # The importer of Blender 3.4 uses a name that is missing from Debian's numpy 1.24.
            numpy.bool = bool
        bpy.ops.import_scene.gltf(filepath=path)
    new = [item for item in bpy.data.objects if item.name not in before and item.type == "MESH"]
    select(*new)
    return new


def select(*items):
    bpy.context.view_layer.update()  # from here on it knows the new objects
    for item in bpy.context.view_layer.objects:
        item.select_set(item in items)
    if items:
        bpy.context.view_layer.objects.active = items[0]
    bpy.context.view_layer.update()


def add_cube(name="Box", size=2.0, location=(0, 0, 0)):
    bpy.ops.mesh.primitive_cube_add(size=size, location=location)
    item = bpy.context.object
    item.name = item.data.name = name
    select(item)
    return item


def add_empty(location, size=1.0, kind="PLAIN_AXES", name="Place"):
    item = bpy.data.objects.new(name, None)
    item.empty_display_type, item.empty_display_size, item.location = kind, size, location
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


def fragments_of(collection):
    return [item for item in collection.all_objects if item.type == "MESH"]


def bonds_of(collection):
    return [item for item in collection.all_objects if item.rigid_body_constraint is not None]


def volume(item, evaluated=False):
    """The volume of the object in the scene, by the divergence theorem, in double precision (Python's floats)."""
    source = item.evaluated_get(bpy.context.evaluated_depsgraph_get()) if evaluated else item
    mesh = source.to_mesh()
    try:
        mesh.calc_loop_triangles()
        world = [[float(value) for value in row] for row in item.matrix_world]
        points = [[sum(row[k] * vertex.co[k] for k in range(3)) for row in world[:3]] for vertex in mesh.vertices]
        total = 0.0
        for triangle in mesh.loop_triangles:
            (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (points[number] for number in triangle.vertices)
            total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    finally:
        source.to_mesh_clear()
    sign = -1.0 if item.matrix_world.determinant() < 0 else 1.0
    return sign * total / 6.0


def open_edges(mesh):
    """Returns the edges with an odd number of faces."""
    count = array("i", bytes(4 * len(mesh.edges)))
    corners = array("i", bytes(4 * len(mesh.loops)))
    mesh.loops.foreach_get("edge_index", corners)
    for edge in corners:
        count[edge] += 1
    return sum(number % 2 for number in count)
