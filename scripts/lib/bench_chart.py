"""The SVG chart in tests/bench/README.md. For each day in tests/bench/results, it shows our speed as a multiple of other programs' speeds.

Each line compares us with one other program in one benchmark. A point is the geometric mean of the cases that all days of the line
contain. The label is at the last point; labels are moved apart if they would overlap.
"""
import html
import math

PATH = "tests/bench/results/history.svg"
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 640, 300, 44, 190, 30, 30
COLOURS = ("#1b6ca8", "#c8553d", "#3f7d20", "#7b4fa3", "#b8860b", "#4a4a4a", "#0f8b8d", "#a23b72")
FIRST = "205c8dc"  # the only release in the chart, because it is the only one with comparisons on several days


def series(files):
    """Returns {label: {file: mean ratio}} for comparisons with at least two days."""
    ratios = {}
    for name, results in files.items():
        for result in results:
            if result.kind == "peer" or (result.kind == "release" and result.against == FIRST):
                if result.unit != "MiB" and result.ratio:
                    of_line = ratios.setdefault(f"{result.benchmark} vs {result.against}", {})
                    of_line.setdefault(name, {})[result.case, result.threads] = float(result.ratio)
    found = {}
    for label, days in ratios.items():
        cases = set.intersection(*(set(cases) for cases in days.values()))
        if len(days) > 1 and cases:
            found[label] = {name: math.exp(sum(math.log(of_day[case]) for case in sorted(cases)) / len(cases))
                            for name, of_day in days.items()}
    return found


def spread(places, least):
    """Returns the positions in the same order, moved down so that neighbours are at least `least` apart."""
    moved = []
    for place in places:
        moved.append(max(place, moved[-1] + least) if moved else place)
    return moved


def draw(files):
    lines, names = series(files), list(files)
    ticks = [factor * 10.0 ** power for power in range(-3, 5) for factor in (1, 2, 5)]
    values = [value for line in lines.values() for value in line.values()] or [1.0, 10.0]
    lowest = max(tick for tick in ticks if tick <= min(values))
    highest = min(tick for tick in ticks if tick >= max(values) and tick > lowest)

    def x_of(name):
        return LEFT + 20 + (WIDTH - LEFT - RIGHT - 40) * names.index(name) / max(1, len(names) - 1)

    def y_of(value):
        return TOP + (HEIGHT - TOP - BOTTOM) * math.log(highest / value) / math.log(highest / lowest)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
           'font-family="sans-serif" font-size="11">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>',
           f'<text x="{LEFT}" y="16" font-size="12" fill="#222222">How many times as fast as another program (mean of the cases)</text>']
    for tick in ticks:
        if lowest <= tick <= highest:
            colour, y = "#888888" if tick == 1 else "#e4e4e4", y_of(tick)
            out.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}"/>')
            out.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end" fill="#555555">{tick:g}</text>')
    for name in names:
        versions = sorted({int(result.algorithm) for result in files[name]})
        label = f"{name[5:-4]}, v{versions[-1]}"
        out.append(f'<text x="{x_of(name):.1f}" y="{HEIGHT - 10}" text-anchor="middle" fill="#555555">{label}</text>')
    ordered = sorted(lines.items(), key=lambda line: -list(line[1].values())[-1])
    places = spread([y_of(list(line.values())[-1]) for _, line in ordered], 14)
    for k, ((label, line), place) in enumerate(zip(ordered, places)):
        colour = COLOURS[k % len(COLOURS)]
        points = " ".join(f"{x_of(name):.1f},{y_of(value):.1f}" for name, value in line.items())
        out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x_of(name):.1f}" cy="{y_of(value):.1f}" r="3" fill="{colour}"/>' for name, value in line.items()]
        last = list(line.values())[-1]
        out.append(f'<text x="{WIDTH - RIGHT + 8}" y="{place + 4:.1f}" fill="{colour}">{html.escape(label)}: {last:.3g}</text>')
    return "\n".join([*out, "</svg>"]) + "\n"
