//! The rings and branches so far, searchable by distance, and joined at the end.

use super::branch::{Anchor, AnchoredBranch, Line, closed};
use super::gaps::Place;
use super::options::ClosingOptions;
use super::tree::Tree;
use crate::geometry::beyond::Parabola;
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::level_set::passes::{Branch, Pass};

/// Longest pieces into which segments are cut for the search, mean passes.
const LONGEST_PIECE: f64 = 2.0;
/// Straight pieces of a bent overrun.
const STEPS: u32 = 4;

/// A piece of a segment in a tree.
struct Piece {
    line: Line,
    segment: usize,
    from: f64,
    to: f64,
    level: f64,
}

/// Passes that were added at the same time.
struct Layer {
    tree: Tree,
    pieces: Vec<Piece>,
    ends: Vec<[DVec2; 2]>,
}

/// The continuations of an open pass beyond its ends: straight, or curved as the pass is.
fn overruns(pass: &Pass, is_straight: bool) -> Vec<[DVec2; 2]> {
    if pass.is_closed {
        return Vec::new();
    }
    let mut line = pass.points.clone();
    let mut ways = Vec::new();
    for far in [pass.overrun[1], pass.overrun[0]] {
        ways.extend(beyond(&line, far, is_straight));
        line.reverse();
    }
    ways
}

/// The continuation of length `far` beyond the last point of a line.
fn beyond(line: &[DVec2], far: f64, is_straight: bool) -> Vec<[DVec2; 2]> {
    let [first, .., end] = line else { return Vec::new() };
    if far <= 0.0 {
        return Vec::new();
    }
    let back = |way: f64| Some((before_end(line, way)? - *end).extend(0.0));
    let whole = Parabola::straight((*end - *first).extend(0.0), far);
    let bent = Parabola::beyond(far, back).unwrap_or(whole);
    let way = if is_straight { Parabola::straight(bent.way, far) } else { bent };
    let steps = if way.bend == DVec3::ZERO { 1 } else { STEPS };
    let at = |step: u32| *end + way.at(f64::from(step) / f64::from(steps)).truncate();
    (0..steps).map(|step| [at(step), at(step + 1)]).collect()
}

/// The point at this distance before the end of a line; `None` where the line is shorter.
fn before_end(line: &[DVec2], way: f64) -> Option<DVec2> {
    let mut left = way;
    for pair in line.windows(2).rev() {
        let length = pair[0].distance(pair[1]);
        if length >= left && length > 0.0 {
            return Some(pair[1].lerp(pair[0], left / length));
        }
        left -= length;
    }
    None
}

/// All passes.
pub struct Passes {
    layers: Vec<Layer>,
    with_overruns: Option<Tree>,
    ring_levels: Vec<f64>,
    branches: Vec<AnchoredBranch>,
    longest_piece: f64,
}

impl Passes {
    /// The rings and the segments given in the options; `mean_pass`: mean size of a pass, flat mm.
    pub fn new(rings: &[Pass], options: &ClosingOptions, mean_pass: f64) -> Self {
        let longest_piece = LONGEST_PIECE * mean_pass;
        let mut passes = Self {
            layers: Vec::new(),
            with_overruns: None,
            ring_levels: rings.iter().map(|r| r.level).collect(),
            branches: Vec::new(),
            longest_piece,
        };
        let lines = rings
            .iter()
            .enumerate()
            .map(|(i, ring)| (Line::Pass(i), ring.level, ring.line().collect()));
        passes.push_layer(lines.collect());
        let beside = options.beside.iter().copied();
        // A tilted flat end goes on straight.
        let beyond = rings.iter().flat_map(|ring| overruns(ring, options.footprint.lags()));
        let beyond: Vec<[DVec2; 2]> = beyond.chain(beside).collect();
        if !beyond.is_empty() {
            let ends: Vec<_> = passes.layers[0].ends.iter().copied().chain(beyond).collect();
            passes.with_overruns = Some(Tree::new(&ends));
        }
        passes
    }

    /// The tree of the passes without branches, but with their overruns: what is near them is machined.
    pub fn without_branches(&self) -> &Tree {
        self.with_overruns.as_ref().unwrap_or(&self.layers[0].tree)
    }

    /// The branches so far.
    pub fn branches(&self) -> &[AnchoredBranch] {
        &self.branches
    }

    /// Adds branches; returns the tree over them.
    pub fn add(&mut self, branches: Vec<AnchoredBranch>) -> &Tree {
        let first = self.branches.len();
        self.branches.extend(branches);
        let added = self.branches[first..].iter().enumerate();
        let lines = added.map(|(i, d)| {
            (Line::Branch(first + i), self.level(d.anchor.line), closed(&d.anchor, &d.points))
        });
        let lines = lines.collect();
        self.push_layer(lines);
        &self.layers[self.layers.len() - 1].tree
    }

    /// Level of the ring that a pass is or leaves from.
    fn level(&self, mut line: Line) -> f64 {
        loop {
            match line {
                Line::Pass(i) => return self.ring_levels[i],
                Line::Branch(i) => line = self.branches[i].anchor.line,
            }
        }
    }

    fn push_layer(&mut self, lines: Vec<(Line, f64, Vec<DVec2>)>) {
        let (mut pieces, mut ends) = (Vec::new(), Vec::new());
        for (line, level, points) in lines {
            for (segment, w) in points.windows(2).enumerate() {
                let n = ((w[1] - w[0]).length() / self.longest_piece).ceil().clamp(1.0, 1e6);
                for k in 0..n as usize {
                    let (from, to) = (k as f64 / n, (k + 1) as f64 / n);
                    pieces.push(Piece { line, segment, from, to, level });
                    ends.push([w[0].lerp(w[1], from), w[0].lerp(w[1], to)]);
                }
            }
        }
        self.layers.push(Layer { tree: Tree::new(&ends), pieces, ends });
    }

    /// The nearest point of a pass closer than `within` passes whose level `accept` allows.
    pub fn nearest(
        &self,
        place: &Place,
        within: f64,
        accept: impl Fn(f64) -> bool,
    ) -> Option<Anchor> {
        let mut best: Option<Anchor> = None;
        for layer in &self.layers {
            let within = best.map_or(within, |a| a.distance);
            let takes = |id: u32| accept(layer.pieces[id as usize].level);
            let Some(hit) = layer.tree.nearest(&place.metric, place.at, within, takes) else {
                continue;
            };
            let piece = &layer.pieces[hit.id as usize];
            let [a, b] = layer.ends[hit.id as usize];
            best = Some(Anchor {
                line: piece.line,
                segment: piece.segment,
                t: piece.from + (piece.to - piece.from) * hit.t,
                at: if hit.t == 1.0 { b } else { a.lerp(b, hit.t) },
                distance: hit.distance,
            });
        }
        best
    }

    /// Adds the branches to the rings.
    pub fn attach(&self, rings: &mut [Pass]) {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); rings.len()];
        let mut nested: Vec<Vec<usize>> = vec![Vec::new(); self.branches.len()];
        for (i, branch) in self.branches.iter().enumerate() {
            match branch.anchor.line {
                Line::Pass(r) => children[r].push(i),
                Line::Branch(s) => nested[s].push(i),
            }
        }
        for list in children.iter_mut().chain(&mut nested) {
            list.order_by(|&a, &b| {
                let (a, b) = (&self.branches[a].anchor, &self.branches[b].anchor);
                a.segment.cmp(&b.segment).then(a.t.total_cmp(&b.t))
            });
        }
        for (ring, list) in rings.iter_mut().zip(&children).filter(|(_, list)| !list.is_empty()) {
            self.attach_to(ring, list, &nested);
        }
    }

    fn attach_to(&self, ring: &mut Pass, branches: &[usize], nested: &[Vec<usize>]) {
        let mut next = branches.iter().copied().peekable();
        let mut points: Vec<DVec2> = Vec::new();
        for (segment, &point) in ring.points.iter().enumerate() {
            if points.last() != Some(&point) {
                points.push(point);
            }
            while let Some(s) = next.next_if(|&s| self.branches[s].anchor.segment == segment) {
                let at = self.branches[s].anchor.at;
                if points[points.len() - 1] != at {
                    points.push(at);
                }
                ring.branches.push(Branch { at: points.len() - 1, points: self.whole(s, nested) });
            }
        }
        // A branch that leaves from the end of a ring's last segment leaves from the first point.
        if ring.is_closed && points.len() > 1 && points[points.len() - 1] == points[0] {
            points.pop();
            let end = points.len();
            ring.branches.iter_mut().filter(|s| s.at == end).for_each(|s| s.at = 0);
        }
        ring.points = points;
    }

    /// Points of a branch with the branches that leave from it.
    fn whole(&self, branch: usize, nested: &[Vec<usize>]) -> Vec<DVec2> {
        let line = closed(&self.branches[branch].anchor, &self.branches[branch].points);
        let mut next = nested[branch].iter().copied().peekable();
        let mut out = Vec::new();
        for (segment, &point) in line.iter().enumerate() {
            out.push(point);
            while let Some(s) = next.next_if(|&s| self.branches[s].anchor.segment == segment) {
                let at = self.branches[s].anchor.at;
                out.push(at);
                // A branch leaves only from branches that were added before it.
                out.extend(self.whole(s, nested));
                out.push(at);
            }
        }
        out.dedup();
        out[1..out.len().max(2) - 1].to_vec()
    }
}
