"""A commit subject names the area and the action, in the form `area: verb object`, with at most 72 characters.

An example is "delaunay: reuse the last located tetrahedron". The check reads the branch's commits, without merges.
"""
import re

LONGEST = 72
AREA = r"[a-z][\w./+-]*"
# Words that cannot be verbs. A subject with one of these words after the colon is a title, not an action.
NO_VERB = ("a an the this that these those its their his her our my your one each every all any some no none nothing nobody not only also "
           "what who whose which where when while why how if of for from to in on at by with without as than and or but so it they there "
           "is are was were be has have had").split()
FORM = re.compile(rf"{AREA}(?:, {AREA})*: (?P<verb>[^\s]+) \S")


def faults(subject):
    """Yields each fault of a commit subject."""
    if len(subject) > LONGEST:
        yield f"has {len(subject)} characters, at most {LONGEST} are allowed"
    form = FORM.match(subject)
    if not form:
        yield "is not `area: verb object`, with the area in lower case"
    elif not re.fullmatch(r"[a-z][a-z-]*", form["verb"]):
        yield f"must continue with a verb in lower case after the colon, but continues with '{form['verb']}'"
    elif form["verb"] in NO_VERB:
        yield f"continues with '{form['verb']}', which is not a verb"
    if subject.endswith("."):
        yield "ends with a period"


def check(checkout, _all):
    if not checkout.has_history:
        print("check subjects: skipped, because this is not a git checkout with history", flush=True)
        return []
    commits = checkout.git("log", "--no-merges", "--format=%h %s", f"{checkout.prose_base}..HEAD", check=False).splitlines()
    return [f"{commit.split(' ', 1)[0]}: '{commit.split(' ', 1)[1]}' {fault}" for commit in reversed(commits)
            for fault in faults(commit.split(" ", 1)[1])]
