//! The counts that a simulation keeps of itself.

/// What a simulation took.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub struct Work {
    /// Time steps of all moves.
    pub steps: u64,
    /// Points of the edge of one tooth, of the part that is simulated where it is the longest.
    pub edge_points: u64,
    /// Quadrilaterals near a tile.
    pub quads: u64,
    /// Lines of nodes tested against a quadrilateral.
    pub tests: u64,
}
