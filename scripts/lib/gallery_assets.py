"""Sheets of real assets broken with every material, with the assets' own materials (scripts/gallery --only real)."""
import json
import os
import pathlib
import random
import struct
import subprocess

from gallery_meshes import MESHES

MONKEY = "/usr/share/assimp/models/BLEND/Suzanne_248.blend"  # Debian: assimp-testmodels
# Searched for in the FRACTURE_TEST_MESHES folders; missing assets are left out.
ASSETS = {
    "chest": "kk_chest.glb", "barrel": "kk_barrel_large.glb", "bottle": "kk_bottle_A_brown.glb", "wall": "kk_wall.glb",
    "column": "kk_column.glb", "helmet": "FlightHelmet/FlightHelmet.gltf", "fox": "Fox.glb", "spot": "spot.obj",
    "penguin": "penguin.obj", "hammer": "hammer.obj", "building": "citybits/building_A.gltf", "plate": "kk_plate_small.glb",
    "stairs": "kk_stairs_walled.glb", "long table": "kk_table_long_decorated_C.glb", "shelf": "kk_shelf_large.glb",
    "keg": "kk_keg_decorated.glb", "banner": "kk_banner_red.glb"}
FRAGMENTS = 40  # for a mesh with one part
MORE_FOR_EACH_PART = 2  # for each further part, so that the parts break instead of only coming apart
# The choices that a judge must distinguish without colours: the name of each choice, and its materials. BLIND_NOT lists objects
# that are too thin to show their insides.
BLIND_MATERIALS = {"glass": ["glass"], "wood": ["wood"], "brick": ["brick"], "stone or concrete": ["stone", "concrete"],
                   "ice": ["ice"], "ceramic": ["ceramic"], "metal": ["metal"]}
BLIND_NOT = {"banner", "building", "plate"}
# Bricks suit walls. The `brick` preset breaks any other mesh into rubble, which looks like stone, and a warning says so.
BLIND_ONLY = {"brick": {"wall", "stairs"}}
BLIND_COLUMNS = 5  # number of columns of a sheet; with more columns, the pictures would be too small
DETAILS = {"stone", "concrete", "wood", "brick"}  # materials whose cuts have a grain that is visible only close up
REPEATS = 2  # number of times that the grain repeats along the longest side
EXPLODED = {"view": "exploded", "explode": 0.5, "margin": 0.8}
HIT = {"view": "impact", "margin": 0.85}
CLOSE = {"view": "exploded", "explode": 0.5, "margin": 0.35}


def document_of(glb):
    return json.loads(glb[20:20 + struct.unpack_from("<I", glb, 12)[0]])


def bounds_of(glb):
    """Returns the corners of the world-space bounding box of one of the server's GLB files. Rotated and scaled nodes of instances do
    not count."""
    document = document_of(glb)
    low, high = [float("inf")] * 3, [float("-inf")] * 3
    for node in document["nodes"]:
        if "mesh" not in node or "rotation" in node or "scale" in node:
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
        """Returns {label: path} for each available asset."""
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
        """Runs bake. `jobs`: (input, output, parameters). bake reports refused jobs, which get no output."""
        if self.gallery.keep:
            jobs = [job for job in jobs if not job[1].exists()]
        if not jobs:
            return
        manifest = self.folder / "manifest.ndjson"
        lines = [{"input": str(i.resolve()), "output": str(o.resolve()), "parameters": p} for i, o, p in jobs]
        manifest.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
        subprocess.run([self.gallery.root / "build/release/server/fracture-server", "bake", "--quiet", "--manifest", manifest],
                       check=False)

    def broken(self, pairs, more=None):
        """Returns the files made for (material, label) pairs, and each asset's hit: point and radius."""
        files = self.files()
        intact = {label: self.folder / f"{label}.glb" for label in files}
        self.bake([(files[label], intact[label], {"sites": 1}) for label in files])
        whole = {label: path.read_bytes() for label, path in intact.items() if path.exists()}
        boxes = {label: bounds_of(glb) for label, glb in whole.items()}
        parts = {label: sum("mesh" in node for node in document_of(glb)["nodes"]) for label, glb in whole.items()}
        made, jobs, hits = {}, [], {}
        for label, (low, high) in boxes.items():
            size = [h - l for l, h in zip(low, high)]
            hits[label] = ([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]],
                           round(0.6 * sum(s * s for s in size) ** 0.5 / 2, 6))
        for material, label in pairs or [(m, label) for m in self.gallery.materials for label in boxes]:
            if label not in boxes:
                continue
            parameters = {"material": material, "fragments": FRAGMENTS + MORE_FOR_EACH_PART * (parts[label] - 1), "seed": 7,
                          **(more or {})}
            if "impacts" in {p["name"] for p in self.gallery.patterns[self.gallery.materials[material]["pattern"]]}:
                parameters["impacts"] = [hits[label][0]]
            if material in DETAILS:
                size = max(h - l for l, h in zip(*boxes[label]))
                parameters.update({"interior_detail": material, "interior_uv_scale": round(REPEATS / size, 6)})
            output = made[material, label] = self.folder / f"{label}_{material}.glb"
            jobs.append((files[label], output, parameters))
        self.bake(jobs)
        return {pair: output for pair, output in made.items() if output.exists()}, hits

    def cell(self, output, hit):
        """Returns the options for a picture of the output file."""
        return {"file": str(output.relative_to(self.gallery.folder)), "impact": hit[0], "impact-radius": hit[1],
                "impact-direction": [-0.25, 0, -1]}

    @staticmethod
    def close(cell):
        """Returns a cell's options with the picture centred on the hit."""
        return {**cell, "target": cell["impact"]}

    def draw(self):
        made, hits = self.broken(None)
        for material in self.gallery.materials:
            cells = {label: self.cell(made[material, label], hit) for label, hit in hits.items() if (material, label) in made}
            rows = [(label, {}, [cell, cell, self.close(cell)]) for label, cell in cells.items()]
            self.gallery.sheet(f"real_{material}",
                               f"material={material}, fragments={FRAGMENTS}, {MORE_FOR_EACH_PART} more for each further part",
                               [("exploded", EXPLODED), ("after an impact", HIT),
                                ("close by", CLOSE)], rows)

    def draw_blind(self, seed):
        """Draws ten cells of seven materials without colours or names, for a judge who must identify them. blind.key contains the
        answers. Each object has the roughness, metalness, opacity and grain of its material."""
        draw = random.Random(seed)
        materials = list(BLIND_MATERIALS) + draw.sample(sorted(BLIND_MATERIALS), 3)
        draw.shuffle(materials)
        labels = [label for label in self.files() if label not in BLIND_NOT]
        if len(labels) < len(materials):
            self.gallery.failures.append(f"blind: only {len(labels)} of the {len(materials)} assets that it needs were found; add folders "
                                         "with more of them to FRACTURE_TEST_MESHES.")
            return
        draw.shuffle(labels)
        pairs = []
        for m in sorted(materials, key=lambda m: m not in BLIND_ONLY):
            label = next((each for each in labels if each in BLIND_ONLY.get(m, labels)), labels[0])
            labels.remove(label)
            pairs.append((draw.choice(BLIND_MATERIALS[m]), label))
        draw.shuffle(pairs)
        made, hits = self.broken(pairs, {"exterior": "material"})
        cells = [self.cell(made[pair], hits[pair[1]]) for pair in pairs if pair in made]
        letters = "ABCDEFGHIJ"[:len(cells)]
        for first in range(0, len(cells), BLIND_COLUMNS):
            some = cells[first:first + BLIND_COLUMNS]
            self.gallery.sheet(f"blind_{first // BLIND_COLUMNS + 1}", "glass, wood, brick, stone or concrete, ice, ceramic, metal?",
                               [(letter, {}) for letter in letters[first:first + BLIND_COLUMNS]],
                               [("exploded", EXPLODED, some), ("hit", HIT, some),
                                ("close by", CLOSE, [self.close(cell) for cell in some])],
                               {"look": "grey"})
        key = "".join(f"{letter} {pair[0]} {pair[1]}\n" for letter, pair in zip(letters, [p for p in pairs if p in made]))
        (self.gallery.folder / "blind.key").write_text(key, encoding="utf-8")
