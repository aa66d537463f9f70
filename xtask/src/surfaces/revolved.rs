//! Patches of spheres, tori and planes as exact NURBS: an arc turned about an axis.
//!
//! A rational quadratic arc of half angle `a` and radius `r` has the middle control point at `r / cos a`, with weight
//! `cos a` (Piegl and Tiller, "The NURBS Book", 2nd edition, chapter 7); turning every control point of the profile
//! about an axis gives the patch (chapter 8.5).

use evencut_core::geometry::math::{cos, sin};
use serde_json::{Value, json};

/// An arc of radius `tube` whose middle is `tube + major` from the axis of turning, both turned through `angle` to either
/// side, rad; the top of the patch is the origin, and it bends down.
///
/// Without `major` it is a piece of a sphere. `is_concave` bends it up instead.
pub fn patch(major: f64, tube: f64, angles: [f64; 2], is_concave: bool) -> Value {
    let up = if is_concave { -1.0 } else { 1.0 };
    let arc = |k: usize, half: f64| match k {
        1 => (0.0, 1.0 / cos(half), cos(half)),
        k => ((k as f64 - 1.0) * sin(half), cos(half), 1.0),
    };
    let point = |i: usize, j: usize| {
        let (along, out, w) = arc(j, angles[1]);
        let (x, z, v) = arc(i, angles[0]);
        // The profile's control point lies so far from the axis.
        let radius = major + tube * out;
        let place = [radius * x, tube * along, up * (radius * z - major - tube)];
        (place.map(rounded), w * v)
    };
    let of = |i: usize| (0..3).map(|j| point(i, j)).collect::<Vec<_>>();
    let grid: Vec<Vec<([f64; 3], f64)>> = (0..3).map(of).collect();
    let places: Vec<Vec<[f64; 3]>> =
        grid.iter().map(|row| row.iter().map(|p| p.0).collect()).collect();
    let weights: Vec<Vec<f64>> = grid.iter().map(|row| row.iter().map(|p| p.1).collect()).collect();
    let knots = [0, 0, 0, 1, 1, 1];
    json!({
        "degree_u": 2, "degree_v": 2, "knots_u": knots, "knots_v": knots,
        "control_points": places, "weights": weights,
    })
}

/// To picometres: zeros are zeros.
fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9 + 0.0
}

/// A patch as a file.
pub fn file(patch: &Value) -> Vec<u8> {
    let mut text = serde_json::to_string_pretty(patch).unwrap_or_default();
    text.push('\n');
    text.into_bytes()
}

/// A dome: a piece of a sphere of radius 40 mm, 12 mm long and wide.
pub fn dome() -> Vec<u8> {
    file(&patch(0.0, 40.0, [0.15; 2], false))
}

#[cfg(test)]
mod tests {
    use super::*;
    use evencut_core::geometry::{DVec2, DVec3};
    use evencut_core::nurbs::{NurbsSurface, read_json};

    fn surface(patch: &Value) -> NurbsSurface {
        read_json(&file(patch)).unwrap().surface
    }

    #[test]
    fn spheres_and_tori_are_exact() {
        for (major, is_concave) in [(0.0, false), (0.0, true), (50.0, false)] {
            let surface = surface(&patch(major, 30.0, [0.2, 0.1], is_concave));
            let up = if is_concave { -1.0 } else { 1.0 };
            for k in 0..100 {
                let at = DVec2::new(f64::from(k % 10), f64::from(k / 10)) / 9.0;
                let p = surface.point(at);
                // Seen from the middle of the ring.
                let q = DVec3::new(p.x, p.y, up * p.z + major + 30.0);
                let ring = DVec2::new(q.x, q.z).length() - major;
                assert!((DVec2::new(ring, q.y).length() - 30.0).abs() < 1e-6, "{p}");
                assert!(surface.normal(at).z > 0.9);
            }
        }
    }
}
