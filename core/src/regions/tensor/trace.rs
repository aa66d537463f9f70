//! Lines along the best feed direction.
//!
//! The direction field has no sign: a line continues in the sense that turns less.
//!
//! # Source
//! Bogacki and Shampine, "A 3(2) pair of Runge-Kutta formulas", Appl. Math. Letters 2 (1989).

use super::field::TensorField;
use crate::geometry::DVec2;
use crate::mesh::FaceId;
use core::cell::Cell;

/// Longest, first and shortest step, and the error allowed in one, in parts of the chart's size.
const LONGEST: f64 = 0.02;
const FIRST: f64 = 1e-3;
const SHORTEST: f64 = 1e-5;
const ERROR: f64 = 1e-5;
/// Safety factor and limits of the change of a step.
const SAFETY: f64 = 0.9;
const CHANGE: (f64, f64) = (0.2, 3.0);
/// Most steps of a line.
const MOST_STEPS: usize = 20_000;
/// Longest line, in sizes of the chart.
const LONGEST_LINE: f64 = 12.0;

/// Where a line ended.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// On the boundary of the chart.
    Boundary,
    /// At a degenerate point.
    Point(usize),
    /// On another line or an earlier part of its own.
    Line,
    /// Not within the greatest length.
    Nowhere,
}

/// What ends a line before the boundary: called with both ends of every step.
pub type Stop<'a> = &'a dyn Fn(&[DVec2], DVec2) -> Option<(DVec2, End)>;

/// Traces lines through a field.
pub struct Tracer<'a> {
    field: &'a TensorField<'a>,
    size: f64,
    hint: Cell<FaceId>,
}

impl<'a> Tracer<'a> {
    /// Of a field; `size`: diameter of its chart, flat mm.
    pub fn new(field: &'a TensorField<'a>, size: f64) -> Self {
        Self { field, size, hint: Cell::new(FaceId(0)) }
    }

    /// The direction at a place, in the sense of `heading`; `heading` itself where there is none,
    /// nothing outside of the chart.
    pub fn direction(&self, at: DVec2, heading: DVec2) -> Option<DVec2> {
        let point = self.field.locator().locate_from(self.hint.get(), at).ok()?;
        self.hint.set(point.face);
        let d = TensorField::direction_of(self.field.at(point));
        Some(match d.dot(heading) {
            _ if d == DVec2::ZERO => heading,
            along if along < 0.0 => -d,
            _ => d,
        })
    }

    /// From `from` along `heading` until something ends it; `from` is the first point.
    pub fn follow(&self, from: DVec2, heading: DVec2, stop: Stop) -> (Vec<DVec2>, End) {
        let mut line = vec![from];
        let (mut at, mut heading) = (from, heading);
        let (mut step, mut way) = (FIRST * self.size, 0.0);
        for _ in 0..MOST_STEPS {
            let shortest = step <= SHORTEST * self.size;
            let Some((to, next, error)) = self.step(at, heading, step) else {
                if shortest {
                    return self.left(line, heading);
                }
                step = (0.5 * step).max(SHORTEST * self.size);
                continue;
            };
            let allowed = ERROR * self.size;
            let change = if error > 0.0 {
                SAFETY * crate::geometry::math::cbrt(allowed / error)
            } else {
                CHANGE.1
            };
            let wanted = step * change.clamp(CHANGE.0, CHANGE.1);
            let wanted = wanted.clamp(SHORTEST * self.size, LONGEST * self.size);
            if error > allowed && !shortest {
                step = wanted;
                continue;
            }
            if let Some((place, end)) = stop(&line, to) {
                line.push(place);
                return (line, end);
            }
            way += at.distance(to);
            line.push(to);
            (at, heading, step) = (to, next, wanted);
            if way > LONGEST_LINE * self.size {
                break;
            }
        }
        (line, End::Nowhere)
    }

    /// End, direction there and error of a step; `None` where it leaves the chart.
    fn step(&self, at: DVec2, heading: DVec2, h: f64) -> Option<(DVec2, DVec2, f64)> {
        let k1 = self.direction(at, heading)?;
        let k2 = self.direction(at + k1 * (0.5 * h), k1)?;
        let k3 = self.direction(at + k2 * (0.75 * h), k2)?;
        let to = at + (k1 * 2.0 + k2 * 3.0 + k3 * 4.0) * (h / 9.0);
        let k4 = self.direction(to, k3)?;
        let error = (k1 * -5.0 + k2 * 6.0 + k3 * 8.0 - k4 * 9.0) * (h / 72.0);
        Some((to, k4, error.length()))
    }

    /// A line that has come to the boundary, with the place where it leaves.
    fn left(&self, mut line: Vec<DVec2>, heading: DVec2) -> (Vec<DVec2>, End) {
        let last = line[line.len() - 1];
        let locator = self.field.locator();
        if let Ok(at) = locator.locate_from(self.hint.get(), last)
            && let Err(outside) =
                locator.walk(at.face, last, last + heading * (0.1 * self.size), |_, _| {})
        {
            // A last stretch too short to be one would bend the end.
            if line.len() > 1 && outside.uv.distance(last) < 2.0 * SHORTEST * self.size {
                line.pop();
            }
            line.push(outside.uv);
        }
        (line, End::Boundary)
    }
}

/// Where the segments `a b` and `c d` cross; `None` for parallel ones.
pub fn crossing(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> Option<DVec2> {
    let (r, s) = (b - a, d - c);
    let across = r.perp_dot(s);
    let (t, u) = ((c - a).perp_dot(s) / across, (c - a).perp_dot(r) / across);
    let within = |x: f64| (0.0..=1.0).contains(&x);
    (within(t) && within(u)).then(|| a + r * t)
}
