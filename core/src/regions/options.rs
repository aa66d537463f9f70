//! How passes are laid out on every region.

use crate::flatten::Locator;
use crate::job::Job;
use crate::surface::Surface;
use crate::walls::Clearance;

/// How passes are laid out on every region.
#[derive(Copy, Clone)]
pub struct LayoutOptions<'a> {
    /// The job.
    pub job: &'a Job,
    /// The undivided surface.
    pub surface: &'a Surface,
    /// Over its chart.
    pub chart: &'a Locator<'a>,
    /// How far polylines may deviate from level curves, flat mm.
    pub tolerance: f64,
    /// Clearance between cutter and walls, if there are any.
    pub clearance: Option<Clearance<'a>>,
    /// Heights of the cusps, mm: that for which passes are laid out, and the largest that they may leave.
    pub cusps: [f64; 2],
    /// Number of threads.
    pub threads: usize,
}
