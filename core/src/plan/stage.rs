//! The steps of planning.

/// The steps of the pipeline that take time.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading and checking the surface.
    Surface,
    /// Flattening it.
    Flatten,
    /// Distance field and rings.
    Rings,
    /// Cutting in the plane, with force control and, for comparison, without.
    Cut,
    /// Mapping onto the surface, locating the cutter, joining.
    Locate,
    /// Laying trochoids again with smaller loops, where those before broke a limit.
    Loops,
    /// Measuring what the passes leave, and adding branches and rest passes.
    Rest,
    /// Simulating the path to verify it.
    Verify,
    /// Simulating the texture of the job's window.
    Texture,
    /// Writing program, tables, pictures and report.
    Write,
}
