//! The removal rate on a stretch of the path, from dense columns of stock along the normals.
//!
//! Two sets of columns that share nothing measure it; how far they differ says how far their mean may be off.

use crate::cutter::{Cutter, Line, Piece};
use crate::part::{Mesh, doubled};
use crate::path::{Row, Sweep};
use crate::random::Random;
use evencut_core::geometry::DVec3;

/// A window of travel, cutter radii.
const WINDOW: f64 = 0.2;
/// Steps on a window.
const STEPS: f64 = 12.0;
/// Windows of a stretch on each side of its middle.
const ASIDE: f64 = 2.0;
/// Columns of a set that the stretch lowers, about.
const COLUMNS: f64 = 3000.0;
/// Distance of the columns that find out where those are: of cutter radii, and of side steps.
const COARSE: (f64, f64) = (1.0 / 12.0, 0.25);

/// What a stretch removes.
#[derive(Copy, Clone, Debug)]
pub struct Peak {
    /// Highest mean rate over a window, mm³/min.
    pub rate: f64,
    /// How far it may be off: the largest difference of the two sets on a window, mm³/min.
    pub noise: f64,
    /// Columns that were lowered.
    pub columns: usize,
}

/// The layer of stock over a surface.
#[derive(Copy, Clone, Debug)]
pub struct Layer {
    /// Height of its top above the surface, mm.
    pub top: f64,
    /// What may be cut into the surface, mm.
    pub floor: f64,
}

struct Step {
    piece: Piece,
    duration: f64,
    travel: f64,
}

/// Steps around the part `share` of a move, and the piece of the first move before them.
fn stretch(rows: &[Row], of: usize, share: f64, window: f64) -> (Vec<Step>, Option<Piece>) {
    let travel = |k: usize| {
        let (from, to) = (&rows[k], &rows[k + 1]);
        to.feed / 60.0 * (to.time - from.time)
    };
    let fed = |k: usize| k + 1 < rows.len() && !rows[k + 1].is_rapid() && rows[k + 1].feed > 0.0;
    let aside = ASIDE * window;
    let (mut first, mut back) = (of, share * travel(of));
    while back < aside && first > 0 && fed(first - 1) {
        first -= 1;
        back += travel(first);
    }
    let start = (back - aside).max(0.0) / travel(first).max(1e-12);
    let mut steps: Vec<Step> = Vec::new();
    let (mut k, mut at, mut gone) = (first, start.min(1.0), 0.0);
    let before = Piece { from: rows[k].pose, to: rows[k + 1].pose, of: k };
    let before = Piece { to: before.at(at), ..before };
    while fed(k) && gone < 2.0 * aside {
        let whole = Piece { from: rows[k].pose, to: rows[k + 1].pose, of: k };
        let (length, time) = (travel(k), rows[k + 1].time - rows[k].time);
        let end = (at + (2.0 * aside - gone) / length.max(1e-12)).min(1.0);
        let turn = whole.from.axis.distance(whole.to.axis) / 0.01;
        let count = ((end - at) * (length * STEPS / window).max(turn)).ceil().max(1.0);
        let part = (end - at) / count;
        for i in 0..count as usize {
            let (a, b) = (at + part * i as f64, at + part * (i + 1) as f64);
            let piece = Piece { from: whole.at(a), to: whole.at(b), of: k };
            steps.push(Step { piece, duration: time * part, travel: length * part });
        }
        gone += length * (end - at);
        (k, at) = (k + 1, 0.0);
    }
    (steps, (start > 0.0).then_some(before))
}

/// A column: its line, and the piece of a facet that it stands for, with the normals at its corners.
struct Column {
    line: Line,
    corners: [DVec3; 3],
    normals: [DVec3; 3],
}

impl Column {
    /// Its section at a height: that of the piece, each corner moved along its normal; none where they have met.
    fn section(&self, height: f64) -> f64 {
        let moved = [0, 1, 2].map(|k| self.corners[k] + height * self.normals[k]);
        0.5 * doubled(moved).dot(doubled(self.corners).normalize_or_zero()).max(0.0)
    }

    /// Its volume between two heights, by Simpson's rule: sections are quadratic.
    fn volume(&self, low: f64, high: f64) -> f64 {
        let middle = 0.5 * (low + high);
        (high - low) * (self.section(low) + 4.0 * self.section(middle) + self.section(high)) / 6.0
    }
}

/// Random columns, one in each piece of the facets that is as small as `spacing` squared.
fn columns(mesh: &Mesh, faces: &[usize], spacing: f64, random: &mut Random) -> Vec<Column> {
    let mut out = Vec::new();
    for &face in faces {
        let mut open = vec![[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
        while let Some(corners) = open.pop() {
            let places = corners.map(|w| mesh.place(face, w).at);
            let area = 0.5 * doubled(places).length();
            let side = |k: usize| places[k].distance_squared(places[(k + 1) % 3]);
            let k = (0..3).fold(0, |best, k| if side(k) > side(best) { k } else { best });
            if area > spacing * spacing || side(k) > 9.0 * spacing * spacing {
                let (a, b, c) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
                let m = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
                open.extend([[a, m, c], [m, b, c]]);
                continue;
            }
            let (mut u, mut v) = (random.unit(), random.unit());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let w = [0, 1, 2]
                .map(|i| corners[0][i] * (1.0 - u - v) + corners[1][i] * u + corners[2][i] * v);
            let place = mesh.place(face, w);
            let normals = corners.map(|w| mesh.place(face, w).normal);
            let line = Line { foot: place.at, along: place.normal };
            out.push(Column { line, corners: places, normals });
        }
    }
    out
}

/// Whether the cutter may enter a column on some of the poses of a stretch.
fn touched(cutter: &Cutter, line: Line, layer: Layer, steps: &[Step], slack: f64) -> bool {
    steps.iter().step_by(4).any(|s| {
        let pose = s.piece.from;
        [0.0, 0.5, 1.0].iter().any(|t| cutter.distance(&pose, line.at(t * layer.top)) < slack)
    })
}

/// Volume that each step takes.
fn taken(
    sweep: &Sweep,
    columns: &[Column],
    steps: &[Step],
    before: Option<Piece>,
    layer: Layer,
) -> (Vec<f64>, Vec<DVec3>) {
    let (mut volumes, mut lowered) = (vec![0.0; steps.len()], Vec::new());
    let first = steps[0].piece.of;
    for column in columns {
        let line = column.line;
        let found = sweep.lowest(line, layer.floor, layer.top, &|of| of < first);
        let mut height = found.map_or(layer.top, |f| f.0);
        for piece in before
            .iter()
            .flat_map(|b| crate::path::pieces(b.from, b.to, b.of, 0.5 * sweep.cutter.radius))
        {
            height = sweep.cutter.lowest(&piece, line, layer.floor, height).unwrap_or(height);
        }
        let start = height;
        for (step, volume) in steps.iter().zip(&mut volumes) {
            if height <= layer.floor {
                break;
            }
            // Steps are a sixtieth of the radius: what stays between their ends is a 30,000th of it.
            let pose = step.piece.to;
            let middle = 0.5 * (layer.floor + height);
            let off = |t: f64| sweep.cutter.distance(&pose, line.at(t)) > 0.0;
            if off(height) && off(middle) {
                continue;
            }
            if let Some((low, _)) = sweep.cutter.span(&pose, line, layer.floor, height) {
                *volume += column.volume(low, height);
                height = low;
            }
        }
        if height < start {
            lowered.push(line.foot);
        }
    }
    (volumes, lowered)
}

/// Rates over all windows that begin at a step, mm³/min.
fn rates(steps: &[Step], volumes: &[f64], window: f64) -> Vec<f64> {
    let mut out = Vec::new();
    for start in 0..steps.len() {
        let (mut travel, mut time, mut volume) = (0.0, 0.0, 0.0);
        for k in start..steps.len() {
            let rest = window - travel;
            let part = if steps[k].travel > rest { rest / steps[k].travel } else { 1.0 };
            travel += part * steps[k].travel;
            time += part * steps[k].duration;
            volume += part * volumes[k];
            if travel >= window * (1.0 - 1e-9) {
                break;
            }
        }
        // A stretch shorter than a window is one.
        if (travel >= window * (1.0 - 1e-9) || start == 0) && time > 0.0 {
            out.push(60.0 * volume / time);
        }
    }
    out
}

/// The highest rate around a part of a move. `None` where nothing is taken there.
pub fn peak(
    sweep: &Sweep,
    rows: &[Row],
    mesh: &Mesh,
    layer: Layer,
    side_step: f64,
    (of, share): (usize, f64),
    random: &mut Random,
) -> Option<Peak> {
    let cutter = &sweep.cutter;
    let window = WINDOW * cutter.radius;
    let (steps, before) = stretch(rows, of, share, window);
    let (first, last) = (steps.first()?, steps.last()?);
    let centre = 0.5 * (first.piece.from.tip + last.piece.to.tip);
    let far = steps.iter().map(|s| s.piece.to.tip.distance(centre)).fold(0.0, f64::max);
    let reach = far + 1.5 * cutter.radius + layer.top;
    let mut faces = mesh.within(centre + first.piece.from.axis * (0.5 * cutter.radius), reach);
    faces.sort_unstable();
    faces.dedup();
    let coarse = (COARSE.0 * cutter.radius).min(COARSE.1 * side_step);
    let kept = |c: &Column| touched(cutter, c.line, layer, &steps, coarse + window);
    let set: Vec<Column> = columns(mesh, &faces, coarse, random).into_iter().filter(kept).collect();
    let (_, lowered) = taken(sweep, &set, &steps, before, layer);
    let spacing = coarse * (lowered.len() as f64 / COLUMNS).sqrt().min(1.0);
    let near = |c: &Column| lowered.iter().any(|l| l.distance(c.line.foot) < 2.0 * coarse);
    let mut sets = Vec::new();
    let mut count = 0;
    for _ in 0..2 {
        let set: Vec<Column> =
            columns(mesh, &faces, spacing, random).into_iter().filter(near).collect();
        let (volumes, lowered) = taken(sweep, &set, &steps, before, layer);
        sets.push(rates(&steps, &volumes, window));
        count += lowered.len();
    }
    let pairs = || sets[0].iter().zip(&sets[1]);
    let rate = pairs().map(|(a, b)| 0.5 * (a + b)).fold(0.0, f64::max);
    let noise = pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (count > 0).then_some(Peak { rate, noise, columns: count })
}

/// The part of a move whose tip is the nearest to a place.
pub fn share_of(rows: &[Row], of: usize, place: DVec3) -> f64 {
    let (a, b) = (rows[of].pose.tip, rows[of + 1].pose.tip);
    let way = b - a;
    ((place - a).dot(way) / way.length_squared().max(1e-24)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Pose;
    use crate::part::tests::sheet;

    fn straight(passes: &[f64], feed: f64) -> Vec<Row> {
        let mut out = Vec::new();
        let mut time = 0.0;
        for (i, y) in passes.iter().enumerate() {
            for (k, x) in [-8.0, 8.0].into_iter().enumerate() {
                let x = if i % 2 == 0 { x } else { -x };
                time += if k == 1 { 16.0 / feed * 60.0 } else { 1.0 };
                out.push(Row {
                    kind: if k == 0 { "rapid" } else { "cut" }.into(),
                    pass: i as u32,
                    pose: Pose { tip: DVec3::new(x, *y, 0.0), axis: DVec3::Z },
                    feed,
                    time,
                });
            }
        }
        out
    }

    /// A second pass beside a first takes side step times depth times feed, whatever the cutter.
    #[test]
    fn a_straight_pass_takes_step_times_depth_times_feed() {
        let mesh = Mesh::of(sheet(10.0, 10, |_, _| 0.0));
        let layer = Layer { top: 0.5, floor: -0.01 };
        for corner in [0.0, 1.0, 2.0] {
            let cutter = Cutter { radius: 2.0, corner, length: f64::INFINITY };
            let rows = straight(&[-1.0, -0.2], 600.0);
            let sweep = Sweep::new(&rows, cutter);
            let mut random = Random::new(1);
            let peak = peak(&sweep, &rows, &mesh, layer, 0.8, (2, 0.5), &mut random).unwrap();
            // A ball leaves a cusp; the others' bottom is wider than the step.
            let cusp = if corner == 2.0 { cusp(corner, 0.8) } else { 0.0 };
            let expected = (0.8 * 0.5 - cusp) * 600.0;
            assert!(
                (peak.rate - expected).abs() < peak.noise + 0.01 * expected,
                "{peak:?} {expected}"
            );
            assert!(peak.noise < 0.1 * expected, "{peak:?} {expected}");
        }
    }

    /// Area under the cusp that a corner leaves over a side step, mm².
    fn cusp(corner: f64, step: f64) -> f64 {
        let n = 10_000;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 0.5 * step;
        let height = |x: f64| corner - (corner * corner - x * x).sqrt();
        (0..n).map(|i| height(at(i))).sum::<f64>() / f64::from(n) * step
    }
}
