//! Engagement of the cutter in the flat plane and the removal rate that follows from it.
//!
//! - *Stock*: the region minus what was swept before.
//! - *Leading half circle*: the part of the cutter circle that faces the feed.
//! - *Engaged arc*: the part of the leading half circle that is in stock.
//!
//! With `alpha` the engaged angle and `V_fc` the mean feed component normal to the engaged arc,
//! `MRR3 = R alpha V_fc H` and `alpha V_fc = V_f * integral of cos(theta) over the engaged arc`.
//!
//! Source: "Trajectory planning for constant-force milling of freeform surfaces based on conformal mapping",
//! a Chinese patent application: the disc in the plane.

mod arc;
mod capsule;
mod prediction;
mod simulation;
mod swept;

pub use arc::Engagement;
pub use capsule::Capsule;
pub use prediction::predicted;
pub use simulation::{Cutting, Mark, Simulation};
pub use swept::{Checkpoint, Stock};

#[cfg(test)]
mod tests;
