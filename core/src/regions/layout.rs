//! The passes of a region.

use super::Ground;
use crate::flat_path::Terrain;
use crate::flatten::Locator;
use crate::geometry::DVec2;
use crate::geometry::polyline::{simplify_closed, simplify_open};
use crate::job::{FirstPass, Job, PathOptions, Pattern, Start};
use crate::level_set::{
    ClosingOptions, ClosingReport, FieldTerrain, INSIDE, LevelSetError, Pass, PassField, close,
    passes as level_curves,
};
use crate::link::{Group, Precedence, oriented};
use crate::mesh::FaceId;
use crate::parallel;
use crate::pattern::{self, Laid, Parameters};
use crate::surface::Surface;

/// A field that grows by less than this per pass is about a ridge, where spurs close the gaps.
const RIDGE: f64 = 0.9;
/// Passes at least this part of the allowed side step apart are even.
const EVEN: f64 = 0.9;

/// How passes are laid on every region.
#[derive(Copy, Clone, Debug)]
pub struct LayoutOptions<'a> {
    /// The job.
    pub job: &'a Job,
    /// The undivided surface.
    pub surface: &'a Surface,
    /// Over its chart.
    pub chart: &'a Locator<'a>,
    /// How far polylines may deviate from level curves, flat mm.
    pub tolerance: f64,
    /// Threads to use.
    pub threads: usize,
}

/// The passes of a region.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Their field.
    pub field: PassField,
    /// The passes.
    pub passes: Vec<Pass>,
    /// What is cut before what.
    pub precedence: Precedence,
    /// Rings on the longest chain of rings inside each other.
    pub depth: usize,
    /// The gaps between passes that were closed.
    pub closing: ClosingReport,
}

/// Distances between neighbouring passes as parts of the side step that is allowed, by area; ridges, where
/// fronts meet and spurs close the gaps, apart.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Spacing {
    /// Area that was asked, mm².
    pub area: f64,
    /// Mean.
    pub mean: f64,
    /// Mean square.
    pub square: f64,
    /// Largest.
    pub most: f64,
    /// Share of the area on which they are at least 0.9.
    pub even: f64,
}

impl Spacing {
    /// Standard deviation.
    pub fn deviation(&self) -> f64 {
        (self.square - self.mean * self.mean).max(0.0).sqrt()
    }

    /// The same everywhere.
    pub fn everywhere(apart: f64, area: f64) -> Self {
        let even = if apart >= EVEN { 1.0 } else { 0.0 };
        Self { area, mean: apart, square: apart * apart, most: apart, even }
    }

    /// That of several regions together.
    pub fn joined(all: impl IntoIterator<Item = Self>) -> Self {
        let mut sum = Self::default();
        for part in all {
            sum.add(part);
        }
        sum
    }

    fn add(&mut self, part: Self) {
        let area = self.area + part.area;
        if area > 0.0 {
            let share = part.area / area;
            self.mean += (part.mean - self.mean) * share;
            self.square += (part.square - self.square) * share;
            self.even += (part.even - self.even) * share;
        }
        (self.area, self.most) = (area, self.most.max(part.most));
    }
}

/// Lays the passes of the job's pattern on every region; `locators` are over their refined meshes.
///
/// # Errors
/// [`LevelSetError`]: no pass can be laid on some region.
pub fn lay_out(
    grounds: &[Ground],
    locators: &[Locator],
    options: &LayoutOptions,
) -> Result<Vec<Layout>, LevelSetError> {
    let tasks: Vec<_> = grounds.iter().zip(locators).collect();
    // A single region is shared by all threads.
    let threads = if tasks.len() > 1 { 1 } else { options.threads };
    let options_of_one = LayoutOptions { threads, ..*options };
    let work = |(ground, locator): &(&Ground, &Locator)| region(ground, locator, &options_of_one);
    parallel::map(options.threads, &tasks, work).into_iter().collect()
}

fn region(
    ground: &Ground,
    locator: &Locator,
    options: &LayoutOptions,
) -> Result<Layout, LevelSetError> {
    let job = options.job;
    let mesh = &ground.fine;
    let Laid { field, passes } = match ground.has_neighbours() && job.path.pattern.has_rings() {
        true => rings(ground, job),
        false => {
            let (coarse, radius) = (&ground.coarse, job.tool.radius());
            let own = (job.path.pattern == Pattern::IsoParametric)
                .then(|| Parameters::of(options.surface, options.chart, mesh))
                .flatten();
            pattern::lay_out(coarse, mesh, locator, &path(ground, job), radius, own.as_ref())?
        }
    };
    let mut passes = simplified(passes, options.tolerance);
    if passes.is_empty() {
        let (low, high) = field.range();
        return Err(LevelSetError::TooSmall { passes: high - low.min(0.0) });
    }
    let precedence = Precedence::new(&passes, job.path.order);
    let depth = precedence.depth();
    let is_spiral = job.path.pattern == Pattern::Spiral;
    if is_spiral {
        passes = pattern::spiral(mesh, &field, &passes, &precedence);
        passes = simplified(passes, options.tolerance);
    }
    let terrain = FieldTerrain::new(mesh, &field, locator);
    // Beside the sharp ridges of regions rings are blunted too much for the field to tell how near they
    // are.
    let on_levels = !is_spiral && !ground.has_neighbours();
    let closing = ClosingOptions { order: job.path.order, on_levels, threads: options.threads };
    let closing = close(&mut passes, mesh, &field, &terrain, &closing);
    if ground.has_neighbours() {
        passes.iter_mut().for_each(|pass| run_over(pass, options, &terrain));
    }
    Ok(Layout { field, passes, precedence, depth, closing })
}

/// How passes are laid on a region: beginning at its own curve if it has one.
fn path(ground: &Ground, job: &Job) -> PathOptions {
    let mut path = job.path.clone();
    if let Some(curve) = &ground.start {
        path.start = Start::Curve(curve.clone());
    } else if path.pattern == Pattern::Mpf {
        path.start = Start::Widest;
    }
    path
}

/// Rings from the boundary of a region with neighbours.
fn rings(ground: &Ground, job: &Job) -> Laid {
    let outside = match job.path.first {
        FirstPass::Edge => INSIDE,
        FirstPass::HalfStrip => 0.5,
    };
    let field = ground.rings(job.regions.blend, outside);
    let (low, high) = field.range();
    let first = if high > 2.0 * INSIDE { INSIDE } else { 0.5 * (low + high) };
    let rest = (1..).map(f64::from).take_while(|&level| level < high);
    let levels: Vec<f64> = core::iter::once(first).chain(rest).collect();
    let passes = level_curves(&ground.fine, &field, &levels);
    Laid { field, passes }
}

/// Lets the ends of an open pass go on over inner borders, on the surface, by the blend and by what they
/// overrun a slanted border.
fn run_over(pass: &mut Pass, options: &LayoutOptions, terrain: &dyn Terrain) {
    if pass.is_closed {
        return;
    }
    // One end, then, turned round, the other.
    for _ in 0..2 {
        if let [.., before, last] = pass.points[..] {
            let blend = options.job.regions.blend / terrain.scale(last).unwrap_or(1.0);
            let way = (last - before).normalize_or_zero() * (blend + pass.overrun[1]);
            let reached = reached(options.chart, last, last + way);
            // Not where the end lies on the boundary of the surface.
            if reached.distance(last) > 0.5 * way.length() {
                pass.points.push(reached);
                pass.overrun[1] = 0.0;
            }
        }
        *pass = oriented(pass, true);
    }
}

/// How far the straight flat way from a point stays on the surface.
fn reached(chart: &Locator, from: DVec2, to: DVec2) -> DVec2 {
    let Ok(start) = chart.locate(from) else { return from };
    match chart.walk(start.face, from, to, |_, _| {}) {
        Ok(_) => to,
        Err(outside) => outside.uv,
    }
}

/// Passes with the points left out that the tolerance does not need.
fn simplified(mut passes: Vec<Pass>, tolerance: f64) -> Vec<Pass> {
    for pass in &mut passes {
        pass.points = match pass.is_closed {
            true => simplify_closed(&pass.points, tolerance),
            false => simplify_open(&pass.points, tolerance),
        };
    }
    passes
}

impl Layout {
    /// Its passes in their order.
    pub fn group(&self) -> Group<'_> {
        Group { passes: &self.passes, precedence: &self.precedence }
    }

    /// Share of the area on which neighbouring passes are at least 0.9 of the allowed side step apart.
    pub fn even_share(&self, ground: &Ground) -> f64 {
        match ground.is_narrowed() {
            false => self.field.even_share(&ground.fine),
            true => self.spacing(ground).even,
        }
    }

    /// How far passes are apart, by their field.
    pub fn spacing(&self, ground: &Ground) -> Spacing {
        let narrowing = ground.narrowing();
        let mesh = &ground.fine;
        let of_face = |(f, face): (usize, &[crate::mesh::VertexId; 3])| {
            let face_id = FaceId(f as u32);
            let uv = face.map(|v| mesh.uv()[v.index()]);
            let metric = mesh.flat_metric(face_id)?;
            let slope = metric.slope(gradient(uv, face.map(|v| self.field.values()[v.index()]))?);
            let middle = (uv[0] + uv[1] + uv[2]) / 3.0;
            let apart = 1.0 / (slope * narrowing(middle));
            let area = ground.area(face_id);
            let spacing = Spacing::everywhere(apart, area);
            (slope >= RIDGE && apart.is_finite()).then_some(spacing)
        };
        Spacing::joined(mesh.connectivity().faces().iter().enumerate().filter_map(of_face))
    }
}

/// Gradient of the linear function with these values at the corners; `None` without area.
fn gradient([a, b, c]: [DVec2; 3], [u, v, w]: [f64; 3]) -> Option<DVec2> {
    let twice_area = (b - a).perp_dot(c - a);
    let gradient = ((b - a).perp() * (w - u) - (c - a).perp() * (v - u)) / twice_area;
    gradient.is_finite().then_some(gradient)
}
