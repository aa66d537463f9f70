//! Edges in space → trimming loops in the parameters.
//!
//! Points along an edge are projected to the surface one after the other, each from the parameters
//! of the one before, so that a loop goes on where a closed surface has its seam. Curves in the
//! parameters that a file may give are not needed: they are approximations of the same edges.

use super::edge::{Edge, Edges};
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::nurbs::{NurbsSurface, TrimLoop};

/// Part of the chord error that the points of an edge may leave.
const PART: f64 = 0.25;
/// Distance of an edge from its surface, as a part of the surface's size, that is refused.
const FARTHEST: f64 = 2e-3;
/// The same from which another place of the surface is looked for.
const ASTRAY: f64 = 1e-5;
/// Places of the surface from which the nearest point is sought, along a parameter, and how many
/// of the nearest are tried.
const SEEDS: (usize, usize) = (24, 6);

/// The trimming loops of a face on `surface`, the face at their left in the parameters.
///
/// `chord`: what the mesh may be off, in the units of the surface; `reversed`: the face looks
/// against `u` cross `v`.
pub(super) fn loops(
    surface: &NurbsSurface,
    edges: &Edges,
    chord: f64,
    reversed: bool,
) -> Result<Vec<TrimLoop>, &'static str> {
    let tracker = Tracker::new(surface);
    let closed = surface.closed() != [false; 2];
    let plain = || edges.bounds.iter().map(|b| b.iter().collect()).collect();
    let chains: Vec<Vec<&Edge>> = if closed { edges.without_seams() } else { plain() };
    let mut result = Vec::new();
    for chain in chains.into_iter().filter(|c| !c.is_empty()) {
        let (mut points, mut corners) = (Vec::new(), Vec::new());
        for edge in chain {
            corners.push(points.len());
            let samples = edge.within(PART * chord);
            points.extend(&samples[..samples.len() - 1]);
        }
        let mut line = tracker.project(&points, &corners)?;
        if reversed {
            line = turned(line);
        }
        result.push(line);
    }
    Ok(result)
}

/// The same loop the other way round.
fn turned(line: TrimLoop) -> TrimLoop {
    let n = line.points.len();
    let TrimLoop { mut points, corners, winding } = line;
    points.reverse();
    let mut corners: Vec<usize> = corners.iter().map(|c| n - 1 - c).collect();
    corners.order_total();
    TrimLoop { points, corners, winding: winding.map(|w| -w) }
}

/// Projects points one after the other.
struct Tracker<'a> {
    surface: &'a NurbsSurface,
    seeds: Vec<(DVec2, DVec3)>,
}

impl<'a> Tracker<'a> {
    fn new(surface: &'a NurbsSurface) -> Self {
        let (low, high) = surface.domain();
        let part = |k: usize| k as f64 / (SEEDS.0 - 1) as f64;
        let mut seeds = Vec::new();
        for i in 0..SEEDS.0 {
            for j in 0..SEEDS.0 {
                let at = low + (high - low) * DVec2::new(part(i), part(j));
                seeds.push((at, surface.point(at)));
            }
        }
        Self { surface, seeds }
    }

    /// The nearest point from anywhere.
    fn anywhere(&self, p: DVec3) -> (DVec2, f64) {
        let mut near: Vec<(f64, DVec2)> =
            self.seeds.iter().map(|(at, q)| (q.distance_squared(p), *at)).collect();
        near.order_by(|a, b| a.0.total_cmp(&b.0));
        let tried = near.iter().take(SEEDS.1).map(|(_, at)| self.surface.project(p, *at));
        tried.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((DVec2::ZERO, f64::INFINITY))
    }

    /// The side that is one point and is at `p`, and the parameters there.
    fn pole(&self, p: DVec3) -> Option<(usize, DVec2)> {
        let (low, high) = self.surface.domain();
        (0..4).filter(|&side| self.surface.degenerate()[side]).find_map(|side| {
            let at = if side % 2 == 0 { low } else { high };
            let near = ASTRAY * self.surface.size();
            (self.surface.point(at).distance(p) <= near).then_some((side / 2, at))
        })
    }

    /// `at` moved by whole periods to where it is nearest to `near`.
    fn unwrapped(&self, at: DVec2, near: DVec2) -> DVec2 {
        let (low, high) = self.surface.domain();
        let mut moved = at;
        for axis in 0..2 {
            if self.surface.closed()[axis] {
                let period = high[axis] - low[axis];
                moved[axis] -= ((at[axis] - near[axis]) / period).round() * period;
            }
        }
        moved
    }

    fn project(&self, points: &[DVec3], corners: &[usize]) -> Result<TrimLoop, &'static str> {
        let size = self.surface.size();
        let n = points.len();
        // Start where the parameters have a meaning.
        let start =
            (0..n).find(|&k| self.pole(points[k]).is_none()).ok_or("its edges are one point")?;
        let mut line = TrimLoop::default();
        let mut before = self.anywhere(points[start]).0;
        let first = before;
        let mut through_pole = false;
        for k in (start..start + n).chain([start + n]) {
            let p = points[k % n];
            if let Some((axis, end)) = self.pole(p) {
                before[axis] = end[axis];
                if !through_pole {
                    line.corners.push(line.points.len());
                    line.points.push(before);
                }
                through_pole = true;
                continue;
            }
            let (mut at, mut off) =
                if through_pole { self.anywhere(p) } else { self.surface.project(p, before) };
            if off > ASTRAY * size {
                let other = self.anywhere(p);
                if other.1 < 0.5 * off {
                    (at, off) = other;
                }
            }
            if off > FARTHEST * size || off.is_nan() {
                return Err("an edge does not lie on its surface");
            }
            at = self.unwrapped(at, before);
            if through_pole {
                // From the pole the loop goes on along another line of the parameters.
                let last = line.points.len() - 1;
                let mut leave = at;
                let (axis, _) =
                    self.pole(points[(k + n - 1) % n]).ok_or("an edge touches a pole")?;
                leave[axis] = line.points[last][axis];
                line.corners.push(line.points.len());
                line.points.push(leave);
                through_pole = false;
            }
            if k < start + n {
                if corners.contains(&(k % n)) {
                    line.corners.push(line.points.len());
                }
                line.points.push(at);
            } else {
                let (low, high) = self.surface.domain();
                let turns = (at - first) / (high - low);
                let turn = |axis: usize| {
                    if self.surface.closed()[axis] { turns[axis].round() as i32 } else { 0 }
                };
                line.winding = [turn(0), turn(1)];
            }
            before = at;
        }
        Ok(line)
    }
}
