#!/usr/bin/env python3
"""CHANGELOG.md lists every algorithm version of common/pipeline/fracture.hpp, with its day and words, newest first."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
header = (ROOT / "common/pipeline/fracture.hpp").read_text()
current = int(re.search(r"kAlgorithmVersion = (\d+);", header).group(1))
in_code = dict(re.findall(r"///\s+(\d+)\s+(\d{4}-\d\d-\d\d)", header))
rows = re.findall(r"^\| (\d+) \| (\d{4}-\d\d-\d\d) \| (.+) \|$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)

wanted = [str(version) for version in range(current, 0, -1)]
if [version for version, _, _ in rows] != wanted:
    sys.exit(f"CHANGELOG.md lists the algorithm versions {[v for v, _, _ in rows]} instead of {wanted}")
for version, day, _ in rows:
    if in_code.get(version) != day:
        sys.exit(f"CHANGELOG.md says {day} of algorithm {version}, common/pipeline/fracture.hpp {in_code.get(version)}")
print(f"{len(rows)} versions")
