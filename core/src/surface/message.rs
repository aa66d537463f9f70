//! How messages write numbers and places.

use std::fmt;

use crate::geometry::DVec3;

/// A position for a message.
pub(super) struct Spot(pub DVec3);

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0.to_array().map(short);
        write!(f, "({x}, {y}, {z})")
    }
}

/// A number with at most six significant digits, without an exponent where it needs none.
pub(super) fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    let size = rounded.abs();
    if size == 0.0 {
        "0".into()
    } else if (1e-4..1e9).contains(&size) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}
