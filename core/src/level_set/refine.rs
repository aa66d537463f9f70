//! A mesh fine enough for the distance field: edges at most about one pass long.

use super::error::LevelSetError;
use super::strip_metric::{FlatMetric, StripMetric, square_of};
use crate::flatten::Chart;
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{Connectivity, FaceId, HalfEdgeId, VertexId};
use crate::surface::Surface;
use std::sync::OnceLock;

mod needles;

/// Edges longer than this many passes are split in a fine mesh. Longer: corners of rings and summits of the field are
/// blunted; shorter: the number of triangles grows quadratically.
const FINE: f64 = 1.0;
/// Where the mesh stays small, edges longer than this are split as well.
const FINEST: f64 = 0.25;
/// A mesh of at most this many triangles is small.
const CHEAP: f64 = 1.2e5;
/// Edges longer than this many passes are split in a coarse mesh: good enough to compare fields.
pub(super) const COARSE: f64 = 6.0;
/// Refinement stops with an error above this many triangles, or above twice as many as the mesh had before; fewer
/// in WebAssembly, all of whose memory is 4 GB.
const MOST_FACES: usize = if cfg!(target_pointer_width = "32") { 2_500_000 } else { 12_000_000 };

/// How many times the fewest triangles halving of good triangles makes at most.
const UNEVEN: f64 = 8.0;

/// A mesh that is fine already costs what was given, whatever the side step.
fn most_faces(given: usize) -> usize {
    MOST_FACES.max(2 * given)
}

/// Area of a triangle with these sides.
fn heron([a, b, c]: [f64; 3]) -> f64 {
    let s = 0.5 * (a + b + c);
    (s * (s - a) * (s - b) * (s - c)).max(0.0).sqrt()
}

/// Flat and spatial mesh with edge lengths measured in passes and in mm.
#[derive(Clone, Debug)]
pub struct PassMesh {
    connectivity: Connectivity,
    uv: Vec<DVec2>,
    scale: Vec<f64>,
    positions: Vec<DVec3>,
    metric: Vec<StripMetric>,
    /// `#F` flat metrics, computed on first use.
    flat: OnceLock<Vec<Option<FlatMetric>>>,
    /// Most triangles that refinement may make.
    most_faces: usize,
}

impl PassMesh {
    /// Refines the chart's mesh until it resolves a field of passes; `metric` is the strip metric at each of the `#V`
    /// vertices, which keep their indices.
    ///
    /// # Errors
    /// [`LevelSetError::TooFine`] when millions of triangles would be needed.
    pub fn new(
        surface: &Surface,
        chart: &Chart,
        metric: Vec<StripMetric>,
    ) -> Result<Self, LevelSetError> {
        Self::coarse(surface, chart, metric)?.refined()
    }

    /// A mesh on which fields can be compared, but passes cannot be laid out.
    ///
    /// # Errors
    /// As [`new`](Self::new), which would fail too.
    pub fn coarse(
        surface: &Surface,
        chart: &Chart,
        metric: Vec<StripMetric>,
    ) -> Result<Self, LevelSetError> {
        Self {
            connectivity: surface.connectivity().clone(),
            uv: chart.uv().to_vec(),
            scale: chart.vertex_scale().to_vec(),
            positions: surface.positions().to_vec(),
            metric,
            flat: OnceLock::new(),
            most_faces: most_faces(surface.connectivity().face_count()),
        }
        .made_coarse()
    }

    /// As [`coarse`](Self::coarse), of the faces of `connectivity` with `#V` flat points, linear scales,
    /// positions and metrics.
    ///
    /// # Errors
    /// As [`coarse`](Self::coarse).
    pub fn coarse_of_faces(
        connectivity: Connectivity,
        uv: Vec<DVec2>,
        scale: Vec<f64>,
        positions: Vec<DVec3>,
        metric: Vec<StripMetric>,
    ) -> Result<Self, LevelSetError> {
        let (flat, most_faces) = (OnceLock::new(), most_faces(connectivity.face_count()));
        Self { connectivity, uv, scale, positions, metric, flat, most_faces }.made_coarse()
    }

    fn made_coarse(self) -> Result<Self, LevelSetError> {
        self.check_size()?;
        self.with_edges_below(COARSE)
    }

    /// The mesh refined until it resolves a field of passes; its vertices keep their indices.
    ///
    /// # Errors
    /// [`LevelSetError::TooFine`] when millions of triangles would be needed.
    pub fn refined(self) -> Result<Self, LevelSetError> {
        let mesh = self.with_edges_below(FINE)?;
        let mut longest = FINE;
        while longest > FINEST && 4.0 * mesh.faces_below(longest) <= CHEAP {
            longest *= 0.5;
        }
        mesh.with_edges_below(longest)
    }

    /// Approximate number of triangles when no edge is longer than that many passes.
    fn faces_below(&self, longest: f64) -> f64 {
        let split = |h: u32| {
            let parts = (self.pass_length(HalfEdgeId(h)) / longest).max(1.0);
            parts * parts
        };
        (0..3 * self.connectivity.face_count() as u32).map(split).sum::<f64>() / 3.0
    }

    pub(super) fn with_edges_below(self, longest: f64) -> Result<Self, LevelSetError> {
        let mut mesh = self.with_needles_cut(longest)?;
        while let Some(finer) = mesh.split_long_edges(longest)? {
            mesh = finer;
        }
        Ok(mesh)
    }

    /// The mesh with other faces between some of its vertices.
    pub(super) fn with_vertices(&self, connectivity: Connectivity, kept: &[VertexId]) -> Self {
        Self {
            connectivity,
            uv: kept.iter().map(|v| self.uv[v.index()]).collect(),
            scale: kept.iter().map(|v| self.scale[v.index()]).collect(),
            positions: kept.iter().map(|v| self.positions[v.index()]).collect(),
            metric: kept.iter().map(|v| self.metric[v.index()]).collect(),
            flat: OnceLock::new(),
            most_faces: self.most_faces,
        }
    }

    /// Half-edge connectivity.
    pub fn connectivity(&self) -> &Connectivity {
        &self.connectivity
    }

    /// `#V` flat points.
    pub fn uv(&self) -> &[DVec2] {
        &self.uv
    }

    /// `#V` positions, mm.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// `#V` linear scales, mm on the surface per flat mm.
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Mean size of a pass on the surface, mm.
    pub fn mean_pass(&self) -> f64 {
        let (mut passes, mut area) = (0.0, 0.0);
        for f in 0..self.connectivity.face_count() as u32 {
            let sides = [0, 1, 2].map(|i| FaceId(f).half_edge(i));
            passes += heron(sides.map(|h| self.pass_length(h)));
            area += heron(sides.map(|h| self.length(h)));
        }
        (area / passes).sqrt()
    }

    /// Length of a side in passes.
    pub fn pass_length(&self, side: HalfEdgeId) -> f64 {
        let (a, b) = self.connectivity.ends(side);
        self.passes_between(a.index(), b.index())
    }

    /// Length of a side, mm.
    pub fn length(&self, side: HalfEdgeId) -> f64 {
        let (a, b) = self.connectivity.ends(side);
        (self.positions[b.index()] - self.positions[a.index()]).length()
    }

    /// The strip metric on a face, in the flat plane; `None` for a face without flat area.
    pub fn flat_metric(&self, face: FaceId) -> Option<FlatMetric> {
        self.flat.get_or_init(|| self.flat_metrics())[face.index()]
    }

    fn flat_metrics(&self) -> Vec<Option<FlatMetric>> {
        let of_face = |face: &[VertexId; 3]| {
            let v = face.map(VertexId::index);
            let [a, b, c] = v.map(|v| &self.metric[v]);
            let mean = core::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0);
            FlatMetric::of_triangle(&mean, v.map(|v| self.positions[v]), v.map(|v| self.uv[v]))
        };
        self.connectivity.faces().iter().map(of_face).collect()
    }

    /// The sides that leave a vertex.
    pub fn sides_around(&self, v: VertexId) -> impl Iterator<Item = HalfEdgeId> + '_ {
        let c = &self.connectivity;
        let first = c.leaving(v);
        let next = move |h: &HalfEdgeId| c.opposite(h.prev()).filter(|next| Some(*next) != first);
        core::iter::successors(first, next)
    }

    /// The vertices that share a side with a vertex.
    pub fn neighbours(&self, v: VertexId) -> impl Iterator<Item = VertexId> + '_ {
        let c = &self.connectivity;
        self.sides_around(v).flat_map(move |h| {
            let last = c.opposite(h.prev()).is_none().then(|| c.ends(h.prev()).0);
            core::iter::once(c.ends(h).1).chain(last)
        })
    }

    fn passes_between(&self, a: usize, b: usize) -> f64 {
        let e = self.positions[b] - self.positions[a];
        let square = 0.5 * (square_of(&self.metric[a], e) + square_of(&self.metric[b], e));
        square.max(0.0).sqrt()
    }

    /// How many triangles there are at least if no side is longer than a pass.
    fn least_faces(&self) -> f64 {
        let passes: f64 = (0..self.connectivity.face_count() as u32)
            .map(|f| heron([0, 1, 2].map(|i| self.pass_length(FaceId(f).half_edge(i)))))
            .sum();
        // An equilateral triangle of the longest side allowed covers 0.433 passes².
        passes / 0.433
    }

    /// Fails before refining when the result could not stay below the most faces.
    fn check_size(&self) -> Result<(), LevelSetError> {
        let limit = self.most_faces;
        if self.least_faces() > limit as f64 {
            return Err(LevelSetError::TooFine { side_step: self.mean_pass(), limit });
        }
        Ok(())
    }

    /// Whether an edge is too long, or joins two boundary vertices through the interior: along such an edge the
    /// distance does not follow from its ends.
    fn is_split(&self, side: HalfEdgeId, longest: f64) -> bool {
        let (a, b) = self.connectivity.ends(side);
        let is_chord = self.connectivity.opposite(side).is_some()
            && self.connectivity.is_boundary(a)
            && self.connectivity.is_boundary(b);
        is_chord || self.pass_length(side) > longest
    }

    /// The same mesh, to which vertices are added.
    fn clone_to_refine(&self) -> Self {
        Self { flat: OnceLock::new(), ..self.clone() }
    }

    /// Adds a vertex between two, at that fraction of the way.
    fn push_between(&mut self, a: usize, b: usize, part: f64) {
        let rest = 1.0 - part;
        self.uv.push(rest * self.uv[a] + part * self.uv[b]);
        self.scale.push(rest * self.scale[a] + part * self.scale[b]);
        self.positions.push(rest * self.positions[a] + part * self.positions[b]);
        let (m, n) = (&self.metric[a], &self.metric[b]);
        self.metric.push(core::array::from_fn(|i| rest * m[i] + part * n[i]));
    }

    /// Why it cannot be refined.
    fn too_many(&self) -> LevelSetError {
        let limit = self.most_faces;
        match self.least_faces() * UNEVEN > limit as f64 {
            true => LevelSetError::TooFine { side_step: self.mean_pass(), limit },
            false => LevelSetError::Needles { limit },
        }
    }

    /// One round of splitting at mid-edges; `None` when there is nothing to split.
    fn split_long_edges(&self, longest: f64) -> Result<Option<Self>, LevelSetError> {
        let sides = 3 * self.connectivity.face_count();
        let mut middle = vec![u32::MAX; sides];
        let mut next = self.clone_to_refine();
        for h in 0..sides {
            let side = HalfEdgeId(h as u32);
            if middle[h] != u32::MAX || !self.is_split(side, longest) {
                continue;
            }
            let (a, b) = self.connectivity.ends(side);
            middle[h] = next.uv.len() as u32;
            if let Some(o) = self.connectivity.opposite(side) {
                middle[o.index()] = middle[h];
            }
            next.push_between(a.index(), b.index(), 0.5);
        }
        if next.uv.len() == self.uv.len() {
            return Ok(None);
        }
        let mut faces = Vec::with_capacity(4 * self.connectivity.face_count());
        for (f, face) in self.connectivity.faces().iter().enumerate() {
            let split = [0, 1, 2].map(|i| middle[3 * f + i]);
            next.split_face(*face, split, &mut faces);
        }
        if faces.len() > self.most_faces {
            return Err(self.too_many());
        }
        // Splitting keeps a manifold a manifold.
        let connectivity = Connectivity::new(next.uv.len(), faces);
        debug_assert!(connectivity.is_ok(), "splitting edges broke the mesh");
        let Ok(connectivity) = connectivity else { return Ok(None) };
        next.connectivity = connectivity;
        Ok(Some(next))
    }

    /// Pushes the pieces of a face whose sides are split at `middle` (`u32::MAX`: not split).
    fn split_face(&self, face: [VertexId; 3], middle: [u32; 3], out: &mut Vec<[VertexId; 3]>) {
        let is_split = middle.map(|m| m != u32::MAX);
        let m = middle.map(VertexId);
        let [a, b, c] = face;
        match is_split.iter().filter(|&&s| s).count() {
            0 => out.push(face),
            3 => {
                out.extend([[a, m[0], m[2]], [m[0], b, m[1]], [m[2], m[1], c], [m[0], m[1], m[2]]])
            }
            1 => {
                let i = is_split.iter().position(|&s| s).unwrap_or(0);
                let (p, q, r) = (face[i], face[(i + 1) % 3], face[(i + 2) % 3]);
                out.extend([[p, m[i], r], [m[i], q, r]]);
            }
            _ => {
                // Side i is whole; cut off the corner opposite to it, then the shorter diagonal.
                let i = is_split.iter().position(|&s| !s).unwrap_or(0);
                let (p, q, r) = (face[i], face[(i + 1) % 3], face[(i + 2) % 3]);
                let (mq, mr) = (m[(i + 1) % 3], m[(i + 2) % 3]);
                out.push([mq, r, mr]);
                if self.passes_between(p.index(), mq.index())
                    <= self.passes_between(q.index(), mr.index())
                {
                    out.extend([[p, q, mq], [p, mq, mr]]);
                } else {
                    out.extend([[p, q, mr], [q, mq, mr]]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level_set::strip_metric::even;

    /// A square of 1 mm, `side` by `side` quads, whose passes are 10 mm apart.
    fn far_finer_than_passes(side: u32) -> Result<PassMesh, LevelSetError> {
        let at = |i: u32| f64::from(i) / f64::from(side);
        let places = (0..=side).flat_map(|j| (0..=side).map(move |i| DVec2::new(at(i), at(j))));
        let uv: Vec<DVec2> = places.collect();
        let quads = (0..side).flat_map(|j| (0..side).map(move |i| j * (side + 1) + i));
        let faces = quads.flat_map(|a| {
            let [a, b, c, d] = [a, a + 1, a + side + 2, a + side + 1].map(VertexId);
            [[a, b, c], [a, c, d]]
        });
        let connectivity = Connectivity::new(uv.len(), faces.collect()).unwrap();
        let positions = uv.iter().map(|p| p.extend(0.0)).collect();
        let (scale, metric) = (vec![1.0; uv.len()], vec![even(10.0); uv.len()]);
        PassMesh::coarse_of_faces(connectivity, uv, scale, positions, metric)
    }

    #[test]
    fn a_mesh_of_more_faces_than_refinement_makes_is_taken_as_it_is() {
        assert_eq!(most_faces(2 * MOST_FACES), 4 * MOST_FACES);
        let mesh = far_finer_than_passes(50).unwrap();
        let given = 2 * 50 * 50;
        let fine = vec![even(0.01); mesh.uv.len()];
        let finer = PassMesh { metric: fine, most_faces: 2 * given, ..mesh.clone() };
        assert!(matches!(finer.refined(), Err(LevelSetError::TooFine { .. })));
        let mesh = PassMesh { most_faces: 2 * given, ..mesh }.refined().unwrap();
        // Two corners have chords, which are split.
        let faces = mesh.connectivity().face_count();
        assert!((given..given + 100).contains(&faces), "{faces}");
    }
}
