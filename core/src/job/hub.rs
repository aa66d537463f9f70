//! The channels between the blades of a blisk.

use crate::geometry::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the passes of a channel are spaced.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HubPasses {
    /// Whichever of the other two gives the shorter path.
    Shortest,
    /// At the distance of one strip from each other, beginning at both blades; where the channel widens, further passes
    /// begin in its middle.
    Strips,
    /// At equal parts of the way across the channel, all from end to end.
    EqualParameter,
}

impl HubPasses {
    /// Its name in the job file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shortest => "shortest",
            Self::Strips => "strips",
            Self::EqualParameter => "equal-parameter",
        }
    }
}

/// Which channels are machined.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HubChannels {
    /// All of them, one after the other.
    All,
    /// One.
    One,
}

/// A surface of a blade: a file, or a face of the STEP file of the hub.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum BladeSurface {
    /// A face of `surface.file`, by its number from 1.
    Face(#[schemars(extend("minimum" = 1, "maximum" = 1_000_000))] u32),
    /// A NURBS surface (json), relative to the job file.
    File(#[schemars(extend("minLength" = 1, "maxLength" = 4096))] String),
}

impl BladeSurface {
    /// The file that it names, if it does.
    pub fn file(&self) -> Option<&str> {
        match self {
            Self::Face(_) => None,
            Self::File(name) => Some(name),
        }
    }
}

/// The blades of a blisk and the channels between them.
#[derive(Clone, Debug, PartialEq)]
pub struct HubOptions {
    /// Number of blades, splitters not counted: that of the channels.
    pub blades: u32,
    /// Unit direction of the axis of rotation.
    pub axis: DVec3,
    /// A point of that axis, mm.
    pub origin: DVec3,
    /// All surfaces of one blade, with its fillet.
    pub blade: Vec<BladeSurface>,
    /// All surfaces of one splitter blade, with its fillet; empty where there is none.
    pub splitter: Vec<BladeSurface>,
    /// Distance that cutter, shank and holder keep from blades and fillets, mm.
    pub clearance: f64,
    /// How far the passes go on beyond both ends of a channel, mm.
    pub extension: f64,
    /// How the passes are spaced.
    pub passes: HubPasses,
    /// Which channels are machined.
    pub channels: HubChannels,
}

impl HubOptions {
    /// The files that it names, in their order, each once.
    pub fn files(&self) -> Vec<&str> {
        let mut files: Vec<&str> = Vec::new();
        for name in self.blade.iter().chain(&self.splitter).filter_map(BladeSurface::file) {
            if !files.contains(&name) {
                files.push(name);
            }
        }
        files
    }
}
