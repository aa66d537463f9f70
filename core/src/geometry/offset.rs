//! The material between a triangle mesh and its offset: how a column along the normals widens with height.
//!
//! A column on a triangle follows the normals at its corners. At height `h` its section is the triangle of the corners
//! moved by `h` along them; over the area at its foot that is `1 + b h + c h²`. Over a convex surface columns widen, over
//! a concave one they narrow, and end where neighbouring ones meet.
//!
//! # Source
//! Steiner's formula; for meshes: Pottmann, Liu, Wallner, Bobenko, Wang, "Geometry of multi-layer freeform structures
//! for architecture", ACM Transactions on Graphics 26 (2007), mixed areas of parallel meshes.

use super::DVec3;

/// Facets that meet at a sharper angle than this cosine (40 degrees) do not share normals.
pub const CREASE: f64 = 0.766_044_443;

/// How the section of a column changes with height.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Widening {
    /// By height, 1/mm: twice the mean curvature, positive where the surface is convex. In single precision, as one of
    /// millions.
    linear: f32,
    /// By height squared, 1/mm²: the Gaussian curvature.
    square: f32,
}

impl Widening {
    /// That of columns on a triangle, mm, with unit normals at its corners; none on a triangle without area.
    pub fn on([a, b, c]: [DVec3; 3], [na, nb, nc]: [DVec3; 3]) -> Self {
        let (u, v) = (b - a, c - a);
        let (nu, nv) = (nb - na, nc - na);
        let normal = u.cross(v);
        let doubled = normal.length_squared();
        let linear = (u.cross(nv) + nu.cross(v)).dot(normal) / doubled;
        let square = nu.cross(nv).dot(normal) / doubled;
        match (linear as f32, square as f32) {
            (linear, square) if linear.is_finite() && square.is_finite() => Self { linear, square },
            _ => Self::default(),
        }
    }

    /// Volume of a column between two heights over the area at its foot, mm.
    pub fn between(self, low: f64, high: f64) -> f64 {
        self.below(high) - self.below(low)
    }

    /// The same from the foot up to a height; negative below the foot. What is beyond the height or depth at which the
    /// column ends has no volume.
    fn below(self, height: f64) -> f64 {
        let (b, c) = (f64::from(self.linear), f64::from(self.square));
        let h = match self.end(height < 0.0) {
            Some(end) if end.abs() < height.abs() => end,
            _ => height,
        };
        h * (1.0 + h * (0.5 * b + h * c / 3.0))
    }

    /// The height at which the section vanishes first, above the foot or below it.
    fn end(self, below: bool) -> Option<f64> {
        let side = if below { -1.0 } else { 1.0 };
        let (b, c) = (side * f64::from(self.linear), f64::from(self.square));
        if b >= 0.0 && c >= 0.0 {
            return None;
        }
        // The smaller positive root of `1 + b t + c t²`, without cancellation. It is double over a sphere, where rounding
        // may leave none.
        let least = 2.0 / ((b * b - 4.0 * c).max(0.0).sqrt() - b);
        Some(side * least)
    }
}

/// Normals at the corners of every face: those of the faces around the vertex that meet this one without a crease,
/// weighted with their area.
pub fn corner_normals(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<[DVec3; 3]> {
    let doubled = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        (b - a).cross(c - a)
    };
    let areas: Vec<DVec3> = faces.iter().map(doubled).collect();
    let mut first = vec![0u32; positions.len() + 1];
    for face in faces {
        face.iter().for_each(|&v| first[v as usize + 1] += 1);
    }
    for i in 1..first.len() {
        first[i] += first[i - 1];
    }
    let mut next = first.clone();
    let mut around = vec![0u32; 3 * faces.len()];
    for (f, face) in faces.iter().enumerate() {
        for &v in face {
            around[next[v as usize] as usize] = f as u32;
            next[v as usize] += 1;
        }
    }
    let normal = |f: usize, v: u32| {
        let own = areas[f];
        let ring = &around[first[v as usize] as usize..first[v as usize + 1] as usize];
        let smooth = |a: &DVec3| a.dot(own) > CREASE * a.length() * own.length();
        let sum: DVec3 = ring.iter().map(|&g| areas[g as usize]).filter(smooth).sum();
        sum.try_normalize().or(own.try_normalize()).unwrap_or(DVec3::Z)
    };
    faces.iter().enumerate().map(|(f, face)| face.map(|v| normal(f, v))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a small triangle, and what makes their normals.
    fn small(normal: impl Fn(DVec3) -> DVec3) -> ([DVec3; 3], [DVec3; 3]) {
        let corners =
            [(0.01, 0.0), (-0.004, 0.008), (-0.003, -0.009)].map(|(x, y)| DVec3::new(x, y, 0.0));
        (corners, corners.map(normal))
    }

    /// Shells: a column over a sphere of radius `R`, from inside or outside, has the volume
    /// `((R + h)³ - R³) / 3 R²` for each mm² of its foot.
    #[test]
    fn a_column_on_a_sphere_is_a_part_of_the_shell() {
        for radius in [7.0, -7.0_f64] {
            let centre = DVec3::new(0.0, 0.0, -radius);
            let (corners, normals) = small(|p| (p - centre) / radius);
            let widening = Widening::on(corners, normals);
            for h in [0.5, 2.0, 6.9] {
                let shell = ((radius + h).powi(3) - radius.powi(3)) / (3.0 * radius * radius);
                let found = widening.between(0.0, h);
                assert!((found / shell - 1.0).abs() < 1e-5, "{radius} {h}: {found} {shell}");
            }
        }
    }

    /// Over a hollow columns meet in its middle, and nothing is beyond it; nor below a ball's.
    #[test]
    fn a_column_ends_where_columns_meet() {
        let (corners, normals) = small(|p| (DVec3::new(0.0, 0.0, 4.0) - p) / 4.0);
        let hollow = Widening::on(corners, normals);
        assert!((hollow.between(0.0, 9.0) - 4.0 / 3.0).abs() < 1e-5);
        assert!((hollow.between(5.0, 9.0)).abs() < 1e-5);
        let (corners, normals) = small(|p| (p + DVec3::new(0.0, 0.0, 4.0)) / 4.0);
        let ball = Widening::on(corners, normals);
        assert!((ball.between(-9.0, 0.0) - 4.0 / 3.0).abs() < 1e-5);
    }

    /// A saddle narrows by the square of the height alone: `1 - h²/R²`.
    #[test]
    fn a_column_on_a_saddle_narrows() {
        let radius = 5.0;
        let (corners, normals) = small(|p| DVec3::new(p.x / radius, -p.y / radius, 1.0));
        let saddle = Widening::on(corners, normals);
        assert!((saddle.between(0.0, 2.0) - (2.0 - 8.0 / 75.0)).abs() < 1e-5);
        assert!((saddle.between(0.0, 9.0) - (5.0 - 125.0 / 75.0)).abs() < 1e-5);
    }

    #[test]
    fn a_needle_without_area_has_no_widening() {
        let x = DVec3::X;
        let widening = Widening::on([DVec3::ZERO, x, 2.0 * x], [DVec3::Z, DVec3::X, DVec3::Y]);
        assert_eq!(widening.between(1.0, 3.5), 2.5);
    }
}
