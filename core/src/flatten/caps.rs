//! Caps: faces that fill the holes of a surface while it is flattened.

use crate::geometry::DVec3;
use crate::mesh::VertexId;
use crate::surface::Surface;

/// The faces and positions of `surface` with every boundary loop but `open` filled.
pub(super) fn fill(surface: &Surface, open: usize) -> (Vec<[VertexId; 3]>, Vec<DVec3>) {
    let mut faces = surface.connectivity().faces().to_vec();
    let mut positions = surface.positions().to_vec();
    for (i, cycle) in surface.connectivity().boundary_loops().iter().enumerate() {
        if i != open {
            fan(cycle, &mut faces, &mut positions);
        }
    }
    (faces, positions)
}

/// Joins every side of a loop to a new vertex at the loop's centre.
fn fan(cycle: &[VertexId], faces: &mut Vec<[VertexId; 3]>, positions: &mut Vec<DVec3>) {
    let sum: DVec3 = cycle.iter().map(|v| positions[v.index()]).sum();
    let centre = VertexId(positions.len() as u32);
    positions.push(sum / cycle.len() as f64);
    for (i, &v) in cycle.iter().enumerate() {
        faces.push([cycle[(i + 1) % cycle.len()], v, centre]);
    }
}
