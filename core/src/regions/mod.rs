//! Regions: a surface divided along lines, and passes laid on every piece of it.
//!
//! - *Sheet*: the faces of the surface with the lines cut into them (`sheet`, `lines`).
//! - *Piece*: connected faces between lines, a disk or a disk with holes (`pieces`).
//! - *Ground*: a piece refined to carry a field of passes (`ground`).
//! - *Layout*: the passes on a ground (`layout`).
//!
//! 1. The lines come from the map's distortion (`distortion`); [`Regions::along`] takes any others.
//! 2. They are cut in; pieces too small go to a neighbour.
//! 3. Every piece gets its passes; along inner borders the outermost ones run half a strip inside, less
//!    half of the blend, so that the strips of both pieces meet and overlap by the blend.
//! 4. Open passes are shifted so that those of neighbours fit (`offsets`), and go on beyond inner borders as
//!    far as neighbours leave something (`joints`).
//! 5. The pieces are put in order.
//!
//! Path and cutter locations stay those of the one surface and its one chart: sheet and surface are the
//! same set of points.
//!
//! Source: spec 04 and 05.

pub mod distortion;
mod divided;
mod division;
mod ground;
mod joints;
mod layout;
mod lines;
mod offsets;
mod options;
mod order;
mod pieces;
mod sheet;
pub mod tensor;
mod terrain;

pub use distortion::{Evenness, Stretch};
pub use divided::{Divided, PartFigures, Undivided};
pub use division::{Part, Regions};
pub use ground::{Ground, grounds};
pub use layout::{Layout, Spacing, even_share, lay_out};
pub use options::LayoutOptions;
pub use order::{in_order, neighbours};
pub use pieces::Piece;
pub use sheet::{Mean, Sheet};
pub use terrain::JointTerrain;
