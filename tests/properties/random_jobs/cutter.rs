//! The cutter as a convex solid, and what a line meets of it, found by search instead of formulas.
//!
//! The cutter is what lies within the corner radius of a cylinder (its core). The distance from it is convex
//! along every line, and along a straight move too: so one search by golden section along a line, or along a
//! move, finds the lowest place, and one by halving finds where the line enters.

use evencut_core::geometry::DVec3;

/// Share of an interval that golden section keeps.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Rounds of golden section: to 5e-7 of the interval; near its least place the function is flat, or its slope
/// times the interval, some millimetres at most, is what it is off.
const ROUNDS: usize = 30;
/// Rounds of halving: to 1e-9 of the interval.
const HALVINGS: usize = 30;

/// A cutter with its shank, a cylinder of the same radius.
#[derive(Copy, Clone, Debug)]
pub struct Cutter {
    /// Radius, mm.
    pub radius: f64,
    /// Corner radius, mm.
    pub corner: f64,
    /// Length from tip to top, mm; may be infinite.
    pub length: f64,
}

/// A cutter's place.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Pose {
    /// Tip, mm.
    pub tip: DVec3,
    /// Unit axis, from the tip up.
    pub axis: DVec3,
}

/// A straight line: a point of it and its unit direction.
#[derive(Copy, Clone, Debug)]
pub struct Line {
    /// Where it is at 0.
    pub foot: DVec3,
    /// Where it goes.
    pub along: DVec3,
}

impl Line {
    /// The point that far along.
    pub fn at(&self, t: f64) -> DVec3 {
        self.foot + self.along * t
    }
}

/// A part of a move: from a pose to a pose, the tip straight, the axis hardly turning.
#[derive(Copy, Clone, Debug)]
pub struct Piece {
    /// Where it starts.
    pub from: Pose,
    /// Where it ends.
    pub to: Pose,
    /// Index of the move it belongs to, which ends at the path's point after that.
    pub of: usize,
}

impl Piece {
    /// The cutter a part `s` of the way.
    pub fn at(&self, s: f64) -> Pose {
        let axis = self.from.axis.lerp(self.to.axis, s);
        Pose { tip: self.from.tip.lerp(self.to.tip, s), axis: axis.normalize() }
    }
}

/// Where a convex function is least on an interval, and its value there.
pub fn least(from: f64, to: f64, of: &mut dyn FnMut(f64) -> f64) -> (f64, f64) {
    let (mut a, mut b) = (from, to);
    let (mut c, mut d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut at_c, mut at_d) = (of(c), of(d));
    for _ in 0..ROUNDS {
        if at_c <= at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - GOLDEN * (b - a);
            at_c = of(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + GOLDEN * (b - a);
            at_d = of(d);
        }
    }
    let ends = [from, to, c, d];
    let best = ends.map(|x| (x, of(x)));
    best.into_iter().fold((from, f64::INFINITY), |l, r| if r.1 < l.1 { r } else { l })
}

impl Cutter {
    /// Distance of a point from the cutter, mm; negative inside.
    pub fn distance(&self, pose: &Pose, point: DVec3) -> f64 {
        let way = point - pose.tip;
        let height = way.dot(pose.axis);
        let across = (way.length_squared() - height * height).max(0.0).sqrt();
        let beside = across - (self.radius - self.corner);
        let beyond = (self.corner - height).max(height - (self.length - self.corner));
        let (x, y) = (beside.max(0.0), beyond.max(0.0));
        (x * x + y * y).sqrt() + beside.max(beyond).min(0.0) - self.corner
    }

    /// Height of the cutter's underside above its tip at a distance from its axis; `None` beside it.
    pub fn underside(&self, across: f64) -> Option<f64> {
        let beside = across - (self.radius - self.corner);
        (across <= self.radius).then(|| match beside > 0.0 {
            true => self.corner - (self.corner * self.corner - beside * beside).max(0.0).sqrt(),
            false => 0.0,
        })
    }

    /// The part of a line from `from` to `to` inside of the cutter.
    pub fn span(&self, pose: &Pose, line: Line, from: f64, to: f64) -> Option<(f64, f64)> {
        let mut of = |t: f64| self.distance(pose, line.at(t));
        let (inside, value) = least(from, to, &mut of);
        if value > 0.0 {
            return None;
        }
        let crossing = |outside: f64| {
            let (mut out, mut ins) = (outside, inside);
            if of(out) <= 0.0 {
                return out;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (out + ins);
                if of(middle) <= 0.0 { ins = middle } else { out = middle }
            }
            ins
        };
        Some((crossing(from), crossing(to)))
    }

    /// The least distance from the cutter of the line's points from `from` to `to`, at least.
    fn bound(&self, pose: &Pose, line: Line, from: f64, to: f64) -> f64 {
        const STEP: f64 = 1e-3;
        let mut of = |t: f64| self.distance(pose, line.at(t));
        let (end, before) = (of(to), of(to - STEP));
        // Convex: where it falls up to the end, the end is the least.
        if before >= end { end - STEP } else { least(from, to, &mut of).1 }
    }

    /// How far the cutter's points near a line move at most on half a piece, mm.
    fn reach(&self, piece: &Piece, line: Line) -> f64 {
        let lever = line.foot.distance(piece.from.tip) + self.radius;
        let turn = piece.from.axis.distance(piece.to.axis);
        0.5 * (piece.from.tip.distance(piece.to.tip) + turn * lever)
    }

    /// Whether the cutter holds both of two points somewhere on a piece of the path.
    pub fn holds(&self, piece: &Piece, a: DVec3, b: DVec3) -> bool {
        let mut of = |s: f64| {
            let pose = piece.at(s);
            self.distance(&pose, a).max(self.distance(&pose, b))
        };
        // Within this of the middle nothing changes more.
        let line = Line { foot: a, along: DVec3::Z };
        of(0.5) <= self.reach(piece, line) && least(0.0, 1.0, &mut of).1 <= 0.0
    }

    /// Where a line enters the cutter between `from` and `to`; where it does not, how far it stays off, added to `to`.
    fn entry(&self, pose: &Pose, line: Line, from: f64, to: f64) -> f64 {
        let mut of = |t: f64| self.distance(pose, line.at(t));
        if of(to) > 0.0 {
            return match self.span(pose, line, from, to) {
                Some((low, _)) => low,
                None => to + least(from, to, &mut of).1,
            };
        }
        if of(from) <= 0.0 {
            return from;
        }
        let (mut out, mut ins) = (from, to);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (out + ins);
            if of(middle) <= 0.0 { ins = middle } else { out = middle }
        }
        ins
    }

    /// The lowest place from `from` to `to` on a line inside of the cutter somewhere on a piece of the path.
    pub fn lowest(&self, piece: &Piece, line: Line, from: f64, to: f64) -> Option<f64> {
        const STEP: f64 = 1e-3;
        let middle = piece.at(0.5);
        if self.bound(&middle, line, from, to) > self.reach(piece, line) {
            return None;
        }
        // Above the line's end, the cutter must first hold the end.
        let end = line.at(to);
        let is_above = [0.0, 0.5, 1.0].iter().all(|&s| {
            let pose = piece.at(s);
            self.distance(&pose, line.at(to - STEP)) >= self.distance(&pose, end)
        });
        if is_above && least(0.0, 1.0, &mut |s| self.distance(&piece.at(s), end)).1 > 0.0 {
            return None;
        }
        if piece.from == piece.to {
            let low = self.entry(&piece.from, line, from, to);
            return (low <= to).then_some(low);
        }
        let mut height = |s: f64| self.entry(&piece.at(s), line, from, to);
        let (_, low) = least(0.0, 1.0, &mut height);
        (low <= to).then_some(low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Pose = Pose { tip: DVec3::ZERO, axis: DVec3::Z };

    fn cutter(radius: f64, corner: f64) -> Cutter {
        Cutter { radius, corner, length: 4.0 * radius }
    }

    fn rising(x: f64, y: f64) -> Line {
        Line { foot: DVec3::new(x, y, 0.0), along: DVec3::Z }
    }

    #[test]
    fn lines_enter_a_ball_where_its_sphere_is() {
        let ball = cutter(5.0, 5.0);
        for x in [0.0, 1.0, 3.0, 4.9] {
            let (low, _) = ball.span(&UP, rising(x, 0.0), -1.0, 8.0).unwrap();
            assert!((low - (5.0 - (25.0 - x * x).sqrt())).abs() < 1e-7);
            assert_eq!(ball.underside(x).map(|u| (u - low).abs() < 1e-7), Some(true));
        }
        assert!(ball.span(&UP, rising(5.01, 0.0), -1.0, 30.0).is_none());
    }

    #[test]
    fn lines_enter_a_flat_and_a_bull_end_where_formulas_say() {
        let (flat, bull) = (cutter(3.0, 0.0), cutter(3.0, 1.0));
        assert!(flat.span(&UP, rising(2.99, 0.0), -1.0, 3.0).unwrap().0.abs() < 1e-7);
        assert!(flat.span(&UP, rising(3.01, 0.0), -1.0, 3.0).is_none());
        let (low, _) = bull.span(&UP, rising(0.0, 2.6), -1.0, 3.0).unwrap();
        assert!((low - (1.0 - (1.0 - 0.36f64).sqrt())).abs() < 1e-7);
        // Tilted by 30 degrees, a flat end's heel.
        let axis = DVec3::new(0.5, 0.0, 0.75f64.sqrt());
        let (low, _) = flat.span(&Pose { axis, ..UP }, rising(1.0, 0.0), -9.0, 9.0).unwrap();
        assert!((low + 0.5 / 0.75f64.sqrt()).abs() < 1e-7);
        // Level lines meet the shank from side to side.
        let level = Line { foot: DVec3::new(-9.0, 0.0, 10.0), along: DVec3::X };
        let (low, high) = bull.span(&UP, level, 0.0, 20.0).unwrap();
        assert!((low - 6.0).abs() < 1e-7 && (high - 12.0).abs() < 1e-7);
        assert!(
            bull.span(&UP, Line { foot: level.foot + DVec3::Z * 3.0, ..level }, 0.0, 20.0)
                .is_none()
        );
    }

    #[test]
    fn a_move_cuts_as_low_as_its_nearest_place() {
        let ball = cutter(5.0, 5.0);
        let to = Pose { tip: DVec3::new(2.0, 0.0, 0.0), ..UP };
        let piece = Piece { from: UP, to, of: 0 };
        let low = |x, y| ball.lowest(&piece, rising(x, y), -1.0, 4.0);
        assert!((low(1.3, 3.0).unwrap() - 1.0).abs() < 1e-7);
        assert!((low(5.0, 0.0).unwrap() - 1.0).abs() < 1e-7);
        assert!(low(1.0, 5.01).is_none() && low(-4.95, 0.0).is_none());
        // A flat end on a slope.
        let flat = cutter(3.0, 0.0);
        let rise = Piece { to: Pose { tip: DVec3::new(2.0, 0.0, 1.0), ..UP }, ..piece };
        let low = flat.lowest(&rise, rising(3.5, 0.0), -1.0, 4.0).unwrap();
        assert!((low - 0.25).abs() < 1e-6);
    }

    #[test]
    fn underside_and_distance_agree() {
        for c in [cutter(3.0, 0.0), cutter(3.0, 3.0), cutter(3.0, 0.7)] {
            for i in 0..30 {
                let x = 0.0999 * f64::from(i);
                let z = c.underside(x).unwrap();
                assert!(c.distance(&UP, DVec3::new(x, 0.0, z)).abs() < 1e-7);
            }
        }
    }
}
