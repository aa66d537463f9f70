//! How finely a window and the time are cut up.
//!
//! Terms of the source: `d_max` is the largest cell of the grid, `l_min` the smallest; `dt` is the time in which no edge
//! point sweeps more than `l_min`, `d_c` the way of the cutter in it, `d_lambda` the angle of an edge element of length
//! `l_min`. The source takes `l_min` from the grid alone; here it is bounded by the marks of the teeth and by the cutter,
//! too, so that the height of a node does not depend on how far away the next one stands.

use std::f64::consts::TAU;

/// Cells in the smaller of feed per tooth and side step.
const CELLS: f64 = 10.0;

/// Largest cell where the job says nothing: `min(f_z, a_e) / 10`, mm.
pub fn largest_cell(feed_per_tooth: f64, side_step: f64) -> f64 {
    feed_per_tooth.min(side_step) / CELLS
}

/// Steps in the radius of a cutter, at least, so that a chord `l² / (8 r)` is the error of one.
const STEPS_PER_RADIUS: f64 = 20.0;
/// Rounding of lengths, as a part of them.
const ROUNDING: f64 = 1e-6;

/// The length `l_min` that time steps and edge elements keep, mm: the shortest cell, but at most `min(f_z, a_e) / 10`,
/// whose chord is a hundredth of the lower cusp, and a twentieth of the cutter's radius `r`.
///
/// All in mm: a chord `l² / (8 r)` over a cusp `f_z² / (8 r)` or `a_e² / (8 r)` is `(l / f_z)²` or `(l / a_e)²`.
pub fn resolution(shortest_cell: f64, f_z: f64, a_e: f64, r: f64) -> f64 {
    let longest = largest_cell(f_z, a_e).min(r / STEPS_PER_RADIUS);
    // A cell of just that length, which rounding made longer, is taken as it is.
    if shortest_cell <= longest * (1.0 + ROUNDING) { shortest_cell } else { longest }
}

/// Feed per tooth `f_z`, mm: feed in mm/s, speed in rev/s.
pub fn feed_per_tooth(feed: f64, speed: f64, flutes: u32) -> f64 {
    feed / (speed * f64::from(flutes))
}

/// `dt = l_min / (2 pi n r_eff + v_f)`, s: cell in mm, speed in rev/s, reach in mm, feed in mm/s.
pub fn time_step(l_min: f64, speed: f64, r_eff: f64, feed: f64) -> f64 {
    l_min / (TAU * speed * r_eff + feed)
}

/// `d_c = v_f dt`, mm.
///
/// Within a move the feed is even, so that even steps of time are even steps of arc length.
pub fn path_step(feed: f64, time_step: f64) -> f64 {
    feed * time_step
}

/// `d_lambda = l_min / r`, rad, on an arc of radius `r` mm.
pub fn edge_step(l_min: f64, r: f64) -> f64 {
    l_min / r
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_formulas() {
        // r 5, 2 teeth, 6000 rev/min, f_z 0.1: v_f 20 mm/s.
        assert!((feed_per_tooth(20.0, 100.0, 2) - 0.1).abs() < 1e-15);
        assert!((largest_cell(0.1, 0.5) - 0.01).abs() < 1e-15);
        let dt = time_step(0.01, 100.0, 1.4, 20.0);
        assert!((dt - 0.01 / (879.645_943_005_142 + 20.0)).abs() < 1e-18, "{dt}");
        assert_eq!(path_step(20.0, dt), 20.0 * dt);
        // In that time the outermost point goes just l_min.
        assert!((TAU * 100.0 * 1.4 * dt + path_step(20.0, dt) - 0.01).abs() < 1e-15);
        assert_eq!(edge_step(0.01, 5.0), 0.002);
    }

    #[test]
    fn steps_are_no_longer_than_the_marks_of_the_teeth_allow() {
        assert_eq!(resolution(0.004, 0.1, 0.5, 5.0), 0.004);
        let rounded = 0.01 * (1.0 + 1e-12);
        assert_eq!(resolution(rounded, 0.1, 0.5, 5.0), rounded);
        for coarse in [0.1, 0.5, 9.0] {
            assert_eq!(resolution(coarse, 0.1, 0.5, 5.0), largest_cell(0.1, 0.5));
        }
        // A feed per tooth as long as the cutter is wide.
        assert_eq!(resolution(1.0, 9.0, 9.0, 5.0), 0.25);
    }
}
