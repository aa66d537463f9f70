//! The strip metric: how many passes a step across the surface counts.

use crate::geometry::DVec3;
use crate::surface::ShapeOperator;

/// The strip metric at a point: a symmetric tensor, passes² per mm², as `[xx, yy, zz, xy, yz, zx]`.
pub type StripMetric = [f64; 6];

/// The same side step everywhere, mm.
pub fn even(side_step: f64) -> StripMetric {
    let m = 1.0 / (side_step * side_step);
    [m, m, m, 0.0, 0.0, 0.0]
}

/// `M = (k_tool I + K) / (8 h)`: the side step whose cusp is `scallop` mm high.
///
/// `widest`: side step, mm, that is not exceeded where the surface is as concave as the tool is
/// convex. Along the normal, where no step goes, the tensor is that of a plane.
///
/// # Source
/// Kim 2007; spec 02.
pub fn of_scallop(k_tool: f64, shape: &ShapeOperator, scallop: f64, widest: f64) -> StripMetric {
    let (k_min, k_max, along_max) = shape.principal();
    let normal = shape.normal();
    let along_min = normal.cross(along_max);
    let floor = 1.0 / (widest * widest);
    let weight = |k: f64| ((k_tool + k) / (8.0 * scallop)).max(floor);
    let mut metric = [0.0; 6];
    for (w, d) in [(weight(k_min), along_min), (weight(k_max), along_max), (weight(0.0), normal)] {
        add_square(&mut metric, d, w);
    }
    metric
}

fn add_square(metric: &mut StripMetric, d: DVec3, w: f64) {
    let square = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.y * d.z, d.z * d.x];
    for (m, s) in metric.iter_mut().zip(square) {
        *m += w * s;
    }
}

/// Squared length of `e` in the metric, passes².
pub fn square_of(m: &StripMetric, e: DVec3) -> f64 {
    m[0] * e.x * e.x
        + m[1] * e.y * e.y
        + m[2] * e.z * e.z
        + 2.0 * (m[3] * e.x * e.y + m[4] * e.y * e.z + m[5] * e.z * e.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ball on a cylinder: across it `w = sqrt(8 h / (1/r + 1/rho))`, along it the plane's.
    #[test]
    fn cylinder_has_two_widths() {
        let (r, rho, h) = (5.0, 40.0, 0.01);
        let shape = ShapeOperator { frame: [DVec3::X, DVec3::Y], k: [1.0 / rho, 0.0, 0.0] };
        let m = of_scallop(1.0 / r, &shape, h, 10.0);
        let width = |d: DVec3| 1.0 / square_of(&m, d).sqrt();
        assert!((width(DVec3::X) - (8.0 * h / (1.0 / r + 1.0 / rho)).sqrt()).abs() < 1e-12);
        assert!((width(DVec3::Y) - (8.0 * h * r).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn too_concave_is_capped() {
        let shape = ShapeOperator { frame: [DVec3::X, DVec3::Y], k: [-1.0, 0.0, -1.0] };
        let m = of_scallop(0.2, &shape, 0.01, 3.0);
        assert!((square_of(&m, DVec3::X).sqrt() - 1.0 / 3.0).abs() < 1e-12);
    }
}
