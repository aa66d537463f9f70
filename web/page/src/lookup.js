// What of a path lies under the pointer in a picture.

/** Side of a cell, px of the picture. */
const CELL = 8;
/** Longest piece of a move, px: places between two points are found too. */
const PIECE = 4;
/** What lies this much behind what is in front is hidden, px. */
const SLACK = 8;

/** Places of a path in a picture, in cells. */
export class Lookup {
  #cells = new Map();
  #places = [];

  /** `table`: the table of places, `size` numbers each; `placement`: where the picture shows them. */
  constructor(path, table, size, placement) {
    this.project = projector(placement);
    const values = path.tables[table];
    let last = null;
    for (let i = 0; i < path.count; i++) {
      const p = this.project(values.subarray(size * i, size * i + size));
      if (!Number.isFinite(p[0])) {
        last = null;
        continue;
      }
      const from = last ?? p;
      const pieces = Math.max(1, Math.ceil(Math.hypot(p[0] - from[0], p[1] - from[1]) / PIECE));
      for (let k = 1; k <= pieces; k++) {
        const part = k / pieces;
        this.#add(from.map((a, j) => a + part * (p[j] - a)), i, part);
      }
      last = p;
    }
  }

  #add([x, y, near], index, part) {
    const key = Math.floor(y / CELL) * 0x10000 + Math.floor(x / CELL);
    const place = this.#places.push({ x, y, near, index, part }) - 1;
    const cell = this.#cells.get(key);
    if (cell) cell.push(place);
    else this.#cells.set(key, [place]);
  }

  /** The nearest visible place within `reach` px, as {index, part}; null if there is none. */
  nearest(x, y, reach) {
    const found = [];
    let front = -Infinity;
    for (let row = Math.floor((y - reach) / CELL); row <= Math.floor((y + reach) / CELL); row++) {
      for (let column = Math.floor((x - reach) / CELL); column <= Math.floor((x + reach) / CELL); column++) {
        for (const i of this.#cells.get(row * 0x10000 + column) ?? []) {
          const place = this.#places[i];
          const distance = Math.hypot(place.x - x, place.y - y);
          if (distance > reach) continue;
          found.push({ distance, place });
          front = Math.max(front, place.near);
        }
      }
    }
    const visible = found.filter(({ place }) => place.near > front - SLACK);
    const best = visible.reduce((a, b) => (a && a.distance <= b.distance ? a : b), null);
    return best && { index: best.place.index, part: best.place.part };
  }
}

/** A function from places to [x, y, nearness], px. */
export function projector({ x, y, near }) {
  const dot = (row, p) => row[0] * p[0] + row[1] * p[1] + (p.length > 2 ? row[2] * p[2] : 0) + row[3];
  return (p) => [dot(x, p), dot(y, p), dot(near, p)];
}
