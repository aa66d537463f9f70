//! Directions of the separatrices at a degenerate point.
//!
//! Along a ray at angle theta the linear field is `(p, q) = (a x + b y, c x + d y)`; the ray is radial
//! to one of the tensor's directions where `q cos 2 theta - p sin 2 theta = 0`, which for
//! `m = tan(theta)` is the cubic `d m³ + (c + 2 b) m² + (2 a - d) m - c = 0`. Each root stands for two
//! opposite rays: along the one on which `p cos 2 theta + q sin 2 theta > 0` the major direction is
//! radial.
//!
//! # Source
//! Delmarcelle (1994); Xu, Li, Liu (2016).

use crate::geometry::math::{acos_clamped, atan, atan2, cbrt, cos, sin};
use crate::geometry::{DVec2, OrderBy};
use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// Directions from which the one is taken that is farthest from a root.
const TURNS: u32 = 7;
/// Roots nearer than this, rad, are one.
const SAME: f64 = 1e-6;

/// Angles of the rays along which the major direction of the linear field `a`, `b`, `c`, `d` is radial,
/// in increasing order from `-pi` to `pi`: three at a trisector, one to three at a wedge.
pub fn rays(linear: [f64; 4]) -> Vec<f64> {
    let cubic = |angle: f64| {
        let (x, y) = (cos(angle), sin(angle));
        let value = value(linear, DVec2::new(x, y));
        value.y * (x * x - y * y) - value.x * 2.0 * x * y
    };
    // Turned so that no root is at a right angle, where its tangent would be infinite.
    let turned = (0..TURNS).map(|i| PI * f64::from(i) / f64::from(TURNS));
    let best =
        turned.max_by(|s, t| cubic(s + FRAC_PI_2).abs().total_cmp(&cubic(t + FRAC_PI_2).abs()));
    let turn = best.unwrap_or(0.0);
    let [c0, c1, c2, c3] = coefficients(&cubic, turn);
    let mut angles: Vec<f64> = roots(c0, c1, c2, c3)
        .into_iter()
        .map(|m| {
            let angle = atan(m) + turn;
            let (x, y) = (cos(angle), sin(angle));
            let value = value(linear, DVec2::new(x, y));
            let along = value.x * (x * x - y * y) + value.y * 2.0 * x * y;
            if along < 0.0 { angle + PI } else { angle }
        })
        .map(|angle| angle - TAU * (angle / TAU).round())
        .collect();
    angles.order_by(f64::total_cmp);
    angles.dedup_by(|a, b| (*a - *b).abs() < SAME);
    angles
}

/// The linear field at a place.
fn value([a, b, c, d]: [f64; 4], at: DVec2) -> DVec2 {
    DVec2::new(a * at.x + b * at.y, c * at.x + d * at.y)
}

/// Coefficients of the form of degree three that `cubic` is on the unit circle, by the tangent of the
/// angle from `turn`.
fn coefficients(cubic: &impl Fn(f64) -> f64, turn: f64) -> [f64; 4] {
    // On the unit circle the form is f(t) = sum of c_k cos^(3-k) sin^k.
    let (c0, c3) = (cubic(turn), cubic(turn + FRAC_PI_2));
    let half = FRAC_PI_2 / 2.0;
    // At 45 degrees all monomials are 8^(-1/2), with the signs of the sine at -45 degrees.
    let root = 8f64.sqrt();
    let (plus, minus) = (cubic(turn + half) * root, cubic(turn - half) * root);
    let (odd, even) = (0.5 * (plus - minus), 0.5 * (plus + minus));
    [c0, odd - c3, even - c0, c3]
}

/// Real roots of `c0 + c1 m + c2 m² + c3 m³`, `c3` not small.
///
/// # Source
/// Cardano's and Viète's formulas, then a step of Newton's method each.
fn roots(c0: f64, c1: f64, c2: f64, c3: f64) -> Vec<f64> {
    if c3 == 0.0 {
        return Vec::new();
    }
    let (a, b, c) = (c2 / c3, c1 / c3, c0 / c3);
    let third = a / 3.0;
    let q = (a * a - 3.0 * b) / 9.0;
    let r = (2.0 * a * a * a - 9.0 * a * b + 27.0 * c) / 54.0;
    let found = if r * r < q * q * q {
        let angle = acos_clamped(r / (q * q * q).sqrt());
        let at = |k: f64| -2.0 * q.sqrt() * cos((angle + TAU * k) / 3.0) - third;
        vec![at(0.0), at(1.0), at(-1.0)]
    } else {
        let s = -cbrt(r.abs() + (r * r - q * q * q).max(0.0).sqrt()) * r.signum();
        vec![s + if s == 0.0 { 0.0 } else { q / s } - third]
    };
    let polished = |m: f64| {
        let (f, slope) = (c + m * (b + m * (a + m)), b + m * (2.0 * a + 3.0 * m));
        if slope.abs() > 1e-9 { m - f / slope } else { m }
    };
    found.into_iter().map(polished).collect()
}

/// Angles, of `samples` on a small circle, at which the best feed direction of a field points nearest
/// to the centre: the source's way. `field`: `(p, q)` on the circle at an angle.
pub fn sampled(field: impl Fn(f64) -> DVec2, samples: u32) -> Vec<f64> {
    let angle = |i: u32| TAU * f64::from(i) / f64::from(samples) - PI;
    // How far the direction is from the radius, -pi/2 to pi/2.
    let off: Vec<f64> = (0..samples)
        .map(|i| {
            let value = field(angle(i));
            let turned = 0.5 * atan2(value.y, value.x) - angle(i);
            turned - PI * (turned / PI).round()
        })
        .collect();
    let n = off.len();
    (0..n)
        .filter(|&i| {
            let (here, next) = (off[i], off[(i + 1) % n]);
            // A change of sign, not the jump where the direction is across.
            (here <= 0.0) != (next <= 0.0) && (here - next).abs() < FRAC_PI_2
        })
        .map(|i| {
            let nearer = if off[i].abs() <= off[(i + 1) % n].abs() { i } else { (i + 1) % n };
            angle(nearer as u32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(a: f64, b: f64) -> f64 {
        let d = a - b;
        (d - TAU * (d / TAU).round()).abs()
    }

    #[test]
    fn an_even_trisector_has_three_rays_a_third_apart() {
        // p = x, q = -y: the directions turn back by half the angle.
        let rays = rays([1.0, 0.0, 0.0, -1.0]);
        assert_eq!(rays.len(), 3, "{rays:?}");
        for (found, expected) in rays.iter().zip([-TAU / 3.0, 0.0, TAU / 3.0]) {
            assert!(apart(*found, expected) < 1e-12, "{rays:?}");
        }
    }

    #[test]
    fn a_wedge_has_one_ray() {
        let rays = rays([1.0, 0.0, 0.0, 1.0]);
        assert_eq!(rays.len(), 1);
        assert!(rays[0].abs() < 1e-12);
    }

    /// The cubic and the circle agree to the sampling angle, for trisectors of all shapes.
    #[test]
    fn the_cubic_agrees_with_the_small_circle() {
        let samples = 3600;
        for k in 0..500 {
            let number = |salt| crate::flatten::samples::jitter(k, salt);
            let linear = [number(1), number(2), number(3), number(4)];
            let [a, b, c, d] = linear;
            if a * d - b * c > -1e-3 {
                continue;
            }
            let cubic = rays(linear);
            let circle = sampled(|t| value(linear, DVec2::new(cos(t), sin(t))), samples);
            assert_eq!(cubic.len(), 3, "{linear:?}");
            assert_eq!(circle.len(), 3, "{linear:?}: {cubic:?} {circle:?}");
            for ray in &cubic {
                let nearest = circle.iter().map(|s| apart(*s, *ray)).fold(PI, f64::min);
                assert!(nearest <= TAU / f64::from(samples), "{linear:?}: {cubic:?} {circle:?}");
            }
        }
    }
}
