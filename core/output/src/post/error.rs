//! Why a path cannot be written as a program.

use super::keys::KeysError;
use evencut_core::geometry::DVec3;
use thiserror::Error;

/// Why a post-processor cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DialectError {
    /// Its file was not given.
    #[error("post: the job names the file {0:?} in output.gcode.post_file, but it was not given")]
    NoFile(String),
    /// Its file cannot be read.
    #[error("post: {0}")]
    File(#[from] KeysError),
    /// A value out of its range.
    #[error("post: {key} is {value}; it must be {rule}")]
    Value {
        /// Which.
        key: String,
        /// What it is.
        value: String,
        /// What it must be.
        rule: String,
    },
    /// A block asks for something that there is not.
    #[error("post: a text of {key} has {{{name}}}; known are {known}")]
    Field {
        /// The key of the text.
        key: String,
        /// What stands in braces.
        name: String,
        /// What may stand there.
        known: String,
    },
    /// It has no programs for such a machine.
    #[error(
        "post: {post} writes no program for {axes}; choose another post, or give a post file with [{table}]"
    )]
    Axes {
        /// Its name.
        post: String,
        /// The table that it lacks.
        table: &'static str,
        /// Which axes.
        axes: &'static str,
    },
    /// It has no word for a rotary axis.
    #[error(
        "post: {post} has no word for the rotary axis {letter}; add words.{key} to a copy of it, or choose another post"
    )]
    Rotary {
        /// Its name.
        post: String,
        /// Of the axis.
        letter: char,
        /// That it lacks.
        key: char,
    },
    /// It has no word for a coolant.
    #[error("post: {post} has no coolant \"{coolant}\"; it has {known}")]
    Coolant {
        /// Its name.
        post: String,
        /// As asked for.
        coolant: &'static str,
        /// Those that it has.
        known: String,
    },
    /// It has no words for arcs.
    #[error(
        "post: {post} has no words for arcs; add [arc] to a copy of it, or leave output.gcode.arcs out"
    )]
    Arcs {
        /// Its name.
        post: String,
    },
    /// It has no word for a work offset.
    #[error("post: {post} has no work offset {offset}; it has {known}")]
    WorkOffset {
        /// Its name.
        post: String,
        /// As asked for.
        offset: &'static str,
        /// Those that it has.
        known: String,
    },
}

/// Why a path cannot be written as a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PostError {
    /// The post-processor cannot write such programs.
    #[error(transparent)]
    Dialect(#[from] DialectError),
    /// There is nothing to write.
    #[error("post: the path has no points")]
    Empty,
    /// A three-axis machine cannot tilt.
    #[error(
        "post: point {index} at ({:.3}, {:.3}, {:.3}) has the axis ({:.3}, {:.3}, {:.3}); a three-axis program needs (0, 0, 1): rotate the part or choose a five-axis machine",
        tip.x, tip.y, tip.z, axis.x, axis.y, axis.z
    )]
    TiltedAxis {
        /// Index of the point.
        index: usize,
        /// Its tip, mm.
        tip: DVec3,
        /// Its axis.
        axis: DVec3,
    },
    /// The rotary axes cannot turn to a direction of the tool axis.
    #[error(
        "post: at ({:.3}, {:.3}, {:.3}) the tool axis is ({:.3}, {:.3}, {:.3}), to which {first} and {second} cannot turn; choose another machine.axes, or lean less (cut.lead)",
        tip.x, tip.y, tip.z, axis.x, axis.y, axis.z
    )]
    Unreachable {
        /// The rotary axis next to the workpiece.
        first: char,
        /// That next to the tool.
        second: char,
        /// The tip, mm.
        tip: DVec3,
        /// The tool axis.
        axis: DVec3,
    },
    /// A rapid would run through part or stock.
    #[error(
        "post: the rapid to point {index} at ({:.3}, {:.3}, {:.3}) runs {height:.3} mm high along the tool axis; rapids must stay at or above the rapid plane at {rapid_plane} mm",
        tip.x, tip.y, tip.z
    )]
    LowRapid {
        /// Index of the point.
        index: usize,
        /// Its tip, mm.
        tip: DVec3,
        /// Lowest height of the move along the tool axis, mm.
        height: f64,
        /// The rapid plane, mm.
        rapid_plane: f64,
    },
    /// A feed move without a feed.
    #[error("post: the move to point {index} has feed {feed} mm/s; it must be a positive number")]
    Feed {
        /// Index of the point.
        index: usize,
        /// Its feed, mm/s.
        feed: f64,
    },
    /// A point that is none.
    #[error("post: point {index} has a tip or unit axis that is not finite")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// An axis would leave its travel.
    #[error(
        "post: axis {axis} would go to {position:.3} mm; machine.travel.{key} allows {low} to {high} mm: move the part (surface.translate, surface.rotate), lower machine.clearance, or choose a larger machine",
        key = axis.to_ascii_lowercase()
    )]
    Travel {
        /// `X`, `Y` or `Z`.
        axis: char,
        /// The position farthest outside, mm.
        position: f64,
        /// Least position allowed, mm.
        low: f64,
        /// Greatest position allowed, mm.
        high: f64,
    },
    /// A rotary axis would leave its range.
    #[error(
        "post: axis {axis} would turn to {position:.3} degrees near ({:.3}, {:.3}, {:.3}); its range is {low} to {high} degrees: {remedy}",
        place.x, place.y, place.z
    )]
    RotaryTravel {
        /// Its letter.
        axis: char,
        /// The position outside, degrees.
        position: f64,
        /// Least position allowed, degrees.
        low: f64,
        /// Greatest position allowed, degrees.
        high: f64,
        /// The tip there, mm.
        place: DVec3,
        /// What would help.
        remedy: &'static str,
    },
    /// The rotary axes cannot follow.
    #[error(
        "post: between ({:.3}, {:.3}, {:.3}) and the next point the rotary axes turn too fast to stay within {tolerance} mm, the tool standing nearly along axis {axis}; keep the tool axis away from that there",
        place.x, place.y, place.z
    )]
    Singular {
        /// Tip before the move, mm.
        place: DVec3,
        /// Tolerance, mm.
        tolerance: f64,
        /// The axis next to the workpiece.
        axis: char,
    },
}
