//! What every front end asks for: the command, the page, and whoever comes next.
//!
//! | module | takes → gives |
//! |---|---|
//! | [`results`] | `Job` + bytes → files of its results; also the numbers behind the pictures, and what is there before the end |
//! | [`compare`] | `Job` + patterns, divisions, or tilts and feeds per tooth → a table |
//! | [`verdict`] | table or program + mesh → the judge's report and pictures |
//! | [`new_job`] | what a mesh holds → what a job for it starts from |
//! | [`faults`], [`failure`] | what is wrong with a job or its planning → message, place in the job file, remedy, exit code |
//! | [`stages`] | stages of planning in words |
//!
//! As the core it takes bytes and returns values: it opens no file, reads no clock and no environment, and prints nothing.

pub mod compare;
pub mod failure;
pub mod faults;
pub mod new_job;
pub mod results;
pub mod stages;
pub mod verdict;
