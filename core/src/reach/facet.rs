//! Triangles.

use crate::geometry::DVec3;

/// Normal of a triangle, twice its area long.
pub(super) fn area_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
