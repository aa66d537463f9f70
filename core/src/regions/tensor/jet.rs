//! Height fields fitted to the surroundings of a place on a mesh, of a degree high enough to show how the curvature
//! changes, and the zero of a tensor's anisotropic part on a smooth surface.
//!
//! # Source
//! Cazals and Pouget, "Estimating differential quantities using polynomial fitting of osculating
//! jets", CAGD 22 (2005).

use crate::geometry::{DVec2, DVec3, any_perpendicular};
use crate::surface::{ShapeOperator, Surface};

/// Degrees that are tried, highest first, and the number of vertices that each needs.
const DEGREES: [(usize, usize); 2] = [(6, 45), (4, 25)];
/// Cosine between normals below which a vertex belongs to another sheet.
const SAME_SHEET: f64 = 0.3;
/// Fraction of a column's norm that must be independent of the columns before it.
const INDEPENDENT: f64 = 1e-9;
/// Steps of Newton's method.
const STEPS: usize = 40;
/// Longest of them, in the unit of the search.
const LONGEST: f64 = 0.3;
/// A step shorter than this, in that unit, is the last.
const LAST: f64 = 1e-10;

/// A smooth surface at parameters: its shape, and its first derivatives.
pub struct Local {
    /// Shape operator.
    pub shape: ShapeOperator,
    /// First derivatives by the parameters, mm.
    pub first: [DVec3; 2],
}

impl Local {
    /// `(p, q)` of the strip-width tensor in the operator's frame, 1/mm.
    fn value(&self) -> DVec2 {
        let [xx, xy, yy] = self.shape.k;
        DVec2::new(0.25 * (xx - yy), 0.5 * xy)
    }
}

/// Where `(p, q)` vanishes.
#[derive(Copy, Clone, Debug)]
pub struct Zero {
    /// Parameters.
    pub at: DVec2,
    /// Frame of the tangent plane.
    pub frame: [DVec3; 2],
    /// `dp/dx`, `dp/dy`, `dq/dx`, `dq/dy` along the frame and in it, 1/mm².
    pub linear: [f64; 4],
}

impl Zero {
    /// Determinant of the linear part, 1/mm⁴.
    pub fn delta(&self) -> f64 {
        let [a, b, c, d] = self.linear;
        a * d - b * c
    }
}

/// The zero that Newton's method finds from `start`; parameters are measured in `unit`, in which the
/// surface changes little over 0.01. `None` where there is none near.
pub fn zero(local: impl Fn(DVec2) -> Option<Local>, start: DVec2, unit: DVec2) -> Option<Zero> {
    let mut at = start;
    for _ in 0..STEPS {
        let here = local(at)?;
        let [pu, pv] = gradient(&local, at, unit)?;
        let value = here.value();
        let determinant = pu.perp_dot(pv);
        // Cramer's rule, in units.
        let step = -DVec2::new(value.perp_dot(pv), pu.perp_dot(value)) / determinant;
        let length = step.length();
        if !length.is_finite() {
            return None;
        }
        at += step * (LONGEST / length).min(1.0) * unit;
        if length < LAST {
            return linearised(&local, at, unit);
        }
    }
    None
}

/// Change of `(p, q)` per unit of each parameter, by central differences.
fn gradient(local: &impl Fn(DVec2) -> Option<Local>, at: DVec2, unit: DVec2) -> Option<[DVec2; 2]> {
    // The error of the difference is its square, that of rounding its inverse.
    let h = 1e-4;
    let difference = |way: DVec2| {
        let step = way * unit * h;
        Some((local(at + step)?.value() - local(at - step)?.value()) / (2.0 * h))
    };
    Some([difference(DVec2::X)?, difference(DVec2::Y)?])
}

fn linearised(local: &impl Fn(DVec2) -> Option<Local>, at: DVec2, unit: DVec2) -> Option<Zero> {
    let [pu, pv] = gradient(local, at, unit)?;
    let here = local(at)?;
    let frame = here.shape.frame;
    let in_frame = |t: DVec3| DVec2::new(t.dot(frame[0]), t.dot(frame[1]));
    let (x, y) = (in_frame(here.first[0] * unit.x), in_frame(here.first[1] * unit.y));
    let determinant = x.perp_dot(y);
    // Rows times the inverse of the matrix with the columns x, y.
    let row =
        |u: f64, v: f64| [(u * y.y - v * x.y) / determinant, (v * x.x - u * y.x) / determinant];
    let ([a, b], [c, d]) = (row(pu.x, pv.x), row(pu.y, pv.y));
    let linear = [a, b, c, d];
    linear.iter().all(|l| l.is_finite()).then_some(Zero { at, frame, linear })
}

/// A height field over the tangent plane of a place.
#[derive(Clone, Debug)]
pub struct Patch {
    origin: DVec3,
    /// Tangents and normal.
    frame: [DVec3; 3],
    radius: f64,
    degree: usize,
    /// Heights in radii by monomials of coordinates in radii, by degree.
    coefficients: Vec<f64>,
    /// Root mean square distance of the vertices from it, mm, of the degrees of freedom left.
    pub deviation: f64,
    /// Standard deviation of `p` in the middle that follows from the deviation, 1/mm.
    pub spread: f64,
    /// Standard deviation of the gradient of `p` in the middle, 1/mm².
    pub slope_spread: f64,
}

impl Patch {
    /// The fit to the vertices within `radius` mm of `origin`, weighted less toward the rim; `None` where there are
    /// too few of them.
    pub fn fit(surface: &Surface, origin: DVec3, normal: DVec3, radius: f64) -> Option<Self> {
        let x = any_perpendicular(normal);
        let frame = [x, normal.cross(x), normal];
        let near = near(surface, origin, normal, radius);
        let (degree, _) = DEGREES.into_iter().find(|(_, fewest)| near.len() >= *fewest)?;
        let samples: Vec<DVec3> = near
            .iter()
            .map(|&v| {
                let d = (surface.positions()[v] - origin) / radius;
                DVec3::new(d.dot(frame[0]), d.dot(frame[1]), d.dot(normal))
            })
            .collect();
        let terms = terms(degree);
        let mut equations = Equations::new(terms);
        for s in &samples {
            let weight = 1.05 - s.length_squared();
            equations.add(&monomials(s.truncate(), degree), s.z, weight);
        }
        let factor = equations.factored()?;
        let coefficients = factor.solve(&equations.right);
        let mut patch = Self {
            origin,
            frame,
            radius,
            degree,
            coefficients,
            deviation: 0.0,
            spread: 0.0,
            slope_spread: 0.0,
        };
        let square: f64 = samples
            .iter()
            .map(|s| {
                let off = s.z - patch.height(s.truncate());
                off * off
            })
            .sum();
        let freedom = (samples.len() - terms).max(1) as f64;
        let relative = (square / freedom).sqrt();
        patch.deviation = relative * radius;
        let deviation_of = |contrast: &[(usize, f64)]| {
            let mut right = vec![0.0; terms];
            contrast.iter().for_each(|&(i, c)| right[i] = c);
            let variance: f64 = factor.solve(&right).iter().zip(&right).map(|(a, b)| a * b).sum();
            relative * variance.max(0.0).sqrt()
        };
        // T is half of K: p is a quarter of the difference of the second derivatives.
        patch.spread = deviation_of(&[(3, 0.5), (5, -0.5)]) / radius;
        let x = deviation_of(&[(6, 1.5), (8, -0.5)]);
        let y = deviation_of(&[(7, 0.5), (9, -1.5)]);
        patch.slope_spread = x.max(y) / (radius * radius);
        Some(patch)
    }

    /// The zero of `(p, q)` nearest to the middle, within the part of the disc where the fit is reliable, and the
    /// point there, mm.
    pub fn zero(&self, start: DVec3) -> Option<(Zero, DVec3)> {
        let d = (start - self.origin) / self.radius;
        let start = DVec2::new(d.dot(self.frame[0]), d.dot(self.frame[1]));
        let found = zero(|at| self.local(at), start, DVec2::ONE)?;
        (found.at.length() <= TOLD).then(|| (found, self.point(found.at)))
    }

    fn point(&self, at: DVec2) -> DVec3 {
        let [x, y, n] = self.frame;
        self.origin + (x * at.x + y * at.y + n * self.height(at)) * self.radius
    }

    fn height(&self, at: DVec2) -> f64 {
        monomials(at, self.degree).iter().zip(&self.coefficients).map(|(m, c)| m * c).sum()
    }

    fn local(&self, at: DVec2) -> Option<Local> {
        if at.length() > 1.5 {
            return None;
        }
        let mut d = [0.0; 5]; // x, y, xx, xy, yy
        let (powers_x, powers_y) = (powers(at.x, self.degree), powers(at.y, self.degree));
        let mut k = 0;
        for total in 0..=self.degree {
            for j in 0..=total {
                let (c, i) = (self.coefficients[k], total - j);
                k += 1;
                let (fi, fj) = (i as f64, j as f64);
                let p = |n: usize| if i >= n { powers_x[i - n] } else { 0.0 };
                let q = |n: usize| if j >= n { powers_y[j - n] } else { 0.0 };
                d[0] += c * fi * p(1) * q(0);
                d[1] += c * fj * p(0) * q(1);
                d[2] += c * fi * (fi - 1.0) * p(2) * q(0);
                d[3] += c * fi * fj * p(1) * q(1);
                d[4] += c * fj * (fj - 1.0) * p(0) * q(2);
            }
        }
        let [x, y, n] = self.frame;
        let first = [(x + n * d[0]) * self.radius, (y + n * d[1]) * self.radius];
        let second = [d[2], d[3], d[4]].map(|s| n * (s * self.radius));
        Some(Local { shape: ShapeOperator::from_derivatives(first, second), first })
    }
}

/// Fraction of the disc's radius within which a zero is trusted.
const TOLD: f64 = 0.7;

/// Vertices within `radius` of `origin` whose normals are near to `normal`.
fn near(surface: &Surface, origin: DVec3, normal: DVec3, radius: f64) -> Vec<usize> {
    let square = radius * radius;
    (0..surface.positions().len())
        .filter(|&v| {
            surface.positions()[v].distance_squared(origin) < square
                && surface.vertex_normals()[v].dot(normal) > SAME_SHEET
        })
        .collect()
}

fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

fn powers(x: f64, degree: usize) -> Vec<f64> {
    let mut powers = vec![1.0; degree + 1];
    for i in 1..=degree {
        powers[i] = powers[i - 1] * x;
    }
    powers
}

/// 1, x, y, x², xy, y², ...
fn monomials(at: DVec2, degree: usize) -> Vec<f64> {
    let (x, y) = (powers(at.x, degree), powers(at.y, degree));
    (0..=degree)
        .flat_map(|total| (0..=total).map(move |j| (total - j, j)))
        .map(|(i, j)| x[i] * y[j])
        .collect()
}

/// Weighted normal equations.
pub struct Equations {
    size: usize,
    /// Rows of the lower triangle.
    matrix: Vec<Vec<f64>>,
    /// Right-hand side.
    pub right: Vec<f64>,
}

/// The Cholesky factor of normal equations.
pub struct Factor(Vec<Vec<f64>>);

impl Equations {
    /// Of `size` unknowns, without any data.
    pub fn new(size: usize) -> Self {
        let matrix = (0..size).map(|i| vec![0.0; i + 1]).collect();
        Self { size, matrix, right: vec![0.0; size] }
    }

    /// Adds `basis · x = value`.
    pub fn add(&mut self, basis: &[f64], value: f64, weight: f64) {
        for i in 0..self.size {
            let scaled = weight * basis[i];
            if scaled == 0.0 {
                continue;
            }
            for (sum, other) in self.matrix[i].iter_mut().zip(basis) {
                *sum += scaled * other;
            }
            self.right[i] += scaled * value;
        }
    }

    /// `None` where an unknown depends on those before it.
    pub fn factored(&self) -> Option<Factor> {
        let mut l = self.matrix.clone();
        for i in 0..self.size {
            for j in 0..=i {
                let (row, other) = (&l[i], &l[j]);
                let known: f64 = row[..j].iter().zip(&other[..j]).map(|(a, b)| a * b).sum();
                let sum = self.matrix[i][j] - known;
                l[i][j] = if i > j {
                    sum / l[j][j]
                } else if sum > INDEPENDENT * self.matrix[i][i] {
                    sum.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Factor(l))
    }
}

impl Factor {
    /// Solution for a right-hand side.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let l = &self.0;
        let mut x = right.to_vec();
        for i in 0..x.len() {
            let known: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
            x[i] = (x[i] - known) / l[i][i];
        }
        for i in (0..x.len()).rev() {
            let known: f64 = (i + 1..x.len()).map(|k| l[k][i] * x[k]).sum();
            x[i] = (x[i] - known) / l[i][i];
        }
        x
    }
}
