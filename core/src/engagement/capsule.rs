//! The area that one straight move of the cutter disc sweeps in the plane.

use crate::geometry::DVec2;

/// The convex hull of two discs: the cutter disc at both ends of a straight move, its radius
/// changing linearly with the map's scale.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Capsule {
    start: DVec2,
    axis: DVec2,
    length: f64,
    start_radius: f64,
    end_radius: f64,
    /// Sine and cosine of the angle between axis and sides; cosine 0 when one disc holds the other.
    taper: (f64, f64),
}

impl Capsule {
    /// The hull of the disc about `start` and the one about `end`; radii positive, flat mm.
    pub fn new(start: DVec2, start_radius: f64, end: DVec2, end_radius: f64) -> Self {
        let length = (end - start).length();
        let sine = if length > 0.0 { (start_radius - end_radius) / length } else { 2.0 };
        if sine.abs() >= 1.0 {
            let (center, radius) =
                if start_radius >= end_radius { (start, start_radius) } else { (end, end_radius) };
            return Self {
                start: center,
                axis: DVec2::X,
                length: 0.0,
                start_radius: radius,
                end_radius: radius,
                taper: (0.0, 0.0),
            };
        }
        let taper = (sine, (1.0 - sine * sine).sqrt());
        Self { start, axis: (end - start) / length, length, start_radius, end_radius, taper }
    }

    /// Signed distance of `p` from the hull's outline, negative inside.
    pub fn signed_distance(&self, p: DVec2) -> f64 {
        let offset = p - self.start;
        if self.length == 0.0 {
            return offset.length() - self.start_radius;
        }
        let along = offset.dot(self.axis);
        let across = offset.perp_dot(self.axis).abs();
        let foot = (along - across * self.taper.0 / self.taper.1).clamp(0.0, self.length);
        let foot_radius =
            self.start_radius + (self.end_radius - self.start_radius) * foot / self.length;
        ((along - foot) * (along - foot) + across * across).sqrt() - foot_radius
    }

    /// Whether `p` lies in the hull.
    pub fn contains(&self, p: DVec2) -> bool {
        let offset = p - self.start;
        if self.length == 0.0 {
            return offset.length_squared() <= self.start_radius * self.start_radius;
        }
        let along = offset.dot(self.axis);
        let across = offset.perp_dot(self.axis).abs();
        let foot = (along - across * self.taper.0 / self.taper.1).clamp(0.0, self.length);
        let foot_radius =
            self.start_radius + (self.end_radius - self.start_radius) * foot / self.length;
        (along - foot) * (along - foot) + across * across <= foot_radius * foot_radius
    }

    /// Largest radius.
    pub fn radius(&self) -> f64 {
        self.start_radius.max(self.end_radius)
    }

    /// Calls `visit` with every point where the circle may cross the hull's outline.
    ///
    /// Points of the two discs and two sides that are not on the outline are included.
    pub fn crossings(&self, center: DVec2, radius: f64, mut visit: impl FnMut(DVec2)) {
        circle_circle(center, radius, self.start, self.start_radius, &mut visit);
        if self.length == 0.0 {
            return;
        }
        let end = self.start + self.axis * self.length;
        circle_circle(center, radius, end, self.end_radius, &mut visit);
        let (sine, cosine) = self.taper;
        for side in [-1.0, 1.0] {
            let normal = self.axis * sine + self.axis.perp() * (side * cosine);
            let along = normal.perp() * -side;
            let distance = (center - self.start).dot(normal) - self.start_radius;
            let foot = center - normal * distance;
            if distance.abs() <= radius {
                let half = (radius * radius - distance * distance).sqrt();
                visit(foot + along * half);
                visit(foot - along * half);
            }
        }
    }
}

/// Calls `visit` with the points common to two circles.
fn circle_circle(a: DVec2, ra: f64, b: DVec2, rb: f64, visit: &mut impl FnMut(DVec2)) {
    let between = b - a;
    let square = between.length_squared();
    if square == 0.0 || square > (ra + rb) * (ra + rb) || square < (ra - rb) * (ra - rb) {
        return;
    }
    let along = 0.5 * (1.0 + (ra * ra - rb * rb) / square);
    let across = (ra * ra / square - along * along).max(0.0).sqrt();
    let foot = a + between * along;
    visit(foot + between.perp() * across);
    visit(foot - between.perp() * across);
}

/// Calls `visit` with the points where a circle crosses the segment from `a` to `b`.
pub(super) fn circle_segment(
    center: DVec2,
    radius: f64,
    a: DVec2,
    b: DVec2,
    mut visit: impl FnMut(DVec2),
) {
    let (side, offset) = (b - a, a - center);
    let (qa, qb, qc) =
        (side.length_squared(), offset.dot(side), offset.length_squared() - radius * radius);
    let discriminant = qb * qb - qa * qc;
    if qa == 0.0 || discriminant < 0.0 {
        return;
    }
    let root = discriminant.sqrt();
    for t in [(-qb - root) / qa, (-qb + root) / qa] {
        if (0.0..=1.0).contains(&t) {
            visit(a + side * t);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_capsule_has_round_ends() {
        let c = Capsule::new(DVec2::ZERO, 1.0, DVec2::new(4.0, 0.0), 1.0);
        assert!((c.signed_distance(DVec2::new(2.0, 3.0)) - 2.0).abs() < 1e-15);
        assert!((c.signed_distance(DVec2::new(7.0, 0.0)) - 2.0).abs() < 1e-15);
        assert!(c.contains(DVec2::new(-0.9, 0.1)) && !c.contains(DVec2::new(-0.9, 0.9)));
    }

    #[test]
    fn tapered_capsule_is_the_union_of_its_discs() {
        let (a, ra, b, rb) = (DVec2::new(1.0, 2.0), 1.5, DVec2::new(4.0, 3.0), 0.5);
        let capsule = Capsule::new(a, ra, b, rb);
        for i in 0..40 {
            for j in 0..40 {
                let p = DVec2::new(-1.0 + 0.17 * i as f64, 0.17 * j as f64);
                let nearest = (0..=4000)
                    .map(|k| {
                        let t = k as f64 / 4000.0;
                        (p - a.lerp(b, t)).length() - (ra + t * (rb - ra))
                    })
                    .fold(f64::INFINITY, f64::min);
                assert!((capsule.signed_distance(p) - nearest).abs() < 5e-4, "{p}");
            }
        }
    }

    #[test]
    fn crossings_lie_on_the_circle_and_the_outline_is_among_them() {
        let capsule = Capsule::new(DVec2::ZERO, 1.0, DVec2::new(3.0, 0.0), 2.0);
        let mut on_outline = 0;
        capsule.crossings(DVec2::new(1.0, 2.0), 1.3, |p| {
            assert!(((p - DVec2::new(1.0, 2.0)).length() - 1.3).abs() < 1e-12);
            on_outline += usize::from(capsule.signed_distance(p).abs() < 1e-12);
        });
        assert_eq!(on_outline, 2);
    }
}
