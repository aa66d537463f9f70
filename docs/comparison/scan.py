"""Writes meshes of a closed terrain, or of a scan with noise.

    python scan.py terrain terrain.stl
    python scan.py NOISE scan.stl

The terrain stands on a block, 100 x 100 mm, 115 200 faces on top: four octaves of noise on grids of 4 to 32 cells,
smoothed by cubic B-splines. The scan has 80 x 60 mm and places that lie irregularly, half a millimetre apart, each
moved up or down by a normal deviate of NOISE mm.
"""

import sys

import numpy as np


def octave(rng, cells, count):
    """A smooth surface over `count` x `count` places, of random heights on a grid of so many cells."""
    x = np.linspace(0, cells, count)
    cell = x.astype(int)
    t = x - cell
    weights = np.zeros((count, cells + 4))
    spline = [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3]
    for k, weight in enumerate(spline):
        weights[np.arange(count), cell + k] += weight / 6
    return weights @ rng.normal(size=(cells + 4, cells + 4)) @ weights.T


def grid(x, y, z):
    """Two triangles for every cell of a grid of places."""
    place = np.stack([x, y, z], axis=-1)
    a, b, c, d = place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ([a, b, c], [a, c, d])])


def terrain():
    """The closed terrain."""
    rng = np.random.default_rng(7)
    count = 241
    z = sum(octave(rng, cells, count) * high for cells, high in [(4, 14), (8, 7), (16, 3), (32, 1.2)])
    z += 8 - z.min()
    at = np.linspace(0, 100, count)
    x, y = np.meshgrid(at, at, indexing="ij")
    out = [grid(x, y, z), grid(x, y, np.zeros_like(z))[:, ::-1]]
    for side in (np.s_[:, 0], np.s_[-1, :], np.s_[::-1, -1], np.s_[0, ::-1]):
        wall = [np.stack([v[side], v[side]]) for v in (x, y)]
        out.append(grid(*wall, np.stack([z[side], 0 * z[side]])))
    return np.concatenate(out)


def scan(noise):
    """An open surface with noise."""
    rng = np.random.default_rng(3)
    x, y = np.meshgrid(np.linspace(0, 80, 161), np.linspace(0, 60, 121), indexing="ij")
    inside = np.zeros_like(x)
    inside[1:-1, 1:-1] = 1
    x = x + inside * rng.uniform(-0.15, 0.15, x.shape)
    y = y + inside * rng.uniform(-0.15, 0.15, x.shape)
    bump = 8 * np.exp(-((x - 50) ** 2 + (y - 25) ** 2) / 120)
    return grid(x, y, 6 * np.sin(x / 14) * np.cos(y / 17) + bump + rng.normal(0, noise, x.shape))


def main():
    what, name = sys.argv[1:3]
    corners = np.array(terrain() if what == "terrain" else scan(float(what)), "<f4")
    faces = np.zeros(len(corners), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    faces["v"] = corners
    with open(name, "wb") as file:
        file.write(b"\0" * 80 + len(faces).to_bytes(4, "little") + faces.tobytes())
    print(f"{len(faces)} faces")


if __name__ == "__main__":
    main()
