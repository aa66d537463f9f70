//! The map of a channel: two parameters in [0, 1], `s` from its one end to the other and `t` from side to side, → the
//! parameters of the hub.
//!
//! Steps: (1) both sides at equal parts of their lengths; (2) Coons' transfinite map in (u, v), whose ends are straight
//! cuts; (3) where its Jacobian is not positive everywhere, nodes are moved until `s` and `t` are harmonic over the
//! channel: such a map onto a convex square does not fold.
//!
//! Source: S-HUB, step 4. Coons, "Surfaces for computer-aided design of space forms", MIT MAC-TR-41 (1967). Harmonic
//! grids: Winslow, J. Comput. Phys. 1 (1966) 149, `g22 x_ss - 2 g12 x_st + g11 x_tt = 0`; that they do not fold:
//! Rado, Kneser and Choquet.

use super::error::HubError;
use super::wheel::Wheel;
use crate::geometry::{DVec2, DVec3};
use crate::nurbs::TrimLoop;

/// Nodes along a channel and across it.
pub const ROWS: usize = 129;
pub const COLUMNS: usize = 25;
/// Sweeps over the nodes until a map counts as harmonic, at most.
const SWEEPS: usize = 4000;
/// Difference of parameters that is none.
const SAME: f64 = 1e-9;
/// Largest move of a node, as a part of the channel, below which it rests.
const STILL: f64 = 1e-7;

/// A channel between two sides.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Parameters of the nodes by row, from side to side.
    nodes: Vec<DVec2>,
    /// Rows at which a side has a corner, and whether that is the right side.
    corners: Vec<(usize, bool)>,
    /// Least Jacobian of the map over its mean.
    pub least_jacobian: f64,
    /// Whether the nodes were moved to make the map harmonic.
    pub is_harmonic: bool,
}

impl Channel {
    /// The channel between two sides of `ROWS` places each, `left` where the parameter around is smaller. `corners`:
    /// rows at which one of them has a corner, and whether that is the right one.
    ///
    /// # Errors
    /// [`HubError::Folded`] where no map is found.
    pub fn new(
        wheel: &Wheel,
        left: &[DVec2],
        right: &[DVec2],
        corners: &[(usize, bool)],
    ) -> Result<Self, HubError> {
        let at = |r: usize, c: usize| {
            // Ruled between the sides, plus ruled between the cuts, less bilinear: between straight cuts the last two are
            // the same.
            left[r].lerp(right[r], part(c, COLUMNS))
        };
        let nodes = (0..ROWS).flat_map(|r| (0..COLUMNS).map(move |c| (r, c)));
        let nodes: Vec<DVec2> = nodes.map(|(r, c)| at(r, c)).collect();
        let corners = corners.to_vec();
        let mut channel = Self { nodes, corners, least_jacobian: 0.0, is_harmonic: false };
        let orientation = if wheel.around == 0 { -1.0 } else { 1.0 };
        channel.least_jacobian = channel.jacobian(orientation);
        if channel.least_jacobian <= 0.0 || !channel.corners.is_empty() {
            channel.make_harmonic(wheel);
            channel.least_jacobian = channel.jacobian(orientation);
        }
        if channel.least_jacobian <= 0.0 {
            let at = wheel.hub.point(channel.node(ROWS / 2, COLUMNS / 2));
            return Err(HubError::Folded { at });
        }
        Ok(channel)
    }

    fn node(&self, row: usize, column: usize) -> DVec2 {
        self.nodes[row * COLUMNS + column]
    }

    /// Least area of a cell's corner over the mean.
    fn jacobian(&self, orientation: f64) -> f64 {
        let mut least = f64::INFINITY;
        let (mut sum, mut count) = (0.0, 0.0);
        for r in 0..ROWS - 1 {
            for c in 0..COLUMNS - 1 {
                let [a, b, d, e] =
                    [(r, c), (r + 1, c), (r, c + 1), (r + 1, c + 1)].map(|(r, c)| self.node(r, c));
                for (p, q) in [(b - a, d - a), (e - b, d - b), (b - a, e - a), (e - d, e - b)] {
                    let area = orientation * p.perp_dot(q);
                    least = least.min(area);
                    sum += area;
                    count += 1.0;
                }
            }
        }
        if sum > 0.0 { least * count / sum } else { -1.0 }
    }

    /// Moves the inner nodes until `s` and `t` are harmonic.
    fn make_harmonic(&mut self, wheel: &Wheel) {
        self.is_harmonic = true;
        // In the plane of the parameters, both measured in mm at the middle.
        let [around, along] = wheel.ways(self.node(ROWS / 2, COLUMNS / 2)).map(|way| way.length());
        let scale = match wheel.around {
            0 => DVec2::new(around, along),
            _ => DVec2::new(along, around),
        };
        let size = (self.node(ROWS - 1, 0) - self.node(0, 0)) * scale;
        let still = STILL * size.length();
        let mut nodes: Vec<DVec2> = self.nodes.iter().map(|p| *p * scale).collect();
        for _ in 0..SWEEPS {
            let mut moved = 0.0f64;
            for r in 1..ROWS - 1 {
                for c in 1..COLUMNS - 1 {
                    let n = |dr: usize, dc: usize| nodes[(r + dr - 1) * COLUMNS + c + dc - 1];
                    let (xs, xt) = (0.5 * (n(2, 1) - n(0, 1)), 0.5 * (n(1, 2) - n(1, 0)));
                    let mixed = 0.25 * (n(2, 2) - n(2, 0) - n(0, 2) + n(0, 0));
                    let (g11, g12, g22) = (xs.dot(xs), xs.dot(xt), xt.dot(xt));
                    let wanted = (g22 * (n(2, 1) + n(0, 1)) + g11 * (n(1, 2) + n(1, 0))
                        - 2.0 * g12 * mixed)
                        / (2.0 * (g11 + g22)).max(f64::MIN_POSITIVE);
                    let node = &mut nodes[r * COLUMNS + c];
                    moved = moved.max(wanted.distance(*node));
                    *node = wanted;
                }
            }
            if moved < still {
                break;
            }
        }
        self.nodes = nodes.into_iter().map(|p| p / scale).collect();
    }

    /// The parameters of the hub at (s, t).
    pub fn at(&self, s: f64, t: f64) -> DVec2 {
        let (r, f) = cell(s, ROWS);
        let (c, g) = cell(t, COLUMNS);
        let row = |r: usize| {
            let column = |c: usize| self.node(r, c);
            hermite(column, c, g, COLUMNS, |_| false)
        };
        let is_on = |right: bool| if right { t >= 1.0 } else { t <= 0.0 };
        let is_corner = |k: usize| self.corners.iter().any(|&(at, right)| at == k && is_on(right));
        hermite(row, r, f, ROWS, is_corner)
    }

    /// Position on the hub at (s, t), mm.
    pub fn place(&self, wheel: &Wheel, s: f64, t: f64) -> DVec3 {
        wheel.hub.point(self.at(s, t))
    }

    /// (s, t) of a place of the hub within the channel or near it, from the nearest of its nodes.
    pub fn inverse(&self, at: DVec2) -> (f64, f64) {
        let nearest = (0..self.nodes.len()).min_by(|&a, &b| {
            self.nodes[a].distance_squared(at).total_cmp(&self.nodes[b].distance_squared(at))
        });
        let nearest = nearest.unwrap_or(0);
        let (mut s, mut t) = (part(nearest / COLUMNS, ROWS), part(nearest % COLUMNS, COLUMNS));
        const STEP: f64 = 1e-5;
        for _ in 0..24 {
            let here = self.at(s, t);
            let by = |value: f64| if value + STEP <= 1.0 { STEP } else { -STEP };
            let (ds, dt) = (by(s), by(t));
            let along = (self.at(s + ds, t) - here) / ds;
            let across = (self.at(s, t + dt) - here) / dt;
            let determinant = along.perp_dot(across);
            if determinant == 0.0 {
                break;
            }
            let missing = at - here;
            let next = (
                (s + missing.perp_dot(across) / determinant).clamp(0.0, 1.0),
                (t + along.perp_dot(missing) / determinant).clamp(0.0, 1.0),
            );
            let moved = (next.0 - s).abs() + (next.1 - t).abs();
            (s, t) = next;
            if moved < 1e-12 {
                break;
            }
        }
        (s, t)
    }

    /// Its outline, as a loop for a mesh.
    pub fn outline(&self) -> TrimLoop {
        let reversed = |points: Vec<DVec2>| points.into_iter().rev().collect::<Vec<DVec2>>();
        let outline = [
            self.side(false),
            self.across(ROWS - 1),
            reversed(self.side(true)),
            reversed(self.across(0)),
        ];
        closed_line(outline.concat(), true)
    }

    /// Rows at which one of its sides has a corner.
    pub fn corners_of(&self, right: bool) -> impl Iterator<Item = usize> {
        self.corners.iter().filter(move |(_, side)| *side == right).map(|(row, _)| *row)
    }

    /// The nodes of one side.
    pub fn side(&self, right: bool) -> Vec<DVec2> {
        (0..ROWS).map(|r| self.node(r, if right { COLUMNS - 1 } else { 0 })).collect()
    }

    /// The nodes of a row.
    pub fn across(&self, row: usize) -> Vec<DVec2> {
        self.nodes[row * COLUMNS..(row + 1) * COLUMNS].to_vec()
    }
}

/// A loop through points, of which neighbours may be the same.
pub fn closed_line(mut points: Vec<DVec2>, counter_clockwise: bool) -> TrimLoop {
    points.dedup_by(|a, b| a.distance(*b) < SAME);
    while points.len() > 1 && points[0].distance(points[points.len() - 1]) < SAME {
        points.pop();
    }
    let n = points.len();
    let area: f64 = (0..n).map(|i| points[i].perp_dot(points[(i + 1) % n])).sum();
    if (area > 0.0) != counter_clockwise {
        points.reverse();
    }
    TrimLoop { points, corners: vec![0], winding: [0, 0] }
}

/// Position of a node between 0 and 1.
pub fn part(index: usize, count: usize) -> f64 {
    index as f64 / (count - 1) as f64
}

/// The cell that holds a value between 0 and 1, and where in it.
pub fn cell(value: f64, count: usize) -> (usize, f64) {
    let scaled = value.clamp(0.0, 1.0) * (count - 1) as f64;
    let index = (scaled as usize).min(count - 2);
    (index, scaled - index as f64)
}

/// Cubic interpolation between values `i` and `i + 1`, with a continuous slope but at corners.
///
/// # Source
/// Catmull and Rom, "A class of local interpolating splines" (1974).
pub fn hermite<T>(
    value: impl Fn(usize) -> T,
    i: usize,
    f: f64,
    count: usize,
    is_corner: impl Fn(usize) -> bool,
) -> T
where
    T: Copy
        + core::ops::Add<Output = T>
        + core::ops::Sub<Output = T>
        + core::ops::Mul<f64, Output = T>,
{
    let (a, b) = (value(i), value(i + 1));
    let straight = b - a;
    let slope = |k: usize| match k {
        0 => straight,
        k if k + 1 == count || is_corner(k) => straight,
        k => (value(k + 1) - value(k - 1)) * 0.5,
    };
    let (m, n) = (slope(i), slope(i + 1));
    let (f2, f3) = (f * f, f * f * f);
    a * (2.0 * f3 - 3.0 * f2 + 1.0)
        + b * (3.0 * f2 - 2.0 * f3)
        + m * (f3 - 2.0 * f2 + f)
        + n * (f3 - f2)
}

#[cfg(test)]
mod tests;
