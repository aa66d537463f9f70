//! The machine: its axes and what they can do.

mod arrangement;
mod chain;
mod limits;
mod post;
mod tables;

pub use arrangement::Arrangement;
pub(crate) use chain::between;
pub use chain::{Angles, Carries, Chain, ChainError, RotaryAxis};
pub use limits::{Axes, LONGEST_TRAVEL, Machine, Travel};
pub use post::{Coolant, Post, Setup, SpindleDirection, WorkOffset};
pub(crate) use tables::{Leg, Tables};
