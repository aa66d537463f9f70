//! A job → the texture of its window → files.
//!
//! Steps: (1) the job is planned, not judged; (2) the window is laid on the surface along the nearest pass; (3) the
//! teeth sweep it; (4) parameters, tables, picture.

use super::OutputFile;
use crate::flatten::Locator;
use crate::geometry::DVec3;
use crate::job::{Job, TextureCells, TextureOptions};
use crate::plan::{Files, PlanError, Planned, Stage, plan};
use crate::preview::texture_map;
use crate::texture::edge::Runout;
use crate::texture::engagement::{Shape, TooConcave, thickness};
use crate::texture::export::{MICRO, Matrix, X3pError, asc, csv, x3p};
use crate::texture::grid::{Discretisation, Grid, GridError};
use crate::texture::kinematics::{Spindle, feed_moves};
use crate::texture::parameters::{Levelled, Profile};
use crate::texture::steps::feed_per_tooth;
use crate::texture::sweep::{Cutter, EdgePart, HeightMap, SweepOptions, sweep};
use crate::texture::window::{Window, WindowError};
use crate::tool::ToolKind;
use serde::Serialize;
use std::fmt::Write;
use thiserror::Error;

/// Difference of the lengths of `constant` cells, as a part of them.
const EPS: f64 = 1e-3;
/// How far the path may be off the surface, in chord tolerances: that of the contact and that of the tip.
const SLACK: f64 = 4.0;
/// Facets that are higher than this part of Sz are worth a word.
const ROUGH: f64 = 0.1;
/// Sections of a line for Rz, each of which is to hold a cusp.
const SECTIONS: f64 = 5.0;

/// Why there is no texture.
#[derive(Debug, Error)]
pub enum TextureError {
    /// The job has no window.
    #[error(
        "texture: the job has no [texture] table; give the place of a window, `at = [x, y, z]`"
    )]
    NoWindow,
    /// Nothing turns or moves.
    #[error(
        "texture: a spindle speed of {spindle} rev/min and a feed of {feed} mm/min; both must be above 0"
    )]
    Still {
        /// Spindle speed, rev/min.
        spindle: f64,
        /// Feed, mm/min.
        feed: f64,
    },
    /// The job cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// There is no window there.
    #[error(transparent)]
    Window(#[from] WindowError),
    /// The window has no grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The cutter is too large for the window.
    #[error(transparent)]
    TooConcave(#[from] TooConcave),
    /// The map is too large for its file.
    #[error(transparent)]
    X3p(#[from] X3pError),
}

/// What `texture.json` tells; lengths in mm and µm as named.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureReport {
    /// The job's name.
    pub job: String,
    /// The window.
    pub window: WindowFigures,
    /// Cutting data.
    pub cutting: CuttingFigures,
    /// Parameters of ISO 25178-2, over the mean plane.
    pub areal: ArealFigures,
    /// Profile parameters of the lines along the feed.
    pub along: ProfileFigures,
    /// Of those across it.
    pub across: ProfileFigures,
    /// What the simulation took.
    pub work: WorkFigures,
    /// What deserves a second look.
    pub notes: Vec<String>,
}

/// The window.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WindowFigures {
    /// Its middle.
    pub middle_mm: [f64; 3],
    /// Unit direction of the feed there.
    pub feed: [f64; 3],
    /// Numbers of nodes along and across the feed.
    pub nodes: [usize; 2],
    /// Mean lengths of cells along and across.
    pub spacing_mm: [f64; 2],
    /// The shortest and the longest cell.
    pub cells_mm: [f64; 2],
    /// Height of the material before.
    pub start_mm: f64,
    /// Nodes that nothing lowered.
    pub uncut: usize,
    /// How far facets of the mesh are off a smooth surface.
    pub facets_um: f64,
}

/// Cutting data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CuttingFigures {
    /// Feed per tooth.
    pub feed_per_tooth_mm: f64,
    /// Side step of a straight pass on a plane.
    pub side_step_mm: f64,
    /// Spindle speed.
    pub spindle_rpm: f64,
    /// Teeth.
    pub flutes: u32,
    /// Least concave radius near the window, if any.
    pub least_concave_radius_mm: Option<f64>,
}

/// Areal parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArealFigures {
    /// Mean of the heights without sign.
    pub sa_um: f64,
    /// Root mean square.
    pub sq_um: f64,
    /// Highest over lowest.
    pub sz_um: f64,
    /// Skewness.
    pub ssk: f64,
    /// Kurtosis.
    pub sku: f64,
}

/// Profile parameters, means over all lines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileFigures {
    /// Mean of the heights without sign.
    pub ra_um: f64,
    /// Root mean square.
    pub rq_um: f64,
    /// Mean of highest over lowest of five sections.
    pub rz_um: f64,
    /// Highest over lowest.
    pub rt_um: f64,
}

/// What the simulation took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorkFigures {
    /// Time steps.
    pub steps: u64,
    /// Points of an edge.
    pub edge_points: u64,
    /// Quadrilaterals near a tile of the grid.
    pub quads: u64,
    /// Nodes tested against a quadrilateral.
    pub tests: u64,
}

/// The texture of a window.
#[derive(Clone, Debug)]
pub struct TextureResults {
    /// All files.
    pub files: Vec<OutputFile>,
    /// What they tell.
    pub report: TextureReport,
}

/// Plans a job without judging it, and simulates what the teeth leave in its window. Arguments as of
/// [`plan`](crate::plan::plan()); the simulation is told as [`Stage::Verify`].
///
/// # Errors
/// [`TextureError`]: no window, a job that cannot be planned, or a window that cannot be simulated.
pub fn texture_results(
    job: &Job,
    files: Files,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<TextureResults, TextureError> {
    let options = job.texture.as_ref().ok_or(TextureError::NoWindow)?;
    let (spindle, feed) = (60.0 * job.cut.spindle, 60.0 * job.cut.feed);
    // A NaN does not turn either.
    if !(spindle > 0.0 && feed > 0.0) {
        return Err(TextureError::Still { spindle, feed });
    }
    let planned = plan(job, files, threads, progress)?;
    progress(Stage::Verify, 0.0);
    let simulated = Simulated::of(job, options, &planned, threads)?;
    progress(Stage::Write, 0.0);
    simulated.results(job)
}

/// A window and what is left on it.
struct Simulated {
    grid: Grid,
    map: HeightMap,
    middle: DVec3,
    feed: DVec3,
    start: f64,
    facets: f64,
    least_concave_radius: Option<f64>,
}

impl Simulated {
    fn of(
        job: &Job,
        options: &TextureOptions,
        planned: &Planned,
        threads: usize,
    ) -> Result<Self, TextureError> {
        let locator = Locator::new(planned.surface.connectivity(), planned.chart.uv());
        let allowed = options.size.max_element();
        let window = Window::new(
            &planned.surface,
            &planned.chart,
            &locator,
            (&planned.toolpath, &job.tool),
            (options.at, allowed),
        )?;
        let cells = match options.cells {
            TextureCells::Uniform => Discretisation::Uniform,
            TextureCells::Constant => Discretisation::Constant { eps: EPS * options.spacing },
        };
        let grid = Grid::new(options.size, options.spacing, cells, threads, &|uv| window.node(uv))?;
        let curvature = planned.surface.curvature(job.surface.curvature_radius);
        let half = 0.5 * options.size.length();
        let near = window.least_concave_radius(&curvature, half);
        let reached = window.least_concave_radius(&curvature, half + 2.0 * job.tool.radius());
        let start = job.cut.stock + job.cut.axial_depth;
        let sweep_options = SweepOptions {
            start,
            thickness: engaged(job, near, reached)?,
            slack: SLACK * job.cut.tolerance,
            part: EdgePart::Effective,
            resolution: None,
            threads,
        };
        let moves = feed_moves(&planned.toolpath, job.tool.corner_radius());
        let map = sweep(&grid, &cutter(job, options), &moves, &sweep_options);
        Ok(Self {
            grid,
            map,
            middle: window.middle,
            feed: window.feed,
            start,
            facets: window.facets(options.size),
            least_concave_radius: near,
        })
    }

    fn results(&self, job: &Job) -> Result<TextureResults, TextureError> {
        let matrix = Matrix::new(&self.grid, &self.map.heights);
        let levelled = Levelled::new(&self.grid, &self.map.heights);
        let report = self.report(job, &levelled);
        let picture = Matrix { heights: levelled.heights(), ..matrix };
        let mut json = serde_json::to_string_pretty(&report).unwrap_or_default();
        json.push('\n');
        let file = |name: &str, bytes| OutputFile { name: name.into(), bytes };
        let files = vec![
            file("texture.csv", csv(&matrix)),
            file("texture.asc", asc(&matrix)),
            file("texture.x3p", x3p(&matrix)?),
            file("texture.svg", texture_map(&picture, &report.caption()).into_bytes()),
            file("texture.json", json.into_bytes()),
        ];
        Ok(TextureResults { files, report })
    }

    fn report(&self, job: &Job, levelled: &Levelled) -> TextureReport {
        let (areal, cells) = (levelled.areal(), self.grid.cells());
        let work = self.map.work;
        let uncut = self.map.heights.iter().filter(|h| **h >= self.start).count();
        let mut report = TextureReport {
            job: job.name.clone(),
            window: WindowFigures {
                middle_mm: self.middle.to_array(),
                feed: self.feed.to_array(),
                nodes: self.grid.counts(),
                spacing_mm: cells.mean,
                cells_mm: [cells.least, cells.largest],
                start_mm: self.start,
                uncut,
                facets_um: self.facets * MICRO,
            },
            cutting: CuttingFigures {
                feed_per_tooth_mm: feed_per_tooth(job.cut.feed, job.cut.spindle, job.flutes),
                side_step_mm: job.nominal_side_step(),
                spindle_rpm: 60.0 * job.cut.spindle,
                flutes: job.flutes,
                least_concave_radius_mm: self.least_concave_radius,
            },
            areal: ArealFigures {
                sa_um: areal.sa * MICRO,
                sq_um: areal.sq * MICRO,
                sz_um: areal.sz * MICRO,
                ssk: areal.ssk,
                sku: areal.sku,
            },
            along: ProfileFigures::of(&levelled.along()),
            across: ProfileFigures::of(&levelled.across()),
            work: WorkFigures {
                steps: work.steps,
                edge_points: work.edge_points,
                quads: work.quads,
                tests: work.tests,
            },
            notes: Vec::new(),
        };
        report.notes = report.second_looks();
        report
    }
}

impl ProfileFigures {
    fn of(profile: &Profile) -> Self {
        let [ra_um, rq_um, rz_um, rt_um] =
            [profile.ra, profile.rq, profile.rz, profile.rt].map(|x| x * MICRO);
        Self { ra_um, rq_um, rz_um, rt_um }
    }
}

impl TextureReport {
    /// What deserves a second look.
    fn second_looks(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let window = &self.window;
        if window.uncut > 0 {
            notes.push(format!(
                "{} nodes were not cut: they stand at the start height of {} mm",
                window.uncut, window.start_mm
            ));
        }
        if window.facets_um > ROUGH * self.areal.sz_um {
            notes.push(format!(
                "facets of the mesh are {:.3} µm off a smooth surface; the path follows them, and so does the part: a \
                 finer mesh shows the teeth alone",
                window.facets_um
            ));
        }
        let across = window.spacing_mm[1] * (window.nodes[1] - 1) as f64;
        let wanted = SECTIONS * self.cutting.side_step_mm;
        if across < wanted * (1.0 - 1e-6) {
            notes.push(format!(
                "the window is {across:.3} mm across the feed; Rz across wants {wanted:.3} mm, a side step for each of \
                 its sections"
            ));
        }
        notes
    }

    /// The main parameters in a line.
    fn caption(&self) -> String {
        let (a, l, c) = (&self.areal, &self.along, &self.across);
        format!(
            "{}: Sa {:.3}, Sq {:.3}, Sz {:.3} µm; along the feed Ra {:.3}, Rz {:.3} µm; across Ra {:.3}, Rz {:.3} µm",
            self.job, a.sa_um, a.sq_um, a.sz_um, l.ra_um, l.rz_um, c.ra_um, c.rz_um
        )
    }

    /// A short summary for a reader.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        let (w, c, a) = (&self.window, &self.cutting, &self.areal);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "window   {} x {} nodes, {:.4} x {:.4} mm apart, about {:.3} {:.3} {:.3}",
            w.nodes[0],
            w.nodes[1],
            w.spacing_mm[0],
            w.spacing_mm[1],
            w.middle_mm[0],
            w.middle_mm[1],
            w.middle_mm[2]
        );
        let _ = writeln!(
            text,
            "teeth    {} at {:.0} rev/min, feed per tooth {:.4} mm, side step {:.4} mm",
            c.flutes, c.spindle_rpm, c.feed_per_tooth_mm, c.side_step_mm
        );
        let _ = writeln!(
            text,
            "areal    Sa {:.3}  Sq {:.3}  Sz {:.3} µm  Ssk {:.2}  Sku {:.2}",
            a.sa_um, a.sq_um, a.sz_um, a.ssk, a.sku
        );
        for (name, p) in [("along ", &self.along), ("across", &self.across)] {
            let _ = writeln!(
                text,
                "{name}   Ra {:.3}  Rq {:.3}  Rz {:.3}  Rt {:.3} µm",
                p.ra_um, p.rq_um, p.rz_um, p.rt_um
            );
        }
        for note in &self.notes {
            let _ = writeln!(text, "note     {note}");
        }
        text
    }
}

/// How far above the contact material reaches on the edge, mm: without end where that is not known.
fn engaged(job: &Job, near: Option<f64>, reached: Option<f64>) -> Result<f64, TooConcave> {
    let (tool, a_p, r) = (&job.tool, job.cut.axial_depth, job.tool.corner_radius());
    if let Some(least_radius) = near.filter(|radius| *radius <= r) {
        return Err(TooConcave { least_radius, radius: r });
    }
    let Some(radius) = reached else { return Ok(a_p) };
    // The cutter touches the surface that the allowance leaves.
    let shape = Shape::Concave { least_radius: radius - job.cut.stock };
    match tool.kind() {
        // Beyond the window, a place where the ball does not fit only means that all of its edge may cut.
        ToolKind::Ball => Ok(thickness(shape, r, a_p).unwrap_or(2.0 * r)),
        ToolKind::Bull | ToolKind::Flat => Ok(f64::INFINITY),
    }
}

fn cutter(job: &Job, options: &TextureOptions) -> Cutter {
    Cutter {
        tool: job.tool,
        flutes: job.flutes,
        helix: job.helix,
        runout: Runout {
            offset: options.runout,
            angle: options.runout_angle,
            teeth: options.tooth_runout.clone(),
        },
        spindle: Spindle { speed: job.cut.spindle, phase: options.spindle_phase },
    }
}

#[cfg(test)]
mod tests;
