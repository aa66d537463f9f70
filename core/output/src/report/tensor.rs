//! What is reported of the best feed direction.

use serde::Serialize;

/// Where the best feed direction is undefined.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TensorFigures {
    /// Places where all feed directions are as good.
    pub points: Vec<PointFigures>,
    /// Lines that part the sectors around them.
    pub separatrices: u64,
    /// Pairs of a trisector and a wedge that were taken for noise.
    pub cancelled_pairs: u64,
    /// Other places at which the field of a mesh vanishes that noise may have made.
    pub doubtful: u64,
    /// Area on which no direction is better than others, mm².
    pub free_mm2: f64,
    /// How far the tensor of a mesh was smoothed, mm; 0 where it is exact.
    pub smoothing_mm: f64,
}

/// A place where all feed directions are as good.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PointFigures {
    /// `trisector` or `wedge`.
    pub kind: String,
    /// Where, mm.
    pub at_mm: [f64; 3],
    /// `dp/dx dq/dy - dp/dy dq/dx` of half the tensor's anisotropy, 1/mm⁴; negative at trisectors.
    pub delta: f64,
    /// Whether the surface was divided there.
    pub divides: bool,
}
