//! What a program is made of, and what is made.

use evencut_core::machine::{Machine, Setup};
use evencut_core::tool::Tool;
use evencut_core::toolpath::Toolpath;

/// What a program needs beside the path.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramOptions {
    /// Name of the job, for a comment.
    pub name: String,
    /// The machine.
    pub machine: Machine,
    /// Machine Z at and above which rapids run, mm: the top of part and stock, in any position of the
    /// tables, and the machine's clearance above it.
    pub rapid_plane: f64,
    /// The cutter.
    pub tool: Tool,
    /// Numbers of program, cutter and offsets; coolant; direction of the spindle.
    pub setup: Setup,
    /// Spindle speed, rev/s.
    pub spindle: f64,
    /// Path tolerance, mm: blending on the machine, and half of it for interpolation between rotary
    /// positions.
    pub tolerance: f64,
}

/// An operation of a program of several.
#[derive(Clone, Debug)]
pub struct OperationProgram<'a> {
    /// Its name, for a comment.
    pub name: String,
    /// Its path.
    pub path: &'a Toolpath,
    /// What it needs beside the path.
    pub options: ProgramOptions,
}

/// A program.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// The text, ASCII, lines ended by a line feed.
    pub text: String,
    /// Customary extension of its file.
    pub extension: String,
}
