"""Sheets of real assets of every material, with the materials that the assets bring (scripts/gallery --only real)."""
import json
import os
import pathlib
import struct
import subprocess

from gallery_meshes import MESHES

MONKEY = "/usr/share/assimp/models/BLEND/Suzanne_248.blend"  # Debian: assimp-testmodels
# Looked for in the folders of FRACTURE_TEST_MESHES; what is not there is left out.
ASSETS = {
    "chest": "kk_chest.glb", "barrel": "kk_barrel_large.glb", "bottle": "kk_bottle_A_brown.glb", "wall": "kk_wall.glb",
    "column": "kk_column.glb", "helmet": "FlightHelmet/FlightHelmet.gltf", "fox": "Fox.glb", "spot": "spot.obj",
    "penguin": "penguin.obj", "hammer": "hammer.obj", "building": "citybits/building_A.gltf", "plate": "kk_plate_small.glb",
    "stairs": "kk_stairs_walled.glb", "long table": "kk_table_long_decorated_C.glb", "shelf": "kk_shelf_large.glb",
    "keg": "kk_keg_decorated.glb", "banner": "kk_banner_red.glb"}
FRAGMENTS = 40


def bounds_of(glb):
    """Corners of the box around the positions of a GLB of the service, in the world (its nodes only move)."""
    document = json.loads(glb[20:20 + struct.unpack_from("<I", glb, 12)[0]])
    low, high = [float("inf")] * 3, [float("-inf")] * 3
    for node in document["nodes"]:
        if "mesh" not in node:
            continue
        shift = node.get("translation", [0, 0, 0])
        for primitive in document["meshes"][node["mesh"]]["primitives"]:
            accessor = document["accessors"][primitive["attributes"]["POSITION"]]
            low = [min(a, b + s) for a, b, s in zip(low, accessor["min"], shift)]
            high = [max(a, b + s) for a, b, s in zip(high, accessor["max"], shift)]
    return low, high


class AssetSheets:
    def __init__(self, gallery):
        self.gallery = gallery
        self.folder = gallery.models / "real"
        self.folder.mkdir(parents=True, exist_ok=True)

    def files(self):
        """Label and path of what is here."""
        folders = [pathlib.Path(f) for f in os.environ.get("FRACTURE_TEST_MESHES", "").split(":") if f]
        found = {}
        for label, name in ASSETS.items():
            found.update({label: folder / name for folder in folders if (folder / name).exists()})
        if os.path.exists(MONKEY):
            found["monkey"] = pathlib.Path(MONKEY)
        vase = self.folder / "vase.obj"
        vase.write_text(MESHES["vase"]()[0], encoding="utf-8")
        found["vase"] = vase
        return found

    def bake(self, jobs):
        """jobs: (input, output, parameters). What is refused is said by bake, and has no output."""
        if self.gallery.keep:
            jobs = [job for job in jobs if not job[1].exists()]
        if not jobs:
            return
        manifest = self.folder / "manifest.ndjson"
        lines = [{"input": str(i.resolve()), "output": str(o.resolve()), "parameters": p} for i, o, p in jobs]
        manifest.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        subprocess.run([self.gallery.root / "build/release/server/fracture-server", "bake", "--quiet", "--manifest", manifest],
                       check=False)

    def draw(self):
        files = self.files()
        intact = {label: self.folder / f"{label}.glb" for label in files}
        self.bake([(files[label], intact[label], {"sites": 1}) for label in files])
        boxes = {label: bounds_of(path.read_bytes()) for label, path in intact.items() if path.exists()}
        made, jobs = {}, []
        for material in self.gallery.materials:
            for label, (low, high) in boxes.items():
                hit = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]]
                parameters = {"material": material, "fragments": FRAGMENTS, "seed": 7}
                if "impacts" in {p["name"] for p in self.gallery.patterns[self.gallery.materials[material]["pattern"]]}:
                    parameters["impacts"] = [hit]
                output = made[material, label] = self.folder / f"{label}_{material}.glb"
                jobs.append((files[label], output, parameters))
        self.bake(jobs)
        for material in self.gallery.materials:
            rows = []
            for label, (low, high) in boxes.items():
                output = made[material, label]
                if not output.exists():
                    continue
                size = [h - l for l, h in zip(low, high)]
                radius = 0.6 * sum(s * s for s in size) ** 0.5 / 2
                options = {"impact": [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]],
                           "impact-radius": round(radius, 6), "impact-direction": [-0.25, 0, -1]}
                rows.append((label, options, [{"file": str(output.relative_to(self.gallery.folder))}] * 3))
            self.gallery.sheet(f"real_{material}", f"material={material}, fragments={FRAGMENTS}",
                               [("exploded", {"view": "exploded", "explode": 0.5}), ("after an impact", {"view": "impact"}),
                                ("close by", {"view": "exploded", "explode": 0.5, "margin": 0.35})], rows)
