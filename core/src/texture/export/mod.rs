//! Files of a height map.
//!
//! - `csv`: one line per node, `x_mm,y_mm,z_um`.
//! - `asc`: a matrix with a header, which SurfaceTopography, Gwyddion and others read; a line is a line of nodes along the
//!   feed.
//! - `x3p`: the container of ISO 25178-72.
//!
//! Heights are those over the nominal form as simulated, mean plane included. Nodes stand at even steps, the mean lengths
//! of the grid's cells: on a curved surface the map is laid flat. Nodes beyond the surface, and those that nothing cut, have no height:
//! an empty field, `nan`, and the NaN that X3P has for points that are not valid.

mod matrix;
mod text;
mod x3p;

pub use matrix::Matrix;
pub use text::{MICRO, asc, csv};
pub use x3p::{X3pError, x3p};
