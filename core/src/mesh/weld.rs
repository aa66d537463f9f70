//! Welding: vertices closer than a tolerance become one.

use crate::geometry::DVec3;

/// Side of a hash cell in tolerances. Larger cells make neighbour look-ups rarer and chains longer.
const CELL: f64 = 16.0;
const NONE: u32 = u32::MAX;

/// For every position the index of the first position within `tolerance` of it.
///
/// A representative maps to itself, and representatives are further than `tolerance` apart, so
/// clusters do not grow into chains. `tolerance` must be positive, positions finite.
pub(super) fn weld(positions: &[DVec3], tolerance: f64) -> Vec<u32> {
    let origin = positions.iter().copied().reduce(DVec3::min).unwrap_or(DVec3::ZERO);
    let mut cells = Cells::new(positions.len());
    let mut first = Vec::with_capacity(positions.len());
    for (i, &p) in positions.iter().enumerate() {
        let scaled = (p - origin) / (CELL * tolerance);
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
    let best = cells.chain(own).filter(near).min();
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
            cells.chain([x, y, z]).filter(near)
        })
        .chain(best)
        .min()
}

/// A hash table from cells to chains of positions; chains of different cells may share a slot,
/// which the distance test sorts out.
struct Cells {
    head: Vec<u32>,
    next: Vec<u32>,
    entry: Vec<u32>,
    shift: u32,
}

impl Cells {
    fn new(positions: usize) -> Self {
        let bits = usize::BITS - positions.max(8).leading_zeros() + 1;
        let head = vec![NONE; 1 << bits];
        Self { head, next: Vec::new(), entry: Vec::new(), shift: 64 - bits }
    }

    fn slot(&self, key: [i64; 3]) -> usize {
        // Multiplicative hashing with the odd constants of SplitMix64.
        const FACTORS: [u64; 3] =
            [0x9e37_79b9_7f4a_7c15, 0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];
        let mixed = (0..3).fold(0_u64, |hash, axis| {
            (hash.rotate_left(23) ^ key[axis] as u64).wrapping_mul(FACTORS[axis])
        });
        ((mixed ^ (mixed >> 29)).wrapping_mul(FACTORS[0]) >> self.shift) as usize
    }

    fn insert(&mut self, key: [i64; 3], position: u32) {
        let slot = self.slot(key);
        self.next.push(self.head[slot]);
        self.entry.push(position);
        self.head[slot] = self.entry.len() as u32 - 1;
    }

    fn chain(&self, key: [i64; 3]) -> impl Iterator<Item = u32> + '_ {
        let mut at = self.head[self.slot(key)];
        std::iter::from_fn(move || {
            let here = at as usize;
            at = *self.next.get(here)?;
            self.entry.get(here).copied()
        })
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
