"""No source file has more than 400 lines, because a reader holds one file in the head at a time.

NOT_YET lists the files that are still longer. A file that is short enough must be removed from the list.
"""
MOST = 400  # lines
SOURCES = (".cpp", ".hpp", ".def", ".glsl", ".py", ".ts", ".mjs", ".css", ".cmake", ".sh", "CMakeLists.txt")
NOT_YET = ("common/fragment/assemble.cpp", "common/import/gltf_document.cpp")


def check(checkout, _all):
    offences = []
    names = [name for name in checkout.texts if name.endswith(SOURCES)]
    for name in names + checkout.scripts("bash", "/sh", "python"):
        lines = len(checkout.lines(name))
        if lines > MOST and name not in NOT_YET:
            offences.append(f"{name}:{MOST + 1}: has {lines} lines; at most {MOST} are allowed")
        elif lines <= MOST and name in NOT_YET:
            offences.append(f"{name}:1: is short enough: remove it from NOT_YET in scripts/lib/checks/length.py")
    return offences
