//! A divided surface: its regions, and the ways to make them.

use super::distortion::{self, Evenness, Flattened, Stretch};
use super::pieces::Piece;
use super::split_mesh::SplitMesh;
use crate::flatten::{Chart, FlattenError, Locator};
use crate::geometry::{DVec2, DVec3};
use crate::job::{Compensation, DistortionOptions};
use crate::mesh::FaceId;
use crate::surface::Surface;

/// Longest side of a triangle that an isoline crosses, side steps.
const FINEST: f64 = 0.5;

/// The function of a region where it is largest, at least.
const WIDE: f64 = 0.25;

/// A divided surface.
#[derive(Clone, Debug)]
pub struct Regions {
    /// The faces of all regions.
    pub split_mesh: SplitMesh,
    /// The regions.
    pub list: Vec<Region>,
    /// How evenly the undivided surface maps.
    pub whole: Evenness,
    /// Stretch of its map.
    pub stretch: Stretch,
}

/// A region.
#[derive(Clone, Debug)]
pub struct Region {
    /// Its faces.
    pub piece: Piece,
    /// How evenly it maps.
    pub evenness: Evenness,
    /// `#V` mean stretches of its own flat map.
    pub stretch: Vec<f64>,
    /// By what factor strips are narrowed at its `#V` vertices, at least 1; `None`: not at all.
    pub narrowing: Option<Vec<f64>>,
    /// The region's own curve, mm, at which iso-scallop passes begin.
    pub start: Option<Vec<DVec3>>,
}

impl Region {
    fn of(flattened: Flattened, compensation: Compensation) -> Self {
        let evenness = flattened.stretch.evenness();
        let narrowing = match compensation {
            Compensation::Exact => None,
            // l_s sigma = w sigma / sigma_ave_max on the surface instead of w.
            Compensation::Piecewise => {
                let stretch = flattened.stretch.vertices().iter();
                // A vertex without flat area tells nothing.
                let by = |s: &f64| evenness.most / s;
                let sound = |r: f64| if r.is_finite() { r.max(1.0) } else { 1.0 };
                Some(stretch.map(by).map(sound).collect())
            }
        };
        let stretch = flattened.stretch.vertices().to_vec();
        Self { piece: flattened.piece, evenness, stretch, narrowing, start: None }
    }
}

impl Regions {
    /// Divides a surface until every region maps evenly; `least`: least area of a region, mm².
    ///
    /// # Errors
    /// [`FlattenError`] when the surface cannot be flattened.
    pub fn even(
        surface: &Surface,
        chart: &Chart,
        options: &DistortionOptions,
        least: f64,
        threads: usize,
    ) -> Result<Self, FlattenError> {
        let mut split_mesh = SplitMesh::new(surface, chart);
        let stretch = Stretch::of(surface, chart);
        let pieces = distortion::divide(&mut split_mesh, options, least, threads)?;
        let list = pieces.into_iter().map(|p| Region::of(p, options.compensation)).collect();
        Ok(Self { split_mesh, list, whole: stretch.evenness(), stretch })
    }

    /// Whether several regions meet at a face of the surface.
    pub fn is_at_border(&self, face: FaceId) -> bool {
        let split_mesh = &self.split_mesh;
        let corners = split_mesh.parts(face).flat_map(|f| split_mesh.faces()[f as usize]);
        let labels =
            corners.flat_map(|v| split_mesh.around(v)).map(|h| split_mesh.labels()[h as usize / 3]);
        let mut labels = labels.peekable();
        let first = labels.peek().copied();
        labels.any(|label| Some(label) != first)
    }

    /// Divides a surface along flat lines that end on the boundary or on other lines; `least`: as for
    /// [`even`](Self::even).
    ///
    /// # Errors
    /// [`FlattenError`] when a region cannot be flattened.
    pub fn along(
        surface: &Surface,
        chart: &Chart,
        lines: &[Vec<DVec2>],
        least: f64,
    ) -> Result<Self, FlattenError> {
        let mut split_mesh = SplitMesh::new(surface, chart);
        let locator = chart.locator(surface);
        lines.iter().for_each(|line| split_mesh.cut_polyline(line, &locator));
        split_mesh.improve();
        let all: Vec<u32> = (0..split_mesh.faces().len() as u32).collect();
        let groups = split_mesh.groups(&all, |_| 0, least);
        Self::of_groups(split_mesh, &groups, Stretch::of(surface, chart))
    }

    /// The regions that groups of faces are, each with a label; `stretch`: of the undivided surface's map.
    fn of_groups(
        mut split_mesh: SplitMesh,
        groups: &[Vec<u32>],
        stretch: Stretch,
    ) -> Result<Self, FlattenError> {
        for (label, faces) in (0..).zip(groups) {
            split_mesh.set_label(faces, label);
        }
        let mut list = Vec::new();
        for faces in groups {
            let flattened = Flattened::of(&split_mesh, faces)?;
            list.extend(flattened.map(|f| Region::of(f, Compensation::Exact)));
        }
        Ok(Self { split_mesh, list, whole: stretch.evenness(), stretch })
    }
}

impl Regions {
    /// The connected parts of a surface in which a function of the flat place is positive, each as if it were alone. The
    /// function, in side steps of `side_step` mm, grows by no more than 1 a side step.
    ///
    /// # Errors
    /// As [`along`](Self::along).
    pub fn where_positive(
        surface: &Surface,
        chart: &Chart,
        value: &dyn Fn(DVec2) -> f64,
        side_step: f64,
    ) -> Result<Self, FlattenError> {
        let mut split_mesh = SplitMesh::new(surface, chart);
        let values = split_mesh.refined_about_zero(value, (side_step, FINEST));
        let values = split_mesh.cut_isoline(0, values);
        split_mesh.improve();
        let all: Vec<u32> = (0..split_mesh.faces().len() as u32).collect();
        let is_positive = |f: u32| {
            let corners = split_mesh.faces()[f as usize];
            corners.iter().map(|&v| values[v as usize]).sum::<f64>() > 0.0
        };
        let groups = split_mesh.groups(&all, |f| u32::from(is_positive(f)), 0.0);
        // Splinters hold no pass.
        let is_wide = |group: &Vec<u32>| {
            let corners = group.iter().flat_map(|&f| split_mesh.faces()[f as usize]);
            corners.map(|v| values[v as usize]).fold(0.0, f64::max) > WIDE
        };
        let is_kept = |group: &Vec<u32>| is_positive(group[0]) && is_wide(group);
        let groups: Vec<Vec<u32>> = groups.into_iter().filter(is_kept).collect();
        split_mesh.set_label(&all, groups.len() as u32);
        let mut regions = Self::of_groups(split_mesh, &groups, Stretch::of(surface, chart))?;
        regions.list.iter_mut().for_each(|region| region.piece.inner_border.clear());
        Ok(regions)
    }
}

impl Regions {
    /// Leaves out some regions.
    pub fn retain(&mut self, is_kept: &[bool]) {
        let mut kept = is_kept.iter();
        self.list.retain(|_| kept.next() == Some(&true));
    }

    /// Gives every region the flat curve that runs longest through it, if any does.
    pub fn with_starts(mut self, curves: &[Vec<DVec2>]) -> Self {
        for region in &mut self.list {
            let uv = region.piece.uv(&self.split_mesh);
            let locator = Locator::new(&region.piece.connectivity, &uv);
            let within = |curve: &Vec<DVec2>| -> Vec<DVec3> {
                let at = |p: &DVec2| locator.locate(*p).ok();
                let place = |at: crate::surface::SurfacePoint| {
                    let corners = region.piece.connectivity.face(at.face);
                    let split_mesh = |i: usize| region.piece.vertices[corners[i].index()] as usize;
                    (0..3).map(|i| self.split_mesh.positions()[split_mesh(i)] * at.weights[i]).sum()
                };
                curve.iter().filter_map(at).map(place).collect()
            };
            let parts = curves.iter().map(within).filter(|c| c.len() > 1);
            region.start = parts.max_by(|a, b| length(a).total_cmp(&length(b)));
        }
        self
    }
}

/// Length of a polyline, mm.
fn length(line: &[DVec3]) -> f64 {
    line.windows(2).map(|w| w[0].distance(w[1])).sum()
}
