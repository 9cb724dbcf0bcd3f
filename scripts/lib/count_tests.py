"""count_tests.py RUN_FOLDER...: sums test cases and prints one line `N passed, N failed, N skipped`.

Each folder holds what one ctest run left: junit.xml, and gtest/<program>.json for each GoogleTest program. A program
with a JSON counts by its cases, every other ctest entry counts as one. A program that ctest calls failed although its
cases did not (a crash, a time-out, a leak found at exit) counts as one failure more. Exits 1 on any failure.
"""
import json
import os
import sys
import xml.etree.ElementTree as xml

passed = failed = skipped = 0
names = []
for folder in sys.argv[1:]:
    junit = os.path.join(folder, "junit.xml")
    if not os.path.exists(junit):
        failed += 1
        names.append(f"{os.path.basename(folder)}: ctest left no report")
        continue
    for case in xml.parse(junit).getroot().iter("testcase"):
        name, status = case.get("name"), case.get("status")
        program_failed = status not in ("run", "disabled", "notrun") or case.find("failure") is not None
        report = os.path.join(folder, "gtest", name + ".json")
        failures_before = failed
        if os.path.exists(report):
            try:
                with open(report, encoding="utf-8") as f:
                    suites = json.load(f).get("testsuites", [])
            except json.JSONDecodeError:
                suites = []
            for suite in suites:
                for test in suite.get("testsuite", []):
                    if test.get("failures"):
                        failed += 1
                        names.append(f"{os.path.basename(folder)}: {name}: {suite['name']}.{test['name']}")
                    elif test.get("result") == "SKIPPED" or test.get("status") == "NOTRUN":
                        skipped += 1
                    else:
                        passed += 1
        elif not program_failed:
            if status == "run" and case.find("skipped") is None:
                passed += 1
            else:
                skipped += 1
        if program_failed and failed == failures_before:
            failed += 1
            names.append(f"{os.path.basename(folder)}: {name}")

for name in names:
    print("FAILED " + name)
print(f"{passed} passed, {failed} failed, {skipped} skipped")
sys.exit(1 if failed or passed == 0 else 0)
