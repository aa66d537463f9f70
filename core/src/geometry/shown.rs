//! How messages write numbers that may be of any size.

use std::fmt;

/// From here on a number is written with an exponent, and below the least, unless it is zero.
const PLAIN: std::ops::Range<f64> = 1e-6..1e15;

/// A number for a message, with all its digits: with an exponent where it would be hundreds of digits long.
#[derive(Copy, Clone, Debug)]
pub struct Shown(pub f64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = *self;
        if value == 0.0 || !value.is_finite() || PLAIN.contains(&value.abs()) {
            write!(f, "{value}")
        } else {
            write!(f, "{value:e}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_long() {
        let shown = [0.0, -1.5, 1e12, 1e308, -1e-300, f64::NAN].map(|x| Shown(x).to_string());
        assert_eq!(shown, ["0", "-1.5", "1000000000000", "1e308", "-1e-300", "NaN"]);
    }
}
