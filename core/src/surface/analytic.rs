//! Test surfaces given by formulas, with exact curvature.

use crate::geometry::math::{asin, cos, exp, sin};
use crate::geometry::shape::ShapeOperator;
use crate::geometry::{DVec2, DVec3};
use crate::mesh::TriangleSoup;

/// Most steps of a mesh along one direction; bounds what a tiny edge length asks for.
const MOST_STEPS: usize = 2000;

/// Surfaces given by formulas, apex at the origin, tool above (+Z); all lengths in mm.
///
/// A point is named by two parameters in mm: `(x, y)` for height fields, arc lengths otherwise.
#[derive(Clone, Debug, PartialEq)]
pub enum AnalyticSurface {
    /// A rectangle in the XY plane.
    Plane {
        /// Extent along X, mm.
        width: f64,
        /// Extent along Y, mm.
        depth: f64,
    },
    /// A spherical cap; parameters are polar arc length times the direction from the apex.
    SphereCap {
        /// Radius of the sphere, mm: positive for a dome (convex), negative for a bowl.
        radius: f64,
        /// Diameter of the rim, mm, at most twice the radius.
        diameter: f64,
    },
    /// A piece of a cylinder along Y; parameters are the arc length across and `y`.
    Cylinder {
        /// Radius, mm: positive for a ridge (convex), negative for a trough.
        radius: f64,
        /// Arc length across, mm.
        width: f64,
        /// Extent along Y, mm.
        length: f64,
    },
    /// A piece around the top circle of a torus, outside (convex) half toward +Y; parameters are
    /// the arc lengths along the top circle and along the tube.
    Torus {
        /// Radius of the circle in the middle of the tube, mm.
        major: f64,
        /// Radius of the tube, mm, less than `major`.
        minor: f64,
        /// Arc length along the top circle, mm.
        length: f64,
        /// Arc length along the tube, mm.
        width: f64,
    },
    /// `z = (x² - y²) / (2 radius)` over a square.
    Saddle {
        /// Radius of both principal curvatures in the middle, mm.
        radius: f64,
        /// Side of the square, mm.
        size: f64,
    },
    /// `z = height (x³ - 3 x y²) / (size/2)³` over a square.
    MonkeySaddle {
        /// Side of the square, mm.
        size: f64,
        /// Height in the middle of the side at +X, mm.
        height: f64,
    },
    /// `z = height exp(-(x² + y²) / (2 width²))` over a square.
    Bump {
        /// Side of the square, mm.
        size: f64,
        /// Height in the middle, mm; negative for a hollow.
        height: f64,
        /// Distance of the inflection from the middle, mm.
        width: f64,
    },
}

/// Set of parameters of a surface.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Domain {
    /// `|a| <= width/2`, `|b| <= depth/2`, mm.
    Rectangle {
        /// Extent of the first parameter, mm.
        width: f64,
        /// Extent of the second parameter, mm.
        depth: f64,
    },
    /// `a² + b² <= radius²`.
    Disk {
        /// Largest distance from the origin, mm.
        radius: f64,
    },
}

impl AnalyticSurface {
    /// The parameters it is defined for.
    pub fn domain(&self) -> Domain {
        let rectangle = |width, depth| Domain::Rectangle { width, depth };
        match *self {
            Self::Plane { width, depth } => rectangle(width, depth),
            Self::SphereCap { radius, diameter } => {
                let sine = (0.5 * diameter / radius.abs()).min(1.0);
                Domain::Disk { radius: radius.abs() * asin(sine) }
            }
            Self::Cylinder { width, length, .. } => rectangle(width, length),
            Self::Torus { length, width, .. } => rectangle(length, width),
            Self::Saddle { size, .. }
            | Self::MonkeySaddle { size, .. }
            | Self::Bump { size, .. } => rectangle(size, size),
        }
    }

    /// Position at parameters `at`, mm.
    pub fn position(&self, at: DVec2) -> DVec3 {
        match *self {
            Self::Plane { .. } => at.extend(0.0),
            Self::SphereCap { radius, .. } => {
                let (angle, direction) = polar(at, radius.abs());
                (direction * (radius.abs() * sin(angle))).extend(radius * (cos(angle) - 1.0))
            }
            Self::Cylinder { radius, .. } => {
                let angle = at.x / radius.abs();
                DVec3::new(radius.abs() * sin(angle), at.y, radius * (cos(angle) - 1.0))
            }
            Self::Torus { major, minor, .. } => {
                let (around, tube) = (at.x / major, at.y / minor);
                let reach = major + minor * sin(tube);
                DVec3::new(
                    reach * sin(around),
                    reach * cos(around) - major,
                    minor * (cos(tube) - 1.0),
                )
            }
            _ => at.extend(self.height(at)[0]),
        }
    }

    /// Exact shape operator at parameters `at`; its normal is the surface's.
    pub fn curvature(&self, at: DVec2) -> ShapeOperator {
        match *self {
            Self::Plane { .. } => ShapeOperator::flat(DVec3::Z),
            Self::SphereCap { radius, .. } => {
                let (angle, direction) = polar(at, radius.abs());
                let normal = (direction * (sin(angle) * radius.signum())).extend(cos(angle));
                ShapeOperator::umbilic(normal, 1.0 / radius)
            }
            Self::Cylinder { radius, .. } => {
                let angle = at.x / radius.abs();
                let across = DVec3::new(cos(angle), 0.0, -sin(angle) * radius.signum());
                ShapeOperator { frame: [across, DVec3::Y], k: [1.0 / radius, 0.0, 0.0] }
            }
            Self::Torus { major, minor, .. } => {
                let (around, tube) = (at.x / major, at.y / minor);
                let ring = DVec3::new(cos(around), -sin(around), 0.0);
                let outward = DVec3::new(sin(around), cos(around), 0.0);
                let meridian = outward * cos(tube) - DVec3::Z * sin(tube);
                let reach = major + minor * sin(tube);
                ShapeOperator { frame: [ring, meridian], k: [sin(tube) / reach, 0.0, 1.0 / minor] }
            }
            _ => {
                let [_, x, y, xx, xy, yy] = self.height(at);
                let first = [DVec3::new(1.0, 0.0, x), DVec3::new(0.0, 1.0, y)];
                ShapeOperator::from_derivatives(first, [xx, xy, yy].map(|s| DVec3::Z * s))
            }
        }
    }

    /// `z`, `zx`, `zy`, `zxx`, `zxy`, `zyy` of a height field; zero for the other surfaces.
    fn height(&self, DVec2 { x, y }: DVec2) -> [f64; 6] {
        match *self {
            Self::Saddle { radius, .. } => {
                let k = 1.0 / radius;
                [0.5 * k * (x * x - y * y), k * x, -k * y, k, 0.0, -k]
            }
            Self::MonkeySaddle { size, height } => {
                let half = 0.5 * size;
                let c = height / (half * half * half);
                [
                    c * (x * x * x - 3.0 * x * y * y),
                    3.0 * c * (x * x - y * y),
                    -6.0 * c * x * y,
                    6.0 * c * x,
                    -6.0 * c * y,
                    -6.0 * c * x,
                ]
            }
            Self::Bump { height, width, .. } => {
                let s = 1.0 / (width * width);
                let z = height * exp(-0.5 * s * (x * x + y * y));
                [
                    z,
                    -z * s * x,
                    -z * s * y,
                    z * s * (s * x * x - 1.0),
                    z * s * s * x * y,
                    z * s * (s * y * y - 1.0),
                ]
            }
            _ => [0.0; 6],
        }
    }

    /// A mesh with edges of about `edge` mm, every vertex exactly on the surface.
    ///
    /// Vertex `i` has the parameters `samples(edge)[i]`. No direction gets more than 2000 steps.
    pub fn mesh(&self, edge: f64) -> TriangleSoup {
        let (samples, faces) = self.tessellation(edge);
        let positions = samples.iter().map(|s| self.position(*s)).collect();
        TriangleSoup { positions, faces, texture: None }
    }

    /// Parameters of the vertices of [`mesh`](Self::mesh).
    pub fn samples(&self, edge: f64) -> Vec<DVec2> {
        self.tessellation(edge).0
    }

    fn tessellation(&self, edge: f64) -> (Vec<DVec2>, Vec<[u32; 3]>) {
        let steps = |length: f64| ((length / edge).ceil() as usize).clamp(2, MOST_STEPS);
        match self.domain() {
            Domain::Disk { radius } => disk(radius, steps(radius)),
            Domain::Rectangle { width, depth } => {
                // Rows of equilateral triangles are lower than their sides are long.
                let rows = steps(depth * 2.0 / 3.0_f64.sqrt());
                rectangle(width, depth, steps(width), rows)
            }
        }
    }
}

/// Angle from the apex and unit direction of a parameter of a sphere.
fn polar(at: DVec2, radius: f64) -> (f64, DVec2) {
    (at.length() / radius, at.normalize_or(DVec2::X))
}

/// Rows of triangles; odd rows are shifted by half a step and have one vertex more.
fn rectangle(width: f64, depth: f64, columns: usize, rows: usize) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    let n = columns as u32;
    let row_start = |row: usize| (row as u32) * (n + 1) + row as u32 / 2;
    for row in 0..=rows {
        let y = depth * (row as f64 / rows as f64 - 0.5);
        let odd = row % 2 == 1;
        for i in 0..=columns + usize::from(odd) {
            let shifted = if odd { (i as f64 - 0.5).clamp(0.0, columns as f64) } else { i as f64 };
            points.push(DVec2::new(width * (shifted / columns as f64 - 0.5), y));
        }
    }
    for row in 0..rows {
        let (low, high) = (row_start(row), row_start(row + 1));
        let (even, odd) = if row % 2 == 0 { (low, high) } else { (high, low) };
        let mut add = |a, b, c| faces.push(if row % 2 == 0 { [a, b, c] } else { [a, c, b] });
        for i in 0..=n {
            add(odd + i, even + i, odd + i + 1);
            if i < n {
                add(even + i, even + i + 1, odd + i + 1);
            }
        }
    }
    (points, faces)
}

/// Rings of six times their number of vertices around the centre.
fn disk(radius: f64, rings: usize) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let (mut points, mut faces) = (vec![DVec2::ZERO], Vec::new());
    for ring in 1..=rings {
        let r = radius * ring as f64 / rings as f64;
        for i in 0..6 * ring {
            let angle = std::f64::consts::TAU * i as f64 / (6 * ring) as f64;
            points.push(DVec2::new(r * cos(angle), r * sin(angle)));
        }
        let vertex = |ring: u32, i: u32| match ring {
            0 => 0,
            _ => 1 + 3 * ring * (ring - 1) + i % (6 * ring),
        };
        let k = ring as u32;
        for sector in 0..6 {
            for j in 0..k {
                let outer = vertex(k, sector * k + j);
                let inner = vertex(k - 1, sector * (k - 1) + j);
                faces.push([outer, vertex(k, sector * k + j + 1), inner]);
                if j + 1 < k {
                    let next = vertex(k - 1, sector * (k - 1) + j + 1);
                    faces.push([inner, vertex(k, sector * k + j + 1), next]);
                }
            }
        }
    }
    (points, faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Connectivity, VertexId};
    use crate::surface::Surface;

    fn all() -> [AnalyticSurface; 9] {
        [
            AnalyticSurface::Plane { width: 30.0, depth: 20.0 },
            AnalyticSurface::SphereCap { radius: 20.0, diameter: 30.0 },
            AnalyticSurface::SphereCap { radius: -20.0, diameter: 40.0 },
            AnalyticSurface::Cylinder { radius: 12.0, width: 20.0, length: 15.0 },
            AnalyticSurface::Cylinder { radius: -12.0, width: 20.0, length: 15.0 },
            AnalyticSurface::Torus { major: 30.0, minor: 10.0, length: 20.0, width: 15.0 },
            AnalyticSurface::Saddle { radius: 20.0, size: 20.0 },
            AnalyticSurface::MonkeySaddle { size: 20.0, height: 2.0 },
            AnalyticSurface::Bump { size: 20.0, height: 3.0, width: 5.0 },
        ]
    }

    #[test]
    fn curvature_agrees_with_differences_of_the_position() {
        let h = 1e-4;
        for surface in all() {
            let at = DVec2::new(2.1, -3.4);
            let p = |i: f64, j: f64| surface.position(at + h * DVec2::new(i, j));
            let first = [
                (p(1.0, 0.0) - p(-1.0, 0.0)) / (2.0 * h),
                (p(0.0, 1.0) - p(0.0, -1.0)) / (2.0 * h),
            ];
            let second = [
                (p(1.0, 0.0) - 2.0 * p(0.0, 0.0) + p(-1.0, 0.0)) / (h * h),
                (p(1.0, 1.0) - p(1.0, -1.0) - p(-1.0, 1.0) + p(-1.0, -1.0)) / (4.0 * h * h),
                (p(0.0, 1.0) - 2.0 * p(0.0, 0.0) + p(0.0, -1.0)) / (h * h),
            ];
            let measured = ShapeOperator::from_derivatives(first, second);
            let exact = surface.curvature(at);
            assert!((exact.normal() - measured.normal()).length() < 1e-7, "{surface:?}");
            let exact = exact.turned_to(measured.normal()).in_frame(measured.frame);
            for i in 0..3 {
                assert!((exact.k[i] - measured.k[i]).abs() < 1e-6, "{surface:?} {exact:?}");
            }
        }
    }

    #[test]
    fn meshes_are_disks_of_well_shaped_triangles_that_look_up() {
        for surface in all() {
            let mesh = surface.mesh(1.0);
            let faces = mesh.faces.iter().map(|f| f.map(VertexId)).collect();
            let connectivity = Connectivity::new(mesh.positions.len(), faces).unwrap();
            assert_eq!(connectivity.euler_characteristic(), 1);
            assert_eq!(connectivity.boundary_loops().len(), 1);
            let built = Surface::new(connectivity, mesh.positions);
            for (normal, s) in built.vertex_normals().iter().zip(surface.samples(1.0)) {
                assert!(normal.dot(surface.curvature(s).normal()) > 0.99, "{surface:?}");
            }
        }
    }

    #[test]
    fn areas_are_those_of_the_formulas() {
        let tau = std::f64::consts::TAU;
        let area = |surface: AnalyticSurface| {
            let mesh = surface.mesh(0.1);
            let at = |v: u32| mesh.positions[v as usize];
            mesh.faces
                .iter()
                .map(|f| 0.5 * (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0])).length())
                .sum::<f64>()
        };
        let cap = area(AnalyticSurface::SphereCap { radius: 5.0, diameter: 8.0 });
        assert!((cap / (tau * 5.0 * 2.0) - 1.0).abs() < 1e-3);
        let tube = area(AnalyticSurface::Cylinder { radius: 5.0, width: 6.0, length: 4.0 });
        assert!((tube / 24.0 - 1.0).abs() < 1e-3);
    }
}
