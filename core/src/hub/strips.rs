//! The passes of a channel as curves `t(s)`.
//!
//! - *Strip*: as wide as the side step that leaves cusps of the height that is aimed at; its width depends on the place.
//! - *Distance* of a place from a side, in strips: the least integral of `|dx| / width` over all ways there.
//!
//! Passes at the distance of a strip: (1) the distance from either side, `|grad F| = 1 / width`, marched from column to
//! column across the channel; (2) passes half a strip and whole strips more from both sides, those farther in only where
//! the gap that the others leave is wider than a strip. So the channel is filled from both blades, and where it widens further passes
//! begin in its middle. Such a pass begins in the middle of its gap, and not before the round end of its own strip
//! is needed to fill it.
//!
//! Passes at equal parts of the way across: `N = ceil(L / s) + 1` of them, `L` the longest line across, `s` the
//! narrowest strip (S-HUB, step 5).

use super::channel::{Channel, ROWS, cell, hermite, part};
use super::wheel::Wheel;
use crate::footprint::Footprint;
use crate::geometry::{DVec2, DVec3};
use crate::surface::ShapeOperator;

/// Steps across a channel in which distances are marched, at least and at most.
const STEPS: (usize, usize) = (192, 4096);
/// Rows to either side of a corner, and at an end, in which distances from a side are measured in space, and up to which distance, mm: there
/// chords are shorter than ways on the hub by less than a thousandth.
const AT_CORNER: usize = 16;
const AT_END: usize = 8;
/// By how much closer passes lie at a corner, which rows as far apart as these round off.
const CLOSER: f64 = 0.7;
const MEASURED_TO: f64 = 5.0;
/// Places of a side for each row, between which it is straight.
const FINER: usize = 8;
/// Columns at which strips are measured.
const MEASURED: usize = 33;
/// Share of the widest strip at which passes lie: distances are accurate to a few thousandths.
const SHARE: f64 = 0.995;
/// Distance of passes, in strips, from which on they are evenly spaced.
const EVEN: f64 = 0.9;
/// Distance of the outermost passes from the sides, strips: their strips reach up to them.
const OUTERMOST: f64 = 0.5;
/// Passes of a channel, at most.
const MOST: usize = 20_000;
/// Rows without a pass, over which it goes on none the less: a link would take as long.
const JOINED: usize = 8;
/// Rows by which a pass beside a side that comes within a strip of the other one is longer than it has to be.
const LONGER: f64 = 1.0;
/// How far ahead of the end of a pass its strip is taken to reach, half strips: in truth 1 on the pass, less beside it.
const AHEAD: f64 = 0.75;
/// The same in the rows at an end of the channel or a corner of a side, where distances are less certain.
const AHEAD_AT_END: f64 = 0.25;
/// Halvings of the way across in the search for the middle of a gap.
const HALVINGS: usize = 32;
/// Shortest pass, rows.
const SHORTEST: f64 = 0.25;

/// A pass: its `t` at every row, and the part of the channel over which it runs.
#[derive(Clone, Debug)]
pub struct Line {
    t: Vec<f64>,
    /// Its number across the channel; pieces of one level have the same.
    pub level: usize,
    /// First and last `s`.
    pub from: f64,
    pub to: f64,
}

impl Line {
    /// Its length on the hub, mm.
    pub fn length(&self, wheel: &Wheel, channel: &Channel) -> f64 {
        let pieces = 2 * ROWS;
        let place = |i: usize| {
            let s = self.from + (self.to - self.from) * i as f64 / pieces as f64;
            channel.place(wheel, s, self.at(s))
        };
        (1..=pieces).map(|i| place(i).distance(place(i - 1))).sum()
    }

    /// A pass through a `t` at every row.
    pub fn new(t: Vec<f64>, level: usize, (from, to): (f64, f64)) -> Self {
        Self { t, level, from, to }
    }

    /// Growth of its `t` with `s`.
    pub fn slope(&self, s: f64) -> f64 {
        const STEP: f64 = 1e-5;
        let (a, b) = ((s - STEP).max(0.0), (s + STEP).min(1.0));
        (self.at(b) - self.at(a)) / (b - a)
    }

    /// Its `t` at `s`.
    pub fn at(&self, s: f64) -> f64 {
        let (r, f) = cell(s, ROWS);
        hermite(|k| self.t[k], r, f, ROWS, |_| false).clamp(0.0, 1.0)
    }
}

/// What passes have to leave.
#[derive(Copy, Clone, Debug)]
pub struct Strip {
    pub footprint: Footprint,
    /// Height of cusps that is aimed at, mm.
    pub cusp: f64,
}

impl Strip {
    /// Width of the strip of a pass along `way`, of any length, at parameters of the hub, mm.
    fn width(&self, wheel: &Wheel, at: DVec2, way: DVec3) -> f64 {
        let jet = wheel.jet(at);
        let shape = ShapeOperator::from_derivatives(jet.first, jet.second);
        let normal = jet.normal();
        let across = normal.cross(way).normalize_or_zero();
        let bend = wheel.side() * shape.normal_curvature(across);
        SHARE * self.footprint.width(self.cusp, bend, 0.0)
    }
}

/// The metric of a channel and the strips at the nodes of a net.
#[derive(Clone, Debug)]
pub struct Measured {
    /// First fundamental form and width of a strip along the channel, by column, then row.
    nodes: Vec<[f64; 4]>,
    /// Longest line across, mm.
    pub longest: f64,
    /// Narrowest strip, mm.
    pub narrowest: f64,
    /// Least length that passes can have: the integral of the area over the width of strips, mm.
    pub floor: f64,
    /// Area, mm².
    pub area: f64,
}

impl Measured {
    /// Measures a channel.
    pub fn new(wheel: &Wheel, channel: &Channel, strip: &Strip) -> Self {
        let mut nodes = Vec::with_capacity(MEASURED * ROWS);
        let (mut floor, mut area, mut narrowest) = (0.0, 0.0, f64::INFINITY);
        for c in 0..MEASURED {
            for r in 0..ROWS {
                let (s, t) = (part(r, ROWS), part(c, MEASURED));
                let [along, across] = ways(wheel, channel, s, t);
                let width = strip.width(wheel, channel.at(s, t), along);
                let end = |i: usize, n: usize| if i == 0 || i + 1 == n { 0.5 } else { 1.0 };
                let weight = end(r, ROWS) * end(c, MEASURED) * part(1, ROWS) * part(1, MEASURED);
                let piece = along.cross(across).length() * weight;
                floor += piece / width * SHARE;
                area += piece;
                narrowest = width.min(narrowest);
                nodes.push([along.dot(along), along.dot(across), across.dot(across), width]);
            }
        }
        let line = |r: usize| {
            let place = |c: usize| channel.place(wheel, part(r, ROWS), part(c, MEASURED));
            (1..MEASURED).map(|c| place(c).distance(place(c - 1))).sum::<f64>()
        };
        let longest = (0..ROWS).map(line).fold(0.0, f64::max);
        Self { nodes, longest, narrowest, floor, area }
    }

    /// First fundamental form and width at a row, between columns.
    pub fn at(&self, row: usize, t: f64) -> [f64; 4] {
        let (c, f) = cell(t, MEASURED);
        let [a, b] = [c, c + 1].map(|c| self.nodes[c * ROWS + row]);
        core::array::from_fn(|i| a[i] + (b[i] - a[i]) * f)
    }

    /// Passes at equal parts of the way across.
    pub fn equal_parts(&self) -> Vec<Line> {
        let count = ((self.longest / self.narrowest).ceil() as usize + 1).clamp(2, MOST);
        let line =
            |level: usize| Line { t: vec![part(level, count); ROWS], level, from: 0.0, to: 1.0 };
        (0..count).map(line).collect()
    }

    /// Share of the area between passes that are at least 0.9 of a strip apart.
    pub fn even_share(&self, lines: &[Line]) -> f64 {
        let (mut even, mut all) = (0.0, 0.0);
        for row in 0..ROWS {
            let s = part(row, ROWS);
            let here = lines.iter().filter(|l| (l.from..=l.to).contains(&s)).map(|l| l.t[row]);
            let here: Vec<f64> = here.collect();
            for pair in here.windows(2) {
                let (t, width) = (0.5 * (pair[0] + pair[1]), (pair[1] - pair[0]).abs());
                let [e, f, g, w] = self.at(row, t);
                let density = (e * g - f * f).max(0.0).sqrt();
                let apart = width * density / e.sqrt() / w;
                all += width * density;
                even += if apart >= EVEN { width * density } else { 0.0 };
            }
        }
        if all > 0.0 { even / all } else { 0.0 }
    }

    /// Passes at the distance of a strip, in order across the channel.
    pub fn strips(&self, wheel: &Wheel, channel: &Channel) -> Vec<Line> {
        let [left, right] = [false, true].map(|right| self.distances(wheel, channel, right));
        let sides = Sides { left, right };
        let rows = || 0..ROWS;
        let corners: Vec<usize> =
            [false, true].into_iter().flat_map(|right| channel.corners_of(right)).collect();
        // The outermost ones; where the channel is no wider than a strip one in the middle will do.
        let outermost = |row: usize| OUTERMOST.min(0.5 * sides.left.at(row, 1.0));
        let all = |t: Vec<f64>| Line { t, level: 0, from: 0.0, to: 1.0 };
        let first = all(rows().map(|row| sides.left.place(row, outermost(row))).collect());
        let last_t = |row: usize| 1.0 - sides.right.place(row, outermost(row));
        let wide: Vec<bool> = rows().map(|row| sides.left.at(row, 1.0) > 1.0).collect();
        let last = runs(&wide).into_iter().map(|(from, to)| {
            let scale = part(1, ROWS);
            let from = (from as f64 - LONGER).max(0.0) * scale;
            let to = ((to as f64 + LONGER) * scale).min(1.0);
            Line { t: rows().map(last_t).collect(), level: 0, from, to }
        });
        let last: Vec<Line> = last.collect();
        let mut inner: [Vec<Vec<Line>>; 2] = [Vec::new(), Vec::new()];
        for number in 0..MOST {
            let middles: Vec<(f64, f64)> = rows().map(|row| sides.middle(row, number)).collect();
            let gaps: Vec<f64> = middles.iter().map(|(_, gap)| *gap).collect();
            let is_open: Vec<bool> = gaps.iter().zip(&wide).map(|(g, w)| *w && *g > 1.0).collect();
            if !is_open.contains(&true) {
                break;
            }
            let t: Vec<f64> = rows().map(|row| sides.inner(row, number, middles[row])).collect();
            let piece = |(from, to): (usize, usize)| {
                let (from, to) = self.ends(&corners, (&gaps, &t), (from, to));
                Line { t: t.clone(), level: 0, from, to }
            };
            inner[number % 2].push(runs(&is_open).into_iter().map(piece).collect());
        }
        let [from_left, from_right] = inner;
        let levels = core::iter::once(vec![first])
            .chain(from_left)
            .chain(from_right.into_iter().rev())
            .chain(core::iter::once(last));
        let numbered = levels
            .enumerate()
            .flat_map(|(level, pieces)| pieces.into_iter().map(move |line| Line { level, ..line }));
        numbered.collect()
    }

    /// Where a pass begins and ends that is needed from the one row to the other: the strips beside it part where the gap
    /// is one strip wide, and the round end of the cutter's own strip reaches ahead of it.
    fn ends(
        &self,
        corners: &[usize],
        (gaps, t): (&[f64], &[f64]),
        (first, last): (usize, usize),
    ) -> (f64, f64) {
        let head = |row: usize| {
            let [e, _, _, w] = self.at(row, t[row]);
            let near = |corner: usize| corner.abs_diff(row) <= AT_CORNER;
            let is_uncertain = is_at_end(row) || corners.iter().copied().any(near);
            let ahead = if is_uncertain { AHEAD_AT_END } else { AHEAD };
            ahead * 0.5 * w / e.sqrt() * (ROWS - 1) as f64
        };
        let parting = |outer: usize, inner: usize| {
            let (a, b) = (gaps[outer], gaps[inner]);
            let part = ((1.0 - a) / (b - a)).clamp(0.0, 1.0);
            outer as f64 + (inner as f64 - outer as f64) * if part.is_finite() { part } else { 0.0 }
        };
        let from = first.checked_sub(1).map(|outer| parting(outer, first) + head(first));
        let to = (last + 1 < ROWS).then(|| parting(last + 1, last) - head(last));
        let (mut low, mut high) = (from.unwrap_or(0.0), to.unwrap_or((ROWS - 1) as f64));
        if high - low < SHORTEST {
            // So short a gap is closed from its middle.
            let middle = 0.5 * (low + high);
            low = if from.is_some() { middle - 0.5 * SHORTEST } else { 0.0 };
            high = if to.is_some() { middle + 0.5 * SHORTEST } else { (ROWS - 1) as f64 };
        }
        let scale = part(1, ROWS);
        ((low * scale).max(0.0), (high * scale).min(1.0))
    }

    /// Distances from the left side, or from the right one with `t` running the other way.
    fn distances(&self, wheel: &Wheel, channel: &Channel, mirrored: bool) -> Distances {
        let corners = Corners::of(wheel, channel, mirrored);
        let form = |row: usize, t: f64| {
            let [e, f, g, w] = self.at(row, if mirrored { 1.0 - t } else { t });
            [e, if mirrored { -f } else { f }, g, w]
        };
        let ds = part(1, ROWS);
        let fastest = (0..ROWS)
            .flat_map(|r| (0..MEASURED).map(move |c| (r, part(c, MEASURED))))
            .map(|(r, t)| {
                let [e, f, ..] = form(r, t);
                (f / e).abs()
            })
            .fold(0.0, f64::max);
        let steps = ((3.0 * fastest / ds).ceil() as usize).clamp(STEPS.0, STEPS.1);
        let dt = 1.0 / steps as f64;
        let mut values = vec![0.0; (steps + 1) * ROWS];
        for k in 0..steps {
            let now = values[k * ROWS..(k + 1) * ROWS].to_vec();
            let first = slopes(&now, ds, |r, p| form_slope(form(r, k as f64 * dt), p));
            let half: Vec<f64> = now.iter().zip(&first).map(|(v, q)| v + 0.5 * dt * q).collect();
            let second = slopes(&half, ds, |r, p| form_slope(form(r, (k as f64 + 0.5) * dt), p));
            for r in 0..ROWS {
                values[(k + 1) * ROWS + r] = now[r] + dt * second[r];
                let t = (k + 1) as f64 * dt;
                let at = if mirrored { 1.0 - t } else { t };
                if let Some(distance) = corners.distance(wheel, channel, r, at) {
                    let narrower = 1.0 + CLOSER * corners.nearness(r);
                    values[(k + 1) * ROWS + r] = narrower * distance / form(r, t)[3];
                }
            }
        }
        Distances { values, steps }
    }
}

/// A side of a channel near its corners and ends, where the map is singular, and nothing is known beyond it: distances from
/// it are measured in space.
struct Corners {
    /// Places of the side, `FINER` for a row, mm.
    places: Vec<DVec3>,
    /// The rows of corners and ends, and how many rows to either side of each.
    rows: Vec<(usize, usize)>,
}

impl Corners {
    fn of(wheel: &Wheel, channel: &Channel, right: bool) -> Self {
        let corners = channel.corners_of(right).map(|row| (row, AT_CORNER));
        let rows: Vec<(usize, usize)> =
            [(0, AT_END), (ROWS - 1, AT_END)].into_iter().chain(corners).collect();
        let count = FINER * (ROWS - 1) + 1;
        let t = if right { 1.0 } else { 0.0 };
        let places = (0..count).map(|i| channel.place(wheel, part(i, count), t)).collect();
        Self { places, rows }
    }

    /// 1 at the row of a corner, 0 from half its reach on.
    fn nearness(&self, row: usize) -> f64 {
        let of = |&(corner, reach): &(usize, usize)| {
            if reach != AT_CORNER {
                return 0.0;
            }
            1.0 - (2.0 * corner.abs_diff(row) as f64 / reach as f64).min(1.0)
        };
        self.rows.iter().map(of).fold(0.0, f64::max)
    }

    /// Distance from the side, mm; `None` far from its corners and from the side.
    fn distance(&self, wheel: &Wheel, channel: &Channel, row: usize, t: f64) -> Option<f64> {
        if !self.rows.iter().any(|(corner, reach)| corner.abs_diff(row) <= *reach) {
            return None;
        }
        let place = channel.place(wheel, part(row, ROWS), t);
        let middle = FINER * row;
        let near = middle.saturating_sub(FINER * AT_CORNER)
            ..(middle + FINER * AT_CORNER + 1).min(self.places.len());
        let distance = |pair: &[DVec3]| {
            let way = pair[1] - pair[0];
            let along = (place - pair[0]).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
            place.distance(pair[0] + way * along.clamp(0.0, 1.0))
        };
        let least = self.places[near].windows(2).map(distance).fold(f64::INFINITY, f64::min);
        (least < MEASURED_TO).then_some(least)
    }
}

/// Directions along and across a channel at (s, t), mm per unit of the parameter.
pub fn ways(wheel: &Wheel, channel: &Channel, s: f64, t: f64) -> [DVec3; 2] {
    const STEP: f64 = 1e-4;
    let jet = wheel.jet(channel.at(s, t));
    let difference = |a: (f64, f64), b: (f64, f64)| {
        let d = channel.at(b.0, b.1) - channel.at(a.0, a.1);
        jet.first[0] * d.x + jet.first[1] * d.y
    };
    let between = |value: f64| ((value - STEP).max(0.0), (value + STEP).min(1.0));
    let ((s0, s1), (t0, t1)) = (between(s), between(t));
    [difference((s0, t), (s1, t)) / (s1 - s0), difference((s, t0), (s, t1)) / (t1 - t0)]
}

/// Growth of the distance across, `F_t`, for a growth along of `p = F_s`: the positive root of
/// `g^ss p² + 2 g^st p q + g^tt q² = 1/w²`; and how fast `s` changes with `t` along the way of that distance.
fn form_slope([e, f, g, w]: [f64; 4], p: f64) -> (f64, f64) {
    let det = (e * g - f * f).max(f64::MIN_POSITIVE);
    let (ss, st, tt) = (g / det, -f / det, e / det);
    let square = (st * p) * (st * p) - tt * (ss * p * p - 1.0 / (w * w));
    let root = square.max(0.0).sqrt();
    let q = ((root - st * p) / tt).max(0.0);
    let speed = (ss * p + st * q) / root.max(f64::MIN_POSITIVE);
    (q, speed)
}

/// The growth across at every row, with differences along from where the distance comes.
fn slopes(values: &[f64], ds: f64, of: impl Fn(usize, f64) -> (f64, f64)) -> Vec<f64> {
    let n = values.len();
    let slope = |r: usize| {
        let central = match r {
            0 => values[1] - values[0],
            r if r + 1 == n => values[n - 1] - values[n - 2],
            r => 0.5 * (values[r + 1] - values[r - 1]),
        };
        let (_, speed) = of(r, central / ds);
        let upwind = match (speed > 0.0, r) {
            (true, r) if r >= 2 => 1.5 * values[r] - 2.0 * values[r - 1] + 0.5 * values[r - 2],
            (false, r) if r + 2 < n => -1.5 * values[r] + 2.0 * values[r + 1] - 0.5 * values[r + 2],
            _ => central,
        };
        of(r, upwind / ds).0
    };
    (0..n).map(slope).collect()
}

/// Distances from a side, by steps across, then rows.
struct Distances {
    values: Vec<f64>,
    steps: usize,
}

impl Distances {
    /// The distance at a row.
    fn at(&self, row: usize, t: f64) -> f64 {
        let (k, f) = cell(t, self.steps + 1);
        let [a, b] = [k, k + 1].map(|k| self.values[k * ROWS + row]);
        a + (b - a) * f
    }

    /// The `t` of a distance at a row; 1 beyond the other side.
    fn place(&self, row: usize, distance: f64) -> f64 {
        let value = |k: usize| self.values[k * ROWS + row];
        let (mut low, mut high) = (0, self.steps);
        if value(high) <= distance {
            return 1.0;
        }
        while high - low > 1 {
            let middle = (low + high) / 2;
            if value(middle) <= distance { low = middle } else { high = middle }
        }
        let f = (distance - value(low)) / (value(high) - value(low));
        (low as f64 + f) / self.steps as f64
    }
}

/// Distances from both sides.
struct Sides {
    left: Distances,
    right: Distances,
}

impl Sides {
    /// The place between the two passes beside the inner pass of this number at which their strips are equally far away, and
    /// the gap there: 1 where they meet. The inner ones come in turn from the left and from the right, the outermost first.
    fn middle(&self, row: usize, number: usize) -> (f64, f64) {
        let of_left = OUTERMOST + number.div_ceil(2) as f64;
        let of_right = OUTERMOST + (number / 2) as f64;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let t = 0.5 * (low + high);
            let is_nearer = self.left.at(row, t) - of_left < self.right.at(row, 1.0 - t) - of_right;
            *(if is_nearer { &mut low } else { &mut high }) = t;
        }
        let t = 0.5 * (low + high);
        (t, self.left.at(row, t) - of_left + self.right.at(row, 1.0 - t) - of_right)
    }

    /// The `t` of that pass: a strip from the one before it on its side, but in the middle of a narrower gap, where its strip
    /// overlaps both.
    fn inner(&self, row: usize, number: usize, (middle, gap): (f64, f64)) -> f64 {
        let distance = OUTERMOST + (number / 2) as f64 + 1.0;
        match number % 2 {
            _ if gap < 2.0 => middle,
            0 => self.left.place(row, distance),
            _ => 1.0 - self.right.place(row, distance),
        }
    }
}

/// Whether a row is so near to an end of the channel that distances are measured in space.
fn is_at_end(row: usize) -> bool {
    row.min(ROWS - 1 - row) <= AT_END
}

/// First and last index of every run of what is so; short gaps are bridged.
fn runs(line: &[bool]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (i, _) in line.iter().enumerate().filter(|(_, v)| **v) {
        match runs.last_mut() {
            Some((_, last)) if i - *last <= JOINED => *last = i,
            _ => runs.push((i, i)),
        }
    }
    runs
}

#[cfg(test)]
mod tests;
