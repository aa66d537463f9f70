//! The cutter as a solid: a cylinder of radius `R` whose lower rim is rounded by the corner radius.
//!
//! It is the set of points within the corner radius of its *core*: a cylinder of radius
//! `R - r_c` that begins `r_c` above the tip. A ball's core is a line, a flat end's core is the
//! cutter itself. The core is convex, hence so is the cutter, and a line meets it in one interval.

use crate::geometry::DVec3;
use crate::tool::Tool;

/// A line whose direction has less than this squared part across the axis runs along it.
const ALONG_AXIS: f64 = 1e-14;
/// A line that rises less than this along the axis hardly enters the flat end, mm/mm.
const FLAT: f64 = 1e-6;
/// Newton steps on the rounded rim; each doubles the number of correct digits, from below.
const MOST_STEPS: usize = 24;
/// Newton steps from a starting value; a good one takes two.
const FEW_STEPS: usize = 6;
/// Largest change by a further step from a starting value, mm.
const CLOSE: f64 = 1e-7;
/// A point this close to the rim lies on it, mm.
const TOUCH: f64 = 1e-9;

/// The solid of a cutter, tip at the origin.
#[derive(Copy, Clone, Debug)]
pub struct Body {
    radius: f64,
    corner: f64,
    /// Radius of the core.
    bottom: f64,
    /// Height of the top above the tip; may be infinite.
    length: f64,
}

/// A cutter in place.
#[derive(Copy, Clone, Debug)]
pub struct Placed {
    /// Tip, mm.
    pub tip: DVec3,
    /// Unit axis, from the tip to the spindle.
    pub axis: DVec3,
}

/// A point as seen from the cutter.
#[derive(Copy, Clone, Debug)]
pub struct Nearest {
    /// Distance from the cutter, mm; zero or negative inside.
    pub distance: f64,
    /// Unit direction from the nearest point of the cutter to the point; meaningless inside.
    pub outward: DVec3,
}

/// A line in the cutter's cylindrical coordinates: height and squared distance from the axis are
/// polynomials of the way along it.
struct Line {
    height: f64,
    rise: f64,
    /// Squared distance from the axis is `q[0] + 2 q[1] t + q[2] t²`.
    q: [f64; 3],
}

impl Body {
    /// The solid of `tool` up to `length` mm above its tip; never less than the corner.
    pub fn new(tool: &Tool, length: f64) -> Self {
        let (radius, corner) = (tool.radius(), tool.corner_radius());
        Self { radius, corner, bottom: radius - corner, length: length.max(2.0 * radius) }
    }

    /// Cutter radius, mm.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Radius of the rounded rim, mm.
    pub fn corner(&self) -> f64 {
        self.corner
    }

    /// Radius of the core, mm.
    pub fn bottom(&self) -> f64 {
        self.bottom
    }

    /// Height of the top above the tip, mm.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Whether it has no sharp edge.
    pub fn is_rounded(&self) -> bool {
        self.corner > 0.0
    }

    /// Whether it is a ball.
    pub fn is_ball(&self) -> bool {
        self.bottom == 0.0
    }

    /// Whether part of a layer that high is cut by the cutter's side.
    pub fn has_wall_below(&self, height: f64) -> bool {
        self.corner < height
    }

    /// How far from a round cutter a point must be at the end of a straight move of `way` mm to be clear of it
    /// throughout, if it is clear at the start, mm; `None` where the cutter has a sharp edge.
    ///
    /// The distance from a solid with radii of curvature of at least `r_c` is convex along the move, with a second
    /// derivative of at most `1/r_c`: `f(s) >= s f(1) - s (1 - s) way² / (2 r_c)`.
    pub fn dip(&self, way: f64) -> Option<f64> {
        (self.corner > 0.0).then(|| way * way / (2.0 * self.corner))
    }

    /// How deep a point lies within the cutter, which goes on above its top, mm; negative: outside.
    pub fn depth(&self, at: &Placed, point: DVec3) -> f64 {
        let w = point - at.tip;
        let height = w.dot(at.axis);
        let rho = (w - at.axis * height).length();
        let (below, beside) = (self.corner - height, rho - self.bottom);
        let from_core = match below.min(beside) > 0.0 {
            true => (below * below + beside * beside).sqrt(),
            false => below.max(beside),
        };
        self.corner - from_core
    }

    /// Distance and direction of a point from the cutter.
    pub fn nearest(&self, at: &Placed, point: DVec3) -> Nearest {
        let w = point - at.tip;
        let height = w.dot(at.axis);
        let across = w - at.axis * height;
        let rho = across.length();
        let out = (rho - self.bottom).max(0.0);
        let top = self.length - self.corner;
        let beyond = if height > top { height - top } else { (height - self.corner).min(0.0) };
        let from_core = (out * out + beyond * beyond).sqrt();
        if from_core == 0.0 {
            return Nearest { distance: -self.corner, outward: -at.axis };
        }
        let radial = if rho > 0.0 { across * (out / rho) } else { DVec3::ZERO };
        Nearest {
            distance: from_core - self.corner,
            outward: (radial + at.axis * beyond) / from_core,
        }
    }

    /// Whether a point is in the cutter or on it.
    pub fn contains(&self, at: &Placed, point: DVec3) -> bool {
        self.nearest(at, point).distance <= TOUCH
    }

    /// The least `t` for which `origin + t direction` lies in the cutter; `None` if none does.
    ///
    /// `direction`: unit.
    pub fn entry(&self, at: &Placed, origin: DVec3, direction: DVec3) -> Option<f64> {
        self.entry_of(&Line::new(at, origin, direction))
    }

    /// As above, but faster with a starting value near the solution, which does not change the result by more than
    /// the tolerance of the search.
    pub fn entry_near(
        &self,
        at: &Placed,
        origin: DVec3,
        direction: DVec3,
        guess: f64,
    ) -> Option<f64> {
        let line = Line::new(at, origin, direction);
        // The others have a closed form.
        let searched = self.bottom > 0.0 && self.corner > 0.0;
        let near = if searched { self.entry_from_guess(&line, guess) } else { None };
        near.or_else(|| self.entry_of(&line))
    }

    /// The lowest entry of a line during a step, given by its ends, of a cutter with a sharp edge that does not turn,
    /// and the pose of the cutter then, if that is known at once.
    ///
    /// The entry is convex along the step, and linear as long as it is through the flat bottom. So the end is the
    /// lowest if the entry is through the flat bottom and the cutter does not rise; the start, if it does rise.
    pub fn lowest_through_flat(
        &self,
        [from, to]: [Placed; 2],
        origin: DVec3,
        direction: DVec3,
    ) -> Option<(f64, Placed)> {
        let rises = (to.tip - from.tip).dot(to.axis) > 0.0;
        let at = if rises { from } else { to };
        let line = Line::new(&at, origin, direction);
        let t = -line.height / line.rise;
        let within = line.rho_squared(t) < self.bottom * self.bottom;
        (line.rise > FLAT && within).then_some((t, at))
    }

    /// By how much the squared distance from the axis, where a line crosses the plane of the flat bottom, is larger
    /// than that of the bottom's edge, mm²; not finite for a line along that plane.
    pub fn outside_of_bottom(&self, at: &Placed, origin: DVec3, direction: DVec3) -> f64 {
        let line = Line::new(at, origin, direction);
        line.rho_squared(-line.height / line.rise) - self.bottom * self.bottom
    }

    fn entry_of(&self, line: &Line) -> Option<f64> {
        // Most lines rise through the flat.
        if line.rise > FLAT && self.bottom > 0.0 {
            let t = -line.height / line.rise;
            if line.rho_squared(t) <= self.bottom * self.bottom {
                return Some(t);
            }
        }
        if self.corner == 0.0 {
            return line.entry(self.radius, 0.0, self.length).map(|(t, _)| t);
        }
        if self.is_ball() {
            let side = line.entry(self.radius, self.corner, self.length);
            let ball = line.ball_entry(self.radius);
            return match (side, ball) {
                (Some((a, _)), Some(b)) => Some(a.min(b)),
                (a, b) => a.map(|(t, _)| t).or(b),
            };
        }
        if let Some(t) = self.entry_from_below(line) {
            return Some(t);
        }
        // Nothing of the cutter lies outside of its cylinder or below its tip.
        let side = line.entry(self.radius, self.corner, self.length);
        if let Some((t, Through::Side)) = side {
            return Some(t);
        }
        let flat = line.entry(self.bottom, 0.0, self.length);
        if let Some((t, Through::End)) = flat
            && line.rise > 0.0
        {
            return Some(t);
        }
        let (outer, _) = line.entry(self.radius, 0.0, self.length)?;
        self.rim_entry(line, outer)
    }

    /// Entry by Newton's method from a starting value; `None` where it does not converge to it.
    ///
    /// The squared distance from the core is convex along the line and decreases on this side of its minimum. So a
    /// step from inside the cutter leads outside, and the next ones approach it from there.
    fn entry_from_guess(&self, line: &Line, guess: f64) -> Option<f64> {
        let mut t = guess;
        for _ in 0..FEW_STEPS {
            let rho = line.rho_squared(t).max(0.0).sqrt();
            let out = (rho - self.bottom).max(0.0);
            let under = (self.corner - line.height_at(t)).max(0.0);
            let excess = out * out + under * under - self.corner * self.corner;
            let spread = if out > 0.0 { out * (line.q[1] + line.q[2] * t) / rho } else { 0.0 };
            let slope = 2.0 * (spread - under * line.rise);
            if slope >= 0.0 {
                return None;
            }
            let way = excess / slope;
            t -= way;
            // The square bends by 4 at most: what a further step would change is `2 way² / slope`.
            if excess.abs() < 0.1 * self.corner * self.corner && way * way <= -0.5 * CLOSE * slope {
                return (line.height_at(t) <= self.length - self.corner).then_some(t);
            }
        }
        None
    }

    /// Entry of a line that rises into the cutter, if its origin lies outside of it and not far.
    fn entry_from_below(&self, line: &Line) -> Option<f64> {
        let start = self.way_to_core(line, 0.0);
        let outside = line.rise > 0.0 && start > self.corner + TOUCH;
        let t = if outside { self.rim_entry(line, 0.0)? } else { return None };
        (line.height_at(t) <= self.length - self.corner).then_some(t)
    }

    fn way_to_core(&self, line: &Line, t: f64) -> f64 {
        let out = (line.rho_squared(t).max(0.0).sqrt() - self.bottom).max(0.0);
        let under = (self.corner - line.height_at(t)).max(0.0);
        (out * out + under * under).sqrt()
    }

    /// Entry through the rounded rim, starting from a place before it. The distance from the core is convex along the
    /// line, so Newton's steps never overshoot.
    fn rim_entry(&self, line: &Line, start: f64) -> Option<f64> {
        let mut t = start;
        for _ in 0..MOST_STEPS {
            let rho = line.rho_squared(t).max(0.0).sqrt();
            let out = (rho - self.bottom).max(0.0);
            let under = (self.corner - line.height_at(t)).max(0.0);
            let from_core = (out * out + under * under).sqrt();
            if from_core <= self.corner + TOUCH {
                return Some(t);
            }
            let spread = if rho > 0.0 { (line.q[1] + line.q[2] * t) / rho } else { 0.0 };
            let slope = (out * spread - under * line.rise) / from_core;
            if slope >= 0.0 {
                return None;
            }
            t += (from_core - self.corner) / -slope;
        }
        // Slow only where the line grazes the rim.
        None
    }

    /// The least `t` at which a ball that moves from `from` to `to` without turning is entered
    /// between its ends, and where it is then; `None` where the ends decide.
    pub fn ball_sweep_entry(
        &self,
        from: &Placed,
        to: &Placed,
        origin: DVec3,
        direction: DVec3,
    ) -> Option<(f64, Placed)> {
        let start = from.tip + from.axis * self.radius;
        let way = to.tip + to.axis * self.radius - start;
        let length_squared = way.length_squared();
        let w = origin - start;
        // Across the way.
        let along = |v: DVec3| v.dot(way) / length_squared;
        let (w_along, d_along) = (along(w), along(direction));
        let (w_across, d_across) = (w - way * w_along, direction - way * d_along);
        let a = d_across.length_squared();
        let b = w_across.dot(d_across);
        let c = w_across.length_squared() - self.radius * self.radius;
        let discriminant = b * b - a * c;
        if !(a > ALONG_AXIS && discriminant > 0.0) {
            return None;
        }
        let t = (-b - discriminant.sqrt()) / a;
        let place = w_along + t * d_along;
        let at = Placed { tip: from.tip.lerp(to.tip, place), axis: from.axis };
        (place > 0.0 && place < 1.0).then_some((t, at))
    }
}

/// The part of the surface through which a line enters a cylinder.
#[derive(Copy, Clone, PartialEq)]
enum Through {
    Side,
    End,
}

impl Line {
    fn new(at: &Placed, origin: DVec3, direction: DVec3) -> Self {
        let w = origin - at.tip;
        let (height, rise) = (w.dot(at.axis), direction.dot(at.axis));
        let q = [
            w.length_squared() - height * height,
            w.dot(direction) - height * rise,
            1.0 - rise * rise,
        ];
        Self { height, rise, q }
    }

    fn height_at(&self, t: f64) -> f64 {
        self.height + self.rise * t
    }

    fn rho_squared(&self, t: f64) -> f64 {
        self.q[0] + t * (2.0 * self.q[1] + t * self.q[2])
    }

    /// Entry into the cylinder of that radius between two heights, and the part of its surface.
    fn entry(&self, radius: f64, low: f64, high: f64) -> Option<(f64, Through)> {
        let c = self.q[0] - radius * radius;
        let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut through = Through::End;
        if self.q[2] > ALONG_AXIS {
            let discriminant = self.q[1] * self.q[1] - self.q[2] * c;
            if discriminant <= 0.0 {
                return None;
            }
            let root = discriminant.sqrt();
            (first, last) = ((-self.q[1] - root) / self.q[2], (-self.q[1] + root) / self.q[2]);
            through = Through::Side;
        } else if c > 0.0 {
            return None;
        }
        if self.rise.abs() > 1e-12 {
            let ends = [(low - self.height) / self.rise, (high - self.height) / self.rise];
            let (near, far) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            if near > first {
                (first, through) = (near, Through::End);
            }
            last = last.min(far);
        } else if !(low..=high).contains(&self.height) {
            return None;
        }
        (first <= last).then_some((first, through))
    }

    /// Entry into the ball of that radius about the point at that height on the axis.
    fn ball_entry(&self, radius: f64) -> Option<f64> {
        let up = self.height - radius;
        let b = self.q[1] + up * self.rise;
        let c = self.q[0] + up * up - radius * radius;
        let discriminant = b * b - c;
        (discriminant > 0.0).then(|| -b - discriminant.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tools() -> [Body; 3] {
        [5.0, 0.0, 1.5].map(|c| Body::new(&Tool::new(5.0, c).unwrap(), 40.0))
    }

    /// Entry by stepping and bisection on the distance.
    fn searched(body: &Body, at: &Placed, o: DVec3, d: DVec3) -> Option<f64> {
        let inside = |t: f64| body.nearest(at, o + d * t).distance <= 1e-9;
        let step = 1e-3;
        let n = (-30_000..60_000).find(|&i| inside(f64::from(i) * step))?;
        let (mut out, mut within) = (f64::from(n - 1) * step, f64::from(n) * step);
        for _ in 0..60 {
            let middle = 0.5 * (out + within);
            if inside(middle) { within = middle } else { out = middle }
        }
        Some(within)
    }

    #[test]
    fn entries_are_where_the_distance_becomes_zero() {
        let at =
            Placed { tip: DVec3::new(1.0, 2.0, 3.0), axis: DVec3::new(0.2, -0.3, 0.9).normalize() };
        let directions =
            [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.48, 0.64, 0.6), at.axis];
        let mut met = 0;
        for body in tools() {
            for direction in directions {
                for i in 0..12 {
                    let offset = DVec3::new(
                        f64::from(i % 4) * 2.3 - 4.0,
                        f64::from(i / 4) * 2.9 - 1.7,
                        -2.0,
                    );
                    let found = body.entry(&at, at.tip + offset, direction);
                    let expected = searched(&body, &at, at.tip + offset, direction);
                    match (found, expected) {
                        (Some(a), Some(b)) => {
                            met += 1;
                            assert!((a - b).abs() < 1e-6, "{body:?} {offset} {direction}: {a} {b}")
                        }
                        (a, b) => {
                            assert_eq!(a.is_some(), b.is_some(), "{body:?} {offset} {direction}")
                        }
                    }
                }
            }
        }
        assert!(met > 40, "{met}");
    }

    #[test]
    fn guesses_do_not_change_entries() {
        let at =
            Placed { tip: DVec3::new(1.0, 2.0, 3.0), axis: DVec3::new(0.2, -0.3, 0.9).normalize() };
        let [_, _, bull] = tools();
        let mut near = 0;
        for direction in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.48, 0.64, 0.6)] {
            for i in 0..600 {
                let (i, k) = (f64::from(i % 25), f64::from(i / 25));
                let origin = at.tip + DVec3::new(0.5 * i - 6.0, 0.5 * k - 6.0, -2.0);
                let expected = bull.entry(&at, origin, direction);
                for guess in [-3.0, 0.0, 2.0, 2.3, 3.0, 9.0] {
                    match (bull.entry_near(&at, origin, direction, guess), expected) {
                        (Some(a), Some(b)) => {
                            near += 1;
                            // Where the line grazes the rim, the tolerance is a longer way.
                            assert!((a - b).abs() < 1e-5, "{origin} {direction} {guess}: {a} {b}");
                        }
                        (a, b) => assert_eq!(a.is_some(), b.is_some(), "{origin} {direction}"),
                    }
                }
            }
        }
        assert!(near > 3000, "{near}");
    }

    #[test]
    fn distance_of_known_points() {
        let at = Placed { tip: DVec3::ZERO, axis: DVec3::Z };
        for body in tools() {
            let below = body.nearest(&at, DVec3::new(0.0, 0.0, -2.0));
            assert!((below.distance - 2.0).abs() < 1e-12 && below.outward == -DVec3::Z);
            let beside = body.nearest(&at, DVec3::new(0.0, 9.0, 10.0));
            assert!((beside.distance - 4.0).abs() < 1e-12 && beside.outward == DVec3::Y);
            assert!(body.contains(&at, DVec3::new(3.0, 0.0, 6.0)));
        }
    }

    #[test]
    fn moving_ball_is_a_capsule() {
        let [ball, ..] = tools();
        let from = Placed { tip: DVec3::ZERO, axis: DVec3::Z };
        let to = Placed { tip: DVec3::new(4.0, 0.0, 0.0), axis: DVec3::Z };
        let entry = |x: f64, y: f64| {
            ball.ball_sweep_entry(&from, &to, DVec3::new(x, y, 0.0), DVec3::Z).map(|e| e.0)
        };
        let height = 5.0 - (25.0f64 - 4.0).sqrt();
        assert!((entry(1.0, 2.0).unwrap() - height).abs() < 1e-12);
        assert_eq!(entry(-0.1, 2.0), None);
        assert_eq!(entry(1.0, 5.1), None);
    }
}
