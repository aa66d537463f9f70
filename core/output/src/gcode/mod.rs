//! G-code → path in the workpiece, and what is wrong with a program.
//!
//! Terms. A *block* is a line; a *word* is a letter and a number; a *code* is a G or M word. *Modal*
//! is what stays in force until it is changed. *Machine coordinates* are the positions that the
//! program commands; *workpiece coordinates* those of the tip on the turned table, the same on
//! three axes.
//!
//! Steps: lines become blocks; codes change the modal state; words of axes become moves; arcs and
//! turning moves become chords; what the controller would do is judged without the path that was
//! written.
//!
//! Assumed: the tip is programmed (G43 changes nothing), one work offset and one cutter, absolute
//! millimetres per minute in the plane G17 until the program says otherwise, rotary axes at 0 until
//! they move.
//!
//! | file | what |
//! |---|---|
//! | `scanner` | which format a program has |
//! | `block`, `heidenhain`, `cldata` | a line → its words; the last two into those that a block would have |
//! | `codes` | what a code changes, or why it is refused |
//! | `arc` | end, centre or radius, turns → circle, helix |
//! | `kinematics` | machine ↔ workpiece coordinates |
//! | `motion` | a move → chords |
//! | `interpret` | blocks → path |
//! | `check` | findings |
//! | `follow` | whether a program is the path that it was written from, with the job's settings |
//! | `setting` | tool, offsets, spindle and coolant |
//! | `options`, `program`, `error` | what is asked, what was read, why not |
//!
//! Source: Kramer, Proctor, Messina, "The NIST RS274/NGC Interpreter, Version 3" (2000); LinuxCNC's
//! documentation where it goes further (G64, G90.1, turns of an arc).

mod arc;
mod block;
mod check;
mod cldata;
mod codes;
mod error;
mod follow;
mod heidenhain;
mod interpret;
mod kinematics;
mod motion;
mod options;
mod program;
mod scanner;
mod setting;

#[cfg(test)]
mod tests;

pub use check::{CheckOptions, check};
pub use error::{Fault, GcodeError};
pub use follow::{Following, differs, leaves};
pub use interpret::read;
pub use kinematics::MachinePosition;
pub use options::ReadOptions;
pub use program::{Finding, FindingKind, GcodeProgram, Move};
pub use setting::Setting;
