//! Franke's test function as a mould.

use super::lifted;
use crate::triangulate::{Domain, triangulate};
use evencut_core::geometry::{DVec2, DVec3, math};
use evencut_core::mesh::TriangleSoup;
use serde_json::{Value, json};

const SIZE: f64 = 100.0;
/// Height of one unit of the function: slopes up to 30 degrees, concave radii down to 15 mm.
const HEIGHT: f64 = 20.0;
const SPACING: f64 = 1.15;

/// Two hills, a shallow and a sharp one, and a dip on a square.
///
/// # Source
/// Franke, "A critical comparison of some methods for interpolation of scattered data", Naval
/// Postgraduate School report NPS-53-79-003 (1979), principal test function.
pub fn mould() -> Result<TriangleSoup, String> {
    let plane = triangulate(&Domain::rectangle(DVec2::ZERO, DVec2::splat(SIZE), SPACING), SPACING)?;
    Ok(lifted(&plane, |p| DVec3::new(p.x, p.y, HEIGHT * franke(p / SIZE))))
}

/// The same as a cubic spline: control heights by the quasi-interpolant that is exact for cubics, a millimetre apart.
///
/// # Source
/// de Boor and Fix, "Spline approximation by quasi-interpolants", J. Approximation Theory 8 (1973).
pub fn spline() -> Value {
    let height = |i: f64, j: f64| HEIGHT * franke(DVec2::new(i, j) / SIZE);
    let across =
        |i: f64, j: f64| (8.0 * height(i, j) - height(i, j - 1.0) - height(i, j + 1.0)) / 6.0;
    let control =
        |i: f64, j: f64| (8.0 * across(i, j) - across(i - 1.0, j) - across(i + 1.0, j)) / 6.0;
    let count = SIZE as i32 + 3;
    let row = |i: i32| {
        let point = |j: i32| {
            let [x, y] = [i, j].map(|k| f64::from(k - 1));
            [x, y, control(x, y)]
        };
        (0..count).map(point).collect::<Vec<_>>()
    };
    let knots: Vec<i32> = (-3..=count).collect();
    json!({
        "degree_u": 3, "degree_v": 3, "knots_u": knots, "knots_v": knots,
        "control_points": (0..count).map(row).collect::<Vec<_>>(),
    })
}

fn franke(p: DVec2) -> f64 {
    let (x, y) = (9.0 * p.x, 9.0 * p.y);
    let square = |t: f64| t * t;
    0.75 * math::exp(-(square(x - 2.0) + square(y - 2.0)) / 4.0)
        + 0.75 * math::exp(-square(x + 1.0) / 49.0 - (y + 1.0) / 10.0)
        + 0.5 * math::exp(-(square(x - 7.0) + square(y - 3.0)) / 4.0)
        - 0.2 * math::exp(-square(x - 4.0) - square(y - 7.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spline_is_the_function() {
        let file = serde_json::to_vec(&spline()).unwrap();
        let surface = evencut_core::nurbs::read_json(&file).unwrap().surface;
        let (low, high) = surface.domain();
        for k in 0..200 {
            let part = DVec2::new(f64::from(k % 20), f64::from(k / 20)) / 20.0;
            let at = surface.point(low + (high - low) * part);
            assert!((at.z - HEIGHT * franke(at.truncate() / SIZE)).abs() < 1e-4, "{at}");
        }
    }

    #[test]
    fn value_at_the_first_hill() {
        // At (2/9, 2/9) the first term is 3/4; the others are far down.
        let value = franke(DVec2::splat(2.0 / 9.0));
        let second = 0.75 * math::exp(-9.0 / 49.0 - 0.3);
        let third = 0.5 * math::exp(-26.0 / 4.0);
        assert!((value - (0.75 + second + third)).abs() < 1e-9, "{value}");
    }
}
