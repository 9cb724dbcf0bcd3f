"""Results of scripts/bench: one CSV file per day in tests/bench/results, and the table in tests/bench/README.md.

Each line is one comparison: our value, and the value of a peer or an earlier release, or a target in the same unit. A case with
two peers has two lines; a case without a comparison has an empty `kind`. A `ratio` of 2 means that we are twice as fast as the other
program, or use half as much memory. `goal` is the ratio to reach. An empty cell means unknown.
"""
import csv
import dataclasses
import io

FOLDER = "tests/bench/results"
PAGE = "tests/bench/README.md"
BEGIN, END = "<!-- results: written by scripts/bench --table -->", "<!-- end of results -->"
KINDS = ("peer", "release", "target", "")


@dataclasses.dataclass
class Result:
    date: str  # day of the measurement, as in 2026-11-29
    algorithm: str  # our algorithm version
    commit: str  # our commit
    machine: str  # processor and number of cores
    benchmark: str
    case: str
    threads: str
    unit: str  # ms, MiB or /s
    ours: str  # our best value of all rounds
    median: str
    kind: str
    against: str  # name of the peer, or commit of the release
    value: str  # their best value
    ratio: str
    goal: str

    @property
    def row(self):
        return self.benchmark, self.case, self.threads

    @property
    def reached(self):
        return bool(self.goal and self.ratio) and float(self.ratio) >= float(self.goal)


COLUMNS = [field.name for field in dataclasses.fields(Result)]


def number(value):
    """Formats a value with three significant digits."""
    return f"{value:.3g}" if value < 100 else f"{value:.0f}"


def read(text):
    rows = list(csv.reader(io.StringIO(text)))
    if not rows or rows[0] != COLUMNS:
        raise ValueError(f"the first line must list the columns {','.join(COLUMNS)}")
    for number_of_line, row in enumerate(rows[1:], 2):
        if len(row) != len(COLUMNS):
            raise ValueError(f"line {number_of_line}: {len(row)} cells instead of {len(COLUMNS)}")
    return [Result(*row) for row in rows[1:]]


def write(results):
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(COLUMNS)
    table.writerows(dataclasses.astuple(result) for result in results)
    return out.getvalue()


def read_all(root):
    """Returns {name of a file: its results}, oldest file first."""
    return {path.name: read(path.read_text(encoding="utf-8")) for path in sorted((root / FOLDER).glob("*.csv"))}


def merge(old, new):
    """Returns the old results with the new ones added. New results replace all old results of the same row."""
    again = {result.row for result in new}
    return [result for result in old if result.row not in again] + new


def latest(files):
    """Returns {row: its results in the newest file that contains the row}. Rows are in the order in which the files first mention them."""
    found = {}
    for results in files.values():
        of_file = {}
        for result in results:
            of_file.setdefault(result.row, []).append(result)
        found.update(of_file)
    return found


def is_shown(results):
    """Returns whether the table shows these results. It shows only rows with a peer or a goal; the files contain all rows."""
    return any(result.kind == "peer" or result.goal for result in results)


HEAD = "|benchmark|threads|ours|release|peers|goal|version|date|\n|---|---|---|---|---|---|---|---|"


def line(results):
    """Returns a row of the table, from all results of one case."""
    first = results[0]
    of_kind = {kind: ", ".join(compared(result) for result in results if result.kind == kind) for kind in KINDS}
    goals = [result for result in results if result.goal]
    state = "" if not goals else "reached" if all(result.reached for result in goals) else "missed"
    target = [f"{result.value} {result.unit}" for result in results if result.kind == "target"]
    cells = [f"{first.benchmark} {first.case}", first.threads, f"{first.ours} {first.unit}", of_kind["release"], of_kind["peer"],
             ": ".join([*target, state]) if state else "", first.algorithm, first.date[5:]]
    return f"|{'|'.join(cells)}|"


def compared(result):
    goal = f" (goal {result.goal})" if result.goal else ""
    return f"{result.ratio} × {result.against}{goal}"


def table(files):
    return "\n".join([HEAD, *(line(results) for results in latest(files).values() if is_shown(results))])


def with_table(page, files):
    """Returns the page with these results in its table."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{PAGE} lacks the lines '{BEGIN}' and '{END}'")
    return f"{before}{begin}\n\n{table(files)}\n\n{end}{after}"
