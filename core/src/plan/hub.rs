//! The channel of a hub → the path through all channels.

use super::error::PlanError;
use super::parameter_map::flat_per_parameter;
use super::planned::{Passes, Planned, Tightest};
use super::prepared::Prepared;
use super::stage::Stage;
use crate::geometry::DVec3;
use crate::hub::{ChannelOptions, Channels, Passage};
use crate::job::Job;
use crate::level_set::ClosingReport;
use crate::machine_time::fill_time;
use crate::removal::Coverage;
use crate::strips::CuspBudget;
use crate::surface::{CurvatureField, Part, Surface};
use std::sync::Arc;

/// Share of the tolerance above the limit from which on a place in a channel is too high: the judge's samples lie between
/// those that are looked at, and at sides beyond them.
const TOO_HIGH: f64 = 0.4;

/// Plans the path through the channels of a hub.
pub(super) fn planned(
    prepared: &Arc<Prepared>,
    (passage, about): &(Passage, Part),
    job: &Job,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<Planned, PlanError> {
    let Some(hub) = &job.hub else {
        return Err(PlanError::Rings(crate::level_set::LevelSetError::NeedsBlades));
    };
    progress(Stage::Cut, 0.0);
    let (surface, curvature): (&Surface, &CurvatureField) =
        (&prepared.surface, &prepared.curvature);
    let cusps = CuspBudget::of(job, surface, curvature);
    let reach = |p: &DVec3| (*p - hub.origin).length() + hub.origin.length();
    let top = prepared.part.positions.iter().map(reach).fold(0.0, f64::max);
    let rapid_plane = top + job.cut.axial_depth + job.cut.allowance + job.machine.clearance;
    let options = ChannelOptions {
        hub,
        assembly: &job.assembly,
        footprint: job.footprint(),
        cusp: cusps.aimed,
        limit: cusps.limit + TOO_HIGH * cusps.tolerance,
        allowance: job.cut.allowance,
        tolerance: job.cut.tolerance,
        feeds: [
            job.cut.feed,
            job.trochoid.return_feed.min(job.machine.max_feed),
            job.machine.max_feed,
        ],
        rapid_plane,
        threads,
    };
    let Channels { mut toolpath, contacts, figures } = passage.channels(about, &options)?;
    if let Some(scale) = flat_per_parameter(surface, &prepared.chart) {
        for (point, at) in toolpath.points.iter_mut().zip(&contacts) {
            point.flat = at.map(|at| at * scale);
        }
    }
    fill_time(&mut toolpath, &job.tool, &job.machine);
    Ok(Planned {
        prepared: Arc::clone(prepared),
        tightest: Tightest::of(job, prepared),
        toolpath,
        plain: None,
        rapid_plane,
        lifted: Vec::new(),
        coverage: Coverage {
            area: surface.area(),
            never_covered: figures.left.0,
            never_covered_at: figures.left.1,
            ..Coverage::default()
        },
        cusps,
        planar: Vec::new(),
        channels: Some(figures),
        passes: Passes {
            count: figures.passes,
            depth: 0,
            loops: 0,
            are_loops_small: false,
            length_floor: figures.length_floor,
            even_share: figures.even_share,
            closing: ClosingReport::joined(core::iter::empty()),
            divided: None,
            topology: None,
        },
    })
}
