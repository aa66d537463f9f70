//! Welding: vertices closer than a tolerance become one.

use crate::geometry::DVec3;

/// Side of a hash cell in tolerances. Larger cells make neighbour look-ups rarer and cells fuller.
const CELL: f64 = 16.0;

/// For every position the index of the first position within `tolerance` of it.
///
/// A representative maps to itself, and representatives are further than `tolerance` apart, so
/// clusters do not grow into chains. `tolerance` must be positive, positions finite.
pub(super) fn weld(positions: &[DVec3], tolerance: f64) -> Vec<u32> {
    let origin = positions.iter().copied().reduce(DVec3::min).unwrap_or(DVec3::ZERO);
    let per_cell = 1.0 / (CELL * tolerance);
    let mut cells = Cells::new();
    let mut first = Vec::with_capacity(positions.len());
    for (i, &p) in positions.iter().enumerate() {
        let scaled = (p - origin) * per_cell;
        let found = find(&cells, positions, p, scaled, tolerance);
        if found.is_none() {
            cells.insert(key(scaled), i as u32);
        }
        first.push(found.unwrap_or(i as u32));
    }
    first
}

fn key(scaled: DVec3) -> [i64; 3] {
    scaled.to_array().map(|c| c.floor() as i64)
}

/// The earliest representative within `tolerance` of `p`, in its cell or in one that it borders on.
fn find(
    cells: &Cells,
    positions: &[DVec3],
    p: DVec3,
    scaled: DVec3,
    tolerance: f64,
) -> Option<u32> {
    let own = key(scaled);
    let near = |j: &u32| (positions[*j as usize] - p).length_squared() <= tolerance * tolerance;
    let best = cells.of(own).filter(near).min();
    // Cells beyond a wall matter only to points within a tolerance of it.
    let margin = 1.0 / CELL;
    let reach = |c: f64| {
        let inside = c - c.floor();
        i64::from(inside >= 1.0 - margin) - i64::from(inside <= margin)
    };
    let step = scaled.to_array().map(reach);
    if step == [0; 3] {
        return best;
    }
    (1..8_u32)
        .filter(|mask| (0..3).all(|axis| mask >> axis & 1 == 0 || step[axis] != 0))
        .flat_map(|mask| {
            let [x, y, z] =
                [0, 1, 2].map(|axis| own[axis] + step[axis] * i64::from(mask >> axis & 1));
            cells.of([x, y, z]).filter(near)
        })
        .chain(best)
        .min()
}

/// A hash table from cells to representatives, open addressing with linear probing.
///
/// It grows with the representatives and not with the positions, so that it stays in the cache:
/// an STL file repeats every vertex about six times.
struct Cells {
    /// Upper half: part of the cell's hash; lower half: the representative.
    slots: Vec<u64>,
    used: usize,
}

impl Cells {
    const EMPTY: u64 = u64::MAX;
    const FEWEST_SLOTS: usize = 1 << 10;

    fn new() -> Self {
        Self { slots: vec![Self::EMPTY; Self::FEWEST_SLOTS], used: 0 }
    }

    fn hash(key: [i64; 3]) -> u32 {
        // Multiplicative hashing with the odd constants of SplitMix64.
        const FACTORS: [u64; 3] =
            [0x9e37_79b9_7f4a_7c15, 0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];
        let mixed = (0..3).fold(0_u64, |hash, axis| {
            (hash.rotate_left(23) ^ key[axis] as u64).wrapping_mul(FACTORS[axis])
        });
        ((mixed ^ (mixed >> 29)).wrapping_mul(FACTORS[0]) >> 32) as u32
    }

    /// All slots, cyclically from the one that a hash starts at.
    fn probe(&self, hash: u32) -> impl Iterator<Item = usize> + use<> {
        let mask = self.slots.len() - 1;
        (0..=mask).map(move |step| (hash as usize).wrapping_add(step) & mask)
    }

    fn insert(&mut self, key: [i64; 3], position: u32) {
        if 2 * (self.used + 1) > self.slots.len() {
            let larger = vec![Self::EMPTY; 2 * self.slots.len()];
            for entry in std::mem::replace(&mut self.slots, larger) {
                if entry != Self::EMPTY {
                    self.put(entry);
                }
            }
        }
        self.used += 1;
        self.put(u64::from(Self::hash(key)) << 32 | u64::from(position));
    }

    fn put(&mut self, entry: u64) {
        let mut slots = self.probe((entry >> 32) as u32);
        if let Some(free) = slots.find(|slot| self.slots[*slot] == Self::EMPTY) {
            self.slots[free] = entry;
        }
    }

    /// Representatives in the cell `key`, and rarely some of others, which the distance test of
    /// the caller sorts out.
    fn of(&self, key: [i64; 3]) -> impl Iterator<Item = u32> + '_ {
        let hash = Self::hash(key);
        self.probe(hash)
            .map(|slot| self.slots[slot])
            .take_while(|entry| *entry != Self::EMPTY)
            .filter(move |entry| (entry >> 32) as u32 == hash)
            .map(|entry| entry as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_points_become_the_first_and_far_ones_stay() {
        let p = |x: f64| DVec3::new(x, 2.0, -7.0);
        let tolerance = 1e-6;
        let points = [p(0.0), p(1.0), p(0.9e-6), p(-0.9e-6), p(1.0 + 2e-6), p(1.0)];
        assert_eq!(weld(&points, tolerance), [0, 1, 0, 0, 4, 1]);
    }

    #[test]
    fn every_cell_wall_is_looked_over() {
        // A point and its twin half a tolerance away, in eight directions, at many places.
        let tolerance = 1e-3;
        let mut points = vec![DVec3::ZERO];
        for i in 1..500 {
            let p = DVec3::new(1.0, 1.7, 0.3) * f64::from(i) * tolerance * CELL / 7.0;
            let octant = DVec3::new(
                if i & 1 == 0 { 1.0 } else { -1.0 },
                if i & 2 == 0 { 1.0 } else { -1.0 },
                if i & 4 == 0 { 1.0 } else { -1.0 },
            );
            points.extend([p, p + 0.5 * tolerance * octant]);
        }
        let first = weld(&points, tolerance);
        for pair in (1..points.len()).step_by(2) {
            assert_eq!(first[pair + 1], pair as u32);
        }
    }
}
