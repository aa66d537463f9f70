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
//! | `block` | a line → its words |
//! | `codes` | what a code changes, or why it is refused |
//! | `arc` | end, centre or radius, turns → circle, helix |
//! | `kinematics` | machine ↔ workpiece coordinates |
//! | `motion` | a move → chords |
//! | `interpret` | blocks → path |
//! | `check` | findings |
//!
//! Source: Kramer, Proctor, Messina, "The NIST RS274/NGC Interpreter, Version 3" (2000); LinuxCNC's
//! documentation where it goes further (G64, G90.1, turns of an arc).

mod arc;
mod block;
mod check;
mod codes;
mod interpret;
mod kinematics;
mod motion;

#[cfg(test)]
mod tests;

pub use check::{CheckOptions, check, check_text};
pub use kinematics::{Kinematics, MachinePosition};

use crate::geometry::DVec3;
use crate::toolpath::Toolpath;
use std::fmt;
use std::ops::Range;
use thiserror::Error;

/// How a program is read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// Rotary axes of the machine; three axes by default.
    pub kinematics: Kinematics,
    /// Largest distance of a chord from its arc, or from the way of the tip while the tables turn,
    /// mm; at least 1e-6. While they turn it also holds 50 mm up the tool, for the axis.
    pub chord_tolerance: f64,
    /// How much the radii at the two ends of an arc may differ, mm; more is a finding.
    pub arc_tolerance: f64,
    /// Speed of rapids, mm/s.
    pub rapid_feed: f64,
    /// Machine zero in the program's coordinates, mm: G53 is measured from it and G28 goes to it.
    /// `None`: where such moves lead is unknown, and they may only stand before and after the path.
    pub machine_zero: Option<DVec3>,
    /// Whether the switch "block delete" is on: blocks that start with `/` are left out.
    pub block_delete: bool,
    /// Most points of the path, each of about 250 bytes.
    pub max_points: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            kinematics: Kinematics::ThreeAxis,
            chord_tolerance: 0.001,
            arc_tolerance: 0.01,
            rapid_feed: 250.0,
            machine_zero: None,
            block_delete: false,
            max_points: 10_000_000,
        }
    }
}

/// A program, read.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct GcodeProgram {
    /// What the tip does, in the workpiece: feed moves are cuts, the rest rapids; pass, region, removal
    /// rate and engagement are 0; the normal is the axis. Starts at the first position known in full.
    ///
    /// Feeds are those of the tip in the workpiece: as programmed on three axes; while tables turn, its
    /// travel by the move's time. Moves without a feed have feed 0 and take no time.
    pub path: Toolpath,
    /// Line of every point, from 1.
    pub lines: Vec<u32>,
    /// Where the machine's axes stand at every point.
    pub machine: Vec<MachinePosition>,
    /// The moves, in order, also those before the path starts.
    pub moves: Vec<Move>,
    /// What reading alone shows to be wrong: arcs, the end.
    pub findings: Vec<Finding>,
}

impl GcodeProgram {
    /// The points of the path that a move made, its end last; none before the path starts.
    pub fn points_of(&self, index: usize) -> Range<usize> {
        let start = if index == 0 { 0 } else { self.moves[index - 1].end };
        start..self.moves[index].end
    }
}

/// A move of the program.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Move {
    /// Line of the program, from 1.
    pub line: u32,
    /// Whether at rapid speed.
    pub rapid: bool,
    /// One past the index of its last point in the path.
    pub end: usize,
    /// Feed in force: mm/min, or 1/min under inverse time.
    pub feed: Option<f64>,
    /// Whether that is inverse time.
    pub inverse_time: bool,
    /// How long it takes, s.
    pub duration: f64,
    /// Whether the spindle turns.
    pub spindle: bool,
    /// Lowest machine Z as far as known, mm.
    pub lowest: Option<f64>,
}

/// What is wrong with a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Line of the program, from 1; the first of several moves.
    pub line: u32,
    /// What it is about.
    pub kind: FindingKind,
    /// Measured value and rule.
    pub message: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "program, line {}: {}", self.line, self.message)
    }
}

/// What a finding is about.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// The ends of an arc lie on different radii.
    ArcRadius,
    /// A rapid below the clearance plane.
    LowRapid,
    /// A rapid that goes below the clearance plane while other axes move.
    DiagonalRapid,
    /// A move at feed without a feed.
    NoFeed,
    /// A feed above the machine's.
    FastFeed,
    /// A move at feed while the spindle stands.
    SpindleOff,
    /// A position that the machine cannot reach.
    Travel,
    /// The program does not end.
    NoEnd,
}

/// Why a program cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GcodeError {
    /// An option out of range.
    #[error("reading a program: {name} is {value}; it must be {rule}")]
    Option {
        /// Which.
        name: &'static str,
        /// As given.
        value: f64,
        /// The rule.
        rule: &'static str,
    },
    /// A block that is not understood or not followed.
    #[error("program, line {line}, \"{block}\": {fault}")]
    Block {
        /// Line, from 1.
        line: u32,
        /// Its text, cut short.
        block: String,
        /// What is wrong with it.
        fault: Fault,
    },
}

/// What is wrong with a block.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// Not a letter and a number.
    #[error("\"{0}\" is not a word; a word is a letter and a decimal number")]
    Word(String),
    /// A comment without its end.
    #[error("a comment is opened and not closed; close it with \")\" on the same line")]
    Comment,
    /// A code or a construct that changes what the program means in a way not followed here.
    #[error("{word} is not read: {remedy}")]
    Refused {
        /// What was found.
        word: String,
        /// What it is, and what to do instead.
        remedy: &'static str,
    },
    /// An axis that the kinematics do not have.
    #[error(
        "{0} moves a rotary axis that {1} does not have; name the machine's tables (the reading option kinematics: xyzac or xyzbc), or write the program for three axes"
    )]
    Rotary(char, &'static str),
    /// A letter or a group of codes twice.
    #[error("{0} stands beside another of its kind; a block may hold one")]
    Twice(String),
    /// A word that nothing in the block uses.
    #[error("{0} means nothing in this block; remove it, or name the code that it belongs to")]
    Unused(char),
    /// Coordinates without a motion code.
    #[error("coordinates while no motion is in force; write G0, G1, G2 or G3 first")]
    NoMotion,
    /// A move that cannot be made.
    #[error("the arc {0}")]
    Arc(&'static str),
    /// A position beyond reason.
    #[error("{axis} would go to {value:e}; at most {limit:e} mm or degrees either way are read")]
    TooFar {
        /// The axis.
        axis: char,
        /// Where to.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// The path goes on from a place that is not known.
    #[error(
        "moves on from where line {since} went, which depends on the machine; give machine zero in the program's coordinates (the reading option machine_zero), or replace G28, G30 and G53 by plain moves"
    )]
    Lost {
        /// The line that left for it.
        since: u32,
    },
    /// More points than allowed.
    #[error(
        "the path has more than {limit} points; allow more (max_points), or longer chords (chord_tolerance)"
    )]
    TooLong {
        /// How many are allowed.
        limit: usize,
    },
}

/// Reads a program, written here or elsewhere.
///
/// Read: G0 to G3 with centres (G91.1, G90.1), radii, helices and turns (P); G4 P in s; G17 to G19;
/// G20, G21; G28, G30, G53; G40, G43 H, G49, G80; one of G54 to G59.3; G61, G64; G90, G91; G93, G94;
/// M0 to M9, M30, M48, M49; S, T, N; a program number at the top; comments; `%`; block delete.
/// Arcs and turning moves become chords within the tolerance, with the time they take: at feed per minute
/// the tip's travel on three axes, the travel of the machine's linear axes on five (of the rotary ones
/// where no other moves, in degrees per minute), as controllers do.
///
/// # Errors
/// [`GcodeError`], naming the line: text that is no program, and whatever else would make the path
/// another one (compensation, cycles, subprograms, expressions, other offsets).
pub fn read(text: &str, options: &ReadOptions) -> Result<GcodeProgram, GcodeError> {
    validate(options)?;
    interpret::read(text, options)
}

fn validate(options: &ReadOptions) -> Result<(), GcodeError> {
    let rules = [
        ("chord_tolerance", options.chord_tolerance, 1e-6, "at least 1e-6 mm"),
        ("arc_tolerance", options.arc_tolerance, 0.0, "at least 0 mm"),
        ("rapid_feed", options.rapid_feed, f64::MIN_POSITIVE, "positive, mm/s"),
    ];
    for (name, value, least, rule) in rules {
        if !(value.is_finite() && value >= least) {
            return Err(GcodeError::Option { name, value, rule });
        }
    }
    let zero = options.machine_zero.unwrap_or_default();
    if !zero.is_finite() {
        return Err(GcodeError::Option { name: "machine_zero", value: f64::NAN, rule: "finite" });
    }
    Ok(())
}
