"""gallery.py ROOT [--only …] [--size …] [--keep]: see scripts/gallery, which calls it.

Gets the materials and patterns from the server (GET /patterns), breaks the meshes with each of them, and draws the sheets with
fracture-render.
"""
import argparse
import contextlib
import hashlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request

from gallery_assets import MONKEY, AssetSheets, bounds_of
from gallery_meshes import MESHES, box

SITES = {"pane": 60, "wall": 70, "monkey": 60, "column": 60, "vase": 50}
ASSETS = 6  # files of FRACTURE_TEST_MESHES on the sheet
ASSET_BYTES = 400_000
# The mesh that proto/materials.md shows for each material and pattern. Each mesh was chosen because it suits the material or pattern.
SHOWN = {"glass": "pane", "wood": "wall", "concrete": "column", "stone": "monkey", "brick": "wall", "ceramic": "vase",
         "metal": "monkey", "cast_iron": "column", "ice": "monkey", "plaster": "monkey", "terracotta": "vase",
         "sandstone": "column", "crystal": "monkey"}
SHOWN_PATTERNS = {"radial": "pane", "grid": "wall", "brick": "wall", "slice": "column"}  # the others: monkey
COLUMNS = [("intact", {}), ("exploded", {"view": "exploded", "explode": 0.5}), ("after an impact", {"view": "impact"})]


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Server:
    """A server on free ports, and the few requests that the gallery sends."""

    def __init__(self, program, log):
        self.port, self.admin = free_port(), free_port()
        self.process = subprocess.Popen(
            [program, "serve", "--port", str(self.port), "--admin-port", str(self.admin), "--enable-format", "blend",
             "--drain-delay", "0", "--log-level", "warn"], stderr=log)
        while True:
            if self.process.poll() is not None:
                sys.exit("gallery: the server did not start; see build/gallery/server.log")
            with contextlib.suppress(OSError):
                urllib.request.urlopen(f"http://127.0.0.1:{self.admin}/readyz").read()
                return
            time.sleep(0.1)

    def ask(self, method, path, body=None, kind="application/json"):
        """Sends a request and returns the bytes of the response. Raises RuntimeError with the server's message if the server
        refuses the request."""
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", body, {"Content-Type": kind}, method=method)
        try:
            with urllib.request.urlopen(request) as answer:
                return answer.read()
        except urllib.error.HTTPError as error:
            problem = json.loads(error.read() or "{}")
            raise RuntimeError(f"{method} {path}: {error.code} {problem.get('detail', '')}") from None

    def stop(self):
        self.process.terminate()
        self.process.wait()


class Mesh:
    """A stored mesh: its address, bounding box, point of impact, and picture options."""

    def __init__(self, server, name, data, query, kind, impact):
        self.server, self.name = server, name
        self.path = "/meshes/sha256:" + hashlib.sha256(data).hexdigest()
        server.ask("PUT", self.path + query, data, kind)
        self.query, self.kind = query, kind
        self.intact = self.fracture({"sites": 1})
        low, high = bounds_of(self.intact)
        size = [h - l for l, h in zip(low, high)]
        # Default: the middle of the front, which faces the camera.
        self.impact = list(impact or [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]])
        axis = size.index(max(size))
        self.grain = [1 if k == axis else 0 for k in range(3)]
        self.radius = 0.55 * sum(s * s for s in size) ** 0.5 / 2
        self.options = {"impact": self.impact, "impact-radius": round(1.1 * self.radius, 6), "grain": self.grain,
                        "impact-direction": [-0.25, 0, -1],
                        # The camera shows the whole bounding sphere; a wide object leaves much of it empty.
                        "margin": 1.1 if axis == 1 else 0.85}

    def fracture(self, parameters):
        return self.server.ask("POST", self.path + "/fracture", json.dumps(parameters).encode())


def sites_for(mesh, pattern, patterns):
    """Returns the parameters for the number of pieces and the point of impact, if the pattern has such parameters."""
    known = {p["name"] for p in patterns.get(pattern, [])} or {"sites"}
    parameters = {"seed": 7}
    if "sites" in known:
        parameters["sites"] = SITES.get(mesh.name, 50)
    if "impacts" in known:
        parameters["impacts"] = [mesh.impact]
    return parameters


class Gallery:
    def __init__(self, root, arguments):
        self.root = root
        self.folder = root / "build/gallery"
        self.models = self.folder / "glb"
        self.models.mkdir(parents=True, exist_ok=True)
        self.render = root / "build/release/client/cli/fracture-render"
        self.size, self.keep, self.seed = arguments.size, arguments.keep, arguments.seed
        self.only = set(arguments.only.split(",")) if arguments.only else None
        self.log = open(self.folder / "server.log", "w", encoding="utf-8")
        self.server = Server(root / "build/release/server/fracture-server", self.log)
        self.failures = []

    def wants(self, *names):
        return self.only is None or bool(self.only & set(names))

    def describe(self):
        """Reads the server's materials and patterns. A server without GET /patterns has only the uniform pattern."""
        try:
            table = json.loads(self.server.ask("GET", "/patterns"))
        except RuntimeError:
            table = {"materials": [], "patterns": [{"name": "uniform", "parameters": []}], "parameters": []}
        self.materials = {m["name"]: m["parameters"] for m in table["materials"]}
        self.patterns = {p["name"]: p["parameters"] for p in table["patterns"]}
        help_text = subprocess.run([self.render, "--help"], capture_output=True, text=True, check=True).stdout
        self.looks = {name for name in self.materials if name in help_text}

    def meshes(self):
        made = []
        if os.path.exists(MONKEY):
            data = pathlib.Path(MONKEY).read_bytes()
            made.append(Mesh(self.server, "monkey", data, "?format=blend", "application/octet-stream", None))
        else:
            print("gallery: the monkey mesh is missing; install the Debian package assimp-testmodels", file=sys.stderr)
        for name, make in MESHES.items():
            text, impact = make()
            made.append(Mesh(self.server, name, text.encode(), "", "model/obj", impact))
        return made

    def model(self, mesh, label, parameters):
        """Fractures a mesh and writes the answer to a file. Returns its path relative to the sheets; None if the server refuses the
        request."""
        path = self.models / f"{mesh.name}_{label}.glb"
        if not (self.keep and path.exists()):
            try:
                path.write_bytes(mesh.fracture(parameters))
            except RuntimeError as refusal:
                self.failures.append(f"{mesh.name}, {label}: {refusal}")
                return None
        return str(path.relative_to(self.folder))

    def sheet(self, name, title, columns, rows, options=None):
        """Draws a sheet. `rows`: (label, options, [options for each cell, None for an empty cell])."""
        rows = [row for row in rows if all(cell is not None for cell in row[2])]
        if not rows:
            return
        description = {"title": title, "options": {"size": self.size, "supersample": 2, **(options or {})},
                       "columns": [{"label": label, "options": own} for label, own in columns],
                       "rows": [{"label": label, "options": own} for label, own, _ in rows],
                       "cells": [cells for _, _, cells in rows]}
        file = self.folder / f"{name}.json"
        file.write_text(json.dumps(description, indent=1), encoding="utf-8")
        start = time.monotonic()
        subprocess.run([self.render, "--sheet", file, "-o", self.folder / f"{name}.png", "-q"], check=True)
        print(f"   {name}.png   {len(rows)} x {len(columns)} pictures, {time.monotonic() - start:.0f} s")

    def material_sheets(self, meshes):
        for material, sets in self.materials.items():
            if not self.wants("materials", material):
                continue
            rows = []
            for mesh in meshes:
                parameters = {"material": material, **sites_for(mesh, sets.get("pattern", "uniform"), self.patterns)}
                broken = self.model(mesh, material, parameters)
                intact = self.model(mesh, f"{material}_intact", {"material": material, "pattern": "uniform", "sites": 1})
                rows.append((mesh.name, mesh.options, [None if f is None else {"file": f} for f in (intact, broken, broken)]))
            look = {"look": material} if material in self.looks else {}
            self.sheet(f"material_{material}", f"material={material}", COLUMNS, rows, look)

    def pattern_sheet(self, meshes):
        if not self.wants("patterns"):
            return
        rows = []
        for pattern in self.patterns:
            if pattern == "points":
                continue  # this pattern needs the caller's own points
            request = {"pattern": pattern} if len(self.patterns) > 1 else {}
            cells = []
            for mesh in meshes:
                file = self.model(mesh, f"pattern_{pattern}", {**request, **sites_for(mesh, pattern, self.patterns)})
                cells.append(None if file is None else {"file": file, **mesh.options})
            rows.append((pattern, {}, cells))
        self.sheet("patterns", "Patterns; each fragment has its own colour", [(mesh.name, {}) for mesh in meshes], rows,
                   {"view": "exploded", "explode": 0.25, "colors": "fragment"})

    def rough_sheet(self):
        """Draws the materials with rough cuts next to the same cuts without roughness, all without textures."""
        if not self.wants("rough"):
            return
        text, impact = box((1, 1, 1), (0.5, 0.8, 0.5))  # thin objects leave little space for relief
        mesh = Mesh(self.server, "block", text.encode(), "", "model/obj", impact)
        rows = []
        for material, sets in self.materials.items():
            if not sets.get("rough_amplitude"):
                continue
            request = {"material": material, **sites_for(mesh, sets.get("pattern", "uniform"), self.patterns), "sites": 12}
            files = [self.model(mesh, f"{material}_{label}", {**request, **more})
                     for label, more in (("flat", {"rough_amplitude": 0}), ("rough", {}))]
            rows.append((material, mesh.options, [None if f is None else {"file": f} for f in files]))
        self.sheet("rough", "Flat and rough cuts, 12 sites",
                   [("rough_amplitude=0", {}), ("rough_amplitude of the material", {})],
                   rows, {"view": "exploded", "explode": 0.9, "colors": "interior"})

    def paper_sheet(self, meshes):
        """Draws the paper's cells next to ours, on the paper's mesh if it is available."""
        if not self.wants("paper"):
            return
        mesh = meshes[0]
        rows = []
        for label, dual in (("ours (dual=circumcenter)", "circumcenter"), ("the paper's (dual=barycenter)", "barycenter")):
            file = self.model(mesh, f"dual_{dual}", {"dual": dual, "sites": 50, "seed": 7})
            rows.append((label, mesh.options, [None if file is None else {"file": file}] * 3))
        self.sheet("paper", "Voronoi cells and hulls of barycentres, 50 sites",
                   [("assembled", {"colors": "fragment"}), ("exploded", {"view": "exploded", "colors": "fragment"}),
                    ("cut faces", {"view": "exploded", "colors": "interior"})], rows)

    def overview_sheet(self, meshes):
        """Draws the README's picture: one object for each of six materials."""
        if not self.wants("overview"):
            return
        by_name = {mesh.name: mesh for mesh in meshes}
        pairs = [(name, material) for name, material in (("pane", "glass"), ("vase", "ceramic"), ("wall", "brick"),
                                                         ("column", "concrete"), ("wall", "wood"), ("monkey", "stone"))
                 if name in by_name and material in self.materials]
        cells = []
        for name, material in pairs:
            mesh, pattern = by_name[name], self.materials[material].get("pattern", "uniform")
            file = self.model(mesh, material, {"material": material, **sites_for(mesh, pattern, self.patterns)})
            look = {"look": material} if material in self.looks else {}
            cells.append(None if file is None else {"file": file, **mesh.options, **look})
        self.sheet("overview", "", [(f"material={material}", {}) for _, material in pairs],
                   [("exploded", {"view": "exploded", "explode": 0.4}, cells), ("hit", {"view": "impact"}, cells)])

    def page_pictures(self, meshes):
        """Draws a small picture of each material and pattern, written directly to proto/pictures. This happens only if --only
        contains `page`."""
        if self.only is None or "page" not in self.only:
            return
        by_name = {mesh.name: mesh for mesh in meshes}
        folder = self.root / "proto/pictures"
        folder.mkdir(exist_ok=True)
        wanted = [(f"material_{name}", {"material": name}, sets.get("pattern", "uniform"), SHOWN[name],
                   ["--look", name] if name in self.looks else []) for name, sets in self.materials.items()]
        wanted += [(f"pattern_{name}", {"pattern": name}, name, SHOWN_PATTERNS.get(name, "monkey"), ["--colors", "fragment"])
                   for name in self.patterns if name != "points"]
        for label, request, pattern, name, options in wanted:
            mesh = by_name[name]
            file = self.model(mesh, label, {**request, **sites_for(mesh, pattern, self.patterns)})
            if file is None:
                continue
            grain = ",".join(map(str, mesh.options["grain"]))
            subprocess.run([self.render, self.folder / file, "-o", folder / f"{label}.png", "-q", "--size", "240x180",
                            "--supersample", "2", "--view", "exploded", "--explode", "0.35", "--grain", grain,
                            "--margin", str(mesh.options["margin"]), *options], check=True)
            subprocess.run(["pngquant", "--force", "--strip", "--quality", "50-90", "--ext", ".png", folder / f"{label}.png"],
                           check=True)
        print(f"   {len(wanted)} pictures in proto/pictures")

    def level_sheet(self, meshes):
        """Draws one hierarchy: each level separately, with a colour per cluster, then the fragments."""
        if not self.wants("levels"):
            return
        levels = [6, 30, 150]
        columns = [(f"level {k}: {count}", {"colors": "level", "level": k, "by-group": True})
                   for k, count in enumerate(levels[:-1])]
        columns.append((f"fragments: {levels[-1]}", {"colors": "level", "level": 0}))
        rows = []
        for mesh in meshes:
            file = self.model(mesh, "levels", {"levels": levels, "seed": 7})
            rows.append((mesh.name, mesh.options, [None if file is None else {"file": file}] * len(columns)))
        self.sheet("levels", f"levels={levels}", columns, rows, {"view": "exploded", "explode": 0.5})

    def local_sheet(self, meshes):
        """Draws a hit that breaks only the area around it. The rest stays in one piece, or breaks as the pattern determines."""
        if not self.wants("local"):
            return
        rows = []
        for mesh in meshes:
            hit = {"seed": 7, "sites": 12, "local_sites": 40,
                   "local_point": mesh.impact, "local_radius": 0.5 * mesh.radius}
            whole = self.model(mesh, "local_whole", {**hit, "local_rest": "whole"})
            fractured = self.model(mesh, "local_fractured", {**hit, "local_rest": "fractured"})
            rows.append((mesh.name, mesh.options, [None if f is None else {"file": f} for f in (whole, whole, fractured)]))
        self.sheet("local", "local_point, local_radius: 40 sites near a hit",
                   [("the rest whole", {}), ("exploded", {"view": "exploded"}), ("the rest fractured", {"view": "exploded"})],
                   rows, {"explode": 0.3, "colors": "fragment"})

    def asset_sheet(self):
        """Draws textured third-party meshes with their own materials."""
        folder = os.environ.get("FRACTURE_TEST_MESHES", "").split(":")[0]
        if not folder or not self.wants("assets"):
            return
        rows = []
        for path in sorted(pathlib.Path(folder).glob("*.glb")):
            if len(rows) == ASSETS or path.stat().st_size > ASSET_BYTES or path.stat().st_size < 10_000:
                continue
            try:
                mesh = Mesh(self.server, path.stem, path.read_bytes(), "", "model/gltf-binary", None)
            except RuntimeError as refusal:
                self.failures.append(f"{path.name}: {refusal}")
                continue
            broken = self.model(mesh, "uniform", {"sites": 40, "seed": 7})
            intact = self.model(mesh, "intact", {"sites": 1})
            rows.append((mesh.name, mesh.options, [None if f is None else {"file": f} for f in (intact, broken, broken)]))
        self.sheet("assets", "Their own materials", COLUMNS, rows)

    def run(self):
        try:
            self.describe()
            meshes = self.meshes()
            print(f"== sheets in {self.folder}")
            self.paper_sheet(meshes)
            self.pattern_sheet(meshes)
            self.overview_sheet(meshes)
            self.page_pictures(meshes)
            self.level_sheet(meshes)
            self.local_sheet(meshes)
            self.rough_sheet()
            self.material_sheets(meshes)
            self.asset_sheet()
            if self.only is not None and "real" in self.only:
                AssetSheets(self).draw()
            if self.only is not None and "blind" in self.only:
                AssetSheets(self).draw_blind(self.seed)
        finally:
            self.server.stop()
            self.log.close()
        for failure in self.failures:
            print("gallery: " + failure, file=sys.stderr)
        return 1 if self.failures else 0


def main():
    parser = argparse.ArgumentParser(prog="scripts/gallery")
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("--only", help="overview, page, materials, patterns, levels, local, rough, paper, assets, real, blind, or "
                        "the name of a material; separate several with commas")
    parser.add_argument("--size", default="400x300", help="size of one picture")
    parser.add_argument("--seed", type=int, default=1, help="seed of the `blind` sheets")
    parser.add_argument("--keep", action="store_true", help="reuse the GLB files of the last run")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # raises an exception, so that the script stops the server before it exits
    try:
        return Gallery(arguments.root, arguments).run()
    except (RuntimeError, subprocess.CalledProcessError) as error:
        print(f"gallery: {error}", file=sys.stderr)
        return 1


sys.exit(main())
