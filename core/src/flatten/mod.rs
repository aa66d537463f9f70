//! Conformal flattening: surface → [`Chart`].

mod abf;
mod angle_layout;
mod bff;
mod caps;
mod chart;
mod curve;
mod disk;
mod distortion;
mod error;
mod intrinsic;
#[cfg(test)]
mod known_charts;
mod laplace;
mod locator;
#[cfg(test)]
mod real_meshes;
#[cfg(test)]
pub(crate) mod samples;
mod unfold;
mod validity;

pub use abf::{AngleBased, abf, abf_unchecked};
pub use bff::{bff, bff_unchecked};
pub use chart::Chart;
pub use disk::outer_loop;
pub use distortion::{Distortion, Quality};
pub use error::{FlattenError, OutsideChart};
pub use locator::{FaceTree, Locator};
pub use unfold::unfolded;
