//! Passes, their order and their links.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry::DVec3;

/// Pattern of the passes.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// Rings parallel to the boundary.
    Contour,
    /// Passes at the distance of one strip from each other, beginning at a curve (`start`).
    IsoScallop,
    /// Passes along a surface parameter, or a conformal coordinate of a mesh.
    IsoParametric,
    /// Passes in parallel vertical planes.
    IsoPlanar,
    /// Passes across the direction in which the strip is widest, as nearly as one field can.
    DirectionField,
    /// Bands of passes that each begin where strips are the widest and end where they would be much
    /// narrower than they could be (machining potential field).
    Mpf,
    /// Rings joined to one continuous path.
    Spiral,
    /// Passes along the channels between the blades of a blisk, whose hub the surface is.
    Hub,
}

impl Pattern {
    /// The patterns for any surface, in the order in which they are compared.
    pub const ALL: [Self; 7] = [
        Self::Contour,
        Self::IsoScallop,
        Self::IsoParametric,
        Self::IsoPlanar,
        Self::DirectionField,
        Self::Mpf,
        Self::Spiral,
    ];

    /// Its name in the job file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contour => "contour",
            Self::IsoScallop => "iso-scallop",
            Self::IsoParametric => "iso-parametric",
            Self::IsoPlanar => "iso-planar",
            Self::DirectionField => "direction-field",
            Self::Mpf => "mpf",
            Self::Spiral => "spiral",
            Self::Hub => "hub",
        }
    }

    /// Keys of `[path]` that belong to some patterns only.
    pub const KEYS: [&str; 10] = [
        "start",
        "curve",
        "along",
        "angle",
        "traverse",
        "order",
        "first",
        "links",
        "entry_radius",
        "boundary",
    ];

    /// Whether one of [`KEYS`](Self::KEYS) says anything about it.
    pub fn uses(self, key: &str) -> bool {
        match key {
            "start" | "curve" => self == Self::IsoScallop,
            "along" => self == Self::IsoParametric,
            "angle" => self == Self::IsoPlanar,
            "order" => self.has_rings(),
            "traverse" => !self.has_rings() && self != Self::Hub,
            _ => self != Self::Hub,
        }
    }

    /// Whether its passes are closed rings about the middle of the surface.
    pub fn has_rings(self) -> bool {
        matches!(self, Self::Contour | Self::Spiral)
    }

    /// Whether its regions are its own: bands, each with a curve at which its passes begin.
    pub fn divides_itself(self) -> bool {
        self == Self::Mpf
    }

    /// Whether trochoids can be inserted into its passes where they would remove too much. `lags`: whether strips of the
    /// cutter lag behind the contact, so that open passes are moved sideways, which loops could not follow.
    pub fn takes_trochoids(self, lags: bool) -> bool {
        match self {
            Self::Contour => true,
            Self::Hub | Self::Spiral => false,
            _ => !lags,
        }
    }

    /// Whether its rings are joined to one pass.
    pub fn joins_rings(self) -> bool {
        self == Self::Spiral
    }

    /// Whether its passes may follow the surface's own parameters.
    pub fn follows_parameters(self) -> bool {
        self == Self::IsoParametric
    }
}

/// Where iso-scallop passes begin.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// Wherever the path is the shortest: at a side of the boundary, a straight line through the middle of
    /// the flat image, or a curve along the best feed direction.
    Shortest,
    /// The curve through the place of the widest strip, across the direction in which it is widest.
    Widest,
    /// The side of the boundary from which the path is shortest.
    Boundary,
    /// A curve through these points, mm, each taken to the nearest point of the surface.
    Curve(Vec<DVec3>),
}

/// Where iso-scallop passes begin, by name.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StartKey {
    /// Wherever the path is the shortest: at a side of the boundary, a straight line through the middle of
    /// the flat image, or a curve along the best feed direction.
    Shortest,
    /// The curve through the place of the widest strip, across the direction in which it is widest.
    Widest,
    /// The side of the boundary from which the path is shortest.
    Boundary,
}

/// Surface parameter along which iso-parametric passes run.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Parameter {
    /// The first.
    U,
    /// The second.
    V,
}

/// How open passes follow each other.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Traverse {
    /// To and fro.
    Zigzag,
    /// All in the direction that the cut direction asks for, with a retract between them.
    OneWay,
}

/// Where the outermost passes run on an open boundary.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FirstPass {
    /// On the boundary.
    Edge,
    /// Half a strip inside: the fewest passes.
    HalfStrip,
}

/// Order of the rings.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RingOrder {
    /// From the boundary inward.
    OutsideIn,
    /// From the core outward.
    InsideOut,
}

/// What lies outside of the surface's boundary.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// Air: the first pass runs on the boundary.
    Open,
    /// Material that stays: the part's own faces where they rise beside the surface, else a wall along the tool
    /// axis (along the surface's normal on five axes). The first pass runs where the cutter touches it.
    Wall,
}

/// How consecutive passes are joined.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Links {
    /// On the surface where that is allowed, else by retract.
    Surface,
    /// Always by retract.
    Retract,
}

/// Passes and links.
#[derive(Clone, Debug, PartialEq)]
pub struct PathOptions {
    /// Pattern of the passes.
    pub pattern: Pattern,
    /// Where iso-scallop passes begin.
    pub start: Start,
    /// Parameter of iso-parametric passes; `None`: the one with the shorter path.
    pub along: Option<Parameter>,
    /// Direction of iso-planar passes from X, rad; `None`: the one with the shortest path.
    pub angle: Option<f64>,
    /// How open passes follow each other.
    pub traverse: Traverse,
    /// Where the outermost passes run.
    pub first: FirstPass,
    /// Order of the rings.
    pub order: RingOrder,
    /// Joining of passes.
    pub links: Links,
    /// Radius of the arcs on which passes are entered and left, mm; 0 for straight down and up.
    pub entry_radius: f64,
    /// Outside of the boundary.
    pub boundary: Boundary,
    /// Height of walls above the edge of the surface, mm.
    pub wall_height: f64,
}
