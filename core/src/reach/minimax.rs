//! The lowest place of the largest of several functions of the plane.
//!
//! Sequential linear programming: the functions are replaced by their tangent planes, the lowest place of the largest
//! plane within a square around the best place is found exactly, and the square shrinks where the functions do not
//! follow.
//!
//! Source: Madsen, "An algorithm for minimax solution of overdetermined systems of non-linear equations", J. Inst.
//! Maths Applics 16 (1975).

use crate::geometry::{DVec2, OrderBy};

/// Most steps.
const STEPS: u32 = 32;
/// Greatest number of planes that are compared, the highest ones.
const PLANES: usize = 8;
/// Step of difference quotients, times the first half width.
const QUOTIENT: f64 = 1e-6;
/// Decrease, times the predicted one, below which the square shrinks, and above which it grows.
const FOLLOWS: [f64; 2] = [0.25, 0.75];

/// Functions lower than the largest by more than this many half widths are not looked at.
const STEEP: f64 = 3.0;

/// Width of the last square, times the first.
const NARROW: f64 = 3e-4;

/// Turns of a step that leads over a jump: none, 23, 45, 68, 85 and 90 degrees to both sides.
const ASIDE: [DVec2; 11] = [
    DVec2::new(1.0, 0.0),
    DVec2::new(0.92, 0.39),
    DVec2::new(0.92, -0.39),
    DVec2::new(0.71, 0.71),
    DVec2::new(0.71, -0.71),
    DVec2::new(0.38, 0.92),
    DVec2::new(0.38, -0.92),
    DVec2::new(0.09, 0.99),
    DVec2::new(0.09, -0.99),
    DVec2::new(0.0, 1.0),
    DVec2::new(0.0, -1.0),
];

/// A function's value and gradient.
type Plane = (f64, DVec2);

/// The lowest place found, and the value there. `of`: the function with that number, of `count`, at a place, or
/// anything not above the last argument where it is not above that; `start`: where the search begins; `width`: half the
/// side of the first square; `enough`: a predicted decrease that is not worth a step.
pub(super) fn lowest(
    of: impl Fn(usize, DVec2, f64) -> f64,
    count: usize,
    start: DVec2,
    width: f64,
    enough: f64,
) -> (f64, DVec2) {
    // The last ones are the most likely to be the largest.
    let largest = |at: DVec2| {
        (0..count).rev().fold(f64::NEG_INFINITY, |floor, i| floor.max(of(i, at, floor)))
    };
    let mut best = (largest(start), start);
    let (quotient, mut half) = (QUOTIENT * width, width);
    for _ in 0..STEPS {
        let floor = best.0 - STEEP * half;
        let values = (0..count).map(|i| (of(i, best.1, floor), i));
        let is_near = |(value, _): &(f64, usize)| value.is_finite() && *value > floor;
        let mut values: Vec<(f64, usize)> = values.filter(is_near).collect();
        values.order_by(|a, b| b.0.total_cmp(&a.0));
        values.truncate(PLANES);
        let planes: Vec<Plane> = values
            .into_iter()
            .map(|(value, i)| {
                let at = |way: DVec2| of(i, best.1 + way * quotient, f64::NEG_INFINITY);
                let slope = |way: DVec2| (at(way) - value) / quotient;
                (value, DVec2::new(slope(DVec2::X), slope(DVec2::Y)))
            })
            .filter(|(_, gradient)| gradient.is_finite())
            .collect();
        let (predicted, step) = lowest_of_planes(&planes, half);
        let is_worth = best.0 - predicted > enough;
        if !is_worth {
            break;
        }
        let value = largest(best.1 + step);
        let follows = (best.0 - value) / (best.0 - predicted);
        if follows >= FOLLOWS[0] {
            best = (value, best.1 + step);
            if follows > FOLLOWS[1] {
                half = (2.0 * half).min(width);
            }
            continue;
        }
        // Functions may jump: along the jump it may still go down.
        let from = best;
        for way in ASIDE.iter().skip(1).map(|turn| turn.rotate(step)) {
            let value = largest(from.1 + way);
            if value < best.0 {
                best = (value, from.1 + way);
            }
        }
        if from.0 - best.0 < FOLLOWS[0] * (from.0 - predicted) {
            half *= 0.3;
            if half < NARROW * width {
                break;
            }
        }
    }
    best
}

/// The lowest value of the largest of some planes within a square around the origin, and where it is: at a corner of
/// the lines in which two planes meet and the sides of the square.
fn lowest_of_planes(planes: &[Plane], half: f64) -> Plane {
    let largest = |at: DVec2| {
        planes.iter().map(|(value, slope)| value + slope.dot(at)).fold(f64::NEG_INFINITY, f64::max)
    };
    // Lines n.x = d.
    let mut lines: Vec<(DVec2, f64)> =
        [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|n| (n, half)).to_vec();
    for (i, a) in planes.iter().enumerate() {
        lines.extend(planes[i + 1..].iter().map(|b| (a.1 - b.1, b.0 - a.0)));
    }
    let mut best = (largest(DVec2::ZERO), DVec2::ZERO);
    for (i, (n, d)) in lines.iter().enumerate() {
        for (m, e) in &lines[i + 1..] {
            let across = n.perp_dot(*m);
            let at = DVec2::new(d * m.y - e * n.y, e * n.x - d * m.x) / across;
            if at.abs().max_element() <= half * (1.0 + 1e-12) {
                let value = largest(at);
                if value < best.0 {
                    best = (value, at);
                }
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_of_three_bowls_is_found() {
        // Bowls of curvature 1 around corners of a triangle: the middle of its circumscribed circle.
        let middles = [DVec2::new(0.0, 0.0), DVec2::new(2.0, 0.3), DVec2::new(0.4, 1.7)];
        let bowl = |i: usize, at: DVec2, _| at.distance_squared(middles[i]);
        let (value, at) = lowest(bowl, 3, DVec2::new(1.9, 1.9), 1.0, 1e-12);
        let distances = middles.map(|m| m.distance(at));
        assert!(distances.iter().all(|d| (d - distances[0]).abs() < 1e-6), "{distances:?}");
        assert!((value - distances[0] * distances[0]).abs() < 1e-6);
    }

    #[test]
    fn a_narrow_valley_is_followed_to_its_end() {
        // A valley along a slanting line, whose floor is lowest 0.6 along it.
        let along = DVec2::new(0.8, 0.6);
        let of = |i: usize, at: DVec2, _| {
            let (x, y) = (at.dot(along), at.perp_dot(along));
            let floor = 0.1 * (x - 0.6) * (x - 0.6);
            if i == 0 { floor + 9.0 * y } else { floor - 9.0 * y }
        };
        let (value, at) = lowest(of, 2, DVec2::new(-0.7, 0.4), 1.0, 1e-12);
        assert!(value < 1e-6 && at.distance(along * 0.6) < 1e-2, "{value} {at}");
    }
}
