"""count_tests.py [--may-skip FILE] RUN_FOLDER...: sums test cases and prints one line `N passed, N failed, N skipped`.

Each folder contains the reports of one ctest run: junit.xml, and gtest/<program>.json for each GoogleTest program. For a
program with a JSON report, each case counts; any other ctest entry counts as one. If ctest reports a program as failed although
its cases passed (a crash, a timeout, a leak found at exit), that is one more failure. The subfolder again/ contains the
second run of failed programs: if a program passes there, the second result counts, and a line says so. Exits with 1 on any failure.

The ten slowest tests of each run are printed. FILE has a line `program: reason` for each program that may be skipped
entirely in every run. With FILE, any other program that no run executed is a failure.
"""
import json
import os
import sys
import xml.etree.ElementTree as xml
from collections import Counter


SLOWEST = 10


def main(arguments):
    may_skip, folders = None, arguments
    if arguments[:1] == ["--may-skip"]:
        may_skip, folders = read_reasons(arguments[1]), arguments[2:]
    total, in_all_runs = Counter(), Counter()
    for folder in folders:
        name = os.path.basename(folder)
        programs = read(folder)
        if programs is None:
            print(f"FAILED {name}: ctest wrote no report")
            total["failed"] += 1
            continue
        print_slowest(name, folder)
        for program, (counts, failures) in programs.items():
            second = (read(os.path.join(folder, "again")) or {}).get(program)
            if failures and second and not second[1]:
                print(f"UNSTEADY {name}: passed only when run again alone: {', '.join(failures)}")
                counts, failures = second
            for failure in failures:
                print(f"FAILED {name}: {failure}")
            total += counts
            total["failed"] += len(failures)
            in_all_runs[program] += counts["passed"] + len(failures)
    for program in sorted(program for program, ran in in_all_runs.items() if may_skip is not None and not ran and program not in may_skip):
        print(f"FAILED {program}: skipped entirely in every run, and {os.path.basename(arguments[1])} gives no reason")
        total["failed"] += 1
    print(f"{total['passed']} passed, {total['failed']} failed, {total['skipped']} skipped")
    return 1 if total["failed"] or total["passed"] == 0 else 0


def read_reasons(file):
    """Returns {program: why it may be skipped}. A line without a reason is an error."""
    reasons = {}
    with open(file, encoding="utf-8") as lines:
        for line in lines:
            if line.strip() and not line.startswith("#"):
                program, _, reason = line.strip().partition(": ")
                if not reason:
                    sys.exit(f"{file}: {program} has no reason")
                reasons[program] = reason
    return reasons


def print_slowest(name, folder):
    times = [(float(case.get("time") or 0), case.get("name")) for case in xml.parse(os.path.join(folder, "junit.xml")).getroot().iter("testcase")]
    slowest = [f"{program} {seconds:.0f} s" for seconds, program in sorted(times, reverse=True)[:SLOWEST] if seconds >= 1]
    if slowest:
        print(f"slowest of {name}: {', '.join(slowest)}")


def read(folder):
    """Returns {program: (counts of passed and skipped cases, names of failed cases)}, or None if the folder has no report."""
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
