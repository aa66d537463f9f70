//! The outline of the flat surface: one outer loop and its islands.

use crate::flatten::Chart;
use crate::geometry::{DVec2, OrderBy, cross2};
use crate::surface::Surface;

/// Closed flat polygons with the region on their left: the outer loop first, then the islands.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    loops: Vec<Vec<DVec2>>,
}

impl Outline {
    /// The whole of a chart.
    pub fn of_chart(surface: &Surface, chart: &Chart) -> Self {
        let uv = chart.uv();
        let loops = surface
            .connectivity()
            .boundary_loops()
            .iter()
            .map(|cycle| cycle.iter().map(|v| uv[v.index()]).collect())
            .collect();
        Self::from_loops(loops)
    }

    /// A region from loops that have it on their left, in any order.
    pub fn from_loops(mut loops: Vec<Vec<DVec2>>) -> Self {
        loops.order_by(|a, b| signed_area(b).total_cmp(&signed_area(a)));
        Self { loops }
    }

    /// The loops: the outer one first.
    pub fn loops(&self) -> &[Vec<DVec2>] {
        &self.loops
    }

    /// Flat area, flat mm².
    pub fn area(&self) -> f64 {
        self.loops.iter().map(|l| signed_area(l)).sum()
    }

    /// Sides of all loops, in order.
    pub fn sides(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        self.loops.iter().flat_map(|l| (0..l.len()).map(move |i| [l[i], l[(i + 1) % l.len()]]))
    }

    /// Lower and upper corner of the bounding box.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        let all = self.loops.iter().flatten();
        all.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)))
    }
}

/// Signed area of a closed polygon, positive when counter-clockwise.
pub fn signed_area(polygon: &[DVec2]) -> f64 {
    let Some(&origin) = polygon.first() else { return 0.0 };
    polygon.windows(2).map(|w| 0.5 * cross2(origin, w[0], w[1])).sum()
}
