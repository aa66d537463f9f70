//! Limits on the cut, and what is done where they would be exceeded.

use crate::load::Material;
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
    /// Nothing: limits are neither kept nor judged.
    Off,
    /// Trochoids are inserted, at the full feed.
    Trochoid,
    /// The feed is reduced.
    Feed,
    /// The feed is reduced, and trochoids are inserted where that may not be.
    Fastest,
}

impl ForceControl {
    /// Whether trochoids may be inserted.
    pub fn takes_trochoids(self) -> bool {
        matches!(self, Self::Trochoid | Self::Fastest)
    }

    /// Its name in job files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Trochoid => "trochoid",
            Self::Feed => "feed",
            Self::Fastest => "fastest",
        }
    }
}

/// Groups of materials by ISO 513.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MaterialGroup {
    /// Steel.
    P,
    /// Stainless steel.
    M,
    /// Cast iron.
    K,
    /// Non-ferrous metals.
    N,
    /// Heat-resistant alloys and titanium.
    S,
    /// Hardened steel.
    H,
}

impl MaterialGroup {
    /// The material of the group that takes the greatest force, so that limits hold for all of them.
    ///
    /// # Source
    /// ISCAR, material groups by ISO 513 and VDI 3323, `k_c1` and `m_c`: groups 11, 14, 20, 22, 33 and 39. The table
    /// gives no exponent for hardened steel; that of most others is taken.
    pub fn hardest(self) -> Material {
        let (kc11, mc) = match self {
            Self::P => (2500.0, 0.23),
            Self::M => (2150.0, 0.20),
            Self::K => (1420.0, 0.30),
            Self::N => (800.0, 0.25),
            Self::S => (3300.0, 0.24),
            Self::H => (4700.0, 0.24),
        };
        Material { kc11, mc }
    }
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

/// Limits on the cut, and what is done to keep them.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Force {
    /// On the removal rate; `None` where power or force are limited instead.
    pub limit: Option<MrrLimit>,
    /// On the power of the cut, W.
    pub power: Option<f64>,
    /// On the mean cutting force, N.
    pub cutting_force: Option<f64>,
    /// What is cut, where power or force are limited.
    pub material: Option<Material>,
    /// Smallest feed per tooth.
    pub min_chip: MinChip,
    /// Largest angle of engagement, rad; pi where there is no limit.
    pub max_engagement: f64,
    /// The cure.
    pub control: ForceControl,
    /// `V_fc`.
    pub vfc: FeedComponent,
}

/// The smallest feed per tooth.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum MinChip {
    /// A limit, mm.
    Limit(f64),
    /// What the cutter would like, mm: below it, trochoids are preferred.
    Wish(f64),
}

impl MinChip {
    /// The feed per tooth, mm.
    pub fn value(self) -> f64 {
        match self {
            Self::Limit(value) | Self::Wish(value) => value,
        }
    }
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
