//! What stands beside the surface and must not be touched.

/// A mesh that the whole tool stays away from: a clamp, a vice, a locating pin.
#[derive(Clone, Debug, PartialEq)]
pub struct Avoid {
    /// Its file, relative to the job file; placed as the surface's file is.
    pub file: String,
    /// How far cutter, shank and holder stay away from it at least, mm.
    pub distance: f64,
    /// What it is called in messages and reports.
    pub name: String,
}
