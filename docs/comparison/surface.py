"""Writes the freeform test surface as binary STL, or prints its shortest possible path.

    python surface.py 20000 freeform-20k.stl
    python surface.py 20000 inside-20k.stl --margin 4      (the same triangles, the rim left out)
    python surface.py lmin --radius 5 --scallop 0.01

L_min is the area divided by the widest strip, integrated: dA / w_max, w_max^2 = 8 h / (1/R + k_min),
where k_min is the smaller normal curvature, positive where the surface is convex. A path that leaves
no cusp above h has at least about this length (first order in h, edges aside).
"""

import argparse
import struct

import numpy as np

SIZE = 100.0


def height(x, y):
    """Heights, mm: a saddle, two bumps and a ripple over [0, 100] x [0, 100]."""
    u, v = x / SIZE * 2 - 1, y / SIZE * 2 - 1
    bump = lambda x0, y0, r: np.exp(-(((x - x0) / r) ** 2 + ((y - y0) / r) ** 2))
    z = 6.0 * (u * u - v * v) + 14.0 * bump(35.0, 40.0, 17.0) + 9.0 * bump(72.0, 70.0, 14.0)
    return z + 0.8 * np.sin(2 * np.pi * x / 50.0) * np.cos(2 * np.pi * y / 60.0)


def write_stl(path, faces, margin):
    """A grid of `faces` triangles, top side up; only those at least `margin` mm from the edge."""
    n = round((faces / 2) ** 0.5)
    x, y = np.meshgrid(*[np.linspace(0.0, SIZE, n + 1)] * 2, indexing="ij")
    p = np.stack([x, y, height(x, y)], -1)
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    t = np.concatenate([np.stack(f, -2).reshape(-1, 3, 3) for f in ((a, b, c), (a, c, d))])
    t = t[((t[..., :2] > margin - 1e-6) & (t[..., :2] < SIZE - margin + 1e-6)).all((1, 2))]
    normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    record = np.zeros(len(t), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    record["n"], record["v"] = normal, t
    with open(path, "wb") as file:
        file.write(b"\0" * 80 + struct.pack("<I", len(t)) + record.tobytes())


def shortest(radius, scallop, n):
    """Area, mm², shortest length, mm, and extreme curvatures, 1/mm, from n x n cell centres."""
    g, e = (np.arange(n) + 0.5) * SIZE / n, 1e-3
    x, y = np.meshgrid(g, g, indexing="ij")
    z = height(x, y)
    east, west, north, south = (height(x + i * e, y + j * e) for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1)))
    zx, zy = (east - west) / (2 * e), (north - south) / (2 * e)
    zxx, zyy = (east - 2 * z + west) / e**2, (north - 2 * z + south) / e**2
    corners = [height(x + i * e, y + j * e) for i, j in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
    zxy = (corners[0] - corners[1] - corners[2] + corners[3]) / (4 * e * e)
    w = np.sqrt(1 + zx**2 + zy**2)
    gauss = (zxx * zyy - zxy**2) / w**4
    # The normal points up, so that a convex place (a peak) is to have positive curvature.
    mean = -((1 + zy**2) * zxx - 2 * zx * zy * zxy + (1 + zx**2) * zyy) / (2 * w**3)
    spread = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
    widest = np.sqrt(8 * scallop / (1 / radius + mean - spread))
    cell = (SIZE / n) ** 2
    return (w * cell).sum(), (w * cell / widest).sum(), (mean - spread).min(), (mean + spread).max()


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("faces", help="number of faces, or lmin")
    ap.add_argument("out", nargs="?")
    ap.add_argument("--margin", type=float, default=0.0)
    ap.add_argument("--radius", type=float, default=5.0)
    ap.add_argument("--scallop", type=float, default=0.01)
    a = ap.parse_args()
    if a.faces != "lmin":
        return write_stl(a.out, int(a.faces), a.margin)
    for n in (500, 1000, 2000):
        area, length, low, high = shortest(a.radius, a.scallop, n)
        print(f"{n} x {n} cells: area {area:.1f} mm2, L_min {length:.1f} mm, curvature {low:.4f} to {high:.4f} 1/mm")


if __name__ == "__main__":
    main()
