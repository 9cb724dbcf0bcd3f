"""spdx_test.py: tests whether docker/spdx writes an SPDX 2.3 document of the packages that dpkg has installed. Exits
with 77 if dpkg is missing."""
import json
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def expect(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def document(name, **variables):
    done = subprocess.run([os.path.join(ROOT, "docker", "spdx"), name], capture_output=True, text=True, timeout=120,
                          env={**os.environ, **variables})
    expect(done.returncode == 0, done.stderr)
    return done.stdout


if not shutil.which("dpkg-query"):
    sys.exit(77)
text = document("fracture 1.0", SOURCE_DATE_EPOCH="1700000000")
expect(text == document("fracture 1.0", SOURCE_DATE_EPOCH="1700000000"), "the same packages give the same bytes")
spdx = json.loads(text)
# SPDX 2.3, sections 6 and 7: the required fields.
expect(spdx["spdxVersion"] == "SPDX-2.3" and spdx["dataLicense"] == "CC0-1.0" and spdx["SPDXID"] == "SPDXRef-DOCUMENT", "the head")
expect(spdx["creationInfo"]["created"] == "2023-11-14T22:13:20Z" and spdx["creationInfo"]["creators"], "who wrote it, and when")
expect(re.fullmatch(r"https://\S+[0-9a-f]{64}", spdx["documentNamespace"]), spdx["documentNamespace"])
installed = {}
for line in subprocess.run(["dpkg-query", "-W", "-f", "${db:Status-Abbrev}\t${Package}\t${Version}\t${Architecture}\n"],
                           capture_output=True, text=True, check=True).stdout.splitlines():
    status, name, version, architecture = line.split("\t")
    if status.startswith("ii"):
        installed[name, architecture] = version
listed = {}
for package in spdx["packages"]:
    expect(re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", package["SPDXID"]), package["SPDXID"])
    for field in "downloadLocation", "licenseConcluded", "licenseDeclared", "copyrightText", "supplier":
        expect(package[field], f"{package['name']} has no {field}")
    locator = package["externalRefs"][0]["referenceLocator"]
    expect(re.fullmatch(r"pkg:deb/debian/[a-z0-9%.B+-]+@[^ ?+:~]+\?arch=[a-z0-9]+&distro=\S+", locator), locator)
    listed[package["name"], re.search(r"arch=([a-z0-9]+)", locator)[1]] = package["versionInfo"]
expect(listed == installed, f"{len(listed)} packages are listed, {len(installed)} installed")
ids = [p["SPDXID"] for p in spdx["packages"]]
expect(len(set(ids)) == len(ids), "every package has an id of its own")
expect([r["relatedSpdxElement"] for r in spdx["relationships"]] == ids, "the document describes every package")
print(f"{len(ids)} packages: all is well")
