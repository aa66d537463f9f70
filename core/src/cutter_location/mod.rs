//! Cutter contact → cutter location: where the tip must be for the cutter to touch the surface at a point, and how
//! far it must be lifted to clear the rest of the part.

mod above;
mod axis;
mod check_mesh;
mod clearance;
mod drop;
mod error;
mod obstacles;
mod options;
mod pass;
mod probe;
mod ruling;
mod solid;
mod standing;
mod tilt;
mod tip;
mod upright;

pub use above::{AboveEnd, KeptClear};
pub use axis::{ToolAxis, tool_axis};
pub use check_mesh::CheckMesh;
pub use clearance::{Clearance, Hindrance, clearance, clearance_above_end, nearest_place};
pub(crate) use clearance::{Pose, Solid, above_end, is_clear};
pub use error::LocateError;
pub use obstacles::{Avoided, Obstacles};
pub use options::PassOptions;
pub use pass::{Contact, LiftedSpan, Located, LocatedPass, facet_error, locate_pass};
pub use probe::{is_in_wall, is_way_clear, lowest_off_walls, raise_at, standing_clear};
pub use ruling::{Pushed, Ruling, Rulings, Stand};
pub use standing::Standing;
pub use tilt::tool_axes;
pub use tip::{contact_offset, is_level, tip};
pub use upright::{Landing, Upright};
