"""Writes an engine-like closed solid: a crowned plate with a raised block, pockets with upright walls, and bosses.

    python solid.py cover.stl [cell]

100 x 70 mm, 25 mm high, cells of 1 mm unless given. Walls stand on lines of the grid, so that it is closed.
"""

import sys

import numpy as np

# x0, x1, y0, y1, height over the plate: later ones replace earlier ones, mm.
STEPS = [
    (0, 100, 0, 70, 10),  # the plate
    (10, 90, 10, 60, 20),  # a block on it
    (15, 50, 15, 55, 8),  # a pocket
    (28, 38, 30, 40, 16),  # a boss in it
    (55, 85, 15, 32, 12),  # another pocket
    (58, 84, 40, 52, 14),  # and a third
    (66, 74, 43, 49, 20),  # with a boss
]


def crown(x, y):
    """What all heights rise by, mm."""
    return 3.0 * (1.0 - ((x - 50.0) / 60.0) ** 2 - ((y - 35.0) / 45.0) ** 2)


def main():
    cell = float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
    nx, ny = round(100 / cell), round(70 / cell)
    x, y = np.arange(nx) * cell + 0.5 * cell, np.arange(ny) * cell + 0.5 * cell
    level = np.zeros((nx, ny))
    for x0, x1, y0, y1, height in STEPS:
        level[np.ix_((x > x0) & (x < x1), (y > y0) & (y < y1))] = height
    out = []

    def quad(a, b, c, d):
        out.extend([(a, b, c), (a, c, d)])

    def at(i, j, height):
        px, py = i * cell, j * cell
        return (px, py, 0.0 if height is None else height + crown(px, py))

    for i in range(nx):
        for j in range(ny):
            h = level[i, j]
            quad(at(i, j, h), at(i + 1, j, h), at(i + 1, j + 1, h), at(i, j + 1, h))
            quad(at(i, j, None), at(i, j + 1, None), at(i + 1, j + 1, None), at(i + 1, j, None))
            # Walls down to lower neighbours, the outside being the plane below.
            for di, dj, (p, q) in [
                (1, 0, ((i + 1, j), (i + 1, j + 1))),
                (-1, 0, ((i, j + 1), (i, j))),
                (0, 1, ((i + 1, j + 1), (i, j + 1))),
                (0, -1, ((i, j), (i + 1, j))),
            ]:
                k, l = i + di, j + dj
                inside = 0 <= k < nx and 0 <= l < ny
                low = level[k, l] if inside else None
                if low is None or low < h:
                    quad(at(*p, low), at(*q, low), at(*q, h), at(*p, h))
    corners = np.array(out, "<f4")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    faces = np.zeros(len(corners), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    faces["n"], faces["v"] = normals, corners
    with open(sys.argv[1], "wb") as file:
        file.write(b"\0" * 80 + len(faces).to_bytes(4, "little") + faces.tobytes())
    print(f"{len(faces)} faces")


if __name__ == "__main__":
    main()
