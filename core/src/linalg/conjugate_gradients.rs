//! Conjugate gradients with the factor of a similar matrix as preconditioner.

use super::cholesky::Cholesky;
use super::matrix::SymmetricMatrix;

/// Improves `x` until no row of `right - matrix x` exceeds `tolerance`, in at most `limit` steps.
///
/// `similar`: factor of a matrix near `matrix`; the nearer, the fewer steps. Returns whether the
/// tolerance was reached.
///
/// # Source
/// Hestenes, Stiefel, "Methods of conjugate gradients for solving linear systems", J. Res. NBS 49,
/// 1952, in preconditioned form.
pub fn conjugate_gradients(
    matrix: &SymmetricMatrix,
    similar: &Cholesky,
    right: &[[f64; 1]],
    x: &mut [[f64; 1]],
    tolerance: f64,
    limit: usize,
) -> bool {
    let mut residual = matrix.multiply(x);
    for (r, b) in residual.iter_mut().zip(right) {
        r[0] = b[0] - r[0];
    }
    let mut direction = vec![[0.0]; x.len()];
    let mut weight = 1.0;
    for _ in 0..limit {
        if largest(&residual) <= tolerance {
            return true;
        }
        let mut corrected = residual.clone();
        similar.solve(&mut corrected);
        let previous = std::mem::replace(&mut weight, dot(&residual, &corrected));
        let keep = weight / previous;
        for (d, c) in direction.iter_mut().zip(&corrected) {
            d[0] = c[0] + keep * d[0];
        }
        let image = matrix.multiply(&direction);
        let step = weight / dot(&direction, &image);
        for i in 0..x.len() {
            x[i][0] += step * direction[i][0];
            residual[i][0] -= step * image[i][0];
        }
    }
    largest(&residual) <= tolerance
}

/// Largest size of an entry; infinite if one is not a number.
fn largest(v: &[[f64; 1]]) -> f64 {
    v.iter().fold(0.0, |most, x| if x[0].is_nan() { f64::INFINITY } else { most.max(x[0].abs()) })
}

fn dot(a: &[[f64; 1]], b: &[[f64; 1]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of springs whose stiffness varies by `spread`.
    fn chain(n: u32, spread: f64) -> SymmetricMatrix {
        let stiffness = |i: u32| 1.0 + spread * f64::from(i % 5);
        let springs: Vec<_> = (0..n - 1).map(|i| (i, i + 1, -stiffness(i))).collect();
        let mut diagonal = vec![0.1; n as usize];
        for &(i, j, k) in &springs {
            diagonal[i as usize] -= k;
            diagonal[j as usize] -= k;
        }
        SymmetricMatrix::new(&diagonal, &springs)
    }

    #[test]
    fn its_own_factor_solves_in_one_step_and_a_similar_one_in_few() {
        let order: Vec<u32> = (0..200).collect();
        let (matrix, other) = (chain(200, 0.1), chain(200, 0.2));
        let truth: Vec<[f64; 1]> = (0..200).map(|i| [f64::from(i % 13) - 6.0]).collect();
        let right = matrix.multiply(&truth);
        for (factored, steps) in [(&matrix, 1), (&other, 12)] {
            let factor = Cholesky::new(factored, &order).unwrap();
            let mut x = vec![[0.0]; 200];
            assert!(conjugate_gradients(&matrix, &factor, &right, &mut x, 1e-10, steps));
            assert!(x.iter().zip(&truth).all(|(x, t)| (x[0] - t[0]).abs() < 1e-8));
        }
        let factor = Cholesky::new(&other, &order).unwrap();
        assert!(!conjugate_gradients(&matrix, &factor, &right, &mut vec![[0.0]; 200], 1e-10, 1));
    }
}
