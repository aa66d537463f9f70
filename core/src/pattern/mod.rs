//! Patterns: which field the passes are level curves of.
//!
//! | pattern | field |
//! |---|---|
//! | `contour` | distance from the boundary (`contour`) |
//! | `iso-scallop` | signed distance from a start curve (`start`) |
//! | `iso-parametric` | surface parameter or conformal coordinate, paced |
//! | `iso-planar` | distance from a vertical plane, paced |
//! | `direction-field` | least-squares potential of the best cross directions (`direction`), paced |
//! | `mpf` | signed distances from several start curves, one for each band (`mpf`) |
//! | `spiral` | the rings of `contour`, joined (`spiral`) |
//!
//! Where a pattern leaves a choice open, the variant with the shortest level curves is chosen.

mod contour;
mod direction;
mod mpf;
mod spiral;
mod start;

pub use mpf::{Bands, bands};
pub use spiral::spiral;

use crate::flatten::Locator;
use crate::footprint::Footprint;
use crate::geometry::math::{cos, sin};
use crate::geometry::{DVec2, DVec3, OrderBy};
use crate::job::{FirstPass, Parameter, PathOptions, Pattern, Start};
use crate::level_set::Pass;
use crate::level_set::{
    Accuracy, LevelSetError, Outermost, PassField, PassMesh, half_levels, open_levels,
    passes as level_curves, ring_levels,
};
use crate::surface::Surface;
use direction::{STRENGTHS, potential};
use start::Source;

/// Penalty for a pass in one more piece: path of this many cutter radii.
const PIECE: f64 = 4.0;
/// Length of the branches per unit of length of a ridge.
const BRANCHES: f64 = 2.0;
/// Length of the move from a ring to the next one, cutter radii.
const RING: f64 = 2.0;
/// Number of start curves, the best by a rough estimate, that are compared accurately.
const FINALISTS: usize = 4;
/// Lengths that differ by less than this fraction count as equal.
const TIE: f64 = 1e-3;
/// Directions in which iso-planar passes are tried, evenly over half a turn.
const ANGLES: u32 = 12;

/// The passes of a pattern.
#[derive(Clone, Debug)]
pub struct Laid {
    /// Their field; levels are one apart.
    pub field: PassField,
    /// The passes, without branches.
    pub passes: Vec<Pass>,
}

/// Surface parameters at the vertices of a mesh; none for a parameter in which the surface is closed: it would jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// `#V` values of the first parameter.
    pub u: Option<Vec<f64>>,
    /// `#V` values of the second parameter.
    pub v: Option<Vec<f64>>,
}

impl Parameters {
    /// The parameters of a NURBS surface at the vertices of a mesh over its chart; `None` for other
    /// surfaces.
    pub fn of(surface: &Surface, chart: &Locator, mesh: &PassMesh) -> Option<Self> {
        let own = surface.parameters()?;
        let at = |p: &DVec2| chart.locate(*p).map_or(DVec2::ZERO, |point| own.at(point));
        let (u, v): (Vec<f64>, Vec<f64>) = mesh.uv().iter().map(at).map(|p| (p.x, p.y)).unzip();
        let [closed_u, closed_v] = own.period().map(|p| p.is_some());
        Some(Self { u: (!closed_u).then_some(u), v: (!closed_v).then_some(v) })
    }
}

/// Properties of the cutter and the region that the passes depend on.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Setting<'a> {
    /// Cutter radius, mm.
    pub radius: f64,
    /// The cutter: if its strip lags, it cuts where it should not beside a sharp turn, and leaves material where it should
    /// cut.
    pub footprint: Footprint,
    /// Whether passes continue in neighbouring regions.
    pub has_neighbours: bool,
    /// Clearance between cutter and walls at the `#V` vertices of the fine mesh, mm; `None` without walls.
    pub clearance: Option<&'a [f64]>,
}

/// Lays out the passes of the requested pattern on a mesh; choices are made on the coarse one. `locator` is over the
/// fine mesh's flat faces; `parameters`: the surface's own, if any.
///
/// # Errors
/// [`LevelSetError`]: no pass can be laid out.
pub fn lay_out(
    coarse: &PassMesh,
    mesh: &PassMesh,
    locator: &Locator,
    options: &PathOptions,
    setting: Setting<'_>,
    parameters: Option<&Parameters>,
) -> Result<Laid, LevelSetError> {
    let sketch = Sketch { coarse, mesh, locator, options, setting };
    let field = match options.pattern {
        Pattern::Contour | Pattern::Spiral => {
            contour::from_boundary(mesh, setting.clearance, setting.radius)?
        }
        // Every band is a region with its own start curve.
        Pattern::IsoScallop | Pattern::Mpf => sketch.iso_scallop()?,
        Pattern::IsoParametric => sketch.iso_parametric(parameters)?,
        Pattern::IsoPlanar => sketch.iso_planar()?,
        Pattern::DirectionField => sketch.direction_field()?,
        Pattern::Hub => return Err(LevelSetError::NeedsBlades),
    };
    Ok(laid(mesh, field, options))
}

/// The level curves of a field.
fn laid(mesh: &PassMesh, field: PassField, options: &PathOptions) -> Laid {
    let outermost = match options.first {
        FirstPass::Edge => Outermost::Edge,
        FirstPass::HalfStrip => Outermost::HalfStrip,
    };
    let has_rings = field.inside() == 0.0;
    let levels = match (has_rings, outermost) {
        (true, Outermost::Edge) => {
            let levels = ring_levels(&field);
            let passes = level_curves(mesh, &field, &levels);
            return Laid { field, passes };
        }
        (true, Outermost::HalfStrip) => half_levels(&field),
        (false, _) => open_levels(&field, outermost),
    };
    // Passes at whole levels.
    let unit = if let [first, second, ..] = levels[..] { second - first } else { 1.0 };
    let field = field.rescaled(levels[0], unit);
    let levels: Vec<f64> = (0..levels.len() as u32).map(f64::from).collect();
    let passes = level_curves(mesh, &field, &levels);
    Laid { field, passes }
}

struct Sketch<'a> {
    coarse: &'a PassMesh,
    mesh: &'a PassMesh,
    locator: &'a Locator<'a>,
    options: &'a PathOptions,
    setting: Setting<'a>,
}

impl Sketch<'_> {
    fn iso_scallop(&self) -> Result<PassField, LevelSetError> {
        let field = |source: Source| source.field(self.mesh, self.locator, Accuracy::Full);
        match self.source(&self.options.start).and_then(field) {
            // In what is left between bands no curve along the widest strips may be long enough to cross a face.
            Err(LevelSetError::NoCurve) if self.options.pattern.divides_itself() => {
                self.source(&Start::Boundary).and_then(field)
            }
            field => field,
        }
    }

    /// Start of the iso-scallop passes: of several starts the one with the shortest level curves.
    fn source(&self, start: &Start) -> Result<Source, LevelSetError> {
        let locator = Locator::new(self.coarse.connectivity(), self.coarse.uv());
        let mut candidates = Source::candidates(self.coarse, &locator, start);
        if self.setting.footprint.lags() {
            candidates = candidates.into_iter().map(Source::going_on).collect();
        }
        if candidates.len() == 1 {
            return candidates.pop().ok_or(LevelSetError::NoCurve);
        }
        let cost = |source: &Source, accuracy: Accuracy| {
            let field = source.field(self.coarse, &locator, accuracy);
            field.map_or(f64::INFINITY, |field| self.cost(field))
        };
        let rated = candidates.into_iter().map(|s| (cost(&s, Accuracy::Sketch), s));
        let mut rated: Vec<_> = rated.filter(|(cost, _)| cost.is_finite()).collect();
        rated.order_by(|a, b| a.0.total_cmp(&b.0));
        rated.truncate(FINALISTS);
        for (length, source) in &mut rated {
            *length = cost(source, Accuracy::Full);
        }
        let best = rated.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, source)| source).ok_or(LevelSetError::NoCurve)
    }

    /// The potential that follows the best direction as closely as gives the shortest level curves, on the coarse
    /// mesh.
    fn direction_field(&self) -> Result<PassField, LevelSetError> {
        let mut before = vec![Before::Distance(self.source(&self.options.start)?)];
        before.extend(self.angle().ok().map(Before::Plane));
        let locator = Locator::new(self.coarse.connectivity(), self.coarse.uv());
        let mut best = (f64::INFINITY, 0, f64::INFINITY);
        for (i, first) in before.iter().enumerate() {
            let like = first.field(self.coarse, &locator)?;
            for half in STRENGTHS {
                let raw = potential(self.coarse, &like, half)?;
                let length = PassField::paced(self.coarse, &raw).map(|f| self.cost(f));
                if let Ok(length) = length
                    && length < best.0
                {
                    best = (length, i, half);
                }
            }
        }
        let like = before[best.1].field(self.mesh, self.locator)?;
        PassField::paced(self.mesh, &potential(self.mesh, &like, best.2)?)
    }

    /// Approximate length of the passes of a field on the coarse mesh, mm, including pieces and gaps.
    fn cost(&self, field: PassField) -> f64 {
        let Laid { passes, field } = laid(self.coarse, field, self.options);
        let pieces = passes.len() as f64 - field.range().1.max(0.0);
        let last = passes.last().map_or(0.0, |pass| pass.level);
        let levels = field.length_of_levels(self.coarse, last) + field.flats(self.coarse);
        let along = match field.inside() == f64::NEG_INFINITY {
            false => levels + RING * self.setting.radius * passes.len() as f64,
            // The levels will be shifted to fit the neighbours', which also end this region's passes: a mean
            // over all shifts, of as many passes as there are.
            true if self.setting.has_neighbours => {
                let (low, high) = field.range();
                field.length(self.coarse) * (last + 1.0) / (high - low).max(f64::MIN_POSITIVE)
            }
            true => levels + field.slants(self.coarse, last),
        };
        along + BRANCHES * field.ridges(self.coarse) + PIECE * self.setting.radius * pieces.max(0.0)
    }

    fn iso_parametric(&self, own: Option<&Parameters>) -> Result<PassField, LevelSetError> {
        let parameters = match own {
            Some(own) => own.clone(),
            None => {
                let axis = start::long_side(self.mesh);
                let along = |p: &DVec2| p.dot(axis);
                let across = |p: &DVec2| axis.perp_dot(*p);
                let uv = self.mesh.uv();
                let (u, v) = (uv.iter().map(along).collect(), uv.iter().map(across).collect());
                Parameters { u: Some(u), v: Some(v) }
            }
        };
        // Passes along u are curves of constant v.
        let chosen = match self.options.along {
            Some(Parameter::U) => [None, parameters.v],
            Some(Parameter::V) => [parameters.u, None],
            None => [parameters.v, parameters.u],
        };
        if chosen.iter().all(Option::is_none) {
            return Err(LevelSetError::ClosedParameter);
        }
        self.shortest(chosen.into_iter().flatten())
    }

    fn iso_planar(&self) -> Result<PassField, LevelSetError> {
        PassField::paced(self.mesh, &across_plane(self.mesh, self.angle()?))
    }

    /// Angle of planes from the x axis, rad: the requested one, or the one whose passes on the coarse mesh are
    /// shortest.
    fn angle(&self) -> Result<f64, LevelSetError> {
        if let Some(angle) = self.options.angle {
            return Ok(angle);
        }
        let step = core::f64::consts::PI / f64::from(ANGLES);
        let mut best = (f64::INFINITY, Err(LevelSetError::NoCurve));
        for angle in (0..ANGLES).map(|i| step * f64::from(i)) {
            match PassField::paced(self.coarse, &across_plane(self.coarse, angle)) {
                Ok(field) => {
                    let length = field.length(self.coarse);
                    // On a plane all are as long: rounding must not decide.
                    if length < best.0 * (1.0 - TIE) {
                        best = (length, Ok(angle));
                    }
                }
                Err(error) if best.1.is_err() => best.1 = Err(error),
                Err(_) => {}
            }
        }
        best.1
    }

    /// The function whose paced level curves are the shortest.
    fn shortest(
        &self,
        functions: impl IntoIterator<Item = Vec<f64>>,
    ) -> Result<PassField, LevelSetError> {
        let mut best: Option<(f64, PassField)> = None;
        let mut refused = LevelSetError::NoCurve;
        for raw in functions {
            match PassField::paced(self.mesh, &raw) {
                Ok(field) => {
                    let length = field.length(self.mesh);
                    if best.as_ref().is_none_or(|(shortest, _)| length < *shortest) {
                        best = Some((length, field));
                    }
                }
                Err(error) => refused = error,
            }
        }
        best.map(|(_, field)| field).ok_or(refused)
    }
}

/// A field that supplies the sign of a potential.
enum Before {
    /// Distance from a start curve.
    Distance(Source),
    /// Distance from a plane at that angle, paced.
    Plane(f64),
}

impl Before {
    fn field(&self, mesh: &PassMesh, locator: &Locator) -> Result<PassField, LevelSetError> {
        match self {
            Self::Distance(source) => source.field(mesh, locator, Accuracy::Sketch),
            Self::Plane(angle) => PassField::paced(mesh, &across_plane(mesh, *angle)),
        }
    }
}

/// Distances of the vertices from the vertical plane through the origin at an angle from the x axis, mm.
fn across_plane(mesh: &PassMesh, angle: f64) -> Vec<f64> {
    let normal = DVec3::new(-sin(angle), cos(angle), 0.0);
    mesh.positions().iter().map(|p| p.dot(normal)).collect()
}
