//! Where the surface is farther than half a pass from every pass.
//!
//! 1. *Ridge faces*: where the field bends or grows by less than one pass per pass, fronts meet. Elsewhere the next
//!    ring is where the field says, and no place is farther than half a pass.
//! 2. Faces near ridges are split until each piece is either close enough to a pass as a whole or smaller than the
//!    resolution; the small pieces that are too far away are the places.

use super::options::ClosingOptions;
use super::tree::Tree;
use crate::geometry::DVec2;
use crate::level_set::field::{PassField, gradient};
use crate::level_set::refine::PassMesh;
use crate::level_set::strip_metric::FlatMetric;
use crate::mesh::{FaceId, HalfEdgeId};
use crate::parallel;
use core::cell::Cell;
use std::collections::VecDeque;

/// Places farther than this from a pass are to be closed, passes. Smaller: the error of the field
/// and the tolerance of the rings would be taken for gaps; larger: cusps grow with its square.
pub const LIMIT: f64 = 0.504;
/// Size of the pieces in which gaps are measured, passes. Larger: gaps are overlooked; smaller: time grows
/// quadratically inside of gaps.
pub const RASTER: f64 = 0.06;
/// A fraction of a pass within which the ring below is certainly near, including the inaccuracy of the field, where
/// the field grows on that face: on top of a plateau a ring slightly below can be far away.
const NEAR_BELOW: f64 = 0.3;
/// Where a field grows by less than this per pass, a ridge is near.
const FLATTER: f64 = 0.97;
/// A change of the field's gradient from one face to the next, per pass, that indicates a ridge.
const BEND: f64 = 0.15;
/// How far from a ridge gaps reach, passes.
const REACH: f64 = 0.75;
/// Splits of a face; each halves its pieces.
const DEEPEST: u32 = 8;
/// Faces handed to a thread at a time.
const CHUNK: usize = 512;

/// A piece of the surface that is too far from every pass.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Place {
    /// Its middle, flat mm.
    pub at: DVec2,
    /// The strip metric there.
    pub metric: FlatMetric,
    /// Value of the field, passes.
    pub level: f64,
    /// Distance from the nearest pass, passes.
    pub gap: f64,
    /// Flat area, flat mm².
    pub area: f64,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gaps {
    /// The places farther than [`LIMIT`], in order of faces.
    pub places: Vec<Place>,
    /// The largest distance within the limit, passes, and its flat place.
    pub widest_kept: (f64, DVec2),
}

/// Finds the gaps between the passes in `tree`.
pub fn gaps(mesh: &PassMesh, field: &PassField, tree: &Tree, options: &ClosingOptions) -> Gaps {
    let faces = near_ridges(mesh, field);
    let chunks: Vec<&[FaceId]> = faces.chunks(CHUNK).collect();
    let parts = parallel::map(options.threads, &chunks, |faces| {
        let (inside, hint) = (field.inside(), Cell::new(None));
        let on_levels = options.on_levels;
        let mut search = Search { tree, inside, on_levels, hint, found: Gaps::default() };
        faces.iter().for_each(|&face| search.face(mesh, field.values(), face));
        search.found
    });
    parts.into_iter().fold(Gaps::default(), |mut all, part| {
        all.places.extend(part.places);
        if part.widest_kept.0 > all.widest_kept.0 {
            all.widest_kept = part.widest_kept;
        }
        all
    })
}

/// The gradient of the field on every face, passes per flat mm, with the face's metric.
fn gradients(mesh: &PassMesh, values: &[f64]) -> Vec<Option<(DVec2, FlatMetric)>> {
    let of_face = |(f, face): (usize, &[crate::mesh::VertexId; 3])| {
        let metric = mesh.flat_metric(FaceId(f as u32))?;
        let corners = face.map(|v| mesh.uv()[v.index()]);
        Some((gradient(corners, face.map(|v| values[v.index()]))?, metric))
    };
    mesh.connectivity().faces().iter().enumerate().map(of_face).collect()
}

/// The faces within [`REACH`] of a ridge of the field, in order. A boundary on which passes end counts as a ridge.
fn near_ridges(mesh: &PassMesh, field: &PassField) -> Vec<FaceId> {
    let (values, connectivity) = (field.values(), mesh.connectivity());
    let ends_there = field.inside() == f64::NEG_INFINITY;
    let is_at_end = |f: usize| {
        ends_there && (0..3).any(|c| connectivity.opposite(FaceId(f as u32).half_edge(c)).is_none())
    };
    let gradients = gradients(mesh, values);
    let bends = |h: HalfEdgeId, (gradient, metric): &(DVec2, FlatMetric)| {
        let across = connectivity.opposite(h).and_then(|o| gradients[o.face().index()]);
        across.is_some_and(|(g, _)| metric.slope(g - *gradient) > BEND)
    };
    let is_ridge = |f: usize| {
        let Some(here) = &gradients[f] else { return true };
        is_at_end(f)
            || here.1.slope(here.0) < FLATTER
            || (0..3).any(|c| bends(FaceId(f as u32).half_edge(c), here))
    };
    let mut distance = vec![f64::INFINITY; values.len()];
    let mut open = VecDeque::new();
    for (_, face) in connectivity.faces().iter().enumerate().filter(|(f, _)| is_ridge(*f)) {
        for v in face {
            if distance[v.index()] > 0.0 {
                distance[v.index()] = 0.0;
                open.push_back(*v);
            }
        }
    }
    while let Some(v) = open.pop_front() {
        for leaving in mesh.sides_around(v) {
            let arriving = leaving.prev();
            let ends = [connectivity.ends(leaving).1, connectivity.ends(arriving).0];
            for (h, w) in [leaving, arriving].into_iter().zip(ends) {
                let reached = distance[v.index()] + mesh.pass_length(h);
                if reached < distance[w.index()] && reached <= REACH {
                    distance[w.index()] = reached;
                    open.push_back(w);
                }
            }
        }
    }
    let is_near =
        |face: &[crate::mesh::VertexId; 3]| face.iter().any(|v| distance[v.index()].is_finite());
    let faces = connectivity.faces().iter().enumerate();
    faces.filter(|(_, face)| is_near(face)).map(|(f, _)| FaceId(f as u32)).collect()
}

/// A search through a set of faces.
struct Search<'a> {
    tree: &'a Tree,
    /// Places of a lower level are not machined.
    inside: f64,
    on_levels: bool,
    /// The pass that was nearest to the last place: usually near to the next one as well.
    hint: Cell<Option<u32>>,
    found: Gaps,
}

/// A piece of a face: its corners and the field there.
#[derive(Copy, Clone)]
struct Piece {
    corners: [DVec2; 3],
    values: [f64; 3],
}

impl Piece {
    fn middle(&self) -> (DVec2, f64) {
        let [a, b, c] = self.corners;
        ((a + b + c) / 3.0, self.values.iter().sum::<f64>() / 3.0)
    }

    /// Whether the field, which grows by `slope` per pass, guarantees that the ring below is near everywhere, or that
    /// the piece is not machined.
    fn is_kept(&self, inside: f64, on_levels: bool, slope: f64) -> bool {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        high < inside || (on_levels && low >= 0.0 && high - low.floor() < NEAR_BELOW * slope)
    }

    fn quarters(&self) -> [Self; 4] {
        let ([a, b, c], [u, v, w]) = (self.corners, self.values);
        let (ab, bc, ca) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a));
        let (uv, vw, wu) = (0.5 * (u + v), 0.5 * (v + w), 0.5 * (w + u));
        let piece = |corners, values| Self { corners, values };
        [
            piece([a, ab, ca], [u, uv, wu]),
            piece([ab, b, bc], [uv, v, vw]),
            piece([ca, bc, c], [wu, vw, w]),
            piece([ab, bc, ca], [uv, vw, wu]),
        ]
    }
}

impl Search<'_> {
    fn face(&mut self, mesh: &PassMesh, values: &[f64], face: FaceId) {
        let vertices = mesh.connectivity().face(face);
        let piece = Piece {
            corners: vertices.map(|v| mesh.uv()[v.index()]),
            values: vertices.map(|v| values[v.index()]),
        };
        if let Some(metric) = mesh.flat_metric(face)
            && piece.values.iter().all(|v| v.is_finite())
        {
            let slope =
                gradient(piece.corners, piece.values).map_or(0.0, |g| metric.slope(g).min(1.0));
            self.piece(&piece, (&metric, slope), 0);
        }
    }

    /// `metric` and the slope of the field, per pass, are those of the whole face.
    fn piece(&mut self, piece: &Piece, (metric, slope): (&FlatMetric, f64), depth: u32) {
        if piece.is_kept(self.inside, self.on_levels, slope) {
            return;
        }
        let (at, level) = piece.middle();
        let radius = piece.corners.iter().map(|c| metric.length(*c - at)).fold(0.0, f64::max);
        let hinted = self.hint.get().map(|slot| self.tree.at_slot(slot, metric, at).distance);
        if hinted.is_some_and(|distance| distance + radius <= LIMIT) {
            return;
        }
        let gap = self.distance(metric, at, hinted.unwrap_or(f64::INFINITY));
        let is_small = radius <= RASTER / 3.0_f64.sqrt() || depth >= DEEPEST;
        if gap + radius > LIMIT && !is_small {
            piece.quarters().iter().for_each(|q| self.piece(q, (metric, slope), depth + 1));
        } else if gap > LIMIT && level >= self.inside {
            let [a, b, c] = piece.corners;
            let area = 0.5 * (b - a).perp_dot(c - a).abs();
            self.found.places.push(Place { at, metric: *metric, level, gap, area });
        } else if gap <= LIMIT && gap > self.found.widest_kept.0 && level >= self.inside {
            self.found.widest_kept = (gap, at);
        }
    }

    /// Distance from the nearest pass, passes; `bound`: that from the suggested pass.
    fn distance(&self, metric: &FlatMetric, at: DVec2, bound: f64) -> f64 {
        match self.tree.nearest(metric, at, bound, |_| true) {
            Some(hit) => {
                self.hint.set(Some(hit.slot));
                hit.distance
            }
            None => bound,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Piece;
    use crate::geometry::DVec2;

    /// A little above a level its ring is near where the field is steep, not on a plateau.
    #[test]
    fn the_ring_below_a_plateau_may_be_far() {
        let kept = |side: f64, high: f64| {
            let corners = [DVec2::ZERO, DVec2::new(side, 0.0), DVec2::new(0.0, side)];
            let piece = Piece { corners, values: [94.0, 94.0 + high, 94.0 + high] };
            piece.is_kept(0.0, true, (high / side * 2.0_f64.sqrt()).min(1.0))
        };
        assert!(kept(0.2, 0.2));
        assert!(!kept(0.4, 0.4));
        assert!(!kept(2.0, 0.2));
    }
}
