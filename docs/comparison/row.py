"""Prints a row of the comparison from a program and one or two reports of `evencut verify --json`.

    python row.py path.ngc whole.json [inside.json]

Lengths are of all moves at feed (plain G0 and G1 programs only), heights in micrometres.
"""

import json
import re
import sys


def feed_length(path):
    """Length of the moves at feed, mm."""
    place, rapid, total = {"X": 0.0, "Y": 0.0, "Z": 0.0}, True, 0.0
    for line in open(path):
        line = re.sub(r"\(.*?\)", "", line)
        words = re.findall(r"([A-Z])(-?[0-9.]+)", line)
        codes = [float(value) for letter, value in words if letter == "G"]
        if 2.0 in codes or 3.0 in codes:
            sys.exit(f"{path}: arcs are not read")
        rapid = 0.0 in codes or (rapid and 1.0 not in codes)
        to = {**place, **{letter: float(value) for letter, value in words if letter in place}}
        if not rapid:
            total += sum((to[axis] - place[axis]) ** 2 for axis in place) ** 0.5
        place = to
    return total


def figures(path):
    v = json.load(open(path))["verification"]
    s = v["scallop"]
    um = lambda value: f"{1e3 * value:.1f}"
    row = [um(s["largest_mm"]), um(s["p99_mm"]), f"{s['above_percent']:.1f}", um(v["gouge_mm"] or 0.0)]
    bands = [f"{um(b['largest_mm'])} / {b['above_percent']:.1f}" for b in v["by_slope"] if b["area_mm2"] > 0]
    return row + bands + [f"bound {um(s['sampling_bound_mm'])}"]


def main():
    print(f"{sys.argv[1]}: {feed_length(sys.argv[1]):.0f} mm")
    for path in sys.argv[2:]:
        print("  " + path, *figures(path), sep=" | ")


if __name__ == "__main__":
    main()
