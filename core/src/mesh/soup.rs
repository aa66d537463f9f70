//! Triangles before anything is known of them.

use crate::geometry::{DVec2, DVec3};

/// Triangles as a file gives them: nothing welded, nothing judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSoup {
    /// `#V` vertex positions, in the file's units.
    pub positions: Vec<DVec3>,
    /// `#F` triples of vertex indices, each below `#V`.
    pub faces: Vec<[u32; 3]>,
    /// Texture coordinates of the three corners of every face, when every face carries them.
    pub texture: Option<Vec<[DVec2; 3]>>,
}

impl TriangleSoup {
    /// Adds the triangles of another; texture coordinates remain where both have them.
    pub fn add(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.faces.extend(other.faces.iter().map(|face| face.map(|v| v + first)));
        self.texture = self.texture.take().zip(other.texture).map(|(mut all, more)| {
            all.extend(more);
            all
        });
    }
}
