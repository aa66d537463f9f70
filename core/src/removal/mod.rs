//! The true removal rate of the delivered path, and feeds set by it.
//!
//! The plane engine ([`crate::engagement`]) models the cutter as a disc around the contact that removes the whole
//! layer. But a ball leaves cusps and meets the layer in a smaller circle, and a flat or bull end that is inclined to
//! the surface touches with its edge while its body stands beside the contact. Here the body itself runs along the
//! delivered path through columns of material on the surface.
//!
//! - *Layer*: the material, from the allowance up to allowance plus axial depth along the normals.
//! - *Column*: a small area of the surface with the height that is left of the layer.
//! - *Stock*: the layer, less what earlier paths removed of it.
//! - *Piece*: a tenth of a cutter radius of a move, or less where the axis turns.
//!
//! Steps: columns are placed (`columns`); the path cuts them piece by piece (`sweep`, with the cutter in `body`);
//! feeds follow from what a window of pieces removes (`rates`); what is left at the end is the coverage (`coverage`),
//! compared with the cusps that are meant to stay (`cusp`). What earlier paths have cut is not there any more (`stock`). Where only the coverage is needed, most columns need not
//! be swept (`remains`).

mod body;
mod columns;
mod coverage;
mod cusp;
mod rates;
mod remains;
mod stock;
mod sweep;
#[cfg(test)]
mod tests;

pub(crate) use body::Line;
pub use body::{Cutter, Layer};
pub use columns::Columns;
pub(crate) use coverage::FeedIndex;
pub use coverage::{Access, Coverage, Place, coverage};
pub use cusp::{Lean, cusp, worst_cusp};
pub use rates::{Beyond, CLOSEST, Feeds, Limit, TooSlow, beyond, excesses, rated};
pub(crate) use remains::{Stage, Strokes};
pub(crate) use stock::Before;
pub use stock::{Earlier, Stock};
pub use sweep::{Piece, Removed};
