#!/usr/bin/env python3
"""Writes proto/parameters.md and proto/materials.md from the tables of fracture-server (GET /limits, GET /patterns).

    parameters_page.py build/release/server/fracture-server             writes the pages
    parameters_page.py build/release/server/fracture-server --check     exits with 1 if a page differs from the tables
    parameters_page.py build/release/server/fracture-server --measure   prints new values of COSTS (needs valgrind)

The headings and their order come from common/parameters/groups.cpp.
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
PAGES = {"parameters": ROOT / "proto/parameters.md", "materials": ROOT / "proto/materials.md"}
MONKEY = "/usr/share/assimp/models/BLEND/Suzanne_248.blend"  # Debian: assimp-testmodels

FIRST = ["material", "fragments", "seed", "impacts", "unit"]

# Instructions of one `fracture-server bake` of the monkey with 50 sites on one thread, divided by those of `pattern=uniform`. An import
# process reads the file, so reading is not included. --measure prints the values.
COSTS = {
    "pattern=uniform": 1.0, "pattern=points": 1.0, "pattern=impact": 1.0, "pattern=radial": 1.2, "pattern=grid": 1.5,
    "pattern=brick": 2.1, "pattern=slice": 2.0, "pattern=clustered": 1.0,
    "rough_amplitude=0.05": 2.2, "dual=barycenter": 2.0,
    "sites=500": 3.4, "sites=5000": 25.9, "cells_per_fragment=6": 2.0,
    "shell_fraction=0.05": 32.8,
}
COST_ON_A_WALL = 4  # pattern=brick on a wall, where a piece has six bricks; the monkey is not a wall


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def ask(program, *paths):
    """Starts the server and returns its JSON answer to a GET of each path."""
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
        return ",".join(map(number, value))
    if isinstance(value, float) and value == int(value) and abs(value) < 1e6:
        return str(int(value))
    if value == 2 ** 53 - 1:
        return "2^53-1"
    return re.sub(r"e([+-])0*", lambda e: "e" + e[1].strip("+"), f"{value:g}") if isinstance(value, float) else str(value)


def shown(value):
    """Returns a value as it is written in a query."""
    if isinstance(value, list) and value and isinstance(value[0], list):
        return ";".join(map(number, value))
    return value if isinstance(value, str) else number(value)


def span(spec):
    ends = [number(spec["minimum"]), number(spec["maximum"])]
    return ("–" if all(end.replace(".", "").isdigit() for end in ends) else " to ").join(ends)


def count(spec):
    return str(spec["minItems"]) if spec["minItems"] == spec["maxItems"] else f"{spec['minItems']}–{spec['maxItems']}"


def described_choices(spec):
    """Returns the introduction, and the meaning of each choice. A description gives the meanings as sentences that begin with
    "`choice`: "."""
    parts = re.split(r"(?:^|(?<=\. ))`(" + "|".join(map(re.escape, spec["enum"])) + ")`: ", spec["description"])
    return parts[0], dict(zip(parts[1::2], parts[2::2]))


def kind(spec):
    """Returns a parameter's type and range in words; "" if its choices are listed."""
    text = spec.get("text", "")
    if "enum" in spec:
        if len(described_choices(spec)[1]) >= len(spec["enum"]) - 1:
            return ""  # a list of the choices follows
        said = "Choice: " + " ".join(f"`{choice}`" for choice in spec["enum"])
    elif spec["type"] in ("integer", "number"):
        said = f"{spec['type'].capitalize()}, {span(spec)}"
    elif spec["name"] == "assign":
        said = f"List of {count(spec)} entries, `{text}` or JSON"
    elif text == "a,b,c":
        said = f"List of {spec['items']['type']}s, {span(spec['items'])}"
    elif text == "x,y,z;x,y,z":
        said = f"{count(spec)} vectors"
    elif text:
        said = "Vector" if text == "x,y,z" else "Matrix"
    else:
        said = "Colour" if "pattern" in spec else "Text"
    return said + (f", {spec['unit']}" if "unit" in spec else "")


def with_patterns(spec, patterns):
    """Returns words that say which patterns a parameter applies to; "" if it applies to all of them."""
    names = [entry["name"] for entry in patterns]
    own = [entry["name"] for entry in patterns if spec["name"] in (p["name"] for p in entry["parameters"])]
    if not own or own == names:
        return ""
    other = [name for name in names if name not in own]
    return f"not with `{other[0]}`" if len(other) == 1 else "only with " + ", ".join(f"`{name}`" for name in own)


def wrapped(text, indent=""):
    text = re.sub(r"`[^`]+`", lambda code: code[0].replace(" ", "\0"), text)  # code stays on one line
    lines = textwrap.wrap(text, 128, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return [line.replace("\0", " ") for line in lines]


def section(spec, patterns):
    facts = [kind(spec)]
    if spec.get("default") is not None:
        facts.append(f"default `{shown(spec['default'])}`")
    facts.append(with_patterns(spec, patterns))
    yield f"### `{spec['name']}`"
    yield ""
    line = "; ".join(filter(None, facts)) + "."
    yield from wrapped(line[0].upper() + line[1:])
    yield ""
    words, choices = described_choices(spec) if "enum" in spec else (spec["description"], {})
    if words:
        yield from wrapped(words.strip())
        yield ""
    for name, meaning in choices.items():
        yield from wrapped(f"- `{name}`: {meaning.strip()}", "  ")
    if choices:
        yield ""


def by_cost(costs):
    """Returns the names at each cost, cheapest first: "`a`, `b` 1; `c` 2"."""
    groups = {}
    for name, cost in sorted(costs.items(), key=lambda item: item[1]):
        groups.setdefault(cost, []).append(f"`{name}`")
    return "; ".join(f"{', '.join(names)} {cost:g}" for cost, names in groups.items())


def costs(patterns):
    def of(*requests):
        return "; ".join(f"{COSTS[request]:g}" for request in requests)
    yield from wrapped(
        "Costs are processor instructions per answer, relative to `pattern=uniform` with 50 sites on a mesh of 4,000 triangles. A hit with "
        "`delta` costs less. For this mesh, one core of a virtual AMD EPYC takes 11 ms (cost 1), 37 ms for `wood`, 55 ms for `stone`, and "
        "160 ms for `glass` with its walls, without reading the file (1 December 2026).")
    yield ""
    yield "| request | cost |"
    yield "|---|---|"
    yield "| `pattern` | " + by_cost({name: COSTS[f"pattern={name}"] for name in (entry["name"] for entry in patterns["patterns"])}) + " |"
    yield f"| `brick` on a wall, six bricks per piece | {COST_ON_A_WALL} |"
    yield "| `material` (no walls) | " + by_cost({entry["name"]: entry["cost"] for entry in patterns["materials"]}) + " |"
    yield f"| walls, only in the first answer for a mesh | {of('shell_fraction=0.05')} |"
    yield f"| 500 sites; 5,000 sites | {of('sites=500', 'sites=5000')} |"
    yield f"| `rough_amplitude=0.05` | {of('rough_amplitude=0.05')} |"
    yield f"| `cells_per_fragment=6` with flat cuts | {of('cells_per_fragment=6')} |"
    yield f"| `dual=barycenter` | {of('dual=barycenter')} |"
    yield ""


def pattern_rows(patterns):
    general = {p["name"] for entry in patterns if entry["name"] == "uniform" for p in entry["parameters"]}
    yield "| | `pattern` | sites | own parameters |"
    yield "|---|---|---|---|"
    for entry in patterns:
        name = entry["name"]
        picture = "" if name == "points" else f"![{name}](pictures/pattern_{name}.png)"
        own = " ".join(f"`{p['name']}`" for p in entry["parameters"] if p["name"] not in general)
        yield f"| {picture} | `{name}` | {entry['description']} | {own} |"
    yield ""


def material_rows(materials):
    yield "| | `material` | how it breaks | typical uses |"
    yield "|---|---|---|---|"
    for entry in materials:
        name = entry["name"]
        yield f"| ![{name}](pictures/material_{name}.png) | `{name}` | {entry['description']} | {entry['use']} |"
    yield ""


def material_values(materials):
    values = {entry["name"]: {key: shown(value) for key, value in entry["parameters"].items()} for entry in materials}
    shared = set.intersection(*(set(own.items()) for own in values.values()))
    yield from wrapped("Every material sets " + " and ".join(f"`{key}={value}`" for key, value in sorted(shared)) + ". In addition:")
    yield ""
    for name, own in values.items():
        ordered = sorted(own.items(), key=lambda item: (item[0] != "pattern", item[0]))
        yield from wrapped(f"- `{name}`: " + ", ".join(f"`{key}={value}`" for key, value in ordered if (key, value) not in shared), "  ")
    yield ""


def check_tables(patterns):
    """Stops the script if a cost or a picture is missing."""
    for entries, key in (("patterns", "pattern"), ("materials", "material")):
        for entry in patterns[entries]:
            if key == "pattern" and f"{key}={entry['name']}" not in COSTS:
                sys.exit(f"parameters_page: COSTS lacks {key}={entry['name']}; --measure prints it")
            if entry["name"] != "points" and not (ROOT / f"proto/pictures/{key}_{entry['name']}.png").exists():
                sys.exit(f"parameters_page: proto/pictures/{key}_{entry['name']}.png is missing; `scripts/gallery --only page` draws it")


def head(title):
    yield f"# {title}"
    yield ""
    yield "<!-- scripts/lib/parameters_page.py writes this page from the server's tables. -->"
    yield ""


def parameters_page(limits, patterns):
    specs = {spec["name"]: spec for spec in limits["parameters"]}
    check_tables(patterns)
    yield from head("Parameters")
    yield from wrapped(
        "This page is for people who choose parameters. Pass them in the query (`?fragments=80&seed=7`), in a form, in JSON "
        "(`{\"fragments\": 80, \"seed\": 7}`), or as flags of `fracture-server bake` (`--fragments 80`). Lengths are in metres, and y is up. The "
        "server refuses unknown and repeated parameters, and those of another pattern. [openapi.yaml](openapi.yaml) has more details. "
        "Programs get this information from `GET /limits` and `GET /patterns`. See also [Requests and answers](interface.md).")
    yield ""
    yield from wrapped(
        "Write a vector or a list as `x,y,z`, and several vectors or the rows of a matrix as `x,y,z;x,y,z`. In JSON, use arrays. Write a "
        "colour as `#rrggbb` (`%23rrggbb` in a query).")
    yield ""
    yield "## Choose parameters"
    yield ""
    yield from wrapped("Start with " + ", ".join(f"[`{name}`](#{name})" for name in FIRST[:-1]) + f" and [`{FIRST[-1]}`](#{FIRST[-1]}). "
                       "For an older algorithm "
                       "version, keep [the old program](guides/upgrade-one-server.md#keep-the-old-algorithm-version).")
    yield ""
    yield "## Cost"
    yield ""
    yield from costs(patterns)
    for group in limits["parameter_groups"]:
        yield f"## {group['title']}"
        yield ""
        if group["description"]:
            yield group["description"]
            yield ""
        for name in group["parameters"]:
            yield from section(specs[name], patterns["patterns"])


def materials_page(patterns):
    yield from head("Patterns and materials")
    yield from wrapped("This page is for people who choose a pattern or a material. See also "
                       "[Parameters](parameters.md) and their [costs](parameters.md#cost).")
    yield ""
    yield "## Patterns"
    yield ""
    yield from pattern_rows(patterns["patterns"])
    yield "## Materials"
    yield ""
    yield from material_rows(patterns["materials"])
    yield "## Values of each material"
    yield ""
    yield from material_values(patterns["materials"])
    yield from wrapped("`GET /patterns` also gives the sources of these values (`source`), and literature on how each material breaks (`mechanics`).")
    yield ""


def pages(limits, patterns):
    """Returns {path: text of the page}."""
    lines = {"parameters": parameters_page(limits, patterns), "materials": materials_page(patterns)}
    return {PAGES[name]: re.sub(r"\s+\Z", "\n", re.sub(r" +\n", "\n", "\n".join(page) + "\n")) for name, page in lines.items()}


def measure(program):
    """Prints COSTS, and the costs of materials for common/materials/notes.cpp. It counts instructions, because times depend on how busy
    the machine is."""
    counted = {}
    (patterns,) = ask(program, "/patterns")
    for name in [*COSTS, *(f"material={entry['name']}" for entry in patterns["materials"])]:
        key, value = name.split("=")
        if name == "pattern=points":
            continue  # costs as much as uniform, because only the sites differ
        flags = [f"--{key.replace('_', '-')}", value] + ([] if key == "sites" else ["--sites", "50"])
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
    differ = False
    for path, text in pages(*ask(options.program, "/limits", "/patterns")).items():
        if not options.check:
            path.write_text(text, encoding="utf-8")
            continue
        written = path.read_text(encoding="utf-8") if path.exists() else ""
        differ = differ or written != text
        sys.stdout.writelines(difflib.unified_diff(written.splitlines(True), text.splitlines(True), str(path), "the server's tables"))
    if differ:
        print(f"\n  repair: python3 scripts/lib/parameters_page.py {options.program}")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
