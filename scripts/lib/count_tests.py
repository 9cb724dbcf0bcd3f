"""count_tests.py RUN_FOLDER...: sums test cases and prints one line `N passed, N failed, N skipped`.

Each folder holds what one ctest run left: junit.xml, and gtest/<program>.json for each GoogleTest program. A program
with a JSON counts by its cases, every other ctest entry counts as one. A program that ctest calls failed although its
cases did not (a crash, a time-out, a leak found at exit) counts as one failure more. The folder again/ in it holds the
second try of programs that failed: where one passed, that counts, and a line says so. Exits 1 on any failure.
"""
import json
import os
import sys
import xml.etree.ElementTree as xml
from collections import Counter


def main(folders):
    total = Counter()
    for folder in folders:
        name = os.path.basename(folder)
        programs = read(folder)
        if programs is None:
            print(f"FAILED {name}: ctest left no report")
            total["failed"] += 1
            continue
        for program, (counts, failures) in programs.items():
            second = (read(os.path.join(folder, "again")) or {}).get(program)
            if failures and second and not second[1]:
                print(f"UNSTEADY {name}: passed only at the second try, alone: {', '.join(failures)}")
                counts, failures = second
            for failure in failures:
                print(f"FAILED {name}: {failure}")
            total += counts
            total["failed"] += len(failures)
    print(f"{total['passed']} passed, {total['failed']} failed, {total['skipped']} skipped")
    return 1 if total["failed"] or total["passed"] == 0 else 0


def read(folder):
    """Of each program: how many cases passed and were skipped, and the names of those that failed. None: no report."""
    junit = os.path.join(folder, "junit.xml")
    if not os.path.exists(junit):
        return None
    return {case.get("name"): judged(case, os.path.join(folder, "gtest")) for case in xml.parse(junit).getroot().iter("testcase")}


def judged(case, reports):
    name, status = case.get("name"), case.get("status")
    program_failed = status not in ("run", "disabled", "notrun") or case.find("failure") is not None
    counts, failures = Counter(), []
    report = os.path.join(reports, name + ".json")
    if os.path.exists(report):
        try:
            with open(report, encoding="utf-8") as f:
                suites = json.load(f).get("testsuites", [])
        except json.JSONDecodeError:
            suites = []
        for suite in suites:
            for test in suite.get("testsuite", []):
                if test.get("failures"):
                    failures.append(f"{name}: {suite['name']}.{test['name']}")
                elif test.get("result") == "SKIPPED" or test.get("status") == "NOTRUN":
                    counts["skipped"] += 1
                else:
                    counts["passed"] += 1
    elif not program_failed:
        counts["passed" if status == "run" and case.find("skipped") is None else "skipped"] += 1
    if program_failed and not failures:
        failures.append(name)
    return counts, failures


sys.exit(main(sys.argv[1:]))
