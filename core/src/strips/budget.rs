//! How high cusps may be.

use crate::cutter_location::ToolAxis;
use crate::job::{Job, Stepover};
use crate::removal::{Lean, cusp, worst_cusp};
use crate::surface::{CurvatureField, Surface};

/// Fraction of the tolerance by which passes stay below the limit, because the chords of the path run above them; at
/// most the fraction of the limit given second.
const CHORDS: (f64, f64) = (0.2, 0.05);
/// Fraction of the tolerance by which the limit may be exceeded between passes that turn or end beside each other: half of
/// what follows, for the chords of the path.
const LEFT_OPEN: f64 = 0.35;
/// Fraction of the tolerance above the limit from which on a place is too high: samples may miss the highest point.
const TOO_HIGH: f64 = 0.7;
/// Fraction of it that may be left above the limit where the cutter does not come lower.
const ALLOWED: f64 = 0.9;

/// Heights of the cusps of a job on a surface.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CuspBudget {
    /// Height that is meant to stay at most, mm: the job's limit, or the largest that its side step leaves.
    pub limit: f64,
    /// Height that passes leave on a plane, mm.
    pub on_plane: f64,
    /// Height for which passes are laid out, mm.
    pub aimed: f64,
    /// By how much the path may leave more, mm.
    pub tolerance: f64,
}

impl CuspBudget {
    /// That of a job on its surface.
    pub fn of(job: &Job, surface: &Surface, curvature: &CurvatureField) -> Self {
        let (tool, lead) = (&job.tool, job.cut.lead);
        let (axis, lean) =
            (ToolAxis::on(job.machine.axes, lead), Lean { angle: lead, heading: 0.0 });
        let (limit, on_plane) = match job.cut.stepover {
            Stepover::Scallop(h) => (h, h),
            Stepover::Fixed(d) => {
                (worst_cusp(tool, axis, surface, curvature, d), cusp(tool, lean, 0.0, d))
            }
        };
        let tolerance = job.cut.tolerance;
        let (of_tolerance, of_limit) = CHORDS;
        let aimed = limit - (of_tolerance * tolerance).min(of_limit * limit);
        Self { limit, on_plane, aimed, tolerance }
    }

    /// Height of the cusp between passes up to which they need no branch, mm.
    pub fn left_open(&self) -> f64 {
        self.limit + LEFT_OPEN * self.tolerance
    }

    /// Sampled height from which on a place is too high, mm.
    pub fn too_high(&self) -> f64 {
        self.limit + TOO_HIGH * self.tolerance
    }

    /// The highest sampled height that may be left where the cutter does not come lower, mm.
    pub fn allowed(&self) -> f64 {
        self.limit + ALLOWED * self.tolerance
    }
}
