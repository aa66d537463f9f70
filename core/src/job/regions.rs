//! Division of the surface into regions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the surface is divided into regions, and how they are put together.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RegionOptions {
    /// How it is divided.
    pub division: Division,
    /// Smaller regions are joined to a neighbour, mm².
    pub min_area: f64,
    /// How far the strips of neighbouring regions overlap, mm.
    pub blend: f64,
    /// In which order the regions are machined.
    pub order: RegionOrder,
}

/// How the surface is divided.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Division {
    /// Not at all.
    Single,
    /// Until every region maps evenly.
    Distortion(DistortionOptions),
    /// Along the lines that part the sectors of the best feed direction.
    Tensor(TensorOptions),
}

/// Regions parted where the best feed direction parts.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TensorOptions {
    /// Standard deviation of the smoothing of the tensor on a mesh, mm; `None` takes what the noise of
    /// the vertices asks for. Larger blurs points that lie near each other into one or none.
    pub scale: Option<f64>,
    /// A trisector divides only if, a quarter of the surface's size away from it, the widest strip is
    /// wider than the narrowest by at least this part. Smaller divides surfaces on which the feed
    /// direction hardly counts.
    pub least_gain: f64,
}

impl Default for TensorOptions {
    /// Smoothing by the noise; a gain of 2 %.
    fn default() -> Self {
        Self { scale: None, least_gain: 0.02 }
    }
}

/// Regions that map evenly.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct DistortionOptions {
    /// What is clustered.
    pub measure: DistortionMeasure,
    /// Where the first cut of every region is tried.
    pub threshold: f64,
    /// Uniformity from which a region is not split further.
    pub uniformity: f64,
    /// How often a region may be split again; 0: not at all.
    pub depth: u32,
    /// How the flat stepover allows for the map.
    pub compensation: Compensation,
}

impl Default for DistortionOptions {
    fn default() -> Self {
        Self {
            measure: DistortionMeasure::Stretch,
            threshold: 0.0,
            uniformity: 0.85,
            depth: 12,
            compensation: Compensation::Exact,
        }
    }
}

/// How the surface is divided, by name.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RegionMethod {
    /// Not at all: the whole surface is one region.
    Single,
    /// Where its flat map is uneven, until every region maps evenly.
    Distortion,
    /// Along the lines that part the sectors of the best feed direction: where it is undefined, no single
    /// family of passes serves all around.
    Tensor,
}

/// What tells where a map is uneven.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DistortionMeasure {
    /// Logarithm of the mean stretch, less its mean.
    Stretch,
    /// Logarithm of the area's scale, less its mean.
    Area,
    /// Quasi-conformal error less 1.
    Angle,
}

/// How the flat stepover allows for the map.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Compensation {
    /// By the largest stretch of the region.
    Piecewise,
    /// By the stretch at the place.
    Exact,
}

/// In which order regions are machined.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RegionOrder {
    /// From neighbour to neighbour as deep as it goes.
    DepthFirst,
    /// All neighbours of a region before theirs.
    BreadthFirst,
    /// Always the nearest next.
    Nearest,
    /// Whichever of these has the shortest way between regions.
    Shortest,
}

impl RegionOptions {
    /// The method's name.
    pub fn method(&self) -> RegionMethod {
        match self.division {
            Division::Single => RegionMethod::Single,
            Division::Distortion(_) => RegionMethod::Distortion,
            Division::Tensor(_) => RegionMethod::Tensor,
        }
    }
}

impl RegionMethod {
    /// Its name in the job file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Distortion => "distortion",
            Self::Tensor => "tensor",
        }
    }
}
