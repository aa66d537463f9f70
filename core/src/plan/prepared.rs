//! The files that a job names → its surface, laid flat: whatever is planned on it, and with which cutter.

use super::error::{FARTHEST, PlanError};
use super::load::{Files, SurfaceKeys, load, load_beside};
use super::stage::Stage;
use crate::cutter_location::CheckMesh;
use crate::flatten::{Chart, FlattenError, Locator, Quality, abf, bff};
use crate::geometry::DVec3;
use crate::job::{FlattenMethod, Job};
use crate::machine::Axes;
use crate::surface::{Built, CurvatureField, Part, Surface, Warning};
use std::sync::Arc;

/// Farthest distance of a part from the origin, mm: half of the largest coordinate that is read back from a program.
const LONGEST_TRAVEL: f64 = 5e5;

/// A surface on which paths can be planned, and its flat map. It is determined by the [`SurfaceKeys`] of a job; jobs
/// that agree in them share it.
#[derive(Debug)]
pub struct Prepared {
    keys: SurfaceKeys,
    /// The surface.
    pub surface: Surface,
    /// Warnings about it.
    pub warnings: Vec<Warning>,
    /// Its curvature.
    pub curvature: CurvatureField,
    /// Its flat image.
    pub chart: Chart,
    /// How the flat image was found.
    pub flattening: Flattening,
    /// How conformal the map is.
    pub quality: Quality,
    /// Facets of the part that are not machined, and of the mesh beside the surface.
    pub rest: Part,
    /// The part to which the surface belongs.
    pub(super) part: Part,
    /// The part as an obstacle.
    pub(super) obstacle: Arc<CheckMesh>,
    /// The mesh beside the surface.
    pub(super) beside: Option<Part>,
}

/// How a flat map was found.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Flattening {
    /// Steps that it took.
    pub steps: usize,
    /// By how much the angles of the map contradict each other; 0 where they are not sought.
    pub residual: f64,
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
        progress: &mut dyn FnMut(Stage, f64),
    ) -> Result<Arc<Self>, PlanError> {
        progress(Stage::Surface, 0.0);
        let Built { surface, part, warnings, .. } = load(&keys, files)?;
        let beside = load_beside(&keys, files)?;
        refuse_too_far(keys.axes, &part)?;
        progress(Stage::Flatten, 0.0);
        let (chart, flattening) = flatten(keys.flatten, &surface)?;
        let mut rest = part.without(&surface);
        if let Some(beside) = &beside {
            rest.add(beside);
        }
        Ok(Arc::new(Self {
            quality: chart.quality(&surface),
            curvature: surface.curvature(keys.surface.curvature_radius),
            obstacle: CheckMesh::new(part.positions.clone(), part.faces.clone()).into(),
            keys,
            surface,
            part,
            beside,
            rest,
            warnings,
            chart,
            flattening,
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

    /// How far the facets may be off a smooth surface, mm.
    pub(super) fn chord(&self) -> f64 {
        self.surface.parameters().map_or(0.0, |_| self.keys.chord)
    }
}

fn flatten(method: FlattenMethod, surface: &Surface) -> Result<(Chart, Flattening), FlattenError> {
    match method {
        FlattenMethod::Bff => Ok((bff(surface)?, Flattening { steps: 1, residual: 0.0 })),
        FlattenMethod::Abf => {
            let map = abf(surface)?;
            Ok((map.chart, Flattening { steps: map.steps, residual: map.residual }))
        }
    }
}

fn refuse_too_far(axes: Axes, part: &Part) -> Result<(), PlanError> {
    let (low, high) = part
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let middle = 0.5 * (low + high);
    let (distance, times) = (middle.length(), middle.length() / (high - low).length());
    if distance > LONGEST_TRAVEL {
        return Err(PlanError::FarFromOrigin { middle, distance });
    }
    if axes != Axes::ThreeAxis && times > FARTHEST {
        return Err(PlanError::FarFromCentre { middle, distance, times });
    }
    Ok(())
}
