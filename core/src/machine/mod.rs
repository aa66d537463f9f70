//! The machine: its axes and what they can do.

mod limits;
mod post;
mod tables;
mod xyzac;

pub use limits::{Axes, Machine, Travel};
pub use post::Post;
pub(crate) use tables::{Leg, Tables};
pub(crate) use xyzac::Rotary;
