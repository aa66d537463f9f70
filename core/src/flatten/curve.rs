//! Closed plane curves from side lengths and turning angles.

use crate::geometry::DVec2;
use crate::geometry::math::{cos, sin};

/// The closed polygon whose side `i` leaves corner `i` and whose corners turn by `turning`.
///
/// `lengths`, `turning`: `#n`, side lengths and exterior angles in rad, the latter summing to
/// 2 pi. Directions are kept; the lengths are changed as little as possible, in the sum of
/// squares relative to each length, so that the polygon closes.
///
/// # Source
/// Sawhney, Crane, "Boundary First Flattening", TOG 2017, section 4.3.
pub(super) fn closed_polygon(lengths: &[f64], turning: &[f64]) -> Vec<DVec2> {
    let mut heading = 0.0;
    let directions: Vec<DVec2> = turning
        .iter()
        .map(|turn| {
            heading += turn;
            DVec2::new(cos(heading), sin(heading))
        })
        .collect();
    let sides = || lengths.iter().zip(&directions);
    let gap: DVec2 = sides().map(|(l, t)| *t * *l).sum();
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (l, t) in sides() {
        xx += l * t.x * t.x;
        xy += l * t.x * t.y;
        yy += l * t.y * t.y;
    }
    let det = xx * yy - xy * xy;
    let share = DVec2::new(yy * gap.x - xy * gap.y, xx * gap.y - xy * gap.x) / det;
    let mut at = DVec2::ZERO;
    sides()
        .map(|(l, t)| {
            let corner = at;
            at += *t * (l - l * t.dot(share));
            corner
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn regular_polygon_closes_unchanged() {
        let corners = closed_polygon(&[2.0; 12], &[TAU / 12.0; 12]);
        for i in 0..12 {
            assert!((corners[i].distance(corners[(i + 1) % 12]) - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn open_polygon_is_closed_with_directions_kept() {
        let corners = closed_polygon(&[2.0, 1.0, 2.5, 1.2], &[TAU / 4.0; 4]);
        let side = |i: usize| corners[(i + 1) % 4] - corners[i];
        assert!((side(0) + side(2)).length() < 1e-12 && (side(1) + side(3)).length() < 1e-12);
        assert!(side(0).x.abs() < 1e-12 && side(0).y > 2.0);
    }
}
