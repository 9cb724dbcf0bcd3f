"""No test waits without a limit, and no test waits for a fixed time if it can check for an event.

A sleep in a test is too long on an idle machine and too short on a busy machine. eventually()
(tests/support/eventually.hpp) polls up to a limit. If a pause is part of the test (a client that sends slowly), the
line or the line above it must say so: `// pause: reason`.
"""
import re

PAUSE = re.compile(r"(//|#) pause: \w+")
CPP = [(re.compile(r"\b(sleep_for|sleep_until|usleep|nanosleep|sleep)\s*\("), "sleeps"),
       (re.compile(r"\b(while|for) \([^;]*\)\s*(std::this_thread::yield|sched_yield|::sched_yield)"), "polls without a limit"),
       (re.compile(r"\.wait\(\w*lock\b"), "waits without a limit (wait_for)"),
       (re.compile(r"\bdo sleep [\d.]+; done"), "polls without a limit")]
SCRIPT = [(re.compile(r"\btime\.sleep\("), "sleeps"),
          (re.compile(r"^\s*sleep [\d.$]"), "sleeps"),
          (re.compile(r"\b(while|until) .*; do sleep "), "polls without a limit")]


def code_of(line, mark):
    """Returns the line without its comment."""
    return line.split(mark)[0]


def check(checkout, _all):
    offences = []
    names = [name for name in checkout.named(".cpp", ".hpp", ".py", ".sh") + checkout.scripts("bash", "/sh", "python")
             if name.startswith("tests/") and not name.startswith(("tests/bench/", "tests/checks/"))]
    for name in names:
        if name == "tests/support/eventually.hpp":
            continue
        cpp = name.endswith((".cpp", ".hpp"))
        lines = checkout.lines(name)
        for number, line in enumerate(lines, 1):
            if PAUSE.search(line) or (number > 1 and PAUSE.search(lines[number - 2])):
                continue
            for pattern, what in CPP if cpp else SCRIPT:
                if pattern.search(code_of(line, "//" if cpp else "# ")):
                    offences.append(f"{name}:{number}: {what}: {line.strip()[:90]}")
                    break
    return offences
