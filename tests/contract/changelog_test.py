#!/usr/bin/env python3
"""Proves that CHANGELOG.md has an entry for every algorithm version up to that of
common/pipeline/algorithm_version.hpp, newest first. Each entry has the form of Keep a Changelog: a heading with the
version and its day, kinds of changes below it, and short lines. The newest may be "unreleased" instead of a day."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
KINDS = ("Added", "Changed", "Deprecated", "Removed", "Fixed", "Security")
LONGEST = 160

header = (ROOT / "common/pipeline/algorithm_version.hpp").read_text()
current = int(re.search(r"kAlgorithmVersion = (\d+);", header).group(1))
text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
entries = re.findall(r"^## Algorithm (\d+) - (\d{4}-\d\d-\d\d|unreleased)\n((?:(?!## ).*\n)*)", text, re.MULTILINE)

wanted = [str(version) for version in range(current, 0, -1)]
if [version for version, _, _ in entries] != wanted:
    sys.exit(f"CHANGELOG.md has entries for the algorithm versions {[v for v, _, _ in entries]} instead of {wanted}")
days = [day for _, day, _ in entries]
if "unreleased" in days[1:]:
    sys.exit("CHANGELOG.md: only the newest entry may be unreleased")
days = [day for day in days if day != "unreleased"]
if days != sorted(days, reverse=True):
    sys.exit(f"CHANGELOG.md lists days of algorithm versions that are not the newest first: {days}")
for version, _, body in entries:
    kinds = re.findall(r"^### (.*)$", body, re.MULTILINE)
    if not kinds or len(set(kinds)) != len(kinds) or not set(kinds) <= set(KINDS):
        sys.exit(f"CHANGELOG.md: the entry for algorithm {version} has the headings {kinds}; each must be one of {KINDS}, given once")
    if not re.search(r"^- ", body, re.MULTILINE):
        sys.exit(f"CHANGELOG.md: the entry for algorithm {version} says nothing")
for number, line in enumerate(text.splitlines(), 1):
    if len(line) > LONGEST:
        sys.exit(f"CHANGELOG.md:{number}: the line has {len(line)} characters; {LONGEST} are allowed")
print(f"{len(entries)} versions")
