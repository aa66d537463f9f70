//! What the passes of a channel leave too high, and passes over that.
//!
//! Passes are laid out by distances on a net; where its lines bend, where passes begin between others, and at the rim
//! they may come out a little too far apart. What is left there is measured on the finished path, on columns of material in the
//! middle of all gaps between passes and at the sides.
//!
//! Steps: (1) the places at which heights are measured ([`gaps`]); (2) their heights ([`Gauge`]); (3) a pass that begins or
//! ends beside a place that is too high is made longer, so that it runs there, too; elsewhere one in the middle of the gap is
//! added ([`with_rest`]).

use super::channel::{Channel, ROWS, cell, part};
use super::strips::{Line, Measured};
use super::wheel::Wheel;
use crate::geometry::{DVec2, OrderBy};
use crate::removal::{Columns, Cutter, Layer, Line as Ray, Stage, Strokes};
use crate::toolpath::Toolpath;

/// Heights are clamped at this multiple of the limit.
const CLAMP: f64 = 10.0;
/// Rows for each strip's width at which gaps between passes are looked at, and at most.
const LOOKED_AT: f64 = 3.0;
const MOST_ROWS: f64 = 8192.0;
/// Places that are looked at, at most: with many passes rows lie farther apart.
const MOST_PLACES: f64 = 3e6;
/// How far beside the middle of a gap heights are looked at, too, parts of the gap: crests may lie beside it.
const BESIDE: f64 = 0.06;
/// How far from what is too high a pass may end that is made longer, and how far passes run beyond it, strips.
const NEAR: f64 = 3.0;
const BEYOND: f64 = 0.5;

/// A place between two passes, or between a pass and a side.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Gap {
    pub s: f64,
    pub t: f64,
    /// The passes on both sides of it; `None` at a side.
    between: [Option<usize>; 2],
    /// The area for which it stands, mm².
    pub area: f64,
}

/// A place that passes leave higher than they should.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TooHigh {
    pub gap: Gap,
    /// Height over the allowance, mm.
    pub height: f64,
}

/// The middles of all gaps between passes, places close beside them, and the sides of the channel.
pub fn gaps(measured: &Measured, lines: &[Line]) -> Vec<Gap> {
    let along = |row: usize| measured.at(row, 0.5)[0].sqrt();
    let long: f64 = (1..ROWS).map(|row| 0.5 * (along(row - 1) + along(row))).sum();
    let long = long * part(1, ROWS);
    let fewest = (ROWS - 1) as f64;
    let most = (MOST_PLACES / (3.0 * (lines.len() + 1) as f64)).clamp(fewest, MOST_ROWS);
    let rows = (LOOKED_AT * long / measured.narrowest).clamp(fewest, most).ceil() as usize + 1;
    let mut gaps = Vec::new();
    for s in (0..rows).map(|row| part(row, rows)) {
        let here = lines.iter().enumerate().filter(|(_, l)| (l.from..=l.to).contains(&s));
        let here = here.map(|(i, l)| (l.at(s), Some(i))).chain([(0.0, None), (1.0, None)]);
        let mut here: Vec<(f64, Option<usize>)> = here.collect();
        here.order_by(|a, b| a.0.total_cmp(&b.0));
        let (row, _) = cell(s, ROWS);
        for pair in here.windows(2) {
            let ((low, first), (high, second)) = (pair[0], pair[1]);
            let at = |x: f64| low + (high - low) * x;
            let beside: &[f64] = match (first, second) {
                (None, None) => &[0.0, 0.5, 1.0],
                (None, _) => &[0.0],
                (_, None) => &[1.0],
                _ => &[0.5 - BESIDE, 0.5, 0.5 + BESIDE],
            };
            let [e, f, g, _] = measured.at(row, at(0.5));
            let area = (e * g - f * f).max(0.0).sqrt() * (high - low) * part(1, rows);
            let area = area / beside.len() as f64;
            let between = [first, second];
            gaps.extend(beside.iter().map(|x| Gap { s, t: at(*x), between, area }));
        }
    }
    gaps
}

/// The path and the cutter that leaves heights.
pub struct Gauge<'a> {
    pub wheel: &'a Wheel,
    /// Its cutter.
    pub cutter: Cutter,
    /// Allowance left on the hub, mm.
    pub allowance: f64,
    /// Height over the allowance above which places are too high, mm.
    pub limit: f64,
    pub threads: usize,
}

impl Gauge<'_> {
    /// The places of each part of a channel that the path leaves too high. `contacts`: parameters of the hub, of each point of
    /// the path.
    pub fn too_high(
        &self,
        mut path: Toolpath,
        contacts: &[Option<DVec2>],
        parts: &[(&Channel, Vec<Gap>)],
    ) -> Vec<Vec<TooHigh>> {
        let mm = self.scale(parts);
        for (point, at) in path.points.iter_mut().zip(contacts) {
            point.flat = at.map(|at| at * mm);
        }
        let all =
            || parts.iter().flat_map(|(channel, gaps)| gaps.iter().map(move |g| (channel, g)));
        let ray = |(channel, gap): (&&Channel, &Gap)| {
            let at = channel.at(gap.s, gap.t);
            (Ray { foot: self.wheel.hub.point(at), normal: self.wheel.normal(at) }, at * mm)
        };
        let rays: Vec<(Ray, DVec2)> = all().map(ray).collect();
        let layer = Layer { allowance: self.allowance, depth: CLAMP * self.limit, falls: false };
        let (columns, ids) = Columns::on(&rays, f64::INFINITY, layer.top());
        let strokes = Strokes::of(&path, &self.cutter.tool);
        let stages = [Stage { strokes: &strokes, cutter: self.cutter }];
        let left = columns.remains(&stages, layer, self.allowance + self.limit, self.threads);
        let mut heights = vec![0.0; rays.len()];
        for (id, height) in ids.iter().zip(left.into_iter().flatten()) {
            heights[*id as usize] = height - self.allowance;
        }
        let mut heights = heights.into_iter();
        let high = |(_, gaps): &(&Channel, Vec<Gap>)| {
            let all = gaps.iter().zip(heights.by_ref());
            let high = all.filter(|(_, height)| *height > self.limit);
            high.map(|(gap, height)| TooHigh { gap: *gap, height }).collect()
        };
        parts.iter().map(high).collect()
    }

    /// mm per unit of either parameter, in the middle of the channel.
    fn scale(&self, parts: &[(&Channel, Vec<Gap>)]) -> DVec2 {
        let middle = parts.first().map_or(DVec2::ZERO, |(channel, _)| channel.at(0.5, 0.5));
        let jet = self.wheel.jet(middle);
        DVec2::new(jet.first[0].length(), jet.first[1].length())
    }
}

/// Passes that run over what they left too high, too.
pub fn with_rest(measured: &Measured, mut lines: Vec<Line>, places: &[TooHigh]) -> Vec<Line> {
    let known = lines.len();
    let mut places: Vec<&TooHigh> = places.iter().collect();
    places.order_by(|a, b| a.gap.between.cmp(&b.gap.between).then(a.gap.s.total_cmp(&b.gap.s)));
    // `s` of a strip's width about a place.
    let strip = |gap: &Gap| {
        let row = (gap.s * (ROWS - 1) as f64).round() as usize;
        let [e, _, _, w] = measured.at(row, gap.t);
        w / e.sqrt()
    };
    let is_next = |a: &&TooHigh, b: &&TooHigh| {
        a.gap.between == b.gap.between && b.gap.s - a.gap.s < NEAR * strip(&a.gap)
    };
    for run in places.chunk_by(is_next) {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
        let [before, after] = first.gap.between.map(|i| i.map(|i| lines[i].clone()));
        let side = |line: &Option<Line>, side: f64, s: f64| line.as_ref().map_or(side, |l| l.at(s));
        let bounds = |s: f64| (side(&before, 0.0, s), side(&after, 1.0, s));
        let (near, beyond) = (NEAR * strip(&first.gap), BEYOND * strip(&first.gap));
        let (from, to) = (first.gap.s - beyond, last.gap.s + beyond);
        let is_between = |line: &Line, s: f64| {
            let (low, high) = bounds(s);
            (low..high).contains(&line.at(s)) && line.at(s) > low
        };
        // A pass that begins behind it, or ends before it.
        let ends_near = |line: &&mut Line| {
            let behind = line.from > 0.0 && (last.gap.s..last.gap.s + near).contains(&line.from);
            let ahead = line.to < 1.0 && (first.gap.s - near..first.gap.s).contains(&line.to);
            (behind || ahead) && is_between(line, first.gap.s) && is_between(line, last.gap.s)
        };
        match lines[..known].iter_mut().find(ends_near) {
            Some(line) => {
                line.from = line.from.min(from.max(0.0));
                line.to = line.to.max(to.min(1.0));
            }
            None => {
                let middle = |row: usize| {
                    let (low, high) = bounds(part(row, ROWS));
                    0.5 * (low + high)
                };
                let level = before.as_ref().map_or(0, |line| line.level);
                let range = (from.max(0.0), to.min(1.0));
                lines.push(Line::new((0..ROWS).map(middle).collect(), level, range));
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests;
