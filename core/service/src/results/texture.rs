//! A path → the texture of the window of its job → files.
//!
//! Steps: (1) the window is placed on the surface along the nearest pass; (2) the teeth sweep it; (3) parameters,
//! tables, picture. The path is either planned just now or read from a file.

use super::error::ResultsError;
pub use super::error::TextureError;
use super::files::OutputFile;
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::job::{Job, TextureCells, TextureOptions};
use evencut_core::plan::{Files, Prepared, Stage, SurfaceKeys, plan};
use evencut_core::texture::edge::Runout;
use evencut_core::texture::engagement::{Shape, TooConcave, thickness};
use evencut_core::texture::export::{MICRO, Matrix, asc, csv, x3p};
use evencut_core::texture::grid::{Discretisation, Grid, GridError, MOST_NODES, Node};
use evencut_core::texture::kinematics::{Spindle, feed_moves};
use evencut_core::texture::parameters::Levelled;
use evencut_core::texture::steps::{feed_per_tooth, resolution};
use evencut_core::texture::sweep::{Cutter, EdgePart, Search, SweepOptions, Work, sweep};
use evencut_core::texture::window::Window;
use evencut_core::toolpath::Toolpath;
use evencut_core::units::per_minute;
use evencut_output::preview::{texture_map, texture_png};
use evencut_output::report::{
    ArealFigures, CuttingFigures, ProfileFigures, TextureFigures, WindowFigures, WorkFigures,
};
use serde::Serialize;

/// Difference of the lengths of `constant` cells, as a fraction of them.
const EPS: f64 = 1e-3;
/// How far the path may be off the surface, in chord tolerances: that of the contact plus that of the tip.
const SLACK: f64 = 4.0;
/// The picture among the files.
pub const PICTURE: &str = "texture.svg";

/// The texture of a window.
#[derive(Clone, Debug)]
pub struct TextureResults {
    /// All files.
    pub files: Vec<OutputFile>,
    /// The texture's figures.
    pub figures: TextureFigures,
}

/// Plans a job without verifying it, and simulates the texture of its window. Arguments as of
/// [`plan`](evencut_core::plan::plan()).
///
/// # Errors
/// [`ResultsError::Plan`]: a job that cannot be planned; [`ResultsError::Texture`]: no window, or one that cannot be
/// simulated.
pub fn texture_results(
    job: &Job,
    files: Files,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<TextureResults, ResultsError> {
    let options = window_of(job)?;
    let planned = plan(job, files, threads, progress)?;
    progress(Stage::Texture, 0.0);
    let on = (&*planned.prepared, &planned.toolpath);
    Ok(texture_on(job, options, on, threads, &mut |part| progress(Stage::Texture, part))?)
}

/// Simulates the texture that a path planned earlier leaves in the window of `job`. Arguments and errors as of
/// [`texture_results`]; nothing is planned.
///
/// # Errors
/// As [`texture_results`].
pub fn texture_of_path(
    job: &Job,
    files: Files,
    path: &Toolpath,
    threads: usize,
    progress: &mut dyn FnMut(Stage, f64),
) -> Result<TextureResults, ResultsError> {
    let options = window_of(job)?;
    let prepared = Prepared::new(SurfaceKeys::of(job), files, threads, progress)?;
    progress(Stage::Texture, 0.0);
    Ok(texture_on(job, options, (&prepared, path), threads, &mut |part| {
        progress(Stage::Texture, part)
    })?)
}

/// The window of a job, checked before any work is done.
pub(crate) fn window_of(job: &Job) -> Result<&TextureOptions, TextureError> {
    let options = job.texture.as_ref().ok_or(TextureError::NoWindow)?;
    let (spindle, feed) = (per_minute(job.cut.spindle), per_minute(job.cut.feed));
    // A NaN does not turn either.
    if !(spindle > 0.0 && feed > 0.0) {
        return Err(TextureError::Still { spindle, feed });
    }
    Ok(options)
}

/// Simulates a window and makes its files. `progress` is called with the fraction done.
///
/// # Errors
/// [`TextureError`]: a window that is not on the surface, has too many nodes, or is too concave for the cutter.
pub(crate) fn texture_on(
    job: &Job,
    options: &TextureOptions,
    on: (&Prepared, &Toolpath),
    threads: usize,
    progress: &mut dyn FnMut(f64),
) -> Result<TextureResults, TextureError> {
    Simulated::of(job, options, on, threads, progress)?.results(job)
}

/// A window and its simulated heights.
pub(crate) struct Simulated {
    grid: Grid,
    /// Heights of the nodes that were cut, mm; NaN of all others.
    heights: Vec<f64>,
    /// Nodes that were not cut.
    uncut: u64,
    work: Work,
    middle: DVec3,
    feed: DVec3,
    start: f64,
    facets: f64,
    least_concave_radius: Option<f64>,
    /// Greatest run-out of a tooth, outward or downward, mm.
    runout: f64,
    /// Whether the surface at the window is flat.
    is_plane: bool,
}

impl Simulated {
    /// Simulates the window of a job. `progress` is called with the fraction done.
    ///
    /// # Errors
    /// [`TextureError`]: a window that is not on the surface, has too many nodes, or is too concave for the cutter.
    pub fn of(
        job: &Job,
        options: &TextureOptions,
        (prepared, path): (&Prepared, &Toolpath),
        threads: usize,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Self, TextureError> {
        let (surface, chart, locator) = (&prepared.surface, &prepared.chart, prepared.locator());
        let allowed = if options.whole { f64::INFINITY } else { options.size.max_element() };
        let by = (path, &job.tool);
        let window = Window::new(surface, chart, &locator, by, (options.at, allowed))?;
        let cells = match options.cells {
            TextureCells::Uniform => Discretisation::Uniform,
            TextureCells::Constant => Discretisation::Constant { eps: EPS * options.spacing },
        };
        let (at, size) = if options.whole { window.whole() } else { (DVec2::ZERO, options.size) };
        let beyond = options.whole.then_some(Node::BEYOND);
        let node = |uv: DVec2| window.node(at + uv).or(beyond);
        let grid = Grid::new(size, options.spacing, cells, threads, &node)
            .map_err(|error| too_fine(error, &window, options, size))?;
        let curvature = &prepared.curvature;
        let half = if options.whole { f64::INFINITY } else { 0.5 * size.length() };
        let near = window.least_concave_radius(curvature, half);
        let reached = window.least_concave_radius(curvature, half + 2.0 * job.tool.radius());
        let start = job.cut.allowance + job.cut.axial_depth;
        let cutter = cutter(job, options);
        let runout = cutter.runout.largest();
        let marks = [feed_per_tooth_of(job), job.nominal_side_step()];
        let sweep_options = SweepOptions {
            start,
            // On a whole surface the cutter leaves places out into which it does not fit.
            thickness: engaged(job, near.filter(|_| !options.whole), reached, runout)?,
            slack: SLACK * job.cut.tolerance,
            part: EdgePart::Effective,
            pace: EdgePart::Effective,
            search: Search::Near,
            resolution: Some(resolution(grid.cells().least, marks[0], marks[1], job.tool.radius())),
            threads,
        };
        let moves = feed_moves(path, job.tool.corner_radius());
        if moves.is_empty() {
            return Err(TextureError::NoTime);
        }
        let map = sweep(&grid, &cutter, &moves, &sweep_options, progress);
        if !map.heights.iter().any(|height| *height < start) {
            return Err(TextureError::NotCut { start });
        }
        // What still stands at the start height is the blank, not what teeth leave.
        let is_uncut = |height: &f64| *height >= start;
        let uncut = map.heights.iter().filter(|height| is_uncut(height)).count() as u64;
        let left = |height: &f64| if is_uncut(height) { f64::NAN } else { *height };
        let heights = map.heights.iter().map(left).collect();
        Ok(Self {
            grid,
            heights,
            uncut,
            work: map.work,
            middle: window.middle,
            feed: window.feed,
            start,
            facets: window.facets((at, size)),
            least_concave_radius: near,
            runout,
            is_plane: window.is_plane(curvature, half),
        })
    }

    fn results(&self, job: &Job) -> Result<TextureResults, TextureError> {
        let matrix = Matrix::new(&self.grid, &self.heights);
        let levelled = self.levelled();
        let figures = self.figures(job, &levelled);
        let picture = Matrix { heights: levelled.heights(), ..matrix };
        let caption = format!("{}: {}", job.name, figures.caption());
        let file = |name: &str, bytes| OutputFile { name: name.into(), bytes };
        let files = vec![
            file("texture.csv", csv(&matrix)),
            file("texture.asc", asc(&matrix)),
            file("texture.x3p", x3p(&matrix)?),
            file(PICTURE, texture_map(&picture, &caption).into_bytes()),
            file("texture.png", texture_png(&picture, [&job.name, &figures.caption()])),
            file("texture.json", json(&job.name, &figures)),
        ];
        Ok(TextureResults { files, figures })
    }

    /// How far straight moves of the path may be off the surface, mm.
    fn off_path(&self, job: &Job) -> f64 {
        if self.is_plane { 0.0 } else { job.cut.tolerance }
    }

    /// The heights relative to their mean plane.
    pub fn levelled(&self) -> Levelled {
        Levelled::new(&self.grid, &self.heights)
    }

    /// What is reported of them.
    pub fn figures(&self, job: &Job, levelled: &Levelled) -> TextureFigures {
        let (areal, cells) = (levelled.areal(), self.grid.cells());
        let work = self.work;
        let mut figures = TextureFigures {
            window: WindowFigures {
                middle_mm: self.middle.to_array(),
                feed: self.feed.to_array(),
                nodes: self.grid.counts().map(|count| count as u64),
                spacing_mm: cells.mean,
                cells_mm: [cells.least, cells.largest],
                start_mm: self.start,
                beyond: self.grid.nodes().iter().filter(|node| !node.is_on_surface()).count()
                    as u64,
                uncut: self.uncut,
                facets_um: self.facets * MICRO,
            },
            cutting: CuttingFigures {
                feed_per_tooth_mm: feed_per_tooth_of(job),
                side_step_mm: job.nominal_side_step(),
                spindle_rpm: per_minute(job.cut.spindle),
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
        let lowest = self.heights.iter().copied().fold(f64::INFINITY, f64::min);
        figures.notes = figures.warnings(lowest + self.runout, self.off_path(job));
        figures
    }
}

/// The figures with all of their digits, under the job's name.
fn json(job: &str, figures: &TextureFigures) -> Vec<u8> {
    #[derive(Serialize)]
    struct Named<'a> {
        job: &'a str,
        #[serde(flatten)]
        figures: &'a TextureFigures,
    }
    // Numbers and text are always JSON.
    let mut text = serde_json::to_string_pretty(&Named { job, figures }).unwrap_or_default();
    text.push('\n');
    text.into_bytes()
}

fn feed_per_tooth_of(job: &Job) -> f64 {
    feed_per_tooth(job.cut.feed, job.cut.spindle, job.flutes)
}

/// A grid of a whole surface with too many nodes, with a spacing that gives few enough.
fn too_fine(
    error: GridError,
    window: &Window,
    options: &TextureOptions,
    size: DVec2,
) -> TextureError {
    match error {
        GridError::TooMany { nodes } if options.whole => {
            TextureError::WholeTooFine { nodes, spacing: window.finest_cell(size, MOST_NODES) }
        }
        error => error.into(),
    }
}

/// How far above the contact material reaches on the edge, mm: infinite where that is not known.
///
/// `runout`: how far a tooth may be outside its intended position, mm; it then meets material that is higher by this;
/// in a hollow that nearly fits the cutter it is engaged for far longer.
fn engaged(
    job: &Job,
    near: Option<f64>,
    reached: Option<f64>,
    runout: f64,
) -> Result<f64, TooConcave> {
    let (tool, a_p, r) = (&job.tool, job.cut.axial_depth + runout, job.tool.corner_radius());
    if let Some(least_radius) = near.filter(|radius| *radius <= r) {
        return Err(TooConcave { least_radius, radius: r });
    }
    let Some(radius) = reached else { return Ok(a_p) };
    // The cutter touches the surface that the allowance leaves.
    let shape = Shape::Concave { least_radius: radius - job.cut.allowance };
    Ok(match tool.bottom_radius() > 0.0 {
        true => f64::INFINITY,
        // Beyond the window, a place where the ball does not fit only means that all of its edge may cut.
        false => thickness(shape, r, a_p).unwrap_or(2.0 * r),
    })
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
pub(crate) mod tests;
