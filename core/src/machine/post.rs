//! The controller of the machine, by what it reads.

/// G-code dialect.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Post {
    /// LinuxCNC (RS-274/NGC).
    LinuxCnc,
}
