//! The degrees that a surface may have.

/// Largest degree; CAD systems stay below it, and it bounds the arrays on the stack.
pub const LARGEST_DEGREE: usize = 15;
