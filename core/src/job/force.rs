//! The limit on the material removal rate and the cures.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Limit on the material removal rate.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum MrrLimit {
    /// In mm³/s.
    Absolute(f64),
    /// As a multiple of a straight pass at the nominal side step: `factor * D * H * V_f`.
    Relative(f64),
}

/// What is done where the limit would be exceeded.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ForceControl {
    /// Nothing; the excess is reported.
    Off,
    /// Trochoids are inserted.
    Trochoid,
    /// The feed is reduced.
    Feed,
}

/// Which feed component the removal rate is formed with.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
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
