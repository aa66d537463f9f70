//! Units of job files and of the inside, and the way back that loses no bit.

use crate::units::{per_minute, per_second};

/// mm in an inch.
pub(super) const INCH: f64 = 25.4;

/// rad from deg.
pub(super) fn radians(degrees: f64) -> f64 {
    degrees * (std::f64::consts::PI / 180.0)
}

/// deg that [`radians`] takes to exactly `angle`.
pub(super) fn to_degrees(angle: f64) -> f64 {
    invert(angle, angle * (180.0 / std::f64::consts::PI), radians)
}

/// Per minute that [`per_second`](crate::units::per_second) takes to exactly `rate`.
pub(super) fn to_per_minute(rate: f64) -> f64 {
    invert(rate, per_minute(rate), per_second)
}

/// The shortest decimal that `forward` takes to exactly `target`, looked for around `guess`.
///
/// Every `target` that came out of `forward` has one, since a guess is off by a few units in the
/// last place at most; for others, `guess` itself.
fn invert(target: f64, guess: f64, forward: impl Fn(f64) -> f64) -> f64 {
    let shortened = (0..17).filter_map(|digits| format!("{guess:.digits$e}").parse::<f64>().ok());
    let (mut below, mut above) = (guess, guess);
    let neighbours = (0..8).flat_map(|_| {
        below = below.next_down();
        above = above.next_up();
        [below, above]
    });
    shortened.chain(neighbours).find(|v| forward(*v) == target).unwrap_or(guess)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_back_is_exact_and_short() {
        for i in 1..20_000 {
            let (feed, angle) = (f64::from(i) * 0.7, f64::from(i) * 0.003);
            assert_eq!(per_second(to_per_minute(per_second(feed))), per_second(feed));
            assert_eq!(radians(to_degrees(radians(angle))), radians(angle));
        }
        assert_eq!(to_per_minute(per_second(1200.0)).to_string(), "1200");
        assert_eq!(to_degrees(radians(0.1)).to_string(), "0.1");
    }
}
