//! A path cuts columns: the volume that every short piece of it removes.
//!
//! Blocks of columns are independent of each other. Each goes through all pieces in time order and down its tree: a
//! node is skipped where a supporting plane of the cutter, at the point nearest to the node's middle, has everything
//! that is left of the node's columns on its other side.

use super::body::{Body, Cutter, Layer, Pose, Stroke};
use super::columns::{Block, Bound, Columns};
use crate::geometry::{DVec3, OrderBy, math};
use crate::machine_time::feed_length;
use crate::parallel;
use crate::tool::Tool;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use core::ops::Range;

/// Longest piece as a fraction of the cutter radius.
const LONGEST: f64 = 0.1;
/// Longest piece as a fraction of the corner radius: at its end the corner is still over the place where it was
/// lowest.
const LONGEST_AT_CORNER: f64 = 0.4;
/// Largest turn of the axis in a piece, rad.
const LARGEST_TURN: f64 = 0.026;
/// Pieces that are tested together against a block.
const RUN: usize = 64;
/// Pieces that are tested together against a tile, and most of such runs in a leaf of the tree over them.
const SHORT: usize = 8;
const FEW: usize = 4;
/// A node is opened only for what is deeper than this, mm: allows for rounding and the faces of the mesh.
const NEGLIGIBLE: f64 = 2e-4;
/// Greatest length of the cutter, cutter radii, that is tested against planes.
const LENGTH: f64 = 20.0;

/// A short piece of a move.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Piece {
    /// Fraction of the move that is done at its end.
    pub end: f64,
    /// Length to which the feed refers, mm.
    pub length: f64,
    /// Volume removed, mm³.
    pub volume: f64,
}

/// What a path removed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Removed {
    /// Where the pieces of the move to each point begin, and their number last.
    pub first: Vec<usize>,
    /// The pieces, in time order.
    pub pieces: Vec<Piece>,
    /// Heights left of the columns, mm, block by block.
    pub(super) heights: Vec<Vec<f64>>,
}

impl Removed {
    /// With what the same path removed of other columns as well.
    pub fn with(mut self, other: &Self) -> Self {
        for (piece, other) in self.pieces.iter_mut().zip(&other.pieces) {
            piece.volume += other.volume;
        }
        self
    }

    /// The pieces of the move that ends at point `i`.
    pub fn of_move(&self, i: usize) -> &[Piece] {
        &self.pieces[self.first[i]..self.first[i + 1]]
    }
}

/// Pieces that lie together: all tips are within a cylinder, whose ends are in the direction of the path there.
#[derive(Debug)]
pub(super) struct Run {
    middle: DVec3,
    /// Unit direction of the cylinder, or zero.
    along: DVec3,
    /// Half its length, mm.
    half: f64,
    /// Its radius, mm.
    across: f64,
    axis: DVec3,
    /// Sine of the largest angle of an axis to that, at least.
    spread: f64,
}

impl Run {
    fn of(strokes: &[Stroke]) -> Self {
        let poses = || strokes.iter().flat_map(|s| [s.from, s.to]);
        let count = 2.0 * strokes.len().max(1) as f64;
        let middle = poses().map(|p| p.tip).sum::<DVec3>() / count;
        let axis = poses().map(|p| p.axis).sum::<DVec3>().normalize_or(DVec3::Z);
        let spread = poses().map(|p| p.axis.distance(axis)).fold(0.0, f64::max);
        let ends = strokes.first().zip(strokes.last());
        let along = ends.map_or(DVec3::ZERO, |(a, b)| (b.to.tip - a.from.tip).normalize_or_zero());
        let (mut half, mut across) = (0.0f64, 0.0f64);
        for pose in poses() {
            let off = pose.tip - middle;
            let part = off.dot(along);
            half = half.max(part.abs());
            across = across.max((off - along * part).length());
        }
        Self { middle, along, half, across, axis, spread }
    }

    /// Whether the cutter may come near a sphere.
    fn reaches(&self, place: DVec3, radius: f64, body: &Body) -> bool {
        let q = place - self.middle;
        let up = q.dot(self.axis);
        let reach = radius + (self.half + self.across) + body.reach();
        let across = (q - self.axis * up).length();
        up > -reach && across <= reach + self.spread * (q.length() + reach)
    }

    /// Whether the cutter may cut what is left of a bound up to `level`.
    fn cuts(&self, bound: &Bound, level: f64, body: &Body) -> bool {
        let pose = Pose { tip: self.middle, axis: self.axis };
        let farther = |d: DVec3| {
            let along = d.dot(self.along);
            along.abs() * self.half + (1.0 - along * along).max(0.0).sqrt() * self.across
        };
        cuts(&pose, self.spread, farther, bound, level, body)
    }
}

impl Columns {
    /// Runs a path through the columns, on `threads` threads, on which the result does not depend.
    pub fn cut(&self, path: &Toolpath, cutter: Cutter, layer: Layer, threads: usize) -> Removed {
        let body = Body::new(cutter, layer, self.spacing);
        let (mut removed, strokes, at) = cut_to_pieces(&path.points, &cutter.tool);
        let runs: Vec<Run> = strokes.chunks(RUN).map(Run::of).collect();
        let cut = parallel::map(threads, &self.blocks, |block| {
            let heights = block.heights.clone();
            let mut work = BlockCut::new(block, &body, heights, f64::NEG_INFINITY);
            work.run(&strokes, &runs);
            (work.heights, work.taken)
        });
        for (heights, taken) in cut {
            for (stroke, volume) in taken {
                removed.pieces[at[stroke as usize]].volume += volume;
            }
            removed.heights.push(heights);
        }
        removed
    }
}

/// Short runs of a path's strokes, in a tree by place: passes beside each other are far apart in the path.
#[derive(Debug)]
pub(super) struct Runs {
    /// Runs of [`SHORT`] strokes.
    short: Vec<Run>,
    /// Their numbers in the order of the leaves.
    order: Vec<u32>,
    /// The root first, the first child of a node behind it.
    nodes: Vec<RunNode>,
}

/// Runs that lie together in space: tips between two corners of a box.
#[derive(Debug)]
struct RunNode {
    low: DVec3,
    high: DVec3,
    axis: DVec3,
    /// Sine of the largest angle of an axis to that, at least.
    spread: f64,
    /// Its runs in the order of the leaves.
    runs: Range<usize>,
    /// Its second child; none for a leaf.
    second: Option<u32>,
}

impl RunNode {
    /// As [`Run::cuts`].
    fn cuts(&self, bound: &Bound, level: f64, body: &Body) -> bool {
        let place = bound.middle + bound.normal * level;
        let nearest = (place - self.axis * body.reach()).clamp(self.low, self.high);
        let pose = Pose { tip: nearest, axis: self.axis };
        let middle = 0.5 * (self.low + self.high);
        let half = 0.5 * (self.high - self.low);
        let farther = |d: DVec3| d.abs().dot(half) + d.dot(middle - nearest);
        cuts(&pose, self.spread, farther, bound, level, body)
    }
}

impl Runs {
    pub fn of(strokes: &[Stroke]) -> Self {
        let short: Vec<Run> = strokes.chunks(SHORT).map(Run::of).collect();
        let boxes: Vec<(DVec3, DVec3)> = strokes
            .chunks(SHORT)
            .map(|run| {
                let tips = run.iter().flat_map(|s| [s.from.tip, s.to.tip]);
                tips.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
            })
            .collect();
        let mut order: Vec<u32> = (0..short.len() as u32).collect();
        let mut nodes = Vec::new();
        if !order.is_empty() {
            let count = order.len();
            add_runs(&short, &boxes, &mut order, 0..count, &mut nodes);
        }
        Self { short, order, nodes }
    }

    /// The short runs that may cut what is left of a bound up to `level`, in the order of the path.
    fn near(&self, bound: &Bound, level: f64, body: &Body) -> Vec<usize> {
        let mut near = Vec::new();
        let mut open: Vec<usize> = (0..self.nodes.len().min(1)).collect();
        while let Some(n) = open.pop() {
            let node = &self.nodes[n];
            if !node.cuts(bound, level, body) {
                continue;
            }
            match node.second {
                Some(second) => open.extend([n + 1, second as usize]),
                None => {
                    let runs = self.order[node.runs.clone()].iter().map(|r| *r as usize);
                    near.extend(runs.filter(|r| self.short[*r].cuts(bound, level, body)));
                }
            }
        }
        near.order_total();
        near
    }
}

/// Adds the node of a range of runs and those below it.
fn add_runs(
    short: &[Run],
    boxes: &[(DVec3, DVec3)],
    order: &mut [u32],
    runs: Range<usize>,
    nodes: &mut Vec<RunNode>,
) {
    let ids = &mut order[runs.clone()];
    let around = ids.iter().map(|r| boxes[*r as usize]);
    let (low, high) =
        around.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), b| (l.min(b.0), h.max(b.1)));
    let axis = ids.iter().map(|r| short[*r as usize].axis).sum::<DVec3>().normalize_or(DVec3::Z);
    let spread = |r: &u32| {
        let run = &short[*r as usize];
        run.axis.distance(axis) + run.spread
    };
    let spread = ids.iter().map(spread).fold(0.0, f64::max);
    let index = nodes.len();
    nodes.push(RunNode { low, high, axis, spread, runs: runs.clone(), second: None });
    if runs.len() <= FEW {
        return;
    }
    let middles = |r: u32| short[r as usize].middle;
    let wide = high - low;
    let along = (0..3).fold(0, |best, k| if wide[k] > wide[best] { k } else { best });
    let half = runs.len() / 2;
    ids.select_nth_unstable_by(half, |a, b| {
        middles(*a)[along].total_cmp(&middles(*b)[along]).then(a.cmp(b))
    });
    add_runs(short, boxes, order, runs.start..runs.start + half, nodes);
    nodes[index].second = Some(nodes.len() as u32);
    add_runs(short, boxes, order, runs.start + half..runs.end, nodes);
}

/// Whether a cutter may cut what is left of a bound up to `level`: else a plane parts the two. Its tips are as much
/// farther than that of `pose` in a direction as `farther` says, its axes within `spread` of that.
fn cuts(
    pose: &Pose,
    spread: f64,
    farther: impl Fn(DVec3) -> f64,
    bound: &Bound,
    level: f64,
    body: &Body,
) -> bool {
    let Some(d) = body.direction_to(pose, bound.middle + bound.normal * level) else {
        return true;
    };
    let length = body.length().min(LENGTH * body.reach());
    let up = d.dot(pose.axis);
    // Turned by the spread, the body extends farther by at most that times what of it is beside the tip.
    let beside = if up < -spread { body.reach() } else { body.reach() + length };
    let support = body.support(pose, d, length) + farther(d) + spread * beside;
    bound.least_along(d, level) < support - NEGLIGIBLE
}

/// The pieces of a path; the moves of those that may cut, and which piece each is.
pub(super) fn cut_to_pieces(
    points: &[PathPoint],
    tool: &Tool,
) -> (Removed, Vec<Stroke>, Vec<usize>) {
    let mut removed = Removed { first: vec![0, 0], ..Removed::default() };
    let (mut strokes, mut at) = (Vec::new(), Vec::new());
    for pair in points.windows(2) {
        let (from, to) = (pose(&pair[0]), pose(&pair[1]));
        let length = feed_length(&pair[0], &pair[1], tool);
        let cuts = pair[1].kind != MoveKind::Rapid;
        let count = if cuts { piece_count(&from, &to, length, tool) } else { 1 };
        for i in 0..count {
            let part = |k: usize| k as f64 / count as f64;
            if cuts {
                let stroke = Stroke::new(from.toward(&to, part(i)), from.toward(&to, part(i + 1)));
                at.push(removed.pieces.len());
                strokes.push(stroke);
            }
            let length = length / count as f64;
            removed.pieces.push(Piece { end: part(i + 1), length, volume: 0.0 });
        }
        removed.first.push(removed.pieces.len());
    }
    if points.is_empty() {
        removed.first.truncate(1);
    }
    (removed, strokes, at)
}

fn pose(point: &PathPoint) -> Pose {
    Pose { tip: point.tip, axis: point.axis }
}

fn piece_count(from: &Pose, to: &Pose, length: f64, tool: &Tool) -> usize {
    let turn = math::acos_clamped(from.axis.dot(to.axis));
    let longest = match tool.corner_radius() {
        corner if corner > 0.0 => (LONGEST * tool.radius()).min(LONGEST_AT_CORNER * corner),
        _ => LONGEST * tool.radius(),
    };
    let pieces = (length / longest).max(turn / LARGEST_TURN);
    // A rounding error more is not a piece more.
    (pieces - 1e-9).ceil().clamp(1.0, 1e6) as usize
}

/// A plane across `d`: the cutter keeps to `d . x <= reach`.
struct Plane {
    d: DVec3,
    reach: f64,
}

/// One block being cut.
pub(super) struct BlockCut<'a> {
    block: &'a Block,
    body: &'a Body,
    pub heights: Vec<f64>,
    /// Columns of at most this height are no longer looked at.
    enough: f64,
    /// Per node the level below which everything left of it lies; minus infinity where nothing is left.
    levels: Vec<f64>,
    /// Per tile, its node.
    nodes: Vec<u32>,
    /// Pieces that took something, and the volume.
    taken: Vec<(u32, f64)>,
    open: Vec<u32>,
}

impl<'a> BlockCut<'a> {
    /// A block whose columns are `heights` high; those of at most `enough` are left as they are.
    pub fn new(block: &'a Block, body: &'a Body, heights: Vec<f64>, enough: f64) -> Self {
        let mut nodes = vec![0; block.tiles.len()];
        for (i, node) in block.nodes.iter().enumerate() {
            if node.children.is_none() {
                nodes[node.tile as usize] = i as u32;
            }
        }
        let levels = vec![f64::INFINITY; block.nodes.len()];
        let (taken, open) = (Vec::new(), Vec::new());
        let mut cut = Self { block, body, heights, enough, levels, nodes, taken, open };
        (0..block.tiles.len()).for_each(|t| cut.set_level(t));
        cut
    }

    /// Sets the levels of a tile and of the nodes above it.
    fn set_level(&mut self, tile: usize) {
        let t = &self.block.tiles[tile];
        let mut level = f64::NEG_INFINITY;
        let stands = |i: &usize| self.heights[*i] > self.enough;
        for i in (t.first..t.first + t.count).filter(stands) {
            level = level.max(t.bound.level(&self.block.columns[i], self.heights[i]));
        }
        let mut node = self.nodes[tile] as usize;
        self.levels[node] = level;
        while node > 0 {
            node = self.block.nodes[node].parent as usize;
            let own = &self.block.nodes[node];
            let Some(children) = own.children else { return };
            let level = children
                .map(|c| c as usize)
                .map(|c| own.bound.level_of(&self.block.nodes[c].bound, self.levels[c]));
            let level = level[0].max(level[1]);
            if level >= self.levels[node] {
                return;
            }
            self.levels[node] = level;
        }
    }

    /// Runs through all strokes.
    pub fn run(&mut self, strokes: &[Stroke], runs: &[Run]) {
        let Some(root) = self.block.nodes.first() else { return };
        let low = root.bound.low.abs().max(self.body.layer().top() + root.bound.low.abs());
        let radius = root.bound.radius + low;
        for (r, run) in runs.iter().enumerate() {
            if !run.reaches(root.bound.middle, radius, self.body) {
                continue;
            }
            let from = r * RUN;
            for (i, stroke) in strokes.iter().enumerate().skip(from).take(RUN) {
                let volume = self.take(stroke);
                if volume > 0.0 {
                    self.taken.push((i as u32, volume));
                }
            }
        }
    }

    /// Goes through all strokes, tile by tile: fast where little is left.
    pub fn run_on_tiles(&mut self, strokes: &[Stroke], runs: &Runs) {
        for (t, tile) in self.block.tiles.iter().enumerate() {
            let node = self.nodes[t] as usize;
            let level = self.levels[node];
            let near = match level > f64::NEG_INFINITY {
                true => runs.near(&tile.bound, level, self.body),
                false => Vec::new(),
            };
            let near = near.into_iter().flat_map(|r| strokes.iter().skip(r * SHORT).take(SHORT));
            for stroke in near {
                let level = self.levels[node];
                if level == f64::NEG_INFINITY {
                    break;
                }
                let dip = self.body.dip(stroke);
                let plane = self.supporting_plane(stroke, dip, &tile.bound, level);
                if tile.bound.least_along(plane.d, level) < plane.reach {
                    self.take_tile(stroke, &plane, t);
                }
            }
        }
    }

    /// Lowers all columns that a stroke meets; returns the volume.
    fn take(&mut self, stroke: &Stroke) -> f64 {
        let mut volume = 0.0;
        let dip = self.body.dip(stroke);
        self.open.push(0);
        while let Some(n) = self.open.pop() {
            let node = &self.block.nodes[n as usize];
            let plane = self.supporting_plane(stroke, dip, &node.bound, self.levels[n as usize]);
            if node.bound.least_along(plane.d, self.levels[n as usize]) >= plane.reach {
                continue;
            }
            match node.children {
                Some([near, far]) => self.open.extend([far, near]),
                None => volume += self.take_tile(stroke, &plane, node.tile as usize),
            }
        }
        volume
    }

    /// A supporting plane of the cutter throughout a stroke, toward what is left of a node.
    ///
    /// The body is tested at both ends; a round one at the end only, since what is left was clear of it at the start,
    /// where the previous stroke ended: `dip`, see [`Body::dip`].
    fn supporting_plane(
        &self,
        stroke: &Stroke,
        dip: Option<f64>,
        bound: &Bound,
        level: f64,
    ) -> Plane {
        let place = bound.middle + bound.normal * level;
        let Some(d) = self.body.direction_to(&stroke.to, place) else {
            return Plane { d: DVec3::ZERO, reach: f64::INFINITY };
        };
        let length = self.body.length().min(LENGTH * self.body.reach());
        let [both, end] = self.body.supports(stroke, d, length);
        let support = dip.map_or(both, |dip| both.min(end + dip));
        Plane { d, reach: support - NEGLIGIBLE }
    }

    fn take_tile(&mut self, stroke: &Stroke, plane: &Plane, tile: usize) -> f64 {
        let t = &self.block.tiles[tile];
        let range = t.first..t.first + t.count;
        // A column leaning away from the plane has all of itself nearer than its top.
        let floor = self.body.layer().allowance;
        let enough = self.enough;
        let mut volume = 0.0;
        for (column, height) in
            self.block.columns[range.clone()].iter().zip(&mut self.heights[range])
        {
            if *height <= enough {
                continue;
            }
            let lean = plane.d.dot(column.line.normal);
            let low = if lean < 0.0 { *height } else { floor };
            if plane.d.dot(column.line.foot) + lean * low >= plane.reach {
                continue;
            }
            let left = self.body.lowered(stroke, &column.line, *height);
            volume += column.section.between(left, *height);
            *height = left;
        }
        if volume > 0.0 {
            self.set_level(tile);
        }
        volume
    }
}
