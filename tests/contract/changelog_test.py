#!/usr/bin/env python3
"""CHANGELOG.md lists every algorithm version up to that of common/pipeline/algorithm_version.hpp, newest first, with its day and words."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
header = (ROOT / "common/pipeline/algorithm_version.hpp").read_text()
current = int(re.search(r"kAlgorithmVersion = (\d+);", header).group(1))
rows = re.findall(r"^\| (\d+) \| (\d{4}-\d\d-\d\d) \| (.+) \|$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)

wanted = [str(version) for version in range(current, 0, -1)]
if [version for version, _, _ in rows] != wanted:
    sys.exit(f"CHANGELOG.md lists the algorithm versions {[v for v, _, _ in rows]} instead of {wanted}")
days = [day for _, day, _ in rows]
if days != sorted(days, reverse=True):
    sys.exit(f"CHANGELOG.md lists days of algorithm versions that are not the newest first: {days}")
print(f"{len(rows)} versions")
