//! Passes → one path in cutting order: reach a pass, cut it, go on to the next.
//!
//! | file | what |
//! |---|---|
//! | `order` | which passes must be cut before which |
//! | `group` | the passes of a region |
//! | `lay` | plain passes, ignoring the removal rate |
//! | `course` | a pass cut in trial: stretches above the limit, ways to them |
//! | `cut` | passes with trochoids where the rate requires them |
//! | `follow` | the same for open passes, as they were laid |
//! | `excess` | where paths exceed the limit in the simulation |
//! | `deliver` | flat path → `Toolpath` with leads and retracts |
//!
//! *Reach*: on the surface when the straight line is inside the region and the cut on it can be kept below the limit,
//! otherwise by retract, rapid and approach.

mod course;
mod cut;
mod deliver;
mod excess;
mod follow;
mod group;
mod lay;
mod order;

pub use course::{CutOptions, Measured};
pub use cut::cut_passes;
pub use deliver::{DeliverError, DeliverOptions, Delivered, Deliverer, OnSurface, rapid_steps};
pub use excess::Excess;
pub use group::Group;
pub(crate) use group::oriented;
pub use lay::{LayOptions, lay};
pub use order::Precedence;
