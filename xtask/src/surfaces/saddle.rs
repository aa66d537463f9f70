//! Hyperbolic paraboloid with a circular island.

use super::lifted;
use crate::triangulate::{Domain, circle, subdivided, triangulate};
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::mesh::TriangleSoup;

const SIZE: DVec2 = DVec2::new(110.0, 80.0);
/// Radius of curvature at the centre, mm, along X (concave) and along Y (convex).
const RADIUS: f64 = 180.0;
/// Off centre, so that the rings round the island meet those of the border askew.
const ISLAND: DVec2 = DVec2::new(12.0, -6.0);
const ISLAND_RADIUS: f64 = 14.0;
const SPACING: f64 = 1.3;

/// `z = (x² - y²) / (2 r)` on a rectangle around an island that stays.
///
/// # Source
/// Hilbert and Cohn-Vossen, "Geometry and the Imagination" (1952), section 3: the hyperbolic
/// paraboloid.
pub fn patch_with_island() -> Result<TriangleSoup, String> {
    let half = SIZE / 2.0;
    let corners = [-half, DVec2::new(half.x, -half.y), half, DVec2::new(-half.x, half.y)];
    let domain = Domain {
        outer: subdivided(&corners, SPACING),
        holes: vec![circle(ISLAND, ISLAND_RADIUS, SPACING)],
    };
    let plane = triangulate(&domain, SPACING)?;
    Ok(lifted(&plane, |p| DVec3::new(p.x, p.y, (p.x * p.x - p.y * p.y) / (2.0 * RADIUS))))
}
