#!/usr/bin/env python3
"""Writes proto/parameters.md from the table of parameters that fracture-server holds (GET /limits, GET /patterns).

    parameters_page.py build/release/server/fracture-server             writes the page
    parameters_page.py build/release/server/fracture-server --check     exits with 1 where the page says something else
    parameters_page.py build/release/server/fracture-server --measure   prints COSTS, measured anew (needs valgrind)

Every parameter stands under one subject: one that is under none, or under two, is an error.
"""
import argparse
import contextlib
import difflib
import json
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import textwrap
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "proto/parameters.md"
MONKEY = "/usr/share/assimp/models/BLEND/Suzanne_248.blend"  # Debian: assimp-testmodels

FIRST = ["material", "fragments", "seed", "impacts", "unit"]
SUBJECTS = [
    ("The mesh", "What the file means, and what is done to it before it breaks.",
     ["format", "unit", "up", "nodes", "materials", "repair", "weld_tolerance", "thickness", "shell", "shell_fraction", "shell_ball"]),
    ("How it breaks", "Where the cuts go. [Patterns](#patterns) and [materials](#materials) have pictures below.",
     ["material", "pattern", "sites", "levels", "seed", "lloyd", "density_from", "stretch", "grain", "grain_of", "stretch_matrix"]),
    ("Ragged chunks", "Cells grown together: fragments that are not convex, with `uniform`, `impact` and `clustered`.",
     ["cells_per_fragment", "size_spread", "max_hulls"]),
    ("Of single patterns", "Each belongs to the patterns that list it [below](#patterns), and is refused with any other.",
     ["points", "impacts", "radius", "exponent", "share", "clusters", "around", "axis", "spokes", "rings", "growth", "merge", "crushed", "jitter",
      "cell", "bond", "mortar", "normals", "spacing", "tilt"]),
    ("Rough cuts", "Noise on the cut faces; both sides still match. `rough_amplitude=0` makes a material's cuts flat.",
     ["rough_amplitude", "rough_frequency", "rough_octaves"]),
    ("Sizes and budgets", "`report.size` of the answer says what was made, and how the volumes are distributed.",
     ["fragments", "min_volume", "min_fraction", "min_of_mean", "max_volume", "max_fragments", "max_triangles"]),
    ("Where nothing is cut", "", ["keep_center", "keep_radius", "keep_box"]),
    ("Hits", "Break only what is near, and name what changed "
     "([how a game uses them](interface.md#what-is-hit-again)).",
     ["local_point", "local_radius", "local_sites", "local_rest", "of", "delta", "local_new"]),
    ("A fragment again", "", ["fragment", "fragment_sites", "fragment_seed"]),
    ("What holds", "`report.support` says what each bond carries, which are too weak, and what falls.",
     ["anchor_plane", "anchor_box", "anchor_points", "gravity", "broken"]),
    ("Look of the outside", "", ["exterior"]),
    ("Look of the cuts", "", ["interior", "interior_color", "interior_mix", "interior_shade", "interior_opacity", "interior_crushed",
                                "interior_roughness", "interior_metallic", "interior_material", "interior_name",
                                "interior_detail", "interior_uv_scale", "interior_uv_u", "interior_uv_v"]),
    ("Physics and engines", "", ["physics", "ue_collision", "pivot", "density", "mass", "friction", "restitution", "bond_strength"]),
    ("The paper's cells", "", ["dual", "drop_above"]),
]

# Instructions of one `fracture-server bake` of the monkey with 50 sites on one thread (without reading the file, which an
# import process does), divided by those of `pattern=uniform`. --measure prints them.
COSTS = {
    "pattern=uniform": 1.0, "pattern=points": 1.0, "pattern=impact": 1.0, "pattern=radial": 1.2, "pattern=grid": 1.5,
    "pattern=brick": 2.1, "pattern=slice": 2.0, "pattern=clustered": 1.0,
    "lloyd=1": 1.1, "levels=5,20,50": 1.0, "rough_amplitude=0.05": 2.2, "dual=barycenter": 2.0, "physics=none": 0.9,
    "sites=500": 3.4, "sites=5000": 25.9, "cells_per_fragment=6": 2.0,
    "shell_fraction=0.05": 32.8,
}


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def ask(program, *paths):
    """The server's JSON answers to GET of each path."""
    port, admin = free_port(), free_port()
    server = subprocess.Popen([program, "serve", "--port", str(port), "--admin-port", str(admin), "--drain-delay", "0",
                               "--log-level", "error"])
    try:
        for _ in range(600):
            if server.poll() is not None:
                sys.exit("parameters_page: the server did not start")
            with contextlib.suppress(OSError), urllib.request.urlopen(f"http://127.0.0.1:{admin}/readyz") as ready:
                ready.read()
                break
            time.sleep(0.1)
        else:
            sys.exit("parameters_page: the server did not become ready within a minute")
        answers = []
        for path in paths:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}") as answer:
                answers.append(json.load(answer))
        return answers
    finally:
        server.terminate()
        server.wait()


def number(value):
    if isinstance(value, list):
        return ", ".join(map(number, value))
    if isinstance(value, float) and value == int(value) and abs(value) < 1e6:
        return str(int(value))
    if value == 2 ** 53 - 1:
        return "2^53 - 1"
    return f"{value:g}" if isinstance(value, float) else str(value)


def span(spec):
    return f"{number(spec['minimum'])} to {number(spec['maximum'])}"


def values(spec):
    """What may be given, in words."""
    kind, text = spec["type"], spec.get("text", "")
    if "enum" in spec:
        return " ".join(f"`{choice}`" for choice in spec["enum"])
    if kind in ("integer", "number"):
        said = span(spec)
    elif kind == "array":
        said = f"`{text}`"
        if text == "a,b,c":
            said += f", each {span(spec['items'])}"
    elif "pattern" in spec:
        said = "`#rrggbb`"
    else:
        said = "text"
    return said + (f", {spec['unit']}" if "unit" in spec else "")


def shown(value):
    if value is None:
        return ""
    return f"`{value}`" if isinstance(value, str) else number(value[0] if value and isinstance(value[0], list) else value) \
        if isinstance(value, list) else number(value)


def cell(text):
    return text.replace("|", "\\|").replace("\n", " ")


def table(specs):
    yield "| parameter | values | default | meaning |"
    yield "|---|---|---|---|"
    for spec in specs:
        yield f"| `{spec['name']}` | {cell(values(spec))} | {cell(shown(spec.get('default')))} | {cell(spec['description'])} |"
    yield ""


def times(request):
    return f"{COSTS[request]:g}"


def page(limits, patterns):
    specs = {spec["name"]: spec for spec in limits["parameters"]}
    listed = [name for _, _, names in SUBJECTS for name in names]
    for name in specs:
        if listed.count(name) != 1:
            sys.exit(f"parameters_page: '{name}' stands under {listed.count(name)} subjects of SUBJECTS instead of one")
    for name in set(listed) - set(specs):
        sys.exit(f"parameters_page: there is no parameter '{name}' any more")
    for kind, key in (("patterns", "pattern"), ("materials", "material")):
        for entry in patterns[kind]:
            if key == "pattern" and f"{key}={entry['name']}" not in COSTS:
                sys.exit(f"parameters_page: COSTS lacks {key}={entry['name']}; --measure prints them")
            if entry["name"] != "points" and not (ROOT / f"proto/pictures/{key}_{entry['name']}.png").exists():
                sys.exit(f"parameters_page: proto/pictures/{key}_{entry['name']}.png is missing; `scripts/gallery --only page` draws it")
    yield "# Parameters"
    yield ""
    yield "<!-- Written by scripts/lib/parameters_page.py from the table that the server holds; a test compares. -->"
    yield ""
    yield "They stand in the query (`?fragments=80&seed=7`), in a form, or in JSON (`{\"fragments\": 80, \"seed\": 7}`), and as flags of"
    yield "`fracture-server bake` (`--fragments 80`). Unknown ones, and those given twice, are refused by name. Vectors are `x,y,z` in a query"
    yield "and `[x, y, z]` in JSON, lists of them `x,y,z;x,y,z` and `[[x, y, z], ...]`; lengths are metres, y is up. A server says the same"
    yield "for programs at `GET /patterns` and `GET /limits`. [How requests and answers look](interface.md)."
    yield ""
    yield "## Start with these five"
    yield ""
    yield from table(specs[name] for name in FIRST)
    yield "A material sets the pattern, the cuts and the physics at once; everything else may stay at its default. `impacts` goes with"
    yield "the patterns `impact`, `radial` and `brick`; with a material that has another one it asks for `impact`."
    yield ""
    yield "## What it costs"
    yield ""
    yield from textwrap.wrap(
        "The columns *cost* below count instructions of one answer, as multiples of `pattern=uniform` with 50 sites, on a mesh of 4,000 "
        f"triangles. The number of pieces decides most: 500 sites cost {times('sites=500')}, 5,000 cost "
        f"{times('sites=5000')}. Rough cuts (`rough_amplitude=0.05`) cost {times('rough_amplitude=0.05')}; their finest octave decides. "
        f"Ragged chunks (`cells_per_fragment=6`) with flat cuts cost {times('cells_per_fragment=6')}. "
        f"Walls (`shell`) are made once, when the mesh is prepared, which costs {times('shell_fraction=0.05')} then; the materials that make "
        "walls are counted below without. "
        f"One pass of `lloyd`: {times('lloyd=1')}, `levels`: {times('levels=5,20,50')}, `dual=barycenter`: {times('dual=barycenter')}, "
        f"without hulls (`physics=none`): {times('physics=none')}. A hit that asks for `delta` is cheaper than the whole answer: only "
        "the cells near it are cut again. On a wall, whose pieces are of six bricks each, brick costs 4.", 128)
    yield ""
    for title, words, names in SUBJECTS:
        yield f"## {title}"
        yield ""
        if words:
            yield words
            yield ""
        yield from table(specs[name] for name in names)
    yield "## Patterns"
    yield ""
    yield "A colour for each fragment; drawn apart."
    yield ""
    yield "| | `pattern` | where the sites go | its parameters (default) | cost |"
    yield "|---|---|---|---|---|"
    for entry in patterns["patterns"]:
        name = entry["name"]
        picture = "" if name == "points" else f"![{name}](pictures/pattern_{name}.png)"
        own = ", ".join(f"`{p['name']}`" + (f" ({shown(p['default'])})" if p.get("default") is not None else "")
                        for p in entry["parameters"])
        yield f"| {picture} | `{name}` | {cell(entry['description'])} | {cell(own)} | {times('pattern=' + name)} |"
    yield ""
    yield "## Materials"
    yield ""
    yield "| | `material` | how it breaks | for | what it sets | cost |"
    yield "|---|---|---|---|---|---|"
    for entry in patterns["materials"]:
        name = entry["name"]
        sets = ", ".join(f"`{key}` {shown(value)}" for key, value in entry["parameters"].items())
        yield (f"| ![{name}](pictures/material_{name}.png) | `{name}` | {cell(entry['description'])} | {entry['use']} | {cell(sets)} | "
               f"{entry['cost']:g} |")
    yield ""
    yield "How each breaks follows these descriptions; its figures come from those:"
    yield ""
    yield "| material | how it breaks | figures |"
    yield "|---|---|---|"
    for entry in patterns["materials"]:
        yield f"| `{entry['name']}` | {cell(entry['mechanics'])} | {cell(entry['source'])} |"


def measure(program):
    """Prints COSTS, and those of materials (common/materials/notes.cpp). Counts instructions, which do not depend on how busy the
    machine is."""
    counted = {}
    (patterns,) = ask(program, "/patterns")
    for name in [*COSTS, *(f"material={entry['name']}" for entry in patterns["materials"])]:
        key, value = name.split("=")
        if name == "pattern=points":
            continue  # as uniform: it is the caller's sites
        flags = [f"--{key.replace('_', '-')}", value] + ([] if key in ("sites", "levels") else ["--sites", "50"])
        flags += ["--shell", "0"] if key == "material" else []
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, "bake", MONKEY, "-o",
                                   f"{folder}/out.glb", "--threads", "1", "-q", *flags], capture_output=True, text=True, check=True)
        counted[name] = int(re.search(r"Collected : (\d+)", done.stderr).group(1))
        print(f'    "{name}": {counted[name] / counted["pattern=uniform"]:.1f},', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--measure", action="store_true")
    options = parser.parse_args()
    if options.measure:
        return measure(options.program)
    text = "\n".join(page(*ask(options.program, "/limits", "/patterns"))) + "\n"
    text = re.sub(r" +\n", "\n", text)
    if not options.check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    written = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    sys.stdout.writelines(difflib.unified_diff(written.splitlines(True), text.splitlines(True), str(PAGE), "the server's table"))
    if written != text:
        print(f"\n  repair: python3 scripts/lib/parameters_page.py {options.program}")
    return 0 if written == text else 1


if __name__ == "__main__":
    sys.exit(main())
