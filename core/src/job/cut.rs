//! Cutting data.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the side step comes from.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Stepover {
    /// The same side step everywhere on the surface, mm.
    Fixed(f64),
    /// The side step whose cusp is this scallop height, mm.
    Scallop(f64),
}

/// On which side of the cutter the material lies.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CutDirection {
    /// Climb (down) milling, clockwise spindle: the uncut material is on the right of the feed.
    Climb,
    /// Conventional (up) milling: the uncut material is on the left of the feed.
    Conventional,
}

/// What to do where the cutter does not fit.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Inaccessible {
    /// Lift the cutter until it clears, report the area.
    Lift,
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
    /// Largest angle between axis and surface normal where the axis is tilted for clearance, rad; 0 for never.
    pub largest_tilt: f64,
    /// Chord tolerance, mm.
    pub tolerance: f64,
    /// Allowance left on the surface, mm.
    pub allowance: f64,
    /// Climb or conventional.
    pub direction: CutDirection,
    /// What to do where the cutter does not fit.
    pub inaccessible: Inaccessible,
}
