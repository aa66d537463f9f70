//! A program that was read: its path, and what is doubtful about it.

use super::kinematics::MachinePosition;
use super::setting::Setting;
use evencut_core::machine::Axes;
use evencut_core::toolpath::Toolpath;
use std::fmt;
use std::ops::Range;

/// A program, read.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct GcodeProgram {
    /// What the tip does, in the workpiece: feed moves are cuts, the rest rapids; pass, region, removal
    /// rate and engagement are 0; the normal is the axis. Starts at the first position known in full.
    ///
    /// Feeds are those of the tip in the workpiece: as programmed on three axes; while rotary axes turn, its
    /// travel by the move's time. Moves without a feed have feed 0 and take no time.
    pub path: Toolpath,
    /// Line of every point, from 1.
    pub lines: Vec<u32>,
    /// The axes that it was read for.
    pub axes: Axes,
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
    /// What the machine is set to.
    pub setting: Setting,
    /// Lowest height of the tip along the tool axis as far as known, mm: of tables about program zero the machine's Z.
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
    /// A move at feed with a tool that was changed without its length.
    NoLength,
    /// Another tool, offset, speed of the spindle or coolant than the job has.
    Setting,
    /// A position that the machine cannot reach.
    Travel,
    /// The program does not end.
    NoEnd,
    /// It is not the path that it was written from.
    OffPath,
}
