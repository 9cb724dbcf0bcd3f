"""Every constant (kName) and function (name()) that a comment mentions exists in the code.

Constants are checked in all comments and documents, functions in the comments of C++ files. CHANGELOG.md is not checked, because it
describes earlier versions. Names are compared without their namespace or class.
"""
import re

CONSTANT = re.compile(r"\bk[A-Z]\w*")
FUNCTION = re.compile(r"(?<![\w.`/-])(?:\w+::)*([a-z]\w*)\(\)")
COMMENT = re.compile(r"(?<!:)//")
CPP = (".cpp", ".hpp", ".def", ".h.in", ".hpp.in", ".cpp.in", ".glsl")
WORD = re.compile(r"\w+")


def parts(name, line):
    """Returns the code and the comment of a line of C++. A "//" after a colon belongs to an address (https://)."""
    mark = COMMENT.search(line)
    return (line[:mark.start()], line[mark.start():]) if mark else (line, "")


def words_of_code(checkout):
    """All words outside comments of C++ files, and all words of other source files."""
    found = set()
    for name in checkout.texts:
        if name.endswith(CPP):
            for line in checkout.lines(name):
                found.update(WORD.findall(parts(name, line)[0]))
        elif name.endswith((".py", ".ts", ".mjs", ".cmake", "CMakeLists.txt")):
            found.update(WORD.findall(checkout.read(name)))
    return found


def check(checkout, _all):
    offences = []
    known = words_of_code(checkout)
    for name in checkout.texts:
        if name == "CHANGELOG.md" or name.startswith(("scripts/lib/checks/", "tests/checks/")):
            continue
        cpp = name.endswith(CPP)
        if not cpp and not name.endswith(".md"):
            continue
        for number, line in enumerate(checkout.lines(name), 1):
            text = parts(name, line)[1] if cpp else line
            for constant in CONSTANT.findall(text):
                if constant not in known:
                    offences.append(f"{name}:{number}: names {constant}, which does not exist")
            for function in FUNCTION.findall(text) if cpp else ():
                if function not in known:
                    offences.append(f"{name}:{number}: names {function}(), which does not exist")
    return list(dict.fromkeys(offences))
