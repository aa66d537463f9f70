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
