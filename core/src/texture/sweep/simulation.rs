//! All that a simulation looks at while it goes over a tile.

use super::options::Search;
use super::stint::{ROUNDING, Stint};
use crate::geometry::DVec3;
use crate::texture::edge::Teeth;
use crate::texture::grid::Grid;
use crate::texture::kinematics::Spindle;
use std::ops::Range;

/// Moves that are looked at together first.
const GROUP: usize = 64;

/// A simulation over a grid.
pub(super) struct Sweep<'a> {
    pub grid: &'a Grid,
    pub teeth: &'a Teeth,
    pub spindle: Spindle,
    pub start: f64,
    /// How far below the surface heights are looked for, mm.
    pub floor: f64,
    pub search: Search,
    /// Radius of the cutter, if it is a ball.
    pub ball: Option<f64>,
    pub stints: Vec<Stint<'a>>,
    pub groups: Vec<Group>,
}

/// Stints that follow each other, in a ball.
pub(super) struct Group {
    pub stints: Range<usize>,
    pub ball: (DVec3, f64),
}

impl Group {
    pub fn all(stints: &[Stint]) -> Vec<Self> {
        let of = |(k, group): (usize, &[Stint])| {
            let middle = group[group.len() / 2].ball.0;
            let radius = group.iter().map(|s| s.ball.0.distance(middle) + s.ball.1);
            let ball = (middle, radius.fold(0.0, f64::max) * (1.0 + ROUNDING));
            Self { stints: k * GROUP..k * GROUP + group.len(), ball }
        };
        stints.chunks(GROUP).enumerate().map(of).collect()
    }
}
