//! Flat points from the angles of all faces.
//!
//! The boundary is laid out as a polygon: its turning is what the angles leave of pi, its lengths
//! follow from each other through the fan of faces around each boundary vertex by the law of
//! sines. The inside solves the Laplace equation with the cotangents of the flat angles, for which
//! the sought coordinates are harmonic: no error adds up along a chain of faces.

use std::f64::consts::PI;

use super::curve::closed_polygon;
use super::disk::Disk;
use super::error::FlattenError;
use super::intrinsic::weights_from_angles;
use super::laplace::DirichletLaplacian;
use crate::geometry::DVec2;
use crate::geometry::math::{exp, ln, sin};
use crate::mesh::VertexId;

/// One flat point per vertex of `disk` from `#F` by 3 angles that fit together in the plane.
pub(super) fn lay_out(disk: &Disk, angles: &[[f64; 3]]) -> Result<Vec<DVec2>, FlattenError> {
    let laplacian = DirichletLaplacian::new(disk, weights_from_angles(disk, angles))?;
    let (lengths, turning) = boundary_from_angles(disk, angles);
    let boundary = disk.boundary();
    let mut flat = vec![DVec2::ZERO; disk.positions.len()];
    for (v, corner) in boundary.iter().zip(closed_polygon(&lengths, &turning)) {
        flat[v.index()] = corner;
    }
    laplacian.extend(&mut flat);
    Ok(flat)
}

/// Length of the side leaving each boundary vertex (the first 1) and turning there.
fn boundary_from_angles(disk: &Disk, angles: &[[f64; 3]]) -> (Vec<f64>, Vec<f64>) {
    let boundary = disk.boundary();
    let fans: Vec<Fan> = boundary.iter().map(|&v| Fan::around(disk, angles, v)).collect();
    let turning = fans.iter().map(|fan| PI - fan.angle).collect();
    // ln(length) of side i from that of side i - 1, which arrives at vertex i.
    let mut logarithms = Vec::with_capacity(boundary.len());
    let mut logarithm = 0.0;
    for i in 0..fans.len() {
        logarithms.push(logarithm);
        logarithm -= fans[(i + 1) % fans.len()].log_ratio;
    }
    // All around it returns to its start but for the residual of the angles, shared out here.
    let drift = logarithm / fans.len() as f64;
    let lengths = logarithms.iter().enumerate().map(|(i, l)| exp(l - drift * i as f64)).collect();
    (lengths, turning)
}

/// The faces around a boundary vertex.
struct Fan {
    /// Sum of their angles there.
    angle: f64,
    /// `ln(arriving boundary side / leaving boundary side)`.
    log_ratio: f64,
}

impl Fan {
    fn around(disk: &Disk, angles: &[[f64; 3]], vertex: VertexId) -> Self {
        let mut fan = Fan { angle: 0.0, log_ratio: 0.0 };
        let mut side = disk.connectivity.leaving(vertex);
        while let Some(s) = side {
            let (face, corner) = (angles[s.face().index()], s.corner());
            fan.angle += face[corner];
            // The side that leaves faces corner + 2, the one that arrives faces corner + 1.
            fan.log_ratio += ln(sin(face[(corner + 1) % 3]) / sin(face[(corner + 2) % 3]));
            side = disk.connectivity.opposite(s.prev());
        }
        fan
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::intrinsic::measure;
    use crate::flatten::samples;

    #[test]
    fn angles_of_a_plane_give_a_similar_plane() {
        let surface = samples::sheared_plane(15, 0.4);
        let disk = Disk::new(&surface).unwrap();
        let (angles, _) = measure(&disk).unwrap();
        let flat = lay_out(&disk, &angles).unwrap();
        let unit = flat[0].distance(flat[15]);
        for (p, q) in surface.positions().iter().zip(&flat) {
            assert!((p.length() - q.distance(flat[0]) / unit).abs() < 1e-9);
        }
    }
}
