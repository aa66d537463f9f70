//! What is machined: source, placement and selection of the surface, and how it is laid flat.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry::DVec3;

/// Source and selection of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceOptions {
    /// File or formula.
    pub source: SurfaceSource,
    /// Factor from the source's lengths to mm (the job's `scale` times the file's unit).
    pub scale: f64,
    /// Rotations about X, Y, Z in this order, rad, applied after the scale.
    pub rotate: DVec3,
    /// Translation applied last, mm.
    pub translate: DVec3,
    /// Which faces are machined.
    pub select: Selection,
    /// Faces of a STEP file.
    pub face: Faces,
    /// Largest distance between a NURBS surface and its mesh, mm; `None` is a quarter of the path's
    /// tolerance.
    pub chord: Option<f64>,
    /// Scale of curvature estimation, mm; `None` takes it from the mesh. NURBS surfaces have exact
    /// curvature and do not use it.
    pub curvature_radius: Option<f64>,
    /// Steepest slope that is machined, rad; `None` plans on the surface as it is, if that is possible.
    pub steepest: Option<f64>,
    /// Whether the surface is machined from the side its faces point away from.
    pub flip: bool,
}

/// Which faces of a STEP file are machined, by their numbers from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Faces {
    /// The only one, or what `select.component` says.
    #[default]
    Only,
    /// This one.
    One(u32),
    /// These.
    Several(Vec<u32>),
    /// All that can be used.
    All,
}

impl Faces {
    /// The number of the face that is named, if it is one.
    pub fn number(&self) -> Option<u32> {
        match self {
            Self::One(number) => Some(*number),
            _ => None,
        }
    }
}

/// Where the surface comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceSource {
    /// A file, relative to the job file.
    File(String),
    /// A surface given by a formula.
    Analytic(AnalyticOptions),
}

/// A surface given by a formula, its middle at the origin, machined from above.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AnalyticOptions {
    /// Which formula.
    pub kind: AnalyticKind,
    /// Its numbers; those that `kind` does not use hold their defaults.
    pub parameters: AnalyticParameters,
}

/// Surfaces that are known by a formula.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AnalyticKind {
    /// A flat square; uses `size`.
    Plane,
    /// The top of a sphere of `radius`, a disk of diameter `size` seen from above.
    SphereCap,
    /// The top of a cylinder of `radius` along Y; `size` long, `size` of arc across.
    Cylinder,
    /// The top of a torus (`radius` to the tube's centre line, `tube_radius`); `size` of arc along
    /// and across.
    TorusPatch,
    /// `z = height (x² - y²) / a²`, `a = size / 2`, over a square of `size`.
    Saddle,
    /// `z = height (x³ - 3 x y²) / a³`, `a = size / 2`, over a square of `size`.
    MonkeySaddle,
    /// `z = height exp(-(x² + y²) / (2 radius²))` over a square of `size`.
    Bump,
}

/// Numbers of a surface given by a formula, mm.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AnalyticParameters {
    /// Side of the square, or diameter of the disk, seen from above.
    pub size: f64,
    /// Main radius.
    pub radius: f64,
    /// Radius of the torus's tube.
    pub tube_radius: f64,
    /// Height.
    pub height: f64,
    /// Edge length of the mesh that is made.
    pub resolution: f64,
}

impl Default for AnalyticParameters {
    /// A 100 mm patch with radii that a 10 mm cutter fits.
    fn default() -> Self {
        Self { size: 100.0, radius: 80.0, tube_radius: 60.0, height: 10.0, resolution: 1.0 }
    }
}

/// Which faces of the mesh are machined; conditions add up.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Selection {
    /// Keep faces whose normal is within an angle (rad) of a unit direction.
    pub normal_within: Option<(f64, DVec3)>,
    /// Keep faces whose centroid is in the box from the first to the second corner, mm.
    pub within_box: Option<(DVec3, DVec3)>,
    /// Which connected component of what is left.
    pub component: Component,
}

/// Choice among connected components.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub enum Component {
    /// There must be only one.
    #[default]
    Only,
    /// The one of largest area.
    Largest,
    /// By index, in order of decreasing area, from 0.
    Index(u32),
}

/// How the surface is laid flat.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FlattenMethod {
    /// Angle-based flattening.
    Abf,
    /// Boundary-first flattening.
    Bff,
}
