//! Boundary First Flattening: the conformal map of least distortion.
//!
//! Terms. `u` is the logarithm of the flat length per surface length; `u = 0` on the boundary
//! gives the conformal map whose scale varies least (Chebyshev, Grötzsch). The *curvature* of a
//! vertex is its angle defect, from 2 pi inside and from pi on the boundary.
//!
//! Steps: 1 holes capped, edges flipped to intrinsic Delaunay; 2 `u` from the curvature; 3 turning
//! of the flat boundary from its curvature and the outward derivative of `u`; 4 boundary polygon,
//! closed by the least change of its lengths; 5 both coordinates harmonic inside. One
//! factorisation serves steps 2 and 5.

use std::f64::consts::{PI, TAU};

use super::chart::Chart;
use super::curve::closed_polygon;
use super::disk::Disk;
use super::error::FlattenError;
use super::intrinsic::measure;
use super::laplace::DirichletLaplacian;
use crate::geometry::DVec2;
use crate::surface::Surface;

/// The conformal chart of least distortion, checked: no face turned over, no overlap.
///
/// Linear scale is constant along the outer boundary up to the polygon's closing.
///
/// # Errors
/// [`FlattenError`] when the surface is not a disk with holes, or its chart is not valid.
///
/// # Source
/// Sawhney, Crane, "Boundary First Flattening", TOG 2017.
pub fn bff(surface: &Surface) -> Result<Chart, FlattenError> {
    let chart = bff_unchecked(surface)?;
    chart.validate(surface)?;
    Ok(chart)
}

/// As [`bff`], without the check that the chart is valid.
///
/// # Errors
/// [`FlattenError`] when the surface is not a disk with holes.
pub fn bff_unchecked(surface: &Surface) -> Result<Chart, FlattenError> {
    let disk = Disk::new(surface)?;
    let (angles, mut metric) = measure(&disk)?;
    metric.flip_to_delaunay();
    let weights = metric.weights();
    drop(metric);
    let mut curvature = vec![0.0; disk.positions.len()];
    for (face, angles) in disk.connectivity.faces().iter().zip(&angles) {
        (0..3).for_each(|c| curvature[face[c].index()] += angles[c]);
    }
    drop(angles);
    for k in &mut curvature {
        *k = TAU - *k;
    }
    let laplacian = DirichletLaplacian::new(&disk, weights)?;
    let source: Vec<f64> = curvature.iter().map(|k| -k).collect();
    let u = laplacian.solve_zero_boundary(&source);
    let flux = laplacian.outward_flux(&u);
    let boundary = disk.boundary();
    let turning: Vec<f64> =
        boundary.iter().map(|v| curvature[v.index()] - PI + flux[v.index()]).collect();
    let mut flat = vec![DVec2::ZERO; disk.positions.len()];
    let corners = closed_polygon(&boundary_lengths(&disk), &turning);
    for (v, corner) in boundary.iter().zip(corners) {
        flat[v.index()] = corner;
    }
    laplacian.extend(&mut flat);
    flat.truncate(surface.positions().len());
    Ok(Chart::new(surface, flat))
}

/// Length of the boundary side that leaves each boundary vertex.
pub(super) fn boundary_lengths(disk: &Disk) -> Vec<f64> {
    let boundary = disk.boundary();
    let at = |i: usize| disk.positions[boundary[i % boundary.len()].index()];
    (0..boundary.len()).map(|i| at(i).distance(at(i + 1))).collect()
}
