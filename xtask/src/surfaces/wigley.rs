//! Half of Wigley's parabolic hull, laid on its centre plane.

use super::lifted;
use crate::triangulate::{Domain, triangulate};
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::mesh::TriangleSoup;

const LENGTH: f64 = 400.0;
/// Full breadth, a tenth of the length as usual; the half hull is half as high.
const BREADTH: f64 = 40.0;
/// Twice the usual sixteenth of the length, so that no place is steeper than 39 degrees.
const DRAUGHT: f64 = 50.0;
const SPACING: f64 = 2.0;

/// `y = (B/2) (1 - (2x/L)²) (1 - (z/T)²)` with the breadth laid along +Z.
///
/// # Source
/// Wigley, "A comparison of experiment and calculated wave profiles and wave resistances for a
/// form having parabolic waterlines", Proc. Royal Society A 144 (1934).
pub fn half_hull() -> Result<TriangleSoup, String> {
    let low = DVec2::new(-LENGTH / 2.0, -DRAUGHT);
    let domain = Domain::rectangle(low, DVec2::new(LENGTH / 2.0, 0.0), SPACING);
    let plane = triangulate(&domain, SPACING)?;
    Ok(lifted(&plane, |p| {
        let (along, deep) = (2.0 * p.x / LENGTH, p.y / DRAUGHT);
        let half_breadth = BREADTH / 2.0 * (1.0 - along * along) * (1.0 - deep * deep);
        DVec3::new(p.x, p.y, half_breadth)
    }))
}
