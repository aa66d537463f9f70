//! Regions: a surface divided along lines, and passes laid on every piece of it.
//!
//! - *Sheet*: the faces of the surface with the lines cut into them (`sheet`, `lines`).
//! - *Piece*: connected faces between lines, a disk or a disk with holes (`pieces`).
//! - *Ground*: a piece refined to carry a field of passes (`ground`).
//! - *Layout*: the passes on a ground (`layout`).
//!
//! 1. The lines come from the map's distortion (`distortion`); [`Regions::along`] takes any others.
//! 2. They are cut in; pieces too small go to a neighbour.
//! 3. Every piece gets its passes; along inner borders the outermost ones run half a strip inside, less
//!    half of the blend, so that the strips of both pieces meet and overlap by the blend.
//! 4. Open passes are shifted so that those of neighbours fit (`offsets`), and go on beyond inner borders as
//!    far as neighbours leave something (`joints`).
//! 5. The pieces are put in order.
//!
//! Path and cutter locations stay those of the one surface and its one chart: sheet and surface are the
//! same set of points.
//!
//! Source: spec 04 and 05.

pub mod distortion;
mod divided;
mod ground;
mod joints;
mod layout;
mod lines;
mod offsets;
mod order;
mod pieces;
mod sheet;
pub mod tensor;
mod terrain;

pub use distortion::{Evenness, Stretch};
pub use divided::{Divided, PartFigures, Undivided};
pub use ground::Ground;
pub use layout::{Layout, LayoutOptions, Spacing, lay_out};
pub use order::in_order;
pub use pieces::Piece;
pub use sheet::{Mean, Sheet};
pub use terrain::JointTerrain;

use crate::flatten::{Chart, FlattenError, Locator};
use crate::geometry::{DVec2, DVec3};
use crate::job::{Compensation, DistortionOptions};
use crate::level_set::{LevelSetError, StripMetric};
use crate::mesh::FaceId;
use crate::parallel;
use crate::surface::Surface;
use distortion::Flattened;

/// A divided surface.
#[derive(Clone, Debug)]
pub struct Regions {
    /// The faces of all regions.
    pub sheet: Sheet,
    /// The regions.
    pub parts: Vec<Part>,
    /// How evenly the undivided surface maps.
    pub whole: Evenness,
    /// Stretch of its map.
    pub stretch: Stretch,
}

/// A region.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its faces.
    pub piece: Piece,
    /// How evenly it maps.
    pub evenness: Evenness,
    /// `#V` mean stretches of its own flat map.
    pub stretch: Vec<f64>,
    /// By how much strips are narrowed at its `#V` vertices, at least 1; `None`: not at all.
    pub narrowing: Option<Vec<f64>>,
    /// A curve of its own, mm, at which iso-scallop passes begin.
    pub start: Option<Vec<DVec3>>,
}

impl Part {
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
    /// [`FlattenError`] when the surface cannot be laid flat.
    pub fn even(
        surface: &Surface,
        chart: &Chart,
        options: &DistortionOptions,
        least: f64,
        threads: usize,
    ) -> Result<Self, FlattenError> {
        let mut sheet = Sheet::new(surface, chart);
        let stretch = Stretch::of(surface, chart);
        let pieces = distortion::divide(&mut sheet, options, least, threads)?;
        let parts = pieces.into_iter().map(|p| Part::of(p, options.compensation)).collect();
        Ok(Self { sheet, parts, whole: stretch.evenness(), stretch })
    }

    /// Whether several regions meet at a face of the surface.
    pub fn is_at_border(&self, face: FaceId) -> bool {
        let sheet = &self.sheet;
        let corners = sheet.parts(face).flat_map(|f| sheet.faces()[f as usize]);
        let labels = corners.flat_map(|v| sheet.around(v)).map(|h| sheet.labels()[h as usize / 3]);
        let mut labels = labels.peekable();
        let first = labels.peek().copied();
        labels.any(|label| Some(label) != first)
    }

    /// For every region the ones that share a side with it.
    pub fn neighbours(&self) -> Vec<Vec<usize>> {
        order::neighbours(&self.sheet, &self.parts)
    }

    /// Divides a surface along flat lines that end on the boundary or where others run; `least`: as for
    /// [`even`](Self::even).
    ///
    /// # Errors
    /// [`FlattenError`] when a region cannot be laid flat.
    pub fn along(
        surface: &Surface,
        chart: &Chart,
        lines: &[Vec<DVec2>],
        least: f64,
    ) -> Result<Self, FlattenError> {
        let mut sheet = Sheet::new(surface, chart);
        let locator = Locator::new(surface.connectivity(), chart.uv());
        lines.iter().for_each(|line| sheet.cut_polyline(line, &locator));
        sheet.improve();
        let all: Vec<u32> = (0..sheet.faces().len() as u32).collect();
        let groups = sheet.groups(&all, |_| 0, least);
        for (label, faces) in (0..).zip(&groups) {
            sheet.set_label(faces, label);
        }
        let mut parts = Vec::new();
        for faces in &groups {
            let flattened = Flattened::of(&sheet, faces)?;
            parts.extend(flattened.map(|f| Part::of(f, Compensation::Exact)));
        }
        let stretch = Stretch::of(surface, chart);
        Ok(Self { sheet, parts, whole: stretch.evenness(), stretch })
    }
}

impl Regions {
    /// Gives every region the flat curve of which the longest part runs through it, if any does.
    pub fn with_starts(mut self, curves: &[Vec<DVec2>]) -> Self {
        for part in &mut self.parts {
            let uv = part.piece.uv(&self.sheet);
            let locator = Locator::new(&part.piece.connectivity, &uv);
            let within = |curve: &Vec<DVec2>| -> Vec<DVec3> {
                let at = |p: &DVec2| locator.locate(*p).ok();
                let place = |at: crate::surface::SurfacePoint| {
                    let corners = part.piece.connectivity.face(at.face);
                    let sheet = |i: usize| part.piece.vertices[corners[i].index()] as usize;
                    (0..3).map(|i| self.sheet.positions()[sheet(i)] * at.weights[i]).sum()
                };
                curve.iter().filter_map(at).map(place).collect()
            };
            let parts = curves.iter().map(within).filter(|c| c.len() > 1);
            part.start = parts.max_by(|a, b| length(a).total_cmp(&length(b)));
        }
        self
    }
}

/// Length of a polyline, mm.
fn length(line: &[DVec3]) -> f64 {
    line.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// The grounds of all regions; of the whole surface if it is not divided. `metric`: at its `#V` vertices.
///
/// # Errors
/// [`LevelSetError::TooFine`] when millions of triangles would be needed.
pub fn grounds(
    regions: Option<&Regions>,
    surface: &Surface,
    chart: &Chart,
    metric: Vec<StripMetric>,
    threads: usize,
) -> Result<Vec<Ground>, LevelSetError> {
    let Some(regions) = regions else { return Ok(vec![Ground::whole(surface, chart, metric)?]) };
    let of = |part: &Part| Ground::of(regions, part, chart, &metric);
    parallel::map(threads, &regions.parts, of).into_iter().collect()
}

/// Share of the area on which neighbouring passes are at least 0.9 of the allowed side step apart.
pub fn even_share(grounds: &[Ground], layouts: &[Layout]) -> f64 {
    if let ([ground], [layout]) = (grounds, layouts) {
        return layout.even_share(ground);
    }
    let areas = grounds.iter().map(Ground::surface_area);
    let shares = layouts.iter().zip(grounds).map(|(l, g)| l.even_share(g));
    areas.clone().zip(shares).map(|(a, s)| a * s).sum::<f64>() / areas.sum::<f64>()
}
