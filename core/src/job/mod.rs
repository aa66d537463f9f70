//! The job: what to machine and how, complete, in millimetres, radians and seconds.

use crate::geometry::DVec3;
use crate::machine::Machine;
use crate::tool::Tool;

/// A complete job: every default filled in, every value checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The job's own name.
    pub name: String,
    /// Where the surface comes from and which part of it is meant.
    pub surface: SurfaceOptions,
    /// How it is laid flat.
    pub flatten: FlattenMethod,
    /// The cutter.
    pub tool: Tool,
    /// Number of flutes.
    pub flutes: u32,
    /// Cutting data.
    pub cut: Cut,
    /// Passes and links.
    pub path: PathOptions,
    /// Limit on the material removal rate.
    pub force: Force,
    /// Trochoid options.
    pub trochoid: TrochoidOptions,
    /// The machine.
    pub machine: Machine,
    /// What to write.
    pub output: OutputOptions,
}

/// Source and selection of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceOptions {
    /// File or formula.
    pub source: SurfaceSource,
    /// Factor from the file's units to mm (the job's `scale` times its unit).
    pub scale: f64,
    /// Rotations about X, Y, Z in this order, rad, applied after the scale.
    pub rotate: DVec3,
    /// Translation applied last, mm.
    pub translate: DVec3,
    /// Which faces are machined.
    pub select: Selection,
    /// Scale of curvature estimation, mm; `None` takes it from the mesh.
    pub curvature_radius: Option<f64>,
    /// Whether the surface is machined from the side its faces point away from.
    pub flip: bool,
}

/// Where the surface comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceSource {
    /// A mesh file, relative to the job file.
    File(String),
    /// A surface given by a formula.
    Analytic(crate::surface::AnalyticSurface),
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
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum FlattenMethod {
    /// Angle-based flattening.
    Abf,
    /// Boundary-first flattening.
    Bff,
}

/// What the side step comes from.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Stepover {
    /// The same side step everywhere on the surface, mm.
    Fixed(f64),
    /// The side step whose cusp is this scallop height, mm.
    Scallop(f64),
}

/// On which side of the cutter the material lies.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum CutDirection {
    /// Climb (down) milling: material on the right of a clockwise spindle's feed... left open cut on the left.
    Climb,
    /// Conventional (up) milling.
    Conventional,
}

/// What to do where the cutter does not fit.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum TooTight {
    /// Raise the cutter until it clears, report the area.
    Avoid,
    /// Refuse the job.
    Refuse,
}

/// Cutting data.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Cut {
    /// Side step.
    pub stepover: Stepover,
    /// Axial depth `H`, mm.
    pub axial_depth: f64,
    /// Nominal feed `V_f`, mm/s.
    pub feed: f64,
    /// Spindle speed, rev/s.
    pub spindle: f64,
    /// Lead angle (five-axis), rad.
    pub lead: f64,
    /// Chord tolerance, mm.
    pub tolerance: f64,
    /// Allowance left on the surface, mm.
    pub stock: f64,
    /// Climb or conventional.
    pub direction: CutDirection,
    /// Policy for places the cutter does not fit.
    pub too_tight: TooTight,
}

/// Order of the rings.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum RingOrder {
    /// From the boundary inward.
    OutsideIn,
    /// From the core outward.
    InsideOut,
}

/// What lies outside of the surface's boundary, for engagement.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Air: the first pass runs on the boundary.
    Open,
    /// Material that stays: the first pass runs a cutter radius inside.
    Wall,
}

/// How consecutive passes are joined.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Links {
    /// On the surface where that is allowed, else by retract.
    Surface,
    /// Always by retract.
    Retract,
}

/// Passes and links.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PathOptions {
    /// Order of the rings.
    pub order: RingOrder,
    /// Joining of passes.
    pub links: Links,
    /// Outside of the boundary.
    pub boundary: Boundary,
}

/// Limit on the material removal rate.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum MrrLimit {
    /// In mm³/s.
    Absolute(f64),
    /// As a multiple of a straight pass at the nominal side step: `factor * D * H * V_f`.
    Relative(f64),
}

/// What is done where the limit would be exceeded.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum ForceControl {
    /// Nothing; the excess is reported.
    Off,
    /// Trochoids are inserted.
    Trochoid,
    /// The feed is reduced.
    Feed,
}

/// Which feed component the removal rate is formed with.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum FeedComponent {
    /// The mean component normal to the engaged arc: exact.
    Mean,
    /// The whole feed: an upper bound.
    Feed,
}

/// Limit on the material removal rate.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Force {
    /// The limit.
    pub limit: MrrLimit,
    /// The cure.
    pub control: ForceControl,
    /// `V_fc`.
    pub vfc: FeedComponent,
}

/// Trochoid options.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TrochoidOptions {
    /// Largest step between loops, mm.
    pub max_step: f64,
    /// Smallest loop radius, mm.
    pub min_radius: f64,
    /// Feed on the half of a loop that cuts nothing, mm/s.
    pub return_feed: f64,
}

/// G-code dialect.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Post {
    /// LinuxCNC (RS-274/NGC).
    LinuxCnc,
}

/// Pictures that can be drawn.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Picture {
    /// Flat map with the path coloured by removal rate.
    Flat,
    /// Shaded surface with the path on it.
    Surface,
    /// Removal rate along time.
    Mrr,
}

/// What to write.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputOptions {
    /// G-code dialect, if a program is wanted.
    pub gcode: Option<Post>,
    /// Pictures wanted.
    pub pictures: Vec<Picture>,
}
