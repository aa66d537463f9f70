//! The free space beside a ring: the largest circle that touches the ring at a place and nothing else.
//!
//! The centres of these circles are the medial line of the space, their radii the radii of the loops that fill it.
//!
//! Source: Ma, Bae, Choi, "3D medial axis point approximation using nearest neighbors and the normal field", The
//! Visual Computer 2012: a ball that touches a place shrinks until nothing lies in it.

use crate::geometry::DVec2;
use std::collections::BTreeMap;

/// A circle may reach beyond a line by this fraction of its radius. Larger: loops overlap their neighbours; smaller:
/// the direction of a polyline at its vertices is not known well enough.
const TOUCHING: f64 = 0.015;
/// Steps in which a circle shrinks; it converges within some five.
const STEPS: usize = 24;

/// Segments, found by place.
#[derive(Clone, Debug)]
struct Lines {
    /// Side of a cell, flat mm.
    cell: f64,
    cells: BTreeMap<[i64; 2], Vec<[DVec2; 2]>>,
}

impl Lines {
    fn new(segments: impl Iterator<Item = [DVec2; 2]>, cell: f64) -> Self {
        let mut cells: BTreeMap<[i64; 2], Vec<[DVec2; 2]>> = BTreeMap::new();
        for [a, b] in segments {
            // Pieces no longer than a cell: none lies in many cells that it does not cross.
            let pieces = ((b - a).length() / cell).ceil().clamp(1.0, 1e6) as usize;
            let at = |i: usize| a.lerp(b, i as f64 / pieces as f64);
            for piece in (0..pieces).map(|i| [at(i), at(i + 1)]) {
                let (low, high) = (piece[0].min(piece[1]), piece[0].max(piece[1]));
                for key in keys(low, high, cell) {
                    cells.entry(key).or_default().push(piece);
                }
            }
        }
        Self { cell, cells }
    }

    /// The nearest point of all segments that is less than `within` away.
    fn nearest(&self, at: DVec2, within: f64) -> Option<DVec2> {
        let (mut best, mut found) = (within * within, None);
        let reach = DVec2::splat(within);
        for key in keys(at - reach, at + reach, self.cell) {
            for [a, b] in self.cells.get(&key).into_iter().flatten() {
                let (side, offset) = (*b - *a, at - *a);
                let square = side.length_squared();
                let part =
                    if square > 0.0 { (offset.dot(side) / square).clamp(0.0, 1.0) } else { 0.0 };
                let foot = *a + side * part;
                let distance = (at - foot).length_squared();
                if distance < best {
                    (best, found) = (distance, Some(foot));
                }
            }
        }
        found
    }

    /// Radius of the largest circle, up to `largest`, that touches `touch`, has its centre toward the unit vector
    /// `side`, and reaches beyond no line.
    fn inscribed(&self, touch: DVec2, side: DVec2, largest: f64) -> f64 {
        let mut radius = largest;
        for _ in 0..STEPS {
            let center = touch + side * radius;
            let Some(inside) = self.nearest(center, radius * (1.0 - TOUCHING)) else { break };
            let way = inside - touch;
            let ahead = way.dot(side);
            // The circle through that point; half the radius where rounding hides it.
            let through = way.length_squared() / (2.0 * ahead);
            radius = if ahead > 0.0 && through < radius { through } else { 0.5 * radius };
        }
        radius
    }
}

/// The cells that a box meets.
fn keys(low: DVec2, high: DVec2, cell: f64) -> impl Iterator<Item = [i64; 2]> {
    let [x0, y0, x1, y1] = [low.x, low.y, high.x, high.y].map(|c| (c / cell).floor() as i64);
    (x0..=x1).flat_map(move |x| (y0..=y1).map(move |y| [x, y]))
}

/// What stands beside a ring.
#[derive(Clone, Debug)]
pub struct Corridor {
    /// The ring itself and others beyond which nothing may be cut.
    bounds: Lines,
    /// Rings that are cut later, or were cut before: loops need not reach beyond them.
    beside: Lines,
}

impl Corridor {
    /// `bounds`, `beside`: segments in flat mm; `size`: of the circles that are asked for, flat mm.
    pub fn new(
        bounds: impl Iterator<Item = [DVec2; 2]>,
        beside: impl Iterator<Item = [DVec2; 2]>,
        size: f64,
    ) -> Self {
        Self { bounds: Lines::new(bounds, size), beside: Lines::new(beside, size) }
    }

    /// Radius of the largest circle, up to `largest`, that touches `touch` from the side of the unit vector `side` and
    /// lies between the ring and what is beside it; up to `least` it may reach beyond that.
    pub fn inscribed(&self, touch: DVec2, side: DVec2, least: f64, largest: f64) -> f64 {
        let within = self.bounds.inscribed(touch, side, largest);
        self.beside.inscribed(touch, side, within).max(least.min(within))
    }
}
