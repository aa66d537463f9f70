//! A region refined until it resolves a field of passes.

use super::division::{Region, Regions};
use super::split_mesh::{Mean, SplitMesh};
use crate::flatten::{Chart, FaceTree, Locator};
use crate::geometry::{DVec2, DVec3};
use crate::level_set::{
    self, INSIDE, LevelSetError, PassField, PassMesh, StripMetric, length_floor,
};
use crate::mesh::{Connectivity, FaceId, HalfEdgeId, VertexId};
use crate::parallel;
use crate::surface::Surface;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A region in which no ring is farther than this inside holds none, passes.
const LEAST_RING: f64 = 1e-2;
/// Inner vertices of the mesh on which patterns are compared. Fewer: the shortest may be missed; more: slower.
const SKETCH: usize = 5000;

/// A region with its strip metric, coarse and refined.
#[derive(Clone, Debug)]
pub struct RegionMesh {
    /// Fine enough to compare fields.
    pub coarse: PassMesh,
    /// Fine enough for passes.
    pub fine: PassMesh,
    /// Over the faces of `fine`.
    tree: Arc<FaceTree>,
    /// Number of vertices before any refinement, which come first.
    vertices: usize,
    /// Sides of the unrefined boundary beyond which another region lies.
    inner_border: BTreeSet<(VertexId, VertexId)>,
    narrowing: Option<Narrowing>,
    /// The region's own curve, mm, at which iso-scallop passes begin.
    pub start: Option<Vec<DVec3>>,
    /// Shortest length that passes on it can have, mm.
    length_floor: f64,
}

/// By what factor strips are narrowed, on the unrefined faces.
#[derive(Clone, Debug)]
struct Narrowing {
    connectivity: Connectivity,
    uv: Vec<DVec2>,
    by: Vec<f64>,
}

impl RegionMesh {
    /// The whole surface; `metric`: at its `#V` vertices.
    ///
    /// # Errors
    /// As [`PassMesh::new`].
    pub fn whole(
        surface: &Surface,
        chart: &Chart,
        metric: Vec<StripMetric>,
    ) -> Result<Self, LevelSetError> {
        let coarse = PassMesh::coarse(surface, chart, metric)?;
        let fine = coarse.clone().refined()?;
        Ok(Self {
            length_floor: length_floor(&fine),
            tree: tree(&fine),
            fine,
            coarse: coarse.thinned(SKETCH),
            vertices: surface.positions().len(),
            inner_border: BTreeSet::new(),
            narrowing: None,
            start: None,
        })
    }

    /// A region; `metric`: at the `#V` vertices of the surface.
    ///
    /// # Errors
    /// As [`PassMesh::new`].
    pub fn of(
        regions: &Regions,
        region: &Region,
        chart: &Chart,
        metric: &[StripMetric],
    ) -> Result<Self, LevelSetError> {
        let (split_mesh, piece) = (&regions.split_mesh, &region.piece);
        let scale = |v: &u32| mean(&split_mesh.means()[*v as usize], chart.vertex_scale());
        let coarse = |metric: Vec<StripMetric>| {
            PassMesh::coarse_of_faces(
                piece.connectivity.clone(),
                piece.uv(split_mesh),
                piece.vertices.iter().map(scale).collect(),
                positions(split_mesh, &piece.vertices),
                metric,
            )
        };
        let means =
            piece.vertices.iter().map(|&v| mean_metric(&split_mesh.means()[v as usize], metric));
        let own = coarse(means.clone().collect())?;
        let (coarse, length_floor) = match &region.narrowing {
            None => (own, None),
            Some(by) => {
                let narrowed = means.zip(by).map(|(m, r)| m.map(|x| x * r * r));
                (coarse(narrowed.collect())?, Some(length_floor(&own)))
            }
        };
        let fine = coarse.clone().refined()?;
        Ok(Self {
            length_floor: length_floor.unwrap_or_else(|| level_set::length_floor(&fine)),
            tree: tree(&fine),
            fine,
            coarse: coarse.thinned(SKETCH),
            vertices: piece.vertices.len(),
            inner_border: piece.inner_border.clone(),
            start: region.start.clone(),
            narrowing: region.narrowing.clone().map(|by| Narrowing {
                connectivity: piece.connectivity.clone(),
                uv: piece.uv(split_mesh),
                by,
            }),
        })
    }

    /// Over the faces of the refined mesh.
    pub fn locator(&self) -> Locator<'_> {
        Locator::by(Arc::clone(&self.tree), self.fine.connectivity(), self.fine.uv())
    }

    /// Shortest length that passes on it can have, mm.
    pub fn length_floor(&self) -> f64 {
        self.length_floor
    }

    /// Whether strips are narrower than the metric of the surface requires.
    pub fn is_narrowed(&self) -> bool {
        self.narrowing.is_some()
    }

    /// Whether other regions lie beside it.
    pub fn has_neighbours(&self) -> bool {
        !self.inner_border.is_empty()
    }

    /// Distance in passes from the boundary, 0 on the outermost pass: beside inner borders that pass runs so that its
    /// strip extends half of `blend` mm beyond them; beside the surface's own boundary it runs `outside` passes
    /// inside.
    pub fn rings(&self, blend: f64, outside: f64) -> PassField {
        let rate = self.passes_per_mm();
        let sources = self.boundary().into_iter().map(|(v, is_inner)| {
            let inside = match is_inner {
                true => (0.5 - 0.5 * blend * rate(v)).max(0.0),
                false => outside,
            };
            // The outermost pass is at INSIDE.
            (v, (INSIDE - inside).min(0.0))
        });
        PassField::from_values(&self.fine, &sources.collect::<Vec<_>>())
    }

    /// Whether rings from its boundary have a place inside.
    pub fn holds_rings(&self) -> bool {
        let (low, high) = self.rings(0.0, 0.0).range();
        high - low.min(0.0) > LEAST_RING
    }

    /// Vertices of the refined boundary, and whether they lie on an inner border.
    fn boundary(&self) -> Vec<(VertexId, bool)> {
        let mut out = Vec::new();
        for cycle in self.fine.connectivity().boundary_loops() {
            let n = cycle.len();
            let is_old = |i: &usize| cycle[*i].index() < self.vertices;
            let old: Vec<usize> = (0..n).filter(is_old).collect();
            let is_inner = |k: usize| {
                let ends = (cycle[old[k]], cycle[old[(k + 1) % old.len()]]);
                self.inner_border.contains(&ends)
            };
            for k in 0..old.len() {
                let before = is_inner((k + old.len() - 1) % old.len());
                let (here, next) = (old[k], old[(k + 1) % old.len()]);
                let inner = is_inner(k);
                out.push((cycle[here], inner || before));
                let between = (next + n - here) % n;
                let between = if between == 0 { n } else { between };
                out.extend((1..between).map(|i| (cycle[(here + i) % n], inner)));
            }
        }
        out
    }

    /// Sides of the refined boundary that were one of the unrefined inner border, and their ends.
    pub(super) fn border_sides(&self) -> Vec<(HalfEdgeId, [VertexId; 2])> {
        let connectivity = self.fine.connectivity();
        let sides = (0..3 * connectivity.face_count() as u32).map(HalfEdgeId);
        let outer = sides.filter(|h| connectivity.opposite(*h).is_none());
        let with_ends = outer.map(|h| (h, connectivity.ends(h)));
        let is_inner = |ends: &(VertexId, VertexId)| self.inner_border.contains(ends);
        with_ends.filter(|(_, ends)| is_inner(ends)).map(|(h, (a, b))| (h, [a, b])).collect()
    }

    /// Passes per mm at a vertex, mean over the sides around.
    fn passes_per_mm(&self) -> impl Fn(VertexId) -> f64 + '_ {
        |v| {
            let sides = self.fine.sides_around(v);
            let (passes, mm) = sides.fold((0.0, 0.0), |(p, l), h| {
                (p + self.fine.pass_length(h), l + self.fine.length(h))
            });
            if mm > 0.0 { passes / mm } else { 0.0 }
        }
    }

    /// By what factor strips are narrowed at flat points.
    pub(super) fn narrowing(&self) -> impl Fn(DVec2) -> f64 + '_ {
        let known = self.narrowing.as_ref().map(|n| (n, Locator::new(&n.connectivity, &n.uv)));
        move |at| {
            let Some((narrowing, locator)) = &known else { return 1.0 };
            let Ok(point) = locator.locate(at) else { return 1.0 };
            let corners = narrowing.connectivity.face(point.face);
            (0..3).map(|i| narrowing.by[corners[i].index()] * point.weights[i]).sum()
        }
    }

    /// Area, mm².
    pub fn surface_area(&self) -> f64 {
        (0..self.fine.connectivity().face_count()).map(|f| self.area(FaceId(f as u32))).sum()
    }

    /// Length of the level curves on a face of a linear function with these values, integrated over the
    /// values, mm.
    pub(super) fn integral(&self, face: FaceId, value: [f64; 3]) -> f64 {
        let corners = self.fine.connectivity().face(face);
        let [a, b, c] = corners.map(|v| self.fine.positions()[v.index()]);
        // |grad| A = |sum of value times opposite side| / 2.
        0.5 * ((c - b) * value[0] + (a - c) * value[1] + (b - a) * value[2]).length()
    }

    /// Area of a face of the refined mesh, mm².
    pub(super) fn area(&self, face: FaceId) -> f64 {
        let corners = self.fine.connectivity().face(face);
        let [a, b, c] = corners.map(|v| self.fine.positions()[v.index()]);
        0.5 * (b - a).cross(c - a).length()
    }
}

fn tree(mesh: &PassMesh) -> Arc<FaceTree> {
    FaceTree::new(mesh.connectivity(), mesh.uv()).into()
}

fn mean(mean: &Mean, values: &[f64]) -> f64 {
    mean.iter().map(|&(v, w)| values[v as usize] * w).sum()
}

fn mean_metric(mean: &Mean, metric: &[StripMetric]) -> StripMetric {
    core::array::from_fn(|i| mean.iter().map(|&(v, w)| metric[v as usize][i] * w).sum())
}

fn positions(split_mesh: &SplitMesh, vertices: &[u32]) -> Vec<DVec3> {
    vertices.iter().map(|&v| split_mesh.positions()[v as usize]).collect()
}

/// The region meshes of all regions; of the whole surface if it is not divided. `metric`: at its `#V` vertices.
///
/// # Errors
/// [`LevelSetError::TooFine`] when millions of triangles would be needed.
pub fn region_meshes(
    regions: Option<&Regions>,
    surface: &Surface,
    chart: &Chart,
    metric: Vec<StripMetric>,
    threads: usize,
) -> Result<Vec<RegionMesh>, LevelSetError> {
    let Some(regions) = regions else {
        return Ok(vec![RegionMesh::whole(surface, chart, metric)?]);
    };
    let of = |region: &Region| RegionMesh::of(regions, region, chart, &metric);
    parallel::map(threads, &regions.list, of).into_iter().collect()
}
