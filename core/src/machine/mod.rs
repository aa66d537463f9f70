//! The machine: its axes and what they can do.

mod arrangement;
mod chain;
mod limits;
mod post;
mod tables;

pub use arrangement::Arrangement;
pub use chain::{Angles, Carries, Chain, ChainError, RotaryAxis, between};
pub use limits::{Axes, LONGEST_TRAVEL, Machine, Travel};
pub use post::{Coolant, Post, Setup, SpindleDirection, WorkOffset};
pub use tables::{Leg, Place, Tables};
