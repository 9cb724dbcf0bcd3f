#!/usr/bin/env python3
"""Tests whether the same requests still have the answers of the stored algorithm version, to the bit.

    golden_bytes.py PROGRAM            compares the answers of fracture-server with golden_bytes.tsv; exits with 1 if they differ
    golden_bytes.py PROGRAM --write    stores the hashes of today's answers, under today's algorithm version
    ... --write --unreleased           also if bytes changed under the stored version, which is not released yet

A version is unreleased while the newest heading of CHANGELOG.md is "## Algorithm 28 - unreleased"; otherwise --unreleased is refused. If the
base of a branch has a day in place of that word, the test golden_bytes fails if a stored hash differs from the base's.

Caches are keyed by the algorithm version. If bytes change and the version does not, every cache mixes old and new bytes.
The hashes show that bytes changed, not that they are right: the invariants and the judges show that.
"""
import argparse
import hashlib
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from golden_requests import MESHES, REQUESTS

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHANGELOG = ROOT / "CHANGELOG.md"
STORED = ROOT / "tests/golden/golden_bytes.tsv"


def algorithm_of(program):
    """Returns the algorithm version that the program states."""
    text = subprocess.run([program, "--version"], check=True, capture_output=True, text=True, timeout=60).stdout
    return int(re.search(r"algorithm (\d+)", text).group(1))


def make_answers(program, folder):
    """Makes the answers to all requests below `folder`, and returns the folder that holds them."""
    for name, content in MESHES.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    manifest = folder / "golden.ndjson"
    manifest.write_text("".join(
        json.dumps({"input": mesh, "output": f"out/{name if '.' in name else name + '.glb'}", "parameters": parameters}) + "\n"
        for name, (mesh, parameters) in REQUESTS.items()))
    done = subprocess.run([program, "bake", "--manifest", str(manifest)], capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        sys.exit(f"golden_bytes: bake ended with {done.returncode}\n{done.stderr[-2000:]}")
    return folder / "out"


def hashes_of(folder):
    """Returns the SHA-256 of each file by its name: the answers, and the materials that belong to an OBJ."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


def read_stored():
    """Returns the stored algorithm version, and the stored hashes by name."""
    return read_table(STORED.read_text())


def read_table(text):
    """Returns the algorithm version of a file of hashes, and the hashes by name."""
    first, *rows = text.splitlines()
    return int(first.split("\t")[1]), dict(row.split("\t") for row in rows)


def newest_heading(changelog):
    """Returns the newest algorithm version in the text of CHANGELOG.md, and its day or "unreleased"."""
    version, day = re.search(r"^## Algorithm (\d+) - (\S+)$", changelog, re.MULTILINE).groups()
    return int(version), day


def refusal_of_unreleased(version, changelog):
    """Returns why the hashes of this version must not be replaced, or None if they may."""
    if newest_heading(changelog) == (version, "unreleased"):
        return None
    return (f"--unreleased is refused: the newest heading of CHANGELOG.md is not \"## Algorithm {version} - unreleased\". Caches may have "
            f"answers of a released version: raise kAlgorithmVersion (common/pipeline/algorithm_version.hpp) instead")


def change_after_release(table, base_table, base_changelog):
    """Compares the text of a file of hashes with the one of an earlier commit. Returns the fault if that commit had released the version and
    hashes differ, else None."""
    version, hashes = read_table(table)
    base_version, base_hashes = read_table(base_table)
    released = re.search(rf"^## Algorithm {version} - \d", base_changelog, re.MULTILINE)
    changed = sorted(name for name in hashes.keys() & base_hashes.keys() if hashes[name] != base_hashes[name])
    if version != base_version or not released or not changed:
        return None
    return f"Algorithm {version} was released, and then its stored hashes of these answers changed: {', '.join(changed)}. Raise kAlgorithmVersion"


def write_stored(version, hashes):
    STORED.write_text(f"algorithm\t{version}\n" + "".join(f"{name}\t{digest}\n" for name, digest in hashes.items()))


def complaint(stored_version, stored, version, hashes):
    """Returns the fault and the remedy, or None if the answers equal the stored ones."""
    changed = sorted(name for name in stored.keys() & hashes.keys() if stored[name] != hashes[name])
    unpaired = sorted(stored.keys() ^ hashes.keys())
    if version != stored_version:
        return (f"The algorithm version is {version}, but tests/golden/golden_bytes.tsv has hashes of version {stored_version} "
                f"({len(changed)} of {len(stored)} differ). Store the new ones: scripts/golden --write")
    if changed:
        return (f"{len(changed)} of {len(stored)} answers have other bytes than algorithm version {version} had: {', '.join(changed)}. "
                "If this is meant, raise kAlgorithmVersion (common/pipeline/algorithm_version.hpp), say in CHANGELOG.md what it changes, and "
                "run scripts/golden --write. Otherwise find out what changed them.")
    if unpaired:
        return f"No hash is stored for these answers, or no request is left for them: {', '.join(unpaired)}. Run scripts/golden --write"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="PROGRAM")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--unreleased", action="store_true")
    options = parser.parse_args()
    version = algorithm_of(options.program)
    if options.unreleased and (refused := refusal_of_unreleased(version, CHANGELOG.read_text(encoding="utf-8"))):
        sys.exit(f"golden_bytes: {refused}")
    with tempfile.TemporaryDirectory() as folder:
        hashes = hashes_of(make_answers(options.program, pathlib.Path(folder)))
    stored_version, stored = read_stored() if STORED.exists() else (0, {})
    wrong = complaint(stored_version, stored, version, hashes)
    if options.write:
        changed = any(stored.get(name, digest) != digest for name, digest in hashes.items())
        if version == stored_version and changed and not options.unreleased:
            sys.exit(f"golden_bytes: {wrong}")
        write_stored(version, hashes)
        print(f"{len(hashes)} hashes of algorithm version {version} are in {STORED.name}")
    elif wrong:
        sys.exit(f"golden_bytes: {wrong}")
    else:
        print(f"{len(hashes)} answers have the bytes of algorithm version {version}")


if __name__ == "__main__":
    main()
