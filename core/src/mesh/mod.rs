//! Triangle meshes: files → raw triangles → repaired and judged faces → half-edge connectivity.

mod connectivity;
mod edges;
mod judge;
mod read;
pub(crate) mod repair;
mod weld;

pub use connectivity::{Connectivity, FaceId, HalfEdgeId, TopologyFault, VertexId};
pub use judge::{ComponentSummary, Judgement, Occurrences, judge};
pub(crate) use judge::{component_of, nonmanifold_vertices};
pub use read::{MeshFormat, Place, ReadError, read};
pub use repair::{Repaired, Repairs, repair};

use crate::geometry::DVec2;
use crate::geometry::DVec3;

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
