//! The machine: its axes and what they can do.

mod limits;
mod post;
mod tables;
mod xyzac;

pub use limits::{Axes, Machine, Travel};
pub use post::{Coolant, Post, Setup, SpindleDirection, WorkOffset};
pub(crate) use tables::{Leg, Tables};
pub(crate) use xyzac::Rotary;
