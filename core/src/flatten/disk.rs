//! The surface as a topological disk: holes capped for the time of the flattening.

use std::borrow::Cow;

use super::caps;
use super::error::FlattenError;
use crate::geometry::DVec3;
use crate::mesh::{Connectivity, VertexId};
use crate::surface::Surface;

/// A surface whose inner boundary loops are filled with further faces.
///
/// Faces and vertices of the surface keep their numbers; those of the caps follow.
pub(super) struct Disk<'a> {
    pub connectivity: Cow<'a, Connectivity>,
    pub positions: Cow<'a, [DVec3]>,
    /// Faces that belong to the surface.
    pub surface_faces: usize,
}

impl<'a> Disk<'a> {
    /// Caps every boundary loop but the longest.
    ///
    /// # Errors
    /// [`FlattenError::NotADisk`] when the surface is closed or has handles.
    pub fn new(surface: &'a Surface) -> Result<Self, FlattenError> {
        let connectivity = surface.connectivity();
        let loops = connectivity.boundary_loops().len();
        let chi = connectivity.euler_characteristic();
        let fault = FlattenError::NotADisk { loops, chi };
        if loops == 0 || chi != 2 - loops as i64 {
            return Err(fault);
        }
        let surface_faces = connectivity.face_count();
        if loops == 1 {
            return Ok(Self {
                connectivity: Cow::Borrowed(connectivity),
                positions: Cow::Borrowed(surface.positions()),
                surface_faces,
            });
        }
        let (faces, positions) = caps::fill(surface, outer_loop_index(surface));
        let connectivity = Connectivity::new(positions.len(), faces).map_err(|_| fault)?;
        Ok(Self {
            connectivity: Cow::Owned(connectivity),
            positions: Cow::Owned(positions),
            surface_faces,
        })
    }

    /// The boundary of the disk.
    pub fn boundary(&self) -> &[VertexId] {
        &self.connectivity.boundary_loops()[0]
    }
}

/// The longest boundary loop: the one that stays open. `None` for a closed surface.
pub fn outer_loop(surface: &Surface) -> Option<&[VertexId]> {
    surface.connectivity().boundary_loops().get(outer_loop_index(surface)).map(Vec::as_slice)
}

fn outer_loop_index(surface: &Surface) -> usize {
    let positions = surface.positions();
    let length = |cycle: &[VertexId]| -> f64 {
        let next = cycle.iter().cycle().skip(1);
        cycle
            .iter()
            .zip(next)
            .map(|(a, b)| positions[a.index()].distance(positions[b.index()]))
            .sum()
    };
    let mut longest = (0, 0.0);
    for (i, cycle) in surface.connectivity().boundary_loops().iter().enumerate() {
        let length = length(cycle);
        if length > longest.1 {
            longest = (i, length);
        }
    }
    longest.0
}
