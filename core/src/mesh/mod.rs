//! Triangle meshes: files → raw triangles → repaired and judged faces → half-edge connectivity.

mod connectivity;
mod edges;
mod judge;
mod read;
pub(crate) mod repair;
mod soup;
mod weld;

pub use connectivity::{Connectivity, FaceId, HalfEdgeId, TopologyFault, VertexId};
pub use judge::{ComponentSummary, Judgement, Occurrences, judge};
pub(crate) use judge::{component_of, nonmanifold_vertices};
pub use read::{MeshFormat, Place, ReadError, read};
pub use repair::{Repaired, Repairs, repair};
pub use soup::TriangleSoup;
