//! Where a picture shows the places of the part.

use evencut_core::geometry::DVec3;

/// Where a picture shows a place, px: `x`, `y` and the nearness to the viewer are each the sum of
/// the place's coordinates times the first three numbers, and the last.
///
/// Places of the flat map have two coordinates and the third zero; of all others, three.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Placement {
    /// To the right.
    pub x: [f64; 4],
    /// Downward.
    pub y: [f64; 4],
    /// Toward the viewer.
    pub near: [f64; 4],
    /// Upper left corner, width and height of what is drawn of the part, px; legends lie beside it.
    pub drawing: [f64; 4],
}

impl Placement {
    /// Where a place is shown, px from the left and from the top.
    pub fn place(&self, p: DVec3) -> [f64; 2] {
        [self.x, self.y].map(|[a, b, c, d]| DVec3::new(a, b, c).dot(p) + d)
    }
}
