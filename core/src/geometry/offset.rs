//! The material between a triangle mesh and its offset: how the section of a column along the normals changes with
//! height.
//!
//! A column on a triangle follows the normals at its corners. At height `h` its section is the triangle of the corners
//! moved by `h` along them: `A (1 + b h + c h²)`. Over a convex surface columns widen, over a concave one they narrow, and
//! end where neighbouring ones meet.
//!
//! At the boundary the columns on the surface end along its normals. Where these lean away from the boundary, stock that
//! goes straight up there has a wedge beyond them: columns on the edge, that fan from the normals to the vertical, and
//! whose section grows from nothing.
//!
//! # Source
//! Steiner's formula; for meshes: Pottmann, Liu, Wallner, Bobenko, Wang, "Geometry of multi-layer freeform structures
//! for architecture", ACM Transactions on Graphics 26 (2007), mixed areas of parallel meshes.

use super::DVec3;

/// Facets that meet at a sharper angle than this cosine (40 degrees) do not share normals.
pub const CREASE: f64 = 0.766_044_443;
/// Normals that lean less than this off the vertical, rad, have no wedge beyond them.
const UPRIGHT: f64 = 1e-3;
/// Widest column of a fan, rad.
const WIDEST: f64 = 0.2;
/// Most columns of a fan beside each other.
const MOST: f64 = 32.0;

/// How the section of a column, mm², changes with height, mm.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct CrossSection {
    /// At its foot, mm².
    pub area: f64,
    /// By height, mm: on a surface twice the mean curvature for each mm², positive where it is convex. In single
    /// precision, as one of millions.
    linear: f32,
    /// By height squared: on a surface the Gaussian curvature for each mm².
    square: f32,
}

impl CrossSection {
    /// That of a column whose foot is `area` mm² of a triangle, mm, with unit normals at its corners; of a triangle without
    /// area it does not change.
    pub fn on(area: f64, [a, b, c]: [DVec3; 3], [na, nb, nc]: [DVec3; 3]) -> Self {
        let (u, v) = (b - a, c - a);
        let (nu, nv) = (nb - na, nc - na);
        let normal = u.cross(v);
        let doubled = normal.length_squared();
        let linear = (u.cross(nv) + nu.cross(v)).dot(normal) / doubled;
        let square = nu.cross(nv).dot(normal) / doubled;
        Self { area, ..Self::default() }.changing(area * linear, area * square)
    }

    /// The same of another area.
    pub fn scaled(self, area: f64) -> Self {
        let by = area / self.area;
        let (linear, square) = (f64::from(self.linear), f64::from(self.square));
        Self { area, ..Self::default() }.changing(by * linear, by * square)
    }

    fn changing(self, linear: f64, square: f64) -> Self {
        match (linear as f32, square as f32) {
            (linear, square) if linear.is_finite() && square.is_finite() => {
                Self { linear, square, ..self }
            }
            _ => self,
        }
    }

    /// Volume of the column between two heights, mm³.
    pub fn between(self, low: f64, high: f64) -> f64 {
        self.below(high) - self.below(low)
    }

    /// The same from the foot up to a height; negative below the foot. What is beyond the height or depth at which the
    /// column ends has no volume.
    fn below(self, height: f64) -> f64 {
        let (a, b, c) = (self.area, f64::from(self.linear), f64::from(self.square));
        let h = match self.end(height < 0.0) {
            Some(end) if end.abs() < height.abs() => end,
            _ => height,
        };
        h * (a + h * (0.5 * b + h * c / 3.0))
    }

    /// The height at which the section vanishes first, above the foot or below it.
    fn end(self, below: bool) -> Option<f64> {
        let side = if below { -1.0 } else { 1.0 };
        let (a, b, c) = (self.area, side * f64::from(self.linear), f64::from(self.square));
        if b >= 0.0 && c >= 0.0 {
            return None;
        }
        if a == 0.0 {
            // On an edge the foot is one root; below it there is nothing.
            return Some(if b > 0.0 { -side * b / c } else { 0.0 });
        }
        // The smaller positive root of `a + b t + c t²`, without cancellation. It is double over a sphere, where rounding
        // may leave none.
        let least = 2.0 * a / ((b * b - 4.0 * a * c).max(0.0).sqrt() - b);
        Some(side * least)
    }
}

/// A column beside the boundary of a surface, on an edge of it.
#[derive(Copy, Clone, Debug)]
pub struct Beside {
    /// Where it stands, from 0 to 1 along the edge.
    pub along: f64,
    /// Where it stands, mm.
    pub foot: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Its section; none at its foot.
    pub section: CrossSection,
}

/// The columns of the wedge between the normals on an edge of the boundary and the vertical, up to the height `top`; none
/// where the normals lean outward or down. `edge`: its ends, mm, with the surface to the left as seen along the normals.
/// Columns are about `spacing` mm apart.
pub fn beside(
    edge: [DVec3; 2],
    normals: [DVec3; 2],
    up: DVec3,
    (spacing, top): (f64, f64),
) -> Vec<Beside> {
    let lean = normals.map(|n| n.dot(up));
    let widest = lean.into_iter().fold(1.0, f64::min);
    if !(widest > 0.0 && top > 0.0 && spacing > 0.0) {
        return Vec::new();
    }
    let [a, b] = edge;
    // Of an angle below a right one.
    let angle = (normals[0].distance(up)).max(normals[1].distance(up));
    let outward = (b - a).cross(normals[0] + normals[1]);
    if angle < UPRIGHT || outward.dot(up) <= 0.0 {
        return Vec::new();
    }
    let count = |parts: f64, most: f64| parts.ceil().clamp(1.0, most) as u32;
    let fan = count((angle * top / spacing).max(angle / WIDEST), MOST);
    let pieces = count(a.distance(b) / spacing, f64::from(u16::MAX));
    let direction = |along: f64, turned: f64| {
        let [from, to] = normals.map(|n| n.lerp(up, turned).normalize_or(up));
        from.lerp(to, along).normalize_or(up)
    };
    let part = |i: u32, of: u32| f64::from(i) / f64::from(of);
    let mut out = Vec::new();
    for (i, k) in (0..pieces).flat_map(|i| (0..fan).map(move |k| (i, k))) {
        let [s, t] = [i, i + 1].map(|i| part(i, pieces));
        let [from, to] = [k, k + 1].map(|k| part(k, fan));
        let [c, d, e, f] = [(s, from), (s, to), (t, from), (t, to)].map(|(s, u)| direction(s, u));
        let Some(middle) = (c + d + e + f).try_normalize() else { continue };
        let (across, along) = (0.5 * (d + f - c - e), 0.5 * (e + f - c - d));
        let linear = across.cross((b - a) * (t - s)).dot(middle);
        let square = across.cross(along).dot(middle);
        if linear > 0.0 {
            let along = 0.5 * (s + t);
            let section = CrossSection::default().changing(linear, square);
            out.push(Beside { along, foot: a.lerp(b, along), direction: middle, section });
        }
    }
    out
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
    use crate::geometry::math;

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
            let section = CrossSection::on(1.0, corners, normals);
            for h in [0.5, 2.0, 6.9] {
                let shell = ((radius + h).powi(3) - radius.powi(3)) / (3.0 * radius * radius);
                let found = section.between(0.0, h);
                assert!((found / shell - 1.0).abs() < 1e-5, "{radius} {h}: {found} {shell}");
            }
        }
    }

    /// Over a hollow columns meet in its middle, and nothing is beyond it; nor below a ball's.
    #[test]
    fn a_column_ends_where_columns_meet() {
        let (corners, normals) = small(|p| (DVec3::new(0.0, 0.0, 4.0) - p) / 4.0);
        let hollow = CrossSection::on(1.0, corners, normals);
        assert!((hollow.between(0.0, 9.0) - 4.0 / 3.0).abs() < 1e-5);
        assert!((hollow.between(5.0, 9.0)).abs() < 1e-5);
        let (corners, normals) = small(|p| (p + DVec3::new(0.0, 0.0, 4.0)) / 4.0);
        let ball = CrossSection::on(1.0, corners, normals);
        assert!((ball.between(-9.0, 0.0) - 4.0 / 3.0).abs() < 1e-5);
    }

    /// A saddle narrows by the square of the height alone: `1 - h²/R²`.
    #[test]
    fn a_column_on_a_saddle_narrows() {
        let radius = 5.0;
        let (corners, normals) = small(|p| DVec3::new(p.x / radius, -p.y / radius, 1.0));
        let saddle = CrossSection::on(1.0, corners, normals);
        assert!((saddle.between(0.0, 2.0) - (2.0 - 8.0 / 75.0)).abs() < 1e-5);
        assert!((saddle.between(0.0, 9.0) - (5.0 - 125.0 / 75.0)).abs() < 1e-5);
    }

    #[test]
    fn a_needle_without_area_does_not_widen() {
        let x = DVec3::X;
        let section =
            CrossSection::on(1.0, [DVec3::ZERO, x, 2.0 * x], [DVec3::Z, DVec3::X, DVec3::Y]);
        assert_eq!(section.between(1.0, 3.5), 2.5);
    }

    fn volume(columns: &[Beside], height: f64) -> f64 {
        columns.iter().map(|c| c.section.between(-1.0, height)).sum()
    }

    /// Beside a straight edge with even normals the wedge is a part of a cylinder; on the other edge there is none, nor
    /// where the surface is level or overhangs.
    #[test]
    fn the_wedge_beside_a_straight_edge_is_a_part_of_a_cylinder() {
        let edge = [DVec3::ZERO, DVec3::X * 3.0];
        let at = |angle: f64| DVec3::new(0.0, math::sin(angle), math::cos(angle));
        let of = |edge, angle| beside(edge, [at(angle); 2], DVec3::Z, (0.2, 2.0));
        for angle in [0.1, 0.7, 1.5] {
            let expected = 3.0 * 0.5 * angle * 4.0;
            let found = volume(&of(edge, angle), 2.0);
            assert!((found / expected - 1.0).abs() < 2e-3, "{angle}: {found} {expected}");
            assert!(of([edge[1], edge[0]], angle).is_empty());
        }
        assert!(of(edge, 0.0).is_empty());
        assert!(of(edge, 1.7).is_empty());
    }

    /// Around the rim of a bowl of radius `R` it is a part of a torus, by Pappus: its section, `θ h² / 2`, on the way of
    /// its centroid, which is `h³ (1 - cos θ) / 3` over that inside the rim.
    #[test]
    fn the_wedge_around_a_bowl_is_a_part_of_a_torus() {
        let (radius, angle, height) = (6.0, 0.9_f64, 3.0_f64);
        let around = |i: u32| {
            let turn = core::f64::consts::TAU * f64::from(i) / 256.0;
            let out = DVec3::new(math::cos(turn), math::sin(turn), 0.0);
            (out * radius, DVec3::Z * math::cos(angle) - out * math::sin(angle))
        };
        let edge = |i: u32| {
            let [(a, na), (b, nb)] = [around(i), around(i + 1)];
            beside([a, b], [na, nb], DVec3::Z, (0.1, height))
        };
        let found: f64 = (0..256).map(|i| volume(&edge(i), height)).sum();
        let section = 0.5 * angle * height * height;
        let inside = height.powi(3) / 3.0 * (1.0 - math::cos(angle)) / section;
        let expected = section * core::f64::consts::TAU * (radius - inside);
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
    }
}
