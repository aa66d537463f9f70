//! Points at which the best feed direction is undefined, and the lines that divide the sectors around them.

use super::field::TensorField;
use super::jet::Zero;
use super::separatrix::rays;
use super::trace::End;
use crate::geometry::math::{atan2, cos, sin};
use crate::geometry::{DVec2, DVec3};
use crate::surface::SurfacePoint;

/// Kind of a degenerate point.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Three hyperbolic sectors, index -1/2.
    Trisector,
    /// Index 1/2.
    Wedge,
}

impl Kind {
    /// By the sign of `delta`.
    pub fn of(delta: f64) -> Self {
        if delta < 0.0 { Self::Trisector } else { Self::Wedge }
    }

    /// As it is written in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Trisector => "trisector",
            Self::Wedge => "wedge",
        }
    }
}

/// A place at which all feed directions are equally good.
#[derive(Clone, Debug, PartialEq)]
pub struct DegeneratePoint {
    /// What it is.
    pub kind: Kind,
    /// Where, mm.
    pub place: DVec3,
    /// The surface point.
    pub at: SurfacePoint,
    /// Its flat image.
    pub flat: DVec2,
    /// Its parameters on a NURBS surface.
    pub parameters: Option<DVec2>,
    /// Determinant of the linear part of `(p, q)`, 1/mm⁴.
    pub delta: f64,
    /// Flat angles of the separatrices, rad.
    pub rays: Vec<f64>,
    /// Whether separatrices were traced from it: a trisector around which the direction matters.
    pub divides: bool,
}

impl DegeneratePoint {
    pub(super) fn new(field: &TensorField, at: SurfacePoint, place: DVec3, zero: Zero) -> Self {
        let uv = |v: crate::mesh::VertexId| field.chart().uv()[v.index()];
        let vertices = field.surface().connectivity().face(at.face);
        let flat = (0..3).map(|i| uv(vertices[i]) * at.weights[i]).sum();
        let [x, y] = zero.frame;
        let to_flat = |angle: f64| {
            let d = field.flat_direction(at, x.cross(y), x * cos(angle) + y * sin(angle));
            atan2(d.y, d.x)
        };
        let rays = rays(zero.linear).into_iter().map(to_flat).collect();
        let delta = zero.delta();
        let kind = Kind::of(delta);
        Self { kind, place, at, flat, parameters: None, delta, rays, divides: false }
    }

    pub(super) fn with_parameters(mut self, parameters: DVec2) -> Self {
        self.parameters = Some(parameters);
        self
    }
}

/// A wedge and a trisector that cancel: they result from noise.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Cancelled {
    /// Between them, mm.
    pub place: DVec3,
    /// Distance between them, mm.
    pub distance: f64,
}

/// An area on which the tensor has no direction; it is not a reason to divide the surface.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FreeArea {
    /// Middle, mm; for a curved area it lies off the surface.
    pub place: DVec3,
    /// mm².
    pub area: f64,
}

/// A dividing line.
#[derive(Clone, Debug, PartialEq)]
pub struct Separatrix {
    /// Index of the trisector where it begins.
    pub from: usize,
    /// What it ends at.
    pub end: End,
    /// Its flat points.
    pub line: Vec<DVec2>,
}

/// The topology of the best feed direction of a surface.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Degenerate points, in the order of the faces.
    pub points: Vec<DegeneratePoint>,
    /// Pairs that were treated as noise.
    pub cancelled: Vec<Cancelled>,
    /// Other places at which the field of a mesh vanishes, possibly because of noise.
    pub doubtful: usize,
    /// Areas without direction.
    pub free: Vec<FreeArea>,
    /// Standard deviation of the smoothing of the tensor, mm; 0 where it is exact.
    pub smoothing: f64,
    /// Separatrices of the points that divide.
    pub separatrices: Vec<Separatrix>,
    /// `#V` pairs `(p, q)`, 1/mm; the best feed direction in the chart lies at half their angle.
    pub values: Vec<DVec2>,
}

impl Topology {
    /// The lines to cut along, flat: each ends on the boundary, at a degenerate point, or on another.
    pub fn cuts(&self) -> Vec<Vec<DVec2>> {
        let ends = self.separatrices.iter().filter(|s| s.end != End::Nowhere);
        ends.map(|s| s.line.clone()).collect()
    }
}
