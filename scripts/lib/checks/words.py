"""Words and sentences: one thing has one name (words.txt), and sentences avoid the habits that make a reader stop (habits.py).

words.txt: `pattern -> what to write  # why`, where patterns are Python regular expressions. Habits are checked in all texts
that users read: documents, messages, help and pages. In comments, only lines changed on the branch are checked; with --all, every line.
not_yet.txt lists the files whose texts are not checked yet; a file that is clean must be removed from it.
"""
import pathlib
import re

from . import habits, prose

LIST = pathlib.Path(__file__).with_name("words.txt")
NOT_YET = "scripts/lib/checks/not_yet.txt"
EXAMPLES = ("scripts/lib/checks/", "tests/checks/")  # they quote what they forbid


def rules(text):
    for line in text.splitlines():
        line = line.split("  #")[0].strip()
        if line and not line.startswith("#"):
            pattern, _, better = line.partition(" -> ")
            yield re.compile(pattern), better


def check_names(checkout, names):
    listed = list(rules(LIST.read_text(encoding="utf-8")))
    for name in names:
        for number, line in enumerate(checkout.lines(name), 1):
            for pattern, better in listed:
                found = pattern.search(line)
                if found:
                    yield f"{name}:{number}: '{found.group()}' -> {better}"


def not_yet(checkout):
    """Returns {file: its line in not_yet.txt}."""
    if not (checkout.root / NOT_YET).is_file():
        return {}
    lines = enumerate(checkout.lines(NOT_YET), 1)
    return {line.strip(): number for number, line in lines if line.strip() and not line.startswith("#")}


def read_passages(checkout, names):
    """Yields (file, its passages) for each of the files."""
    script = {**dict.fromkeys(checkout.scripts("python"), "python"), **dict.fromkeys(checkout.scripts("bash", "/sh"), "shell")}
    for name in names:
        yield name, prose.passages(name, checkout.read(name), script.get(name, ""))


def in_texts(checkout, name, passages):
    """Yields offences in the texts that users read."""
    for passage in passages:
        if not passage.comment:
            for offence in habits.find(passage):
                yield f"{name}:{offence.first}: {offence.habit}: '{offence.found}' -> {offence.better}"
    if name.endswith(".md"):
        for number, length in habits.long_rows(checkout.read(name)):
            yield f"{name}:{number}: row: {length} characters -> at most {habits.LONGEST_ROW}: shorten it, or make sections of the table"


def in_comments(passages, name, lines):
    """Yields offences in comments. `lines`: the lines to check; None: all."""
    for passage in passages:
        if passage.comment:
            for offence in habits.find(passage):
                if lines is None or not lines.isdisjoint(range(offence.first, offence.last + 1)):
                    yield f"{name}:{offence.first}: {offence.habit}: '{offence.found}' -> {offence.better}"


def fix(checkout):
    """Removes clean and deleted files from the list."""
    listed = not_yet(checkout)
    unclean = {name for name, passages in read_passages(checkout, [name for name in listed if name in checkout.texts])
               if any(in_texts(checkout, name, passages))}
    if unclean != set(listed):
        kept = [line for line in checkout.lines(NOT_YET) if line.startswith("#") or line.strip() in unclean]
        (checkout.root / NOT_YET).write_text("".join(f"{line}\n" for line in kept), encoding="utf-8")
        checkout.lines.cache_clear()
        checkout.read.cache_clear()


def check_habits(checkout, names, every):
    listed = not_yet(checkout)
    changed = checkout.changed_lines if checkout.has_history else {}
    read = [name for name in names if every or name in changed or name.endswith(".md") or not name.startswith("tests/")]
    for name, passages in read_passages(checkout, read):
        offences = list(in_texts(checkout, name, passages))
        if name not in listed:
            yield from offences
        elif not offences:
            yield f"{NOT_YET}:{listed[name]}: {name} -> its texts are clean: remove it from the list (scripts/check --fix words)"
        yield from in_comments(passages, name, None if every else changed.get(name, set()))
    for name in sorted(set(listed) - set(names)):
        yield f"{NOT_YET}:{listed[name]}: {name} -> the file does not exist: remove it from the list"
    if listed:
        print(f"check words: {len(listed)} files are not checked for writing habits yet ({NOT_YET})", flush=True)


def check(checkout, every):
    names = [name for name in checkout.texts if not name.startswith(EXAMPLES)]
    return [*check_names(checkout, names), *check_habits(checkout, names, every)]
