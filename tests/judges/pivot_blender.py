"""pivot=source in Blender's own importer: the fragments are where the source is, whose nodes are moved, turned and scaled.

usage: blender --background --factory-startup --python-exit-code 1 --python pivot_blender.py -- FOLDER
"""
import importlib.util
import pathlib
import sys

import bpy

if importlib.util.find_spec("numpy") is None:
    print("skipped: Blender's importer of glTF needs numpy (Debian: python3-numpy)", flush=True)
    sys.exit()
import numpy

if not hasattr(numpy, "bool"):  # Blender 3.4's importer uses this name, which Debian's numpy 1.24 lacks
    numpy.bool = bool


def points_of(path):
    """World positions of the vertices of all meshes in the file, by the names of their objects."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(path))
    bpy.context.view_layer.update()
    return {item.name: [tuple(item.matrix_world @ vertex.co) for vertex in item.data.vertices]
            for item in bpy.data.objects if item.type == "MESH"}


def missing(wanted, found, near):
    return [p for p in wanted if not any(all(abs(x - y) <= near for x, y in zip(p, q)) for q in found)]


folder = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
source = [p for points in points_of(folder / "source.glb").values() for p in points]
size = max(max(p[axis] for p in source) - min(p[axis] for p in source) for axis in range(3))
shown = points_of(folder / "fragments.glb")
for kind, names in (("fragments", [name for name in shown if "_intact" not in name]),
                    ("intact", [name for name in shown if "_intact" in name])):
    points = [p for name in names for p in shown[name]]
    lost = missing(source, points, 1e-6 * size)
    print(f"{kind}: {len(names)} objects, {len(source)} corners, {len(lost)} missing")
    if lost or not names:
        sys.exit(1)
