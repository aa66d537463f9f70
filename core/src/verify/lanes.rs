//! Several points processed at once: the same sums as for one, in loops without branches that a compiler turns into
//! vector instructions.
//!
//! A set of lanes is a `u32` with one bit per lane.

use super::body::{Body, Placed};
use super::motion::Step;
use crate::geometry::DVec3;

/// Vectors, one per lane.
#[derive(Copy, Clone, Debug)]
pub struct Vectors<const N: usize> {
    x: [f64; N],
    y: [f64; N],
    z: [f64; N],
}

/// Points as seen from the cutter; see [`super::body::Nearest`].
pub struct NearestOf<const N: usize> {
    /// Distance from the cutter, mm; zero or negative inside.
    pub distance: [f64; N],
    /// Unit direction to the point; NaN where the distance is not positive.
    pub outward: Vectors<N>,
}

/// The greater of two numbers; the second if the first is NaN.
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The lesser of two numbers; the second if either is NaN.
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The lanes for which a condition holds.
pub fn lanes<const N: usize>(holds: impl Fn(usize) -> bool) -> u32 {
    (0..N).fold(0, |set, i| set | u32::from(holds(i)) << i)
}

/// The lanes of a set, lowest first.
pub fn each(mut set: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = set.trailing_zeros();
        let found = set != 0;
        set &= set.wrapping_sub(1);
        found.then_some(lane as usize)
    })
}

impl<const N: usize> Vectors<N> {
    /// Zero everywhere.
    pub const ZERO: Self = Self { x: [0.0; N], y: [0.0; N], z: [0.0; N] };

    /// Puts a vector into a lane.
    pub fn set(&mut self, lane: usize, v: DVec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }

    /// The vector in a lane.
    pub fn get(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Inner products lane by lane.
    pub fn dot(&self, other: &Self) -> [f64; N] {
        core::array::from_fn(|i| {
            self.x[i] * other.x[i] + self.y[i] * other.y[i] + self.z[i] * other.z[i]
        })
    }

    /// Inner products with one vector.
    pub fn along(&self, v: DVec3) -> [f64; N] {
        core::array::from_fn(|i| self.x[i] * v.x + self.y[i] * v.y + self.z[i] * v.z)
    }

    /// Distances from a point.
    pub fn distances(&self, from: DVec3) -> [f64; N] {
        core::array::from_fn(|i| {
            let (x, y, z) = (self.x[i] - from.x, self.y[i] - from.y, self.z[i] - from.z);
            (x * x + y * y + z * z).sqrt()
        })
    }

    /// Squared distances from the cutter's axis.
    pub fn rho_squared(&self, at: &Placed) -> [f64; N] {
        let (tip, axis) = (at.tip, at.axis);
        core::array::from_fn(|i| {
            let w = [self.x[i] - tip.x, self.y[i] - tip.y, self.z[i] - tip.z];
            let height = w[0] * axis.x + w[1] * axis.y + w[2] * axis.z;
            let across = [w[0] - axis.x * height, w[1] - axis.y * height, w[2] - axis.z * height];
            across[0] * across[0] + across[1] * across[1] + across[2] * across[2]
        })
    }
}

impl Body {
    /// Distances and directions of points from the cutter, as [`Body::nearest`] gives them.
    pub fn nearest_of<const N: usize>(&self, at: &Placed, points: &Vectors<N>) -> NearestOf<N> {
        let (tip, axis) = (at.tip, at.axis);
        let (bottom, corner, top) = (self.bottom(), self.corner(), self.length() - self.corner());
        let mut near = NearestOf { distance: [0.0; N], outward: Vectors::ZERO };
        for i in 0..N {
            let w = [points.x[i] - tip.x, points.y[i] - tip.y, points.z[i] - tip.z];
            let height = w[0] * axis.x + w[1] * axis.y + w[2] * axis.z;
            let a = [w[0] - axis.x * height, w[1] - axis.y * height, w[2] - axis.z * height];
            let rho = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
            let out = greater(rho - bottom, 0.0);
            let beyond = greater(height - top, 0.0) - greater(corner - height, 0.0);
            let from_core = (out * out + beyond * beyond).sqrt();
            let spread = if rho > 0.0 { out / rho } else { 0.0 };
            near.distance[i] = from_core - corner;
            let inverse = 1.0 / from_core;
            near.outward.x[i] = (a[0] * spread + axis.x * beyond) * inverse;
            near.outward.y[i] = (a[1] * spread + axis.y * beyond) * inverse;
            near.outward.z[i] = (a[2] * spread + axis.z * beyond) * inverse;
        }
        near
    }
}

/// Lines seen from the cutter in place.
struct Seen<const N: usize> {
    /// Distance of each line's top, mm.
    distance: [f64; N],
    /// Positive where the line's material points away from the cutter.
    down: [f64; N],
    /// How fast the cutter approaches, mm per step; NaN inside the cutter.
    closing: [f64; N],
}

impl Step {
    /// The lines whose material a step may reach: all but those that certainly stay unchanged.
    ///
    /// `tops`: highest material on each line; `normals`: the lines' directions; `of`: the lines to test. Apart from
    /// the effect of turning, the distance of the cutter from a line's material is convex along the step, and it is
    /// not negative at its start, where the previous step ended. So it stays positive if it still decreases at the
    /// end without having reached zero, or already increases at the start.
    pub fn reaches<const N: usize>(
        &self,
        body: &Body,
        tops: &Vectors<N>,
        normals: &Vectors<N>,
        of: u32,
    ) -> u32 {
        let of = of & !self.above(tops, normals);
        if of == 0 {
            return 0;
        }
        let end = self.seen(&self.to, body, tops, normals);
        let bent = self.bent(tops);
        // The last is what may be no number.
        let least = |i: usize| lesser(end.distance[i] - bent[i], end.down[i]);
        let away = of & !lanes::<N>(|i| lesser(least(i), end.closing[i]) >= 0.0);
        let open = lanes::<N>(|i| lesser(least(i), -end.closing[i]) >= 0.0);
        if away & open == 0 {
            return away;
        }
        let start = self.seen(&self.from, body, tops, normals);
        let clear = lanes::<N>(|i| {
            // It falls at the start and grows at the end: it stays above both tangents.
            let (falls, grows) = (greater(start.closing[i], 0.0), -end.closing[i]);
            let meet = (start.distance[i] - end.distance[i] + grows) / (falls + grows);
            let least = start.distance[i] - falls * meet;
            lesser(lesser(start.distance[i], start.down[i]), least - bent[i]) > 0.0
        });
        away & !(open & clear)
    }

    /// By how much the distance of a point may be less than convex along the step, mm: turning and moving at once,
    /// the cutter approaches it by twice their product, turning alone by the square of the turn at the point's
    /// distance, both halved from an end on.
    fn bent<const N: usize>(&self, tops: &Vectors<N>) -> [f64; N] {
        if self.half_turn == 0.0 {
            return [0.0; N];
        }
        let (turn, way) = (2.0 * self.half_turn, 2.0 * self.half_way.length());
        tops.distances(self.middle.tip).map(|far| turn * (way + 0.5 * turn * far))
    }

    /// The lines that stay below the tip of a cutter that does not turn, and lead away from it.
    fn above<const N: usize>(&self, tops: &Vectors<N>, normals: &Vectors<N>) -> u32 {
        if self.half_turn != 0.0 {
            return 0;
        }
        let (tip, axis) = (self.to.tip, self.to.axis);
        // What is below the tip at the end by less than the cutter rose was above it at the start.
        let risen = greater(2.0 * self.half_way.dot(axis), 0.0);
        let (heights, rises) = (tops.along(axis), normals.along(axis));
        let level = tip.dot(axis) - risen;
        lanes::<N>(|i| heights[i] <= level && rises[i] >= 0.0)
    }

    fn seen<const N: usize>(
        &self,
        at: &Placed,
        body: &Body,
        tops: &Vectors<N>,
        normals: &Vectors<N>,
    ) -> Seen<N> {
        // Most cutters never turn.
        if self.half_turn == 0.0 {
            self.seen_on::<N, false>(at, body, tops, normals)
        } else {
            self.seen_on::<N, true>(at, body, tops, normals)
        }
    }

    /// As given by [`Body::nearest`] and [`Step::approach`], all over the same denominator.
    #[inline(always)]
    fn seen_on<const N: usize, const TURNS: bool>(
        &self,
        at: &Placed,
        body: &Body,
        tops: &Vectors<N>,
        normals: &Vectors<N>,
    ) -> Seen<N> {
        let (tip, axis, way) = (at.tip, at.axis, 2.0 * self.half_way);
        let turn = self.to.axis - self.from.axis;
        let (axis_way, axis_turn) = (axis.dot(way), axis.dot(turn));
        let (bottom, corner, top) = (body.bottom(), body.corner(), body.length() - body.corner());
        let mut seen = Seen { distance: [0.0; N], down: [0.0; N], closing: [0.0; N] };
        for i in 0..N {
            let w = [tops.x[i] - tip.x, tops.y[i] - tip.y, tops.z[i] - tip.z];
            let n = [normals.x[i], normals.y[i], normals.z[i]];
            let height = w[0] * axis.x + w[1] * axis.y + w[2] * axis.z;
            let a = [w[0] - axis.x * height, w[1] - axis.y * height, w[2] - axis.z * height];
            let rho = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
            let out = greater(rho - bottom, 0.0);
            let beyond = greater(height - top, 0.0) - greater(corner - height, 0.0);
            let from_core = (out * out + beyond * beyond).sqrt();
            let (upright, inverse) = (rho * beyond, 1.0 / (rho * from_core));
            let distance = from_core - corner;
            let rise = n[0] * axis.x + n[1] * axis.y + n[2] * axis.z;
            let spread = a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
            let sideways = a[0] * way.x + a[1] * way.y + a[2] * way.z;
            let mut closing = (out * sideways + upright * axis_way) * inverse;
            if TURNS {
                let sideways = a[0] * turn.x + a[1] * turn.y + a[2] * turn.z;
                let outward = [(out * sideways + upright * axis_turn) * inverse, upright * inverse];
                let along = height - outward[1] * distance;
                let swung = sideways + height * axis_turn - outward[0] * distance;
                closing += outward[0] * along - outward[1] * swung;
            }
            seen.distance[i] = distance;
            seen.down[i] = -(out * spread + upright * rise);
            seen.closing[i] = closing;
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tool::Tool;

    #[test]
    fn lanes_find_what_one_point_finds() {
        let at =
            Placed { tip: DVec3::new(1.0, 2.0, 3.0), axis: DVec3::new(0.2, -0.3, 0.9).normalize() };
        for (corner, length) in [(5.0, f64::INFINITY), (1.5, 20.0), (0.0, 20.0)] {
            let body = Body::new(&Tool::new(5.0, corner).unwrap(), length);
            for k in 0..40 {
                let mut points = Vectors::<16>::ZERO;
                let point = |i: usize| {
                    let (i, k) = (i as f64, f64::from(k));
                    DVec3::new(1.3 * i - 9.0, k - 15.0, (0.7 * i + 0.3 * k) % 9.0 * 4.0 - 9.0)
                };
                (0..16).for_each(|i| points.set(i, point(i)));
                let near = body.nearest_of(&at, &points);
                for i in 0..16 {
                    let one = body.nearest(&at, point(i));
                    assert_eq!(near.distance[i], one.distance);
                    if one.distance > 0.0 {
                        assert!(near.outward.get(i).distance(one.outward) < 1e-15);
                    }
                }
            }
        }
    }

    #[test]
    fn sets_name_their_lanes() {
        assert_eq!(lanes::<16>(|i| i % 5 == 1), 0b1000_0100_0010);
        assert_eq!(each(0b1000_0100_0010).collect::<Vec<_>>(), [1, 6, 11]);
        assert_eq!(each(0).count(), 0);
    }
}
