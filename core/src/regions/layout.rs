//! The passes of a region.

use super::joints::{Joints, decide, joints, machined, reset, run_on, ways_on};
use super::offsets::shifts;
use super::options::LayoutOptions;
use super::region_mesh::RegionMesh;
use crate::flatten::Locator;
use crate::geometry::DVec2;
use crate::geometry::polyline::{simplify_closed, simplify_open};
use crate::job::{FirstPass, Job, PathOptions, Start};
use crate::level_set::{
    ClosingOptions, ClosingReport, FieldTerrain, INSIDE, LevelSetError, Pass, PassField, close,
    passes as level_curves,
};
use crate::link::{Group, Precedence};
use crate::mesh::FaceId;
use crate::parallel;
use crate::pattern::{self, Laid, Parameters, Setting};

/// Where a field grows by less than this per pass there is a ridge, where branches close the gaps.
const RIDGE: f64 = 0.9;
/// Longest overrun of a flat bottom, half distances of passes.
const LONGEST_OVERRUN: f64 = 6.0;
/// Passes at least this fraction of the allowed side step apart count as even.
const EVEN: f64 = 0.9;

/// The passes of a region.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Their field.
    pub field: PassField,
    /// The passes.
    pub passes: Vec<Pass>,
    /// The order constraints of the passes.
    pub precedence: Precedence,
    /// Rings on the longest chain of rings inside each other.
    pub depth: usize,
    /// The gaps between passes that were closed.
    pub closing: ClosingReport,
}

/// Distances between neighbouring passes as fractions of the allowed side step, by area; excluding ridges, where
/// fronts meet and branches close the gaps.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Spacing {
    /// Area that was evaluated, mm².
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

    /// The same distance everywhere.
    pub fn everywhere(apart: f64, area: f64) -> Self {
        let even = if apart >= EVEN { 1.0 } else { 0.0 };
        Self { area, mean: apart, square: apart * apart, most: apart, even }
    }

    /// The distances of several regions together.
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

/// Lays out the passes of the job's pattern on every region.
///
/// # Errors
/// [`LevelSetError`]: no pass can be laid out on some region.
pub fn lay_out(
    region_meshes: &[RegionMesh],
    options: &LayoutOptions,
) -> Result<Vec<Layout>, LevelSetError> {
    let locators: Vec<Locator> = region_meshes.iter().map(RegionMesh::locator).collect();
    let tasks: Vec<_> = region_meshes.iter().zip(&locators).collect();
    // A single region is shared by all threads.
    let threads = if tasks.len() > 1 { 1 } else { options.threads };
    let options_of_one = LayoutOptions { threads, ..*options };
    let draft = |(region_mesh, locator): &(&RegionMesh, &Locator)| {
        Draft::of(region_mesh, locator, &options_of_one, tasks.len() > 1)
    };
    let drafts = parallel::map(options.threads, &tasks, draft);
    let mut drafts = drafts.into_iter().collect::<Result<Vec<_>, _>>()?;
    let pattern = options.job.path.pattern;
    // Bands end half a pass from their neighbours by themselves.
    if region_meshes.len() > 1 && !pattern.has_rings() && !pattern.divides_itself() {
        let fields: Vec<&PassField> = drafts.iter().map(|d| &d.field).collect();
        let shifts = shifts(region_meshes, &fields);
        for ((draft, region_mesh), shift) in drafts.iter_mut().zip(region_meshes).zip(shifts) {
            draft.shift(region_mesh, shift, options);
        }
    }
    for (draft, (region_mesh, locator)) in drafts.iter_mut().zip(&tasks) {
        draft.find_joints(region_mesh, locator, options);
    }
    for k in (0..drafts.len()).chain(0..drafts.len()) {
        if !drafts[k].joints.is_empty() {
            reset(&mut drafts[k].joints);
            let all: Vec<_> = drafts.iter().flat_map(Draft::machined).collect();
            let closing = drafts[k].closing_options(tasks[k].0, &[], options);
            let mut joints = core::mem::take(&mut drafts[k].joints);
            decide(&mut joints, (tasks[k].0, &drafts[k].field), &all, options, &closing);
            drafts[k].joints = joints;
        }
    }
    let indices: Vec<usize> = (0..drafts.len()).collect();
    let work = |&k: &usize| drafts[k].clone().closed(k, &drafts, tasks[k], &options_of_one);
    Ok(parallel::map(options.threads, &indices, work))
}

/// Passes of a region before they are joined with those of others.
#[derive(Clone)]
struct Draft {
    field: PassField,
    passes: Vec<Pass>,
    precedence: Precedence,
    is_spiral: bool,
    /// By pass; none where passes are rings.
    joints: Vec<Joints>,
}

impl Draft {
    fn of(
        region_mesh: &RegionMesh,
        locator: &Locator,
        options: &LayoutOptions,
        is_one_of_many: bool,
    ) -> Result<Self, LevelSetError> {
        let job = options.job;
        let mesh = &region_mesh.fine;
        let Laid { field, passes } =
            match region_mesh.has_neighbours() && job.path.pattern.has_rings() {
                true => rings(region_mesh, job),
                false => {
                    let coarse = &region_mesh.coarse;
                    let clearance = options.clearance.map(|c| c.of_mesh(mesh, options.threads));
                    let setting = Setting {
                        radius: job.tool.radius(),
                        footprint: job.footprint(),
                        has_neighbours: region_mesh.has_neighbours(),
                        clearance: clearance.as_deref(),
                    };
                    let own = (job.path.pattern.follows_parameters())
                        .then(|| Parameters::of(options.surface, options.chart, mesh))
                        .flatten();
                    pattern::lay_out(
                        coarse,
                        mesh,
                        locator,
                        &path(region_mesh, job),
                        setting,
                        own.as_ref(),
                    )?
                }
            };
        let (mut field, mut passes) = (field, simplified(passes, options.tolerance));
        if passes.is_empty() && is_one_of_many {
            // A ring halfway to its middle is enough.
            let Laid { field: of_rings, passes: rings } = rings(region_mesh, job);
            (field, passes) = (of_rings, simplified(rings, options.tolerance));
        }
        if passes.is_empty() {
            let (low, high) = field.range();
            return Err(LevelSetError::TooSmall { passes: high - low.min(0.0) });
        }
        let precedence = Precedence::new(&passes, job.path.order);
        let is_spiral = job.path.pattern.joins_rings();
        if is_spiral {
            passes = pattern::spiral(mesh, &field, &passes, &precedence);
            passes = simplified(passes, options.tolerance);
        }
        Ok(Self { field, passes, precedence, is_spiral, joints: Vec::new() })
    }

    /// Shifts open passes, unless none would be left.
    fn shift(&mut self, region_mesh: &RegionMesh, shift: f64, options: &LayoutOptions) {
        let field = self.field.clone().rescaled(shift, 1.0);
        let (low, high) = field.range();
        let levels = (0..).map(|k| low.ceil() + f64::from(k)).take_while(|level| *level < high);
        let levels: Vec<f64> = levels.collect();
        let passes =
            simplified(level_curves(&region_mesh.fine, &field, &levels), options.tolerance);
        if shift != 0.0 && !passes.is_empty() {
            self.precedence = Precedence::new(&passes, options.job.path.order);
            (self.field, self.passes) = (field, passes);
        }
    }

    /// Finds the ends on inner borders of passes that are not rings.
    fn find_joints(
        &mut self,
        region_mesh: &RegionMesh,
        locator: &Locator,
        options: &LayoutOptions,
    ) {
        if region_mesh.has_neighbours() && !options.job.path.pattern.has_rings() {
            let terrain = FieldTerrain::new(&region_mesh.fine, &self.field, locator);
            self.joints = joints(&mut self.passes, options.chart, &terrain);
        }
    }

    /// What its passes machine of neighbouring regions, if they are not rings.
    fn machined(&self) -> Vec<[DVec2; 2]> {
        machined(&self.passes, &self.joints)
    }

    fn closing_options<'a>(
        &self,
        region_mesh: &RegionMesh,
        beside: &'a [[DVec2; 2]],
        options: &LayoutOptions,
    ) -> ClosingOptions<'a> {
        // Beside the sharp ridges of regions rings are blunted too much for the field to tell how near they
        // are.
        let on_levels = !self.is_spiral && !region_mesh.has_neighbours();
        ClosingOptions {
            order: options.job.path.order,
            on_levels,
            beside,
            footprint: options.job.footprint(),
            cusps: options.cusps,
            threads: options.threads,
        }
    }

    /// The passes with those gaps closed that neither they nor the passes of other regions reach; `own`: index of the
    /// region in `all`.
    fn closed(
        mut self,
        own: usize,
        all: &[Self],
        (region_mesh, locator): (&RegionMesh, &Locator),
        options: &LayoutOptions,
    ) -> Layout {
        let mut beside: Vec<[DVec2; 2]> = ways_on(&self.joints).collect();
        if !self.joints.is_empty() {
            let others = all.iter().enumerate().filter(|(k, _)| *k != own);
            beside.extend(others.flat_map(|(_, other)| other.machined()));
        }
        let depth = self.precedence.depth();
        let terrain = FieldTerrain::new(&region_mesh.fine, &self.field, locator);
        let closing = self.closing_options(region_mesh, &beside, options);
        let lags = options.job.footprint().lags();
        let overruns = lags.then(|| overruns(&mut self.passes));
        let closing = close(&mut self.passes, &region_mesh.fine, &self.field, &terrain, &closing);
        for (pass, overrun) in self.passes.iter_mut().zip(overruns.into_iter().flatten()) {
            pass.overrun = overrun;
        }
        run_on(&mut self.passes, &self.joints);
        let Self { field, passes, precedence, .. } = self;
        Layout { field, passes, precedence, depth, closing }
    }
}

/// How passes are laid out on a region: starting at its own curve if it has one.
fn path(region_mesh: &RegionMesh, job: &Job) -> PathOptions {
    let mut path = job.path.clone();
    if let Some(curve) = &region_mesh.start {
        path.start = Start::Curve(curve.clone());
    } else if path.pattern.divides_itself() {
        path.start = Start::Widest;
    }
    path
}

/// Rings from the boundary of a region with neighbours.
fn rings(region_mesh: &RegionMesh, job: &Job) -> Laid {
    let outside = match job.path.first {
        FirstPass::Edge => INSIDE,
        FirstPass::HalfStrip => 0.5,
    };
    let field = region_mesh.rings(job.regions.blend, outside);
    let (low, high) = field.range();
    let first = if high > 2.0 * INSIDE { INSIDE } else { 0.5 * (low + high) };
    let rest = (1..).map(f64::from).take_while(|&level| level < high);
    let levels: Vec<f64> = core::iter::once(first).chain(rest).collect();
    let passes = level_curves(&region_mesh.fine, &field, &levels);
    Laid { field, passes }
}

/// Sets how far passes of a cutter with a flat bottom overrun the boundary; until then they overrun only as far as
/// the cutter also machines beside them, which it does not at the very end.
fn overruns(passes: &mut [Pass]) -> Vec<[f64; 2]> {
    let of = |pass: &mut Pass| {
        let mut whole = pass.overrun;
        for (end, whole) in whole.iter_mut().enumerate() {
            let (half, beside) = (pass.half[end], pass.beside[end]);
            let longest = LONGEST_OVERRUN * half;
            if pass.overrun[end] > 0.0 {
                *whole = beside.min(longest);
                pass.overrun[end] = if beside > longest { longest - half } else { beside };
            }
        }
        whole
    };
    passes.iter_mut().map(of).collect()
}

/// Passes without the points that the tolerance does not need.
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
    pub fn even_share(&self, region_mesh: &RegionMesh) -> f64 {
        match region_mesh.is_narrowed() {
            false => self.field.even_share(&region_mesh.fine),
            true => self.spacing(region_mesh).even,
        }
    }

    /// How far passes are apart, by their field.
    pub fn spacing(&self, region_mesh: &RegionMesh) -> Spacing {
        let narrowing = region_mesh.narrowing();
        let mesh = &region_mesh.fine;
        let of_face = |(f, face): (usize, &[crate::mesh::VertexId; 3])| {
            let face_id = FaceId(f as u32);
            let uv = face.map(|v| mesh.uv()[v.index()]);
            let metric = mesh.flat_metric(face_id)?;
            let slope = metric.slope(gradient(uv, face.map(|v| self.field.values()[v.index()]))?);
            let middle = (uv[0] + uv[1] + uv[2]) / 3.0;
            let apart = 1.0 / (slope * narrowing(middle));
            let area = region_mesh.area(face_id);
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

/// Share of the area on which neighbouring passes are at least 0.9 of the allowed side step apart.
pub fn even_share(region_meshes: &[RegionMesh], layouts: &[Layout]) -> f64 {
    if let ([region_mesh], [layout]) = (region_meshes, layouts) {
        return layout.even_share(region_mesh);
    }
    let areas = region_meshes.iter().map(RegionMesh::surface_area);
    let shares = layouts.iter().zip(region_meshes).map(|(l, g)| l.even_share(g));
    areas.clone().zip(shares).map(|(a, s)| a * s).sum::<f64>() / areas.sum::<f64>()
}
