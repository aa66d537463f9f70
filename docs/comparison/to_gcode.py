"""Turns a list of tips into a three-axis program: x,y,z a line in mm, a blank line where to lift.

    python to_gcode.py path.csv path.ngc --clearance 10 --feed 1200
"""

import argparse


def passes(path):
    """Lists of tips (x, y, z), one for each stretch between blank lines."""
    stretch = []
    for line in open(path):
        if line.strip():
            stretch.append(tuple(float(value) for value in line.split(",")))
        elif stretch:
            yield stretch
            stretch = []
    if stretch:
        yield stretch


def program(stretches, clearance, feed):
    """Lines of the program; rapids run `clearance` mm above the highest tip."""
    top = max(z for stretch in stretches for _, _, z in stretch) + clearance
    yield from ("G21 G90 G17 G94 G40 G49 G80", "G54", "T1 M6", "S8000 M3", f"G0 Z{top:.4f}")
    for stretch in stretches:
        x, y, z = stretch[0]
        yield f"G0 X{x:.5f} Y{y:.5f}"
        yield f"G1 Z{z:.5f} F{feed:g}"
        yield from (f"G1 X{x:.5f} Y{y:.5f} Z{z:.5f}" for x, y, z in stretch[1:])
        yield f"G0 Z{top:.4f}"
    yield from ("M5", "M2")


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("csv")
    ap.add_argument("program")
    ap.add_argument("--clearance", type=float, default=10.0)
    ap.add_argument("--feed", type=float, default=1200.0)
    a = ap.parse_args()
    with open(a.program, "w") as file:
        file.writelines(line + "\n" for line in program(list(passes(a.csv)), a.clearance, a.feed))


if __name__ == "__main__":
    main()
