#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on as a zip for Blender, including the Python package fracture_client (MIT).

    client/blender/pack.py [--describe fracture-server] [fracture_blender.zip]

--describe: the program fracture-server, or a server's URL. The server's list of parameters is packed into the zip, so that the panel is
complete before the add-on contacts a server. The same sources and server give the same bytes.
"""
import argparse
import importlib.util
import json
import pathlib
import sys
import types
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ADDON = HERE / "fracture_blender"
PACKAGE = HERE.parent / "python" / "fracture_client"
LICENCE = HERE.parents[1] / "LICENSE"
DATE = (1980, 1, 1, 0, 0, 0)  # the earliest date that a zip can store; with today's date, the bytes would change each day


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", nargs="?", type=pathlib.Path, default=pathlib.Path("fracture_blender.zip"),
                        help="the zip to write (default: fracture_blender.zip)")
    parser.add_argument("--describe", metavar="PROGRAM_OR_URL", help="program or server whose list of parameters is packed into the zip")
    options = parser.parse_args()
    files = {f"fracture_blender/{path.name}": path.read_bytes() for path in (*ADDON.glob("*.py"), *ADDON.glob("*.toml"))}
    for path in (*PACKAGE.glob("*.py"), PACKAGE / "py.typed"):
        files[f"fracture_blender/fracture_client/{path.name}"] = path.read_bytes()
    files["fracture_blender/fracture_client/LICENSE"] = LICENCE.read_bytes()
    if options.describe:
        files["fracture_blender/description.json"] = described(options.describe)
    with zipfile.ZipFile(options.output, "w", zipfile.ZIP_DEFLATED) as packed:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, DATE)
            entry.external_attr, entry.compress_type = 0o644 << 16, zipfile.ZIP_DEFLATED
            packed.writestr(entry, files[name])
    print(f"{options.output}: {len(files)} files, {options.output.stat().st_size:,} bytes")


def described(program_or_url):
    """Returns the description in the add-on's own format. Loads only the modules that do not need Blender."""
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(PACKAGE.parent))
    package = types.ModuleType("fracture_blender")
    package.__path__ = [str(ADDON)]
    sys.modules["fracture_blender"] = package
    spec = importlib.util.spec_from_file_location("fracture_blender.description", ADDON / "description.py")
    description = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(description)
    if "://" in program_or_url:
        with description.Client(program_or_url) as client:
            found = description.of_server(client)
    else:
        found = description.of_program(program_or_url)
    return json.dumps(found.document, ensure_ascii=False, sort_keys=True).encode("utf-8")


if __name__ == "__main__":
    main()
