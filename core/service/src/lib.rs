//! The operations that every front end needs: the command line, the page, and any other.
//!
//! | module | takes → gives |
//! |---|---|
//! | [`results`] | `Job` + bytes → files of its results; also the numbers behind the pictures, and early results |
//! |  | several operations → files of each, one program, one report |
//! | [`compare`] | `Job` + patterns, divisions, or tilts and feeds per tooth → a table |
//! | [`verdict`] | table or program + mesh → report and pictures of the verification |
//! | [`new_job`] | a surface file → what it holds, and a job file to start from |
//! | [`faults`], [`failure`] | what is wrong with a job or its planning → message, place in the job file, remedy, exit code |
//! | [`stages`] | names of the stages of planning |
//!
//! Like the core it takes bytes and returns values: it opens no file, reads no clock and no environment, and prints
//! nothing.

pub mod blisk;
pub mod compare;
pub mod failure;
pub mod faults;
pub mod new_job;
pub mod results;
pub mod stages;
pub mod verdict;
