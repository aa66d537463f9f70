//! Passes, their order and their links.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Order of the rings.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RingOrder {
    /// From the boundary inward.
    OutsideIn,
    /// From the core outward.
    InsideOut,
}

/// What lies outside of the surface's boundary, for engagement.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// Air: the first pass runs on the boundary.
    Open,
    /// Material that stays: the first pass runs a cutter radius inside.
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
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PathOptions {
    /// Order of the rings.
    pub order: RingOrder,
    /// Joining of passes.
    pub links: Links,
    /// Outside of the boundary.
    pub boundary: Boundary,
}
