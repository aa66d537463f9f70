//! Where simulated paths cut more than may be cut at once.
//!
//! The disc model in the plane that places trochoids knows the removal rate only roughly: where plain passes keep to the
//! limits in the simulation, no trochoids are needed, and where loops do not, they need smaller bites.

use crate::flat_path::Terrain;
use crate::geometry::DVec2;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use std::collections::BTreeMap;

/// Distance of places along a move, as a fraction of their reach.
const SPACING: f64 = 0.5;
/// Allowance for rounding above the limit.
const ROUNDING: f64 = 1e-9;

/// A place of a move above the limit.
#[derive(Copy, Clone, Debug)]
struct Above {
    at: DVec2,
    /// How far it reaches, flat mm.
    reach: f64,
    /// How much it cuts, in units of the caller's.
    amount: f64,
}

/// Flat places of moves above the limit.
#[derive(Clone, Debug)]
pub struct Excess {
    /// Side of a cell: no place reaches farther, flat mm.
    cell: f64,
    cells: BTreeMap<[i64; 2], Vec<Above>>,
}

impl Excess {
    /// The places of a path's plain cutting moves that remove more than `section`, mm³ per mm of travel, and all within
    /// `radius`, mm, of them, with their rates, mm³/s.
    pub fn above(path: &Toolpath, section: f64, radius: f64, terrain: &dyn Terrain) -> Self {
        let is_above =
            |p: &PathPoint| p.kind == MoveKind::Cut && p.mrr > section * p.feed * (1.0 + ROUNDING);
        let rates = path.points.iter().map(|p| is_above(p).then_some(p.mrr));
        Self::of(path, rates, radius, terrain)
    }

    /// The places of the moves for which `amounts`, one for each point of the path, tells how much they cut, and all
    /// within `radius`, mm, of them.
    pub fn of(
        path: &Toolpath,
        amounts: impl Iterator<Item = Option<f64>>,
        radius: f64,
        terrain: &dyn Terrain,
    ) -> Self {
        let mut places = Vec::new();
        for (pair, amount) in path.points.windows(2).zip(amounts.skip(1)) {
            let (Some(from), Some(to), Some(amount)) = (pair[0].flat, pair[1].flat, amount) else {
                continue;
            };
            let Some(scale) = terrain.scale(to).or_else(|| terrain.scale(from)) else { continue };
            let reach = radius / scale;
            let steps = (from.distance(to) / (SPACING * reach)).ceil().clamp(1.0, 1e4) as u32;
            let at = |i: u32| from.lerp(to, f64::from(i) / f64::from(steps));
            places.extend((0..=steps).map(|i| Above { at: at(i), reach, amount }));
        }
        let cell = places.iter().map(|p| p.reach).max_by(f64::total_cmp).unwrap_or(1.0);
        let mut cells: BTreeMap<[i64; 2], Vec<Above>> = BTreeMap::new();
        for place in places {
            cells.entry(cell_of(place.at, cell)).or_default().push(place);
        }
        Self { cell, cells }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// How much the nearest one cuts that reaches a flat place.
    pub fn nearest(&self, at: DVec2) -> Option<f64> {
        self.reaching(at).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, p)| p.amount)
    }

    /// The most that one cuts that reaches a flat place.
    pub fn most(&self, at: DVec2) -> Option<f64> {
        self.reaching(at).map(|(_, p)| p.amount).max_by(f64::total_cmp)
    }

    /// The places that reach a flat one, with their distances from it.
    fn reaching(&self, at: DVec2) -> impl Iterator<Item = (f64, &Above)> {
        let [x, y] = cell_of(at, self.cell);
        let around = (-1..=1).flat_map(move |i| (-1..=1).map(move |j| [x + i, y + j]));
        let places = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        places.map(move |p| (p.at.distance(at), p)).filter(|(distance, p)| *distance <= p.reach)
    }
}

fn cell_of(at: DVec2, side: f64) -> [i64; 2] {
    [at.x, at.y].map(|c| (c / side).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec3;

    struct Plane;

    impl Terrain for Plane {
        fn scale(&self, _: DVec2) -> Option<f64> {
            Some(2.0)
        }
        fn room(&self, _: DVec2) -> Option<f64> {
            Some(1.0)
        }
        fn joins(&self, _: DVec2, _: DVec2) -> bool {
            true
        }
    }

    #[test]
    fn only_places_beside_moves_above_the_limit_are_near() {
        let point = |x: f64, mrr: f64, kind: MoveKind| PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: DVec3::ZERO,
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: Some(DVec2::new(x, 0.0)),
            feed: 1.0,
            mrr,
            alpha: 0.0,
            time: 0.0,
        };
        let (cut, link) = (MoveKind::Cut, MoveKind::Link);
        let moves = [(0.0, 0.0, cut), (20.0, 1.0, cut), (60.0, 1.1, cut), (99.0, 9.0, link)];
        let points = moves.map(|(x, mrr, kind)| point(x, mrr, kind)).to_vec();
        // A radius of 6 mm is 3 flat mm.
        let excess = Excess::above(&Toolpath { points }, 1.0, 6.0, &Plane);
        for (x, y, is_near) in [
            (10.0, 0.0, false),
            (16.9, 0.0, false),
            (17.1, 0.0, true),
            (40.0, 2.5, true),
            (40.0, 3.1, false),
            (62.9, 0.0, true),
            (63.1, 0.0, false),
        ] {
            assert_eq!(excess.nearest(DVec2::new(x, y)), is_near.then_some(1.1), "({x}, {y})");
        }
        let none = Excess::above(&Toolpath::default(), 1.0, 6.0, &Plane);
        assert!(none.is_empty() && none.nearest(DVec2::ZERO).is_none() && !excess.is_empty());
    }
}
