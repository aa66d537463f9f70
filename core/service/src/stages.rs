//! Stages of planning in words.

use evencut_core::plan::Stage;

/// A stage in words.
pub fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::Surface => "reading the surface",
        Stage::Flatten => "laying the surface flat",
        Stage::Rings => "laying rings",
        Stage::Cut => "cutting within the limit",
        Stage::Locate => "locating the cutter",
        Stage::Verify => "simulating the path",
        Stage::Texture => "simulating what the teeth leave",
        Stage::Write => "writing the results",
    }
}
