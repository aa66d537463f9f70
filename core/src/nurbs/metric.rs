//! How long an edge may be in each direction at a place.

use crate::geometry::DVec3;

/// Growth of the edge length with the distance. Larger makes worse triangles, smaller more.
pub(super) const GROWTH: f64 = 0.3;

/// Edges at a place: up to `wide` along one tangent, up to `narrow` across it.
///
/// The length that it gives an edge is 1 for one that is as long as allowed, so that a triangle
/// of even lengths is long along the way in which the surface bends least.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Metric {
    /// Longest edge across `along`, mm.
    pub narrow: f64,
    /// Longest edge along `along`, mm; `narrow` at least.
    pub wide: f64,
    /// Unit tangent.
    pub along: DVec3,
    /// Square of the length of an edge of 1 mm across `along`, and how much less it is along it.
    across: f64,
    less: f64,
}

impl Metric {
    /// Edges up to `wide` mm along a unit tangent, up to `narrow` mm across it.
    pub fn new(narrow: f64, wide: f64, along: DVec3) -> Self {
        let across = 1.0 / (narrow * narrow);
        Self { narrow, wide, along, across, less: across - 1.0 / (wide * wide) }
    }

    /// Square of the length of an edge, of its allowed length.
    pub fn square(&self, edge: DVec3) -> f64 {
        let way = edge.dot(self.along);
        (self.across * edge.length_squared() - self.less * way * way).max(0.0)
    }

    /// Length of an edge, of its allowed length.
    pub fn length(&self, edge: DVec3) -> f64 {
        self.square(edge).sqrt()
    }

    /// The same with lengths multiplied by `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        Self::new(factor * self.narrow, factor * self.wide, self.along)
    }

    /// No longer than what may have grown from `other`, `distance` mm away.
    pub fn near(self, other: &Self, distance: f64) -> Self {
        let growth = GROWTH * distance;
        let narrow = self.narrow.min(other.narrow + growth);
        Self::new(narrow, self.wide.min(other.wide + growth).max(narrow), self.along)
    }
}

/// Shape of a triangle from the squares of its lengths: 1 for an equilateral one, 0 for a needle.
///
/// # Source
/// Heron's formula for `16 A²`.
pub(super) fn shape([a, b, c]: [f64; 3]) -> f64 {
    let sum = a + b + c;
    let area = (2.0 * (a * b + b * c + c * a) - (a * a + b * b + c * c)).max(0.0);
    if sum > 0.0 { (3.0 * area).sqrt() / sum } else { 0.0 }
}
