//! The effective edge: the part of an edge that can touch material.
//!
//! Terms. The *thickness* is how far above the contact, along the surface normal there, the uncut material reaches on
//! the cutter. The *limit plane* stands at that distance over the tangent plane; of an edge, only what is below it
//! cuts. Steps: (1) thickness from the shape of the surface; (2) where the discretised edge crosses the limit plane;
//! (3) the four cases of the source.
//!
//! An edge point is below the plane at some angles of the spindle and above it at others. What is simulated is what is
//! below it at the angle at which the point is the lowest: a safe superset of what is below it at any time. Run-out,
//! the length of an element and the tolerance of the path are added to the thickness, so that leaving the rest out
//! changes no height.

use super::edge::EdgePlace;
use crate::geometry::math::acos_clamped;
use thiserror::Error;

/// Shape of the surface about the contact.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Shape {
    /// A plane.
    Plane,
    /// Convex in all directions.
    Convex,
    /// Concave in some direction.
    Concave {
        /// `R_min`: least concave radius of curvature, mm, of the design surface, not of the uncut one over it.
        least_radius: f64,
    },
}

/// A cutter that is too large for the surface.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
#[error(
    "texture: the surface has a concave radius of {least_radius:.4} mm at the window; a cutter with a corner of \
     {radius:.4} mm does not fit: use a smaller one or another place"
)]
pub struct TooConcave {
    /// Least concave radius of the surface, mm.
    pub least_radius: f64,
    /// Radius of the cutter's corner, mm.
    pub radius: f64,
}

/// Thickness of the engaged part of a ball of radius `r` mm above its contact, mm, under `a_p` mm of material.
///
/// A plane: `a_p`. Convex: at most `a_p`, which is returned. Concave, `R_min` the least radius of the *design* surface,
/// which the ball touches, so that `d_c = R_min - r` lies between the centres and the uncut surface has the radius
/// `R_min - a_p`: `cos(A) = (d_c² + r² - (R_min - a_p)²) / (2 d_c r)`, and `r + r cos(A)`. Never above `2 r`.
///
/// # Errors
/// [`TooConcave`] where `R_min` is not larger than `r`.
///
/// # Source
/// The two triangles of the circles of ball and uncut surface; the source prints `d_c` with the case of its letters
/// lost.
pub fn thickness(shape: Shape, r: f64, a_p: f64) -> Result<f64, TooConcave> {
    let least_radius = match shape {
        Shape::Plane | Shape::Convex => return Ok(a_p),
        Shape::Concave { least_radius } => least_radius,
    };
    let d_c = least_radius - r;
    // A NaN does not fit either.
    if d_c.is_nan() || d_c <= 0.0 {
        return Err(TooConcave { least_radius, radius: r });
    }
    let uncut = (least_radius - a_p).max(0.0);
    // r + r cos(A), written so that a large R_min loses no digits.
    let rise = ((d_c + r) * (d_c + r) - uncut * uncut) / (2.0 * d_c);
    Ok(rise.min(2.0 * r))
}

/// Axial angles `[0, arccos(1 - thic / r)]` between which the edge of a ball without tilt cuts, rad.
pub fn untilted(thickness: f64, r: f64) -> [f64; 2] {
    [0.0, acos_clamped(1.0 - thickness / r)]
}

/// The part of a discretised edge below the limit plane, in steps of its points: `[first, last]`.
///
/// `heights`: of the points above the contact, from the axis to the upper end; `thickness` as they are. With crossings
/// `l1 < l2` of the plane: two, `[l1, l2]`; one and the upper end below the plane, `[l1, end]`; one and the upper end
/// above it, `[0, l2]`; none, all of it. Empty edges give `[0, 0]`.
pub fn effective(heights: &[f64], thickness: f64) -> [f64; 2] {
    let end = heights.len().saturating_sub(1) as f64;
    let is_below = |h: f64| h <= thickness;
    let mut crossings = heights.windows(2).enumerate().filter_map(|(k, pair)| {
        let part = (thickness - pair[0]) / (pair[1] - pair[0]);
        (is_below(pair[0]) != is_below(pair[1])).then_some(k as f64 + part)
    });
    let upper_is_below = heights.last().is_some_and(|&h| is_below(h));
    match (crossings.next(), crossings.next_back()) {
        (Some(first), Some(last)) => [first, last],
        (Some(first), None) if upper_is_below => [first, end],
        (Some(last), None) => [0.0, last],
        (None, _) => [0.0, end],
    }
}

/// A stretch of an edge: the indices of its first and last point.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// First point.
    pub first: usize,
    /// Last point.
    pub last: usize,
}

impl Stretch {
    /// The smallest stretch that holds both.
    pub fn hull(self, other: Self) -> Self {
        Self { first: self.first.min(other.first), last: self.last.max(other.last) }
    }
}

/// The points of a profile that come lower than `thickness` mm above the contact in a turn of the cutter, and one more
/// on either side.
///
/// `cosine`: of the tilt, the angle between axis and surface normal. At its lowest, a point is
/// `z cos(tilt) - rho sin(tilt)` above the corner's centre, which is convex along a profile: the stretch has no gap.
pub fn lowest_stretch(profile: &[EdgePlace], cosine: f64, thickness: f64) -> Stretch {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let height = |p: &EdgePlace| p.z * cosine - p.rho * sine;
    let lowest = profile.iter().map(height).fold(f64::INFINITY, f64::min);
    let heights: Vec<f64> = profile.iter().map(|p| height(p) - lowest).collect();
    let [first, last] = effective(&heights, thickness);
    let end = profile.len().saturating_sub(1);
    Stretch {
        first: (first.floor() as usize).saturating_sub(1),
        last: ((last.ceil() as usize) + 1).min(end),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};
    use crate::texture::edge::Edge;
    use crate::tool::Tool;
    use std::f64::consts::FRAC_PI_2;

    const N: u32 = 200_000;

    /// Largest height above the contact at which a circle of radius `r` that touches the design at the origin from
    /// above lies in the material; `uncut`: the signed distance outside of it.
    fn brute(r: f64, uncut: impl Fn(f64, f64) -> f64) -> f64 {
        let angles = (0..=N).map(|i| f64::from(i) * 2.0 * FRAC_PI_2 / f64::from(N));
        let places = angles.map(|a| (r * sin(a), r - r * cos(a)));
        places.filter(|&(x, y)| uncut(x, y) <= 0.0).map(|(_, y)| y).fold(0.0, f64::max)
    }

    #[test]
    fn thickness_is_that_of_the_circles() {
        let (r, a_p, big) = (5.0, 0.2, 40.0);
        let plane = brute(r, |_, y| y - a_p);
        assert!((thickness(Shape::Plane, r, a_p).unwrap() - plane).abs() < 1e-4);
        let dome = brute(r, |x, y| (x * x + (y + big) * (y + big)).sqrt() - big - a_p);
        let convex = thickness(Shape::Convex, r, a_p).unwrap();
        assert!(dome <= convex && dome > 0.8 * convex, "{dome}");
        for least_radius in [5.5, 8.0, big, 1e7] {
            let bowl = brute(r, |x, y| {
                least_radius - a_p - (x * x + (y - least_radius) * (y - least_radius)).sqrt()
            });
            let found = thickness(Shape::Concave { least_radius }, r, a_p).unwrap();
            assert!((found - bowl).abs() < 2e-4, "{least_radius}: {found} {bowl}");
        }
        assert!(thickness(Shape::Concave { least_radius: 4.9 }, r, a_p).is_err());
        assert!(thickness(Shape::Concave { least_radius: f64::NAN }, r, a_p).is_err());
    }

    #[test]
    fn the_four_cases() {
        assert_eq!(effective(&[3.0, 1.0, 0.0, 1.0, 3.0], 2.0), [0.5, 3.5]);
        assert_eq!(effective(&[3.0, 1.0, 0.0], 2.0), [0.5, 2.0]);
        assert_eq!(effective(&[0.0, 1.0, 3.0], 2.0), [0.0, 1.5]);
        assert_eq!(effective(&[0.0, 1.0, 1.5], 2.0), [0.0, 2.0]);
        assert_eq!(effective(&[], 2.0), [0.0, 0.0]);
    }

    #[test]
    fn a_tilted_ball_cuts_where_brute_force_says() {
        let (r, thic, step) = (5.0, 0.2, 0.01);
        let edge = Edge::new(&Tool::new(r, r).unwrap(), 0.5);
        let count = (FRAC_PI_2 * r / step) as u32;
        let profile: Vec<_> = (0..=count).map(|k| edge.at(f64::from(k) * step)).collect();
        let a = untilted(thic, r)[1];
        assert!((r * (1.0 - cos(a)) - thic).abs() < 1e-12);
        for degrees in [0.0, 5.0, 15.0, 40.0, 80.0_f64] {
            let tilt = degrees.to_radians();
            // All angles of the spindle, by the position of the point.
            let comes_below = |p: &EdgePlace| {
                (0..720).any(|i| {
                    let turn = f64::from(i) * FRAC_PI_2 / 180.0;
                    r + p.z * cos(tilt) + p.rho * cos(turn) * sin(tilt) <= thic
                })
            };
            let first = profile.iter().position(comes_below).unwrap();
            let last = profile.iter().rposition(comes_below).unwrap();
            let found = lowest_stretch(&profile, cos(tilt), thic);
            assert!(
                found.first <= first && first - found.first <= 2,
                "{degrees} {found:?} {first}"
            );
            assert!(found.last >= last && found.last - last <= 2, "{degrees} {found:?} {last}");
            let low = ((tilt - a).max(0.0) * r / step) as usize;
            let high = (((tilt + a).min(FRAC_PI_2)) * r / step) as usize;
            assert!(found.first.abs_diff(low) <= 2 && found.last.abs_diff(high) <= 2);
        }
    }
}
