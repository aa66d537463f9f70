//! Passes → one path in cutting order: reach a pass, cut it, go on to the next.
//!
//! | file | what |
//! |---|---|
//! | `order` | which passes must be cut before which |
//! | `group` | the passes of a region |
//! | `lay` | plain passes, ignoring the removal rate |
//! | `cut` | rings with trochoids where the rate requires them |
//! | `excess` | where paths exceed the limit in the simulation |
//! | `deliver` | flat path → `Toolpath` with leads and retracts |
//!
//! *Reach*: on the surface when the straight line is inside the region and the cut on it can be kept below the limit,
//! otherwise by retract, rapid and approach.

mod cut;
mod deliver;
mod excess;
mod group;
mod lay;
mod order;

pub use cut::{CutOptions, Measured, cut_passes};
pub use deliver::{DeliverError, DeliverOptions, Delivered, Deliverer, OnSurface, rapid_steps};
pub use excess::Excess;
pub use group::Group;
pub(crate) use group::oriented;
pub use lay::{LayOptions, lay};
pub use order::Precedence;
