//! Places on a surface.

use crate::mesh::FaceId;

/// A point on the surface: a face and barycentric coordinates that sum to 1.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The face.
    pub face: FaceId,
    /// Weights of its three vertices.
    pub weights: [f64; 3],
}
