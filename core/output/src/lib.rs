//! What evencut writes about a plan: machine programs, which it reads back, reports and pictures.
//!
//! All of it is made of paths, surfaces and figures; none of it knows the planner or the job file. Bytes go in and
//! out: it opens no file, reads no clock and no environment, and prints nothing.
#![forbid(unsafe_code)]

pub mod gcode;
pub mod post;
pub mod preview;
pub mod report;
