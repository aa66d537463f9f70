//! What a run writes.

pub use crate::machine::Post;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pictures that can be drawn.
#[derive(
    Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Picture {
    /// Flat map with the path coloured by removal rate, or by time where that is not limited.
    Flat,
    /// Shaded surface with the path on it.
    Surface,
    /// The regions and how evenly they map; nothing where there is one only.
    Regions,
    /// Best feed directions, where they are undefined, and the regions parted there; nothing with other
    /// divisions.
    Tensor,
    /// Removal rate along time.
    Mrr,
    /// What the simulation found left on the surface.
    Scallop,
    /// The removal rate that the simulation measured, on the surface.
    Removal,
    /// The channel of a hub with its blades, passes and tool axes; nothing without a hub.
    Channel,
    /// How far the tool stays clear of a hub's blades, along time; nothing without a hub.
    Clearance,
}

/// Where the post-processor comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum PostSource {
    /// It comes along.
    Named(Post),
    /// A file, relative to the job file.
    File(String),
}

/// What to write.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputOptions {
    /// Post-processor, if a program is wanted.
    pub gcode: Option<PostSource>,
    /// Pictures wanted, without repeats.
    pub pictures: Vec<Picture>,
}
