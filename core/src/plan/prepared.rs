//! The files that a job names → its surface, laid flat: whatever is planned on it, and with which cutter.

use super::design::Design;
use super::error::PlanError;
use super::load::{Files, SurfaceKeys};
use super::parameter_map;
use super::stage::Stage;
use crate::cutter_location::{CheckMesh, is_level};
use crate::flatten::{Chart, FlattenError, Locator, Quality, abf, bff, unfolded};
use crate::geometry::{DVec2, DVec3};
use crate::hub::ChannelLines;
use crate::job::{FlattenMethod, Job};
use crate::reach::ReachOptions;
use crate::surface::{CurvatureField, Part, Surface};
use core::ops::Deref;
use std::sync::Arc;

/// Error of the curvature that the accuracy of a reached surface may cause, curvatures of the cutter.
const CURVATURE_ERROR: f64 = 0.05;

/// A surface on which paths can be planned, and its flat map. It is determined by the [`SurfaceKeys`] of a job; jobs
/// that agree in them share it.
#[derive(Debug)]
pub struct Prepared {
    keys: SurfaceKeys,
    /// What is machined.
    pub design: Design,
    /// Its curvature.
    pub curvature: CurvatureField,
    /// Its flat image.
    pub chart: Chart,
    /// How the flat image was found.
    pub flattening: Flattening,
    /// How conformal the map is.
    pub quality: Quality,
    /// The part as an obstacle.
    pub(super) obstacle: Arc<CheckMesh>,
}

/// How a flat map was found.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Flattening {
    /// Steps that it took.
    pub steps: usize,
    /// By how much the angles of the map contradict each other; 0 where they are not sought.
    pub residual: f64,
    /// What kind of map it is.
    pub kind: MapKind,
}

/// Kinds of flat maps.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum MapKind {
    /// A conformal map.
    Conformal,
    /// A conformal map, changed where it would turn faces over or overlap.
    Unfolded,
    /// The view along the tool axis, which turns no face of a reached surface over.
    View,
    /// The parameters of the surface.
    Parameters,
}

impl Deref for Prepared {
    type Target = Design;

    fn deref(&self) -> &Design {
        &self.design
    }
}

impl Prepared {
    /// Reads the surface of jobs with these keys and lays it flat. `progress` is called with the stage and the fraction
    /// of it that is done.
    ///
    /// # Errors
    /// [`PlanError`]: a surface that cannot be read, used or flattened.
    pub fn new(
        keys: SurfaceKeys,
        files: Files,
        threads: usize,
        progress: &mut dyn FnMut(Stage, f64),
    ) -> Result<Arc<Self>, PlanError> {
        progress(Stage::Surface, 0.0);
        let design = Design::new(&keys, files, threads)?;
        progress(Stage::Flatten, 0.0);
        let surface = &design.surface;
        let (chart, flattening) = match design.aside {
            None if design.passage.is_some() => {
                let kind = MapKind::Parameters;
                (parameter_map::parameters(surface), Flattening { steps: 0, residual: 0.0, kind })
            }
            None => flatten(keys.flatten, surface).or_else(|fault| laid(surface, fault))?,
            Some(_) if design.pieces > 1 => view(surface),
            Some(_) => flatten(keys.flatten, surface).unwrap_or_else(|_| view(surface)),
        };
        let Part { positions, faces } = &design.part;
        let curvature = match keys.reach(threads) {
            Some(reached) => curvature_of_reached(&design, &keys, &reached),
            None => surface.curvature(keys.surface.curvature_radius),
        };
        Ok(Arc::new(Self {
            quality: chart.quality(surface),
            curvature,
            obstacle: CheckMesh::new(positions.clone(), faces.clone()).into(),
            keys,
            chart,
            flattening,
            design,
        }))
    }

    /// Whether it is the surface of a job.
    pub fn is_of(&self, job: &Job) -> bool {
        self.keys == SurfaceKeys::of(job)
    }

    /// Finds its points by their flat points.
    pub fn locator(&self) -> Locator<'_> {
        self.chart.locator(&self.surface)
    }

    /// Whether it is what a cutter with a flat bottom reaches of a part, some of it level: from what rises beside that the
    /// cutter is moved off.
    pub fn is_reached_by_flat(&self, job: &Job) -> bool {
        let is_level = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| self.surface.positions()[v as usize]);
            is_level((b - a).cross(c - a).normalize_or_zero(), DVec3::Z)
        };
        let is_flat = self.keys.reach(1).is_some() && job.tool.bottom_radius() > 0.0;
        is_flat && self.surface.triangles().1.iter().any(is_level)
    }

    /// The lines of the channel of a hub in the flat map, flat mm, if the surface is one.
    pub fn channel_lines(&self) -> Option<ChannelLines> {
        parameter_map::lines(&self.surface, &self.chart, self.passage()?)
    }

    /// How far the facets may be off a smooth surface, mm.
    pub(super) fn chord(&self) -> f64 {
        self.surface.parameters().map_or(0.0, |_| self.keys.chord)
    }
}

/// Where the cutter bridges the part the surface is round as the cutter, however coarsely it is meshed. Elsewhere it is
/// sampled with an accuracy that hides smaller shapes.
fn curvature_of_reached(
    design: &Design,
    keys: &SurfaceKeys,
    reached: &ReachOptions,
) -> CurvatureField {
    let (radius, corner) = (reached.tool.radius(), reached.tool.corner_radius());
    let round = if corner > 0.0 { corner } else { radius };
    let least = (8.0 * reached.accuracy * round / CURVATURE_ERROR).sqrt();
    let given = keys.surface.curvature_radius;
    CurvatureField::of_normals(&design.surface, &design.is_of_cutter, given, least)
}

/// The view along the tool axis as a flat map.
fn view(surface: &Surface) -> (Chart, Flattening) {
    let flat: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate()).collect();
    (Chart::new(surface, flat), Flattening { steps: 0, residual: 0.0, kind: MapKind::View })
}

/// What a conformal map fails for is laid flat without one.
fn laid(surface: &Surface, fault: FlattenError) -> Result<(Chart, Flattening), FlattenError> {
    match fault {
        FlattenError::Flipped { .. }
        | FlattenError::Overlap { .. }
        | FlattenError::NotConverged { .. } => {
            let kind = MapKind::Unfolded;
            Ok((unfolded(surface)?, Flattening { steps: 1, residual: 0.0, kind }))
        }
        other => Err(other),
    }
}

fn flatten(method: FlattenMethod, surface: &Surface) -> Result<(Chart, Flattening), FlattenError> {
    match method {
        FlattenMethod::Bff => {
            Ok((bff(surface)?, Flattening { steps: 1, residual: 0.0, kind: MapKind::Conformal }))
        }
        FlattenMethod::Abf => {
            let map = abf(surface)?;
            Ok((
                map.chart,
                Flattening { steps: map.steps, residual: map.residual, kind: MapKind::Conformal },
            ))
        }
    }
}
