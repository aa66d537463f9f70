// A planned path: its points by time, and what holds at one of them.

export class Path {
  constructor(plan) {
    this.tables = plan.tables;
    this.scales = plan.scales;
    const { time } = this.tables;
    this.count = time.length;
    this.duration = this.count ? time[this.count - 1] : 0;
  }

  /** The judge's samples, sorted when they are asked for first. */
  get samples() {
    this.sorted ??= new Samples(this.tables);
    return this.sorted;
  }

  /** Where a move lies on the scale of the path's colours; above 1 only where a limit is exceeded. */
  share(i) {
    const { rate, time } = this.tables;
    const { limit } = this.scales;
    return limit === null ? time[i] / (this.duration || 1) : rate[i] / limit;
  }

  /** The place on the path at a time: point that the move ends at, and the part of the move done. */
  at(time) {
    const times = this.tables.time;
    let [low, high] = [0, this.count - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < time) low = middle + 1;
      else high = middle;
    }
    const before = low > 0 ? times[low - 1] : 0;
    const span = times[low] - before;
    const part = span > 0 ? Math.min(Math.max((time - before) / span, 0), 1) : 1;
    return { index: low, part, time: Math.min(Math.max(time, 0), this.duration) };
  }

  /** The time at which a part of the move that ends at a point is done. */
  timeAt(index, part) {
    const times = this.tables.time;
    const before = index > 0 ? times[index - 1] : 0;
    return before + part * (times[index] - before);
  }

  /** A vector of a table, `size` numbers, at a place; null where there is none. */
  vector(table, { index, part }, size = 3) {
    const values = this.tables[table];
    const end = values.subarray(size * index, size * index + size);
    const start = index > 0 ? values.subarray(size * (index - 1), size * index) : end;
    const mixed = Array.from(end, (b, i) => start[i] + part * (b - start[i]));
    if (mixed.every(Number.isFinite)) return mixed;
    return [part < 0.5 ? start : end, end, start].map((v) => Array.from(v)).find((v) => v.every(Number.isFinite)) ?? null;
  }

  /** What is said about a place. `near`: the place on the surface that is meant, else the path's. */
  values(place, near) {
    const t = this.tables;
    const i = place.index;
    const at = near ?? this.vector("contact", place);
    const sample = at ? this.samples.nearest(at) : -1;
    return {
      kind: this.scales.kinds[t.kind[i]],
      pass: t.pass[i],
      region: t.region[i],
      // Without a limit no rate is predicted: what the simulation measured is shown.
      rate: this.scales.limit === null ? (sample < 0 ? NaN : t.sampleRate[sample]) : t.rate[i],
      share: this.scales.limit === null ? NaN : t.rate[i] / this.scales.limit,
      engagement: this.scales.limit === null ? NaN : t.engagement[i],
      feed: t.feed[i],
      time: place.time,
      residual: sample < 0 ? null : t.sampleResidual[sample],
      state: sample < 0 ? null : t.sampleState[sample],
    };
  }
}

/** The judge's samples in a grid of cubes. */
class Samples {
  #cells = new Map();
  #places;
  #size = 1;

  constructor({ samplePlace }) {
    this.#places = samplePlace;
    const count = samplePlace.length / 3;
    if (count === 0) return;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    samplePlace.forEach((x, i) => {
      low[i % 3] = Math.min(low[i % 3], x);
      high[i % 3] = Math.max(high[i % 3], x);
    });
    const diagonal = Math.hypot(...high.map((h, i) => h - low[i]));
    this.#size = Math.max((3 * diagonal) / Math.sqrt(count), 1e-6);
    for (let i = 0; i < count; i++) {
      const key = this.#key(samplePlace[3 * i], samplePlace[3 * i + 1], samplePlace[3 * i + 2]);
      const cell = this.#cells.get(key);
      if (cell) cell.push(i);
      else this.#cells.set(key, [i]);
    }
  }

  #key(x, y, z) {
    const [a, b, c] = [x, y, z].map((v) => Math.floor(v / this.#size) & 0xffff);
    return (a * 0x10000 + b) * 0x10000 + c;
  }

  /** The sample nearest to a place; -1 where none is near. */
  nearest([x, y, z]) {
    let [best, least] = [-1, Infinity];
    const s = this.#size;
    for (let cell = 0; cell < 27; cell++) {
      const key = this.#key(x + ((cell % 3) - 1) * s, y + (((cell / 3) | 0) % 3 - 1) * s, z + (((cell / 9) | 0) - 1) * s);
      for (const i of this.#cells.get(key) ?? []) {
        const p = this.#places.subarray(3 * i, 3 * i + 3);
        const distance = (p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2;
        if (distance < least) [best, least] = [i, distance];
      }
    }
    return best;
  }
}
