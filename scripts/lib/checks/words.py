"""One thing has one name. words.txt: `pattern -> what to write  # why`, patterns are Python's regular expressions."""
import pathlib
import re

LIST = pathlib.Path(__file__).with_name("words.txt")


def rules(text):
    for line in text.splitlines():
        line = line.split("  #")[0].strip()
        if line and not line.startswith("#"):
            pattern, _, better = line.partition(" -> ")
            yield re.compile(pattern), better


def check(checkout, _all):
    listed = list(rules(LIST.read_text(encoding="utf-8")))
    offences = []
    for name in checkout.texts:
        if name.startswith(("scripts/lib/checks/", "tests/checks/")):
            continue
        for number, line in enumerate(checkout.lines(name), 1):
            for pattern, better in listed:
                found = pattern.search(line)
                if found:
                    offences.append(f"{name}:{number}: '{found.group()}' -> {better}")
    return offences
