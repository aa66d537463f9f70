//! A piece of a surface with a flat map of its own.

use super::measure::Stretch;
use crate::flatten::{Chart, FlattenError, bff_unchecked};
use crate::regions::pieces::Piece;
use crate::regions::split_mesh::SplitMesh;
use crate::surface::Surface;

/// A piece and its own flat map.
#[derive(Clone, Debug)]
pub struct Flattened {
    /// The piece.
    pub piece: Piece,
    /// Its own surface.
    pub surface: Surface,
    /// Its own chart, which may overlap itself: only its scale is used.
    pub chart: Chart,
    /// The chart's stretch.
    pub stretch: Stretch,
}

impl Flattened {
    /// Lays some faces of a split mesh flat.
    ///
    /// # Errors
    /// [`FlattenError`] when the equations cannot be solved; the inner `None` when the faces are not a manifold.
    pub fn of(split_mesh: &SplitMesh, faces: &[u32]) -> Result<Option<Self>, FlattenError> {
        let Some(piece) = split_mesh.piece(faces) else { return Ok(None) };
        let surface = piece.surface(split_mesh);
        let chart = bff_unchecked(&surface)?;
        let stretch = Stretch::of(&surface, &chart);
        Ok(Some(Self { piece, surface, chart, stretch }))
    }

    pub(super) fn uniformity(&self) -> f64 {
        self.stretch.evenness().uniformity
    }
}
