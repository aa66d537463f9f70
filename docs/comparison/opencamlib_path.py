"""Plans a raster with OpenCAMLib (pip install opencamlib numpy) and writes its tips.

    python opencamlib_path.py part.stl raster.csv --stepover 0.632

Lines run along x from edge to edge, to and fro. One tip a line, x,y,z in mm.
Prints figures as one line; CPU time is that of planning only.
"""

import argparse
import math
import resource
import struct
import time

import numpy as np
import opencamlib as ocl


def read_stl(path):
    raw = open(path, "rb").read()
    kind = [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]
    return np.frombuffer(raw, kind, struct.unpack("<I", raw[80:84])[0], 84)["v"].astype(float)


def raster_lines(low, high, stepover):
    """Ends of lines along x, to and fro; the last one on the edge."""
    count = math.ceil((high[1] - low[1]) / stepover - 1e-9)
    for i in range(count + 1):
        y = min(low[1] + i * stepover, high[1])
        ends = [(low[0], y), (high[0], y)]
        yield ends[::-1] if i % 2 else ends


def raster(surface, cutter, low, high, a):
    """Tips, one drop of the cutter every `sampling` mm, all in one batch."""
    batch = ocl.BatchDropCutter()
    batch.setBucketSize(100)  # triangles in a leaf of its tree
    batch.setCutter(cutter)
    batch.setSTL(surface)
    for p, q in raster_lines(low, high, a.stepover):
        for t in np.linspace(0.0, 1.0, math.ceil(math.dist(p, q) / a.sampling) + 1):
            batch.appendPoint(ocl.CLPoint(p[0] + t * (q[0] - p[0]), p[1], low[2] - 1.0))
    batch.run()
    return np.array([(p.x, p.y, p.z) for p in batch.getCLPoints()])


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("stl")
    ap.add_argument("csv")
    ap.add_argument("--diameter", type=float, default=10.0, help="of the ball, mm")
    ap.add_argument("--stepover", type=float, default=0.632)
    ap.add_argument("--sampling", type=float, default=0.1)
    a = ap.parse_args()
    triangles = read_stl(a.stl)
    low, high = triangles.min((0, 1)).tolist(), triangles.max((0, 1)).tolist()
    surface = ocl.STLSurf()
    for triangle in triangles.tolist():
        surface.addTriangle(ocl.Triangle(*(ocl.Point(*p) for p in triangle)))
    cpu = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    start, wall = cpu(), time.perf_counter()
    tips = raster(surface, ocl.BallCutter(a.diameter, 100.0), low, high, a)
    start, wall = cpu() - start, time.perf_counter() - wall
    np.savetxt(a.csv, tips, "%.6f", ",")
    length = np.linalg.norm(np.diff(tips, axis=0), axis=1).sum()
    figures = f"{len(tips)} points, {length:.0f} mm, {start:.1f} s CPU, {wall:.1f} s wall"
    print(f"OpenCAMLib {ocl.version()} raster: {figures}")


if __name__ == "__main__":
    main()
