//! What a program is made of, and what is made.

use crate::machine::{Machine, Post};
use crate::tool::Tool;

/// What a program needs beside the path.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramOptions {
    /// The dialect.
    pub post: Post,
    /// Name of the job, for a comment.
    pub name: String,
    /// The machine.
    pub machine: Machine,
    /// Machine Z at and above which rapids run, mm: the top of part and stock, in any position of the
    /// tables, and the machine's clearance above it.
    pub rapid_plane: f64,
    /// The cutter.
    pub tool: Tool,
    /// Its number in the tool table.
    pub tool_number: u32,
    /// Spindle speed, rev/s.
    pub spindle: f64,
    /// Path tolerance, mm: blending on the machine, and half of it for interpolation between rotary
    /// positions.
    pub tolerance: f64,
}

/// A program.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// The text, ASCII, lines ended by a line feed.
    pub text: String,
    /// Customary extension of its file.
    pub extension: &'static str,
}
