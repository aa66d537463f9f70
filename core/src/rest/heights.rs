//! How high a path leaves the samples, and where between them it may leave more.

use super::context::{Rest, RestOptions};
use super::samples::{Ball, LEVELS, Sample};
use crate::cutter_location::{PassOptions, ToolAxis};
use crate::geometry::math::cos;
use crate::geometry::{DVec2, OrderBy};
use crate::link::Delivered;
use crate::parallel;
use crate::removal::{Columns, Layer, Line, Strokes};
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use std::collections::BTreeSet;

/// Fractions of the limit above which more samples are placed around one, and still more around each of those: the
/// samples nearest to the crest of a sharp cusp as high as the limit are not lower than this.
const NEARLY: [f64; LEVELS as usize] = [0.85, 0.95];
/// No sample lower than this fraction of the limit counts as nearly too high.
const LEAST: f64 = 0.3;
/// Steepest flank of a cusp that is assumed.
const STEEPEST: f64 = 1.0;
/// How much steeper than on a plane the flank of a cusp that a rounded corner leaves may be: on places as convex as the
/// corner itself the square root of 2.
const ON_CONVEX: f64 = 1.5;
/// Fraction of the limit from which on a sample that is higher than those before and behind it may lie beside a place
/// that is too high: a cusp is as much lower a ninth of its width beside its ridge, half the distance between samples.
const TOP: f64 = 0.6;
/// Fraction of the limit by which a sample must be higher than another to count as clearly higher.
const CLEARLY: f64 = 0.01;
/// Size of the cells in each of which the cutter is tested at one sample, side steps. Smaller: slower.
const CELL: f64 = 0.1;
/// Greatest number of steps toward higher places, halved where none is higher; and the shortest step, side steps.
const CLIMBS: usize = 18;
const FINEST: f64 = 0.0003;
/// The same for a ball, whose cusps are less steep: at this distance from its ridge a cusp is lower by 0.5 %.
const FINEST_OF_BALL: f64 = 0.00125;
/// Width of what is measured together, side steps. Wider: more of the path comes near it; narrower: more of them.
const TOGETHER: f64 = 0.5;
/// Greatest number of samples that are measured at a time; more take more memory.
const MANY: usize = 1 << 18;
/// Heights are clamped at this multiple of the limit.
pub(super) const CLAMP: f64 = 10.0;

impl Rest<'_> {
    /// All places that may be too high; of those beside the passes of a ball the ones that are. `near`: of these only
    /// those in the given cells.
    pub(super) fn all_samples(
        &self,
        path: &Delivered,
        near: Option<&BTreeSet<[i64; 2]>>,
    ) -> Vec<Sample> {
        let is_near = |s: &Sample| near.is_none_or(|cells| cells.contains(&self.cell_of(s.flat)));
        let mut samples = Vec::new();
        match self.ball() {
            None => samples = self.places.over_faces(),
            Some(ball) => {
                let strokes = self.strokes(&path.toolpath);
                self.places.beside_passes(path, &ball, |mut run| {
                    run.retain(is_near);
                    samples.extend(self.high_or_top(run, &strokes));
                });
            }
        }
        samples.extend(self.places.over_edges().into_iter().filter(is_near));
        if self.options.has_open_rim {
            samples.extend(self.places.on_rim().into_iter().filter(is_near));
        }
        samples
    }

    /// Of samples beside passes, alternately on one side and the other, those that are nearly too high.
    fn high_or_top(&self, run: Vec<Sample>, path: &Strokes) -> Vec<Sample> {
        let close = self.options.close;
        let heights = self.heights(&run, path, close.min(TOP * self.options.limit));
        let is_top = |i: usize| i >= 2 && is_top([&heights[i - 2..], &heights[i..]], &self.options);
        let seen = |(i, sample)| Sample { is_top: is_top(i), ..sample };
        let kept = |(i, sample): &(usize, Sample)| heights[*i] >= close || sample.is_top;
        let run = run.into_iter().enumerate().map(|(i, s)| (i, seen((i, s))));
        run.filter(kept).map(|(_, sample)| sample).collect()
    }

    /// The places beside a path up to which a ball lowers the surface; none for other cutters, which are checked all
    /// over it.
    pub(super) fn samples_beside(&self, path: &Delivered) -> Vec<Sample> {
        let mut samples = Vec::new();
        if let Some(ball) = self.ball() {
            self.places.beside_passes(path, &ball, |run| samples.extend(run));
        }
        samples
    }

    /// The cutter, if it is a ball.
    pub(super) fn ball(&self) -> Option<Ball> {
        let pass = &self.deliverer.options.pass;
        let radius = pass.tool.radius();
        let ball = Ball { radius, allowance: pass.allowance, limit: self.options.limit };
        (pass.tool.bottom_radius() == 0.0).then_some(ball)
    }

    /// The heights of all samples, with additional samples where it is nearly too high.
    pub(super) fn refined(&mut self, path: &Strokes) -> Vec<f64> {
        let limit = self.options.limit;
        let exact = self.samples.iter().map(|s| self.nearly(s)).fold(self.options.close, f64::min);
        let mut heights = self.heights(&self.samples, path, exact);
        let mut known = 0;
        while known < self.samples.len() {
            // What is too high is gone over anyway.
            let mut more = Vec::new();
            for (i, height) in heights.iter().enumerate().skip(known) {
                let sample = &self.samples[i];
                if sample.level < LEVELS && (self.nearly(sample)..=limit).contains(height) {
                    more.extend(self.places.about(sample));
                    self.samples[i].level = LEVELS;
                }
            }
            known = self.samples.len();
            heights.extend(self.heights(&more, path, exact));
            self.samples.extend(more);
        }
        heights
    }

    /// The height of a sample from which on a place around it may be too high, mm.
    fn nearly(&self, sample: &Sample) -> f64 {
        let RestOptions { limit, close, .. } = self.options;
        let nearly = NEARLY.get(usize::from(sample.level)).map_or(close, |n| n * limit);
        if self.ball().is_some() {
            return nearly;
        }
        nearly.min((limit - self.rise(sample)).max(LEAST * limit))
    }

    /// How much higher a place halfway to the next sample may be, mm.
    ///
    /// Where the edge of a flat bottom leaves a cusp, its flank is as steep as the bottom lies on the surface. A rounded
    /// corner of radius `r` that touches the surface has risen to the limit `h` where it is `acos(1 - h/r)` steep, or at
    /// its bottom before; on convex places it is a little steeper.
    fn rise(&self, sample: &Sample) -> f64 {
        let PassOptions { axis, tool, .. } = self.deliverer.options.pass;
        let cosine = match axis {
            ToolAxis::Fixed(axis) => axis.dot(sample.normal),
            ToolAxis::Lead(lead) => cos(lead),
        };
        let of_bottom = (1.0 - cosine * cosine).max(0.0).sqrt() / cosine.max(f64::MIN_POSITIVE);
        let of_corner = match tool.corner_radius() {
            corner if corner > 0.0 => ON_CONVEX * (2.0 * self.options.limit / corner).sqrt(),
            _ => STEEPEST,
        };
        0.5 * sample.spacing * of_bottom.min(of_corner).min(STEEPEST)
    }

    /// Height of a sample from which on its surroundings are searched for higher places, mm.
    pub(super) fn climbed_from(&self, sample: &Sample) -> f64 {
        let RestOptions { limit, close, .. } = self.options;
        let nearly = NEARLY[0] * limit;
        let has_corner =
            self.ball().is_none() && self.deliverer.options.pass.tool.corner_radius() > 0.0;
        match (self.on_ridges, has_corner) {
            // Beside passes samples lie on ridges already.
            (true, _) => close,
            (false, true) => nearly.min((limit - self.rise(sample)).max(LEAST * limit)),
            // Peaks that the edge of a flat end leaves are narrow.
            (false, false) => close.min(nearly),
        }
    }

    /// Climbs from samples that are nearly too high to higher places beside them: samples leave gaps, and the peaks
    /// left by the edge of a flat end are narrow.
    pub(super) fn climb(&mut self, heights: &mut Vec<f64>, path: &Strokes) {
        let (limit, close) = (self.options.limit, self.options.close);
        let is_nearly = |i: &usize| {
            let sample = &self.samples[*i];
            let is_nearly = (self.climbed_from(sample)..=limit).contains(&heights[*i]);
            let is_high = is_nearly || self.on_ridges && sample.is_top;
            is_high && !sample.is_climbed
        };
        let finest = if self.ball().is_some() { FINEST_OF_BALL } else { FINEST };
        let finest = finest * self.options.side_step;
        let nearly = self.by_cell((0..heights.len()).filter(is_nearly), heights);
        let mut front: Vec<usize> = nearly.iter().map(|cell| cell[0]).collect();
        for _ in 0..CLIMBS {
            if front.is_empty() {
                break;
            }
            let threads = self.deliverer.options.threads;
            let beside = parallel::map(threads, &front, |&i| self.places.beside(&self.samples[i]));
            front.iter().for_each(|&i| self.samples[i].is_climbed = true);
            let low = front.iter().map(|&i| self.climbed_from(&self.samples[i]));
            let low = low.fold(f64::INFINITY, f64::min);
            let found = self.heights(&beside.concat(), path, low);
            let mut next = Vec::new();
            let mut known = 0;
            for (&from, beside) in front.iter().zip(beside) {
                let of = &found[known..known + beside.len()];
                known += beside.len();
                let highest = beside.into_iter().zip(of).max_by(|a, b| a.1.total_cmp(b.1));
                if let Some((sample, &height)) = highest.filter(|h| *h.1 > heights[from]) {
                    if height <= limit {
                        next.push(self.samples.len());
                    }
                    self.samples.push(sample);
                    heights.push(height);
                } else if heights[from] >= close && self.samples[from].spacing > finest {
                    self.samples[from].spacing *= 0.5;
                    next.push(from);
                }
            }
            front = next;
        }
    }

    /// Size of the cells in each of which the cutter is tested at one sample, mm.
    pub(super) fn cell(&self) -> f64 {
        CELL * self.options.side_step
    }

    /// Samples by the cells in which they lie, the highest of each first.
    pub(super) fn by_cell(
        &self,
        some: impl Iterator<Item = usize>,
        heights: &[f64],
    ) -> Vec<Vec<usize>> {
        let side = self.cell();
        let cell = |i: usize| (self.samples[i].at / side).to_array().map(|x| x.floor() as i64);
        let mut keyed: Vec<([i64; 3], usize)> = some.map(|i| (cell(i), i)).collect();
        keyed.order_by(|a, b| a.0.cmp(&b.0).then(heights[b.1].total_cmp(&heights[a.1])));
        let cells = keyed.chunk_by(|a, b| a.0 == b.0);
        cells.map(|cell| cell.iter().map(|c| c.1).collect()).collect()
    }

    /// The strokes of a path.
    pub(super) fn strokes(&self, path: &Toolpath) -> Strokes {
        let tool = &self.deliverer.options.pass.tool;
        Strokes::of(&near_links(path, tool.radius()), tool)
    }

    /// The height that a path leaves above the allowance on every sample, mm: exact above `enough`, an upper bound
    /// elsewhere.
    pub(super) fn heights(&self, samples: &[Sample], path: &Strokes, enough: f64) -> Vec<f64> {
        let pass = &self.deliverer.options.pass;
        let layer =
            Layer { allowance: pass.allowance, depth: CLAMP * self.options.limit, falls: false };
        let stages = self.before.with(path, pass.tool, pass.reach);
        let line = |s: &Sample| (Line { foot: s.at, normal: s.normal }, s.flat);
        let width = TOGETHER * self.options.side_step;
        let mut heights = vec![0.0; samples.len()];
        for (samples, heights) in samples.chunks(MANY).zip(heights.chunks_mut(MANY)) {
            let lines: Vec<(Line, DVec2)> = samples.iter().map(line).collect();
            let (columns, ids) = Columns::on(&lines, width, layer.top());
            let threads = self.deliverer.options.threads;
            let left = columns.remains(&stages, layer, pass.allowance + enough, threads);
            for (id, height) in ids.iter().zip(left.into_iter().flatten()) {
                heights[*id as usize] = height - pass.allowance;
            }
        }
        heights
    }
}

/// Whether a sample is nearly too high and clearly higher than those before and behind it; `heights`: from the one
/// before on, and from itself on, where every other one is on the same side of the pass.
fn is_top([before, here]: [&[f64]; 2], options: &RestOptions) -> bool {
    let (Some(&before), Some(&behind), Some(&here)) = (before.first(), here.get(2), here.first())
    else {
        return false;
    };
    (TOP * options.limit..=options.limit).contains(&here)
        && here >= before.max(behind)
        && here - before.min(behind) > CLEARLY * options.limit
}

/// The path with links longer than the radius as rapids, since on them the cutter arrives from above and may turn; a
/// link without length remains at their ends.
fn near_links(path: &Toolpath, radius: f64) -> Toolpath {
    let mut points: Vec<PathPoint> = Vec::with_capacity(path.points.len());
    for point in &path.points {
        let way = points.last().map_or(0.0, |before| before.tip.distance(point.tip));
        if point.kind == MoveKind::Link && way > radius {
            points.push(PathPoint { kind: MoveKind::Rapid, ..*point });
        }
        points.push(*point);
    }
    Toolpath { points }
}
