//! The machine: its axes and what they can do.

mod limits;
mod tables;
mod xyzac;

pub use limits::{Axes, Machine, Travel};
pub(crate) use tables::{Leg, Tables};
pub(crate) use xyzac::Rotary;
