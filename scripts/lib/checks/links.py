"""Everything that documents and comments refer to must exist: files and anchors in Markdown links, paths in text, document names.

No reference may lead to a file outside the repository, because readers of the code cannot open it. Network addresses
are not checked.
"""
import posixpath
import re

FOLDERS = ("common", "server", "client", "tests", "scripts", "proto", "docker")
LINK = re.compile(r"!?\[(?:[^\]\[]|\[[^\]]*\])*\]\(([^)\s]+)\)")
# A path from the root with a file extension, and any name of a document or header, anywhere in a text.
PATH = re.compile(r"(?<![\w./-])((?:" + "|".join(FOLDERS) + r")/[\w./-]*\.(?:hpp|cpp|md|py|yaml|def|cmake|glsl))\b")
NAME = re.compile(r"(?<![\w./<>*-])((?:[\w-]+/)*[\w-]+\.(?:md|hpp|def))\b")


def slug(heading):
    """Returns the anchor that GitHub generates for a heading."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def anchors(text):
    found, count, fenced = set(), {}, False
    for line in text.splitlines():
        if line.lstrip().startswith("```"):
            fenced = not fenced
        heading = re.match(r"#{1,6}\s+(.*?)\s*#*$", line)
        if heading and not fenced:
            name = slug(heading.group(1))
            n = count.get(name, 0)
            count[name] = n + 1
            found.add(name if n == 0 else f"{name}-{n}")
        found.update(re.findall(r'<a (?:id|name)="([^"]+)"', line))
    return found


def check_links(checkout, name):
    existing = set(checkout.files)
    folders = {posixpath.dirname(f) for f in existing}
    folders |= {parent for f in set(folders) for parent in parents(f)}
    for number, line in enumerate(checkout.lines(name), 1):
        for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            full = posixpath.normpath(posixpath.join(posixpath.dirname(name), path)) if path else name
            if full not in existing and full not in folders:
                yield f"{name}:{number}: links to {target}, which does not exist"
            elif anchor and full.endswith(".md") and anchor not in anchors(checkout.read(full)):
                yield f"{name}:{number}: links to {target}, and {full} has no such heading"


def parents(path):
    while path:
        yield path
        path = posixpath.dirname(path)
    yield "."


def comment_of(name, line):
    """Returns the part of a line in which names are references; "" if there is none."""
    if name.endswith(".md"):
        return line
    for mark in ("//",) if name.endswith((".cpp", ".hpp", ".glsl", ".def")) else ("#",):
        at = line.find(mark)
        if at >= 0 and not line.lstrip().startswith("#include"):
            return line[at:]
    return ""


def check(checkout, _all):
    offences = []
    endings = set()
    for file in checkout.files:
        parts = file.split("/")
        endings.update("/".join(parts[k:]) for k in range(len(parts)))
    generated = {"common/base/error_codes.def"}
    for name in checkout.texts:
        if name.startswith("scripts/lib/checks/") or name.startswith("tests/checks/"):
            continue
        if name.endswith(".md"):
            offences += check_links(checkout, name)
        if not name.endswith((".md", ".cpp", ".hpp", ".py", ".txt", ".cmake", ".yaml", ".sh", ".glsl", ".def")) and \
                not name.startswith("scripts/"):
            continue
        for number, line in enumerate(checkout.lines(name), 1):
            text = comment_of(name, line)
            for path in PATH.findall(text) + NAME.findall(text):
                if path not in endings and path not in generated:
                    offences.append(f"{name}:{number}: names {path}, which does not exist")
    return list(dict.fromkeys(offences))
