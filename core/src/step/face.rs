//! A face before it is meshed: its surface and the edges around it.

use super::edge::Edges;
use crate::nurbs::NurbsSurface;

/// A face of a STEP file.
#[derive(Clone, Debug)]
pub struct StepFace {
    /// Number of its instance.
    pub id: u64,
    /// Kind of its surface, in the field's words.
    pub kind: String,
    /// Its surface and loops, or why there are none.
    pub(super) shape: Result<Trimmed, String>,
}

/// A surface with loops.
#[derive(Clone, Debug)]
pub(super) struct Trimmed {
    pub surface: NurbsSurface,
    pub edges: Edges,
    /// Whether the face looks against `u` cross `v`.
    pub reversed: bool,
}
