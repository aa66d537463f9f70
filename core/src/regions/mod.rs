//! Division of a surface into regions.

pub mod tensor;
