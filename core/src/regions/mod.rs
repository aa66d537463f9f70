//! Regions: a surface divided along lines, with passes laid out on every piece.
//!
//! - *Split mesh*: the faces of the surface with the lines cut into them (`split_mesh`, `lines`).
//! - *Piece*: connected faces between lines, a disk or a disk with holes (`pieces`).
//! - *Region mesh*: a piece refined until it resolves a field of passes (`region_mesh`).
//! - *Layout*: the passes on a region mesh (`layout`).
//!
//! 1. The lines come from the map's distortion (`distortion`); [`Regions::along`] takes any others.
//! 2. They are inserted into the mesh; pieces that are too small are merged into a neighbour.
//! 3. Passes are laid out on every piece; along inner borders the outermost ones run half a strip inside, less half
//!    of the blend, so that the strips of both pieces meet and overlap by the blend.
//! 4. Open passes are shifted so that those of neighbouring pieces match (`offsets`), and continue beyond inner
//!    borders where the neighbours leave material (`joints`).
//! 5. The order of the pieces is chosen.
//!
//! Path and cutter locations still refer to the one surface and its one chart: split mesh and surface are the same
//! set of points.

pub mod distortion;
mod divided;
mod division;
mod joints;
mod layout;
mod lines;
mod offsets;
mod options;
mod order;
mod pieces;
mod region_mesh;
mod split_mesh;
pub mod tensor;
mod terrain;

pub use distortion::{Evenness, Stretch};
pub use divided::{Divided, PartFigures, Undivided};
pub use division::{Region, Regions};
pub use layout::{Layout, Spacing, even_share, lay_out};
pub use options::LayoutOptions;
pub use order::{in_order, neighbours};
pub use pieces::Piece;
pub use region_mesh::{RegionMesh, region_meshes};
pub use split_mesh::{Mean, SplitMesh};
pub use terrain::JointTerrain;
