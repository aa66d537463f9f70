//! How a line goes on beyond its end: on the parabola that it follows before it.

use super::DVec3;

/// Most that a line leaves the straight way beyond its end, as a part of that way's length.
const LARGEST_BEND: f64 = 0.2;

/// A parabola from the end of a line on, `way * t + bend * t²`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Parabola {
    /// For the whole of the way, mm.
    pub way: DVec3,
    /// For the whole of the way, mm.
    pub bend: DVec3,
}

impl Parabola {
    /// Over a way of length `far`, mm, beyond the end of a line; `back`: the place of the line so far before
    /// its end, from the end.
    ///
    /// The bend is that of the last `far` or of the last `2 far` before the end, whichever is less; none where
    /// they bend to different sides or more than smooth lines do, as beside a corner. `None` for a line that is
    /// shorter than half of `far`.
    pub fn beyond(far: f64, back: impl Fn(f64) -> Option<DVec3>) -> Option<Self> {
        let near = back(0.5 * far)?;
        let straight = Self::straight(-near, far);
        let Some((middle, last)) = back(far).zip(back(2.0 * far)) else { return Some(straight) };
        // Through both places and the end.
        let wide = Self { way: 0.5 * last - 2.0 * middle, bend: 0.5 * last - middle };
        let close = Self { way: middle - 4.0 * near, bend: 2.0 * middle - 4.0 * near };
        let less = if wide.bend.length() <= close.bend.length() { wide } else { close };
        let is_smooth = wide.bend.dot(close.bend) > 0.0 && less.bend.length() <= LARGEST_BEND * far;
        Some(if is_smooth { less } else { straight })
    }

    /// Straight on along `way`, of any length, for `far` mm.
    pub fn straight(way: DVec3, far: f64) -> Self {
        Self { way: way.normalize_or_zero() * far, bend: DVec3::ZERO }
    }

    /// The place at a part of the way, from the end of the line.
    pub fn at(&self, part: f64) -> DVec3 {
        (self.way + self.bend * part) * part
    }

    /// The heading there, of unit length.
    pub fn heading(&self, part: f64) -> DVec3 {
        (self.way + self.bend * (2.0 * part)).normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};

    #[test]
    fn a_circle_goes_on_as_a_circle() {
        let on_circle = |s: f64| DVec3::new(sin(s / 10.0) * 10.0, 10.0 - 10.0 * cos(s / 10.0), 0.0);
        let parabola = Parabola::beyond(1.0, |s| Some(on_circle(-s))).unwrap();
        assert!(parabola.at(1.0).distance(on_circle(1.0)) < 0.012);
        assert!(parabola.at(0.5).distance(on_circle(0.5)) < 0.005);
    }

    #[test]
    fn a_line_with_a_corner_before_its_end_goes_on_straight() {
        // East at last, from the north before.
        for corner in [0.5, 0.7, 0.9, 1.5] {
            let back = |s: f64| DVec3::new(-s.min(corner), (s - corner).max(0.0), 0.0);
            let parabola = Parabola::beyond(1.0, |s| Some(back(s))).unwrap();
            assert!(parabola.at(1.0).distance(DVec3::X) < 1e-12, "{corner}: {parabola:?}");
        }
    }

    #[test]
    fn a_short_line_goes_on_straight_and_a_shorter_one_not_at_all() {
        let line = |length: f64| move |s: f64| (s < length).then_some(DVec3::new(-s, 0.0, 0.0));
        assert_eq!(Parabola::beyond(1.0, line(1.5)), Some(Parabola::straight(DVec3::X, 1.0)));
        assert_eq!(Parabola::beyond(1.0, line(0.4)), None);
    }
}
