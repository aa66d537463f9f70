//! Plans milling paths for freeform surfaces so that the cut is even and the cusps are even.
//!
//! A job passes through a short row of named values; each has one home module:
//! [`job::Job`] → [`surface::Surface`] → [`flatten::Chart`] → rings → [`toolpath::Toolpath`] →
//! program. The crate takes bytes and returns values: it opens no file, reads no clock and no
//! environment, and prints nothing.
#![forbid(unsafe_code)]

pub mod geometry;
pub mod linalg;
pub mod mesh;
pub mod parallel;
pub mod units;

pub mod footprint;
pub mod load;
pub mod machine;
mod strips;
pub mod tool;

pub mod job;

pub mod nurbs;

pub mod surface;

pub mod step;

pub mod flatten;

pub mod outline;
pub mod regions;

pub mod toolpath;

mod centring;
pub mod flat_path;

pub mod level_set;

pub mod pattern;

pub mod engagement;

pub mod trochoid;

pub mod cutter_location;
pub mod reach;
pub mod walls;

pub mod removal;

pub mod lift;

pub mod machine_time;

pub mod hub;

pub mod link;

mod rest;

pub mod verify;

pub mod texture;

pub mod plan;

#[cfg(test)]
mod shared_data;
