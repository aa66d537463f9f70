//! [`Toolpath`] → [`Program`]: a dialect is data, the renderer is shared.
//!
//! | file | what |
//! |---|---|
//! | `linuxcnc` | the dialect |
//! | `render` | blocks, modal words, feeds |

mod linuxcnc;
mod render;

use crate::geometry::DVec3;
use crate::machine::{Machine, Post};
use crate::tool::Tool;
use crate::toolpath::Toolpath;
use thiserror::Error;

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

/// Why a path cannot be written as a program.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PostError {
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
    /// A rapid would run through part or stock.
    #[error(
        "post: the rapid to point {index} at ({:.3}, {:.3}, {:.3}) runs at machine Z {height:.3} mm; rapids must stay at or above the rapid plane at {rapid_plane} mm",
        tip.x, tip.y, tip.z
    )]
    LowRapid {
        /// Index of the point.
        index: usize,
        /// Its tip, mm.
        tip: DVec3,
        /// Lowest machine Z of the move, mm.
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
    /// The rotary axes cannot follow.
    #[error(
        "post: between ({:.3}, {:.3}, {:.3}) and the next point the rotary axes turn too fast near A = 0 to stay within {tolerance} mm; keep the tool axis away from the C axis there",
        place.x, place.y, place.z
    )]
    Singular {
        /// Tip before the move, mm.
        place: DVec3,
        /// Tolerance, mm.
        tolerance: f64,
    },
}

/// Writes a path as a program.
///
/// Three-axis programs give the tip and feed per minute; five-axis ones the position of the tip in the
/// turned table (rotary centre at program zero) and inverse time, so that the feed holds at the
/// contact; rotary moves are split until the tip stays within half the tolerance of the straight line.
///
/// # Errors
/// [`PostError`]; nothing is written that would rapid below the rapid plane or feed at no speed.
pub fn program(path: &Toolpath, options: &ProgramOptions) -> Result<Program, PostError> {
    let dialect = match options.post {
        Post::LinuxCnc => &linuxcnc::DIALECT,
    };
    render::render(path, options, dialect)
}

/// What differs between controllers.
struct Dialect {
    extension: &'static str,
    /// Blocks before the first move; `{tolerance}`, `{tool}`, `{speed}` and `{feed_mode}` are filled in.
    preamble: &'static [&'static str],
    /// Blocks after the last move.
    ending: &'static [&'static str],
    /// What opens and closes a comment.
    comment: [&'static str; 2],
    feed_per_minute: &'static str,
    inverse_time: &'static str,
    rapid: &'static str,
    feed: &'static str,
    /// Decimals of lengths in mm, of angles in degrees and of feeds.
    decimals: [u32; 3],
}
