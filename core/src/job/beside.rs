//! Files that a job is completed with before it is resolved.

use super::fault::Fault;

/// Such a file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Beside {
    /// The library from which its tool is taken, `tool.library`.
    Library,
    /// The description of its machine, `machine.file`.
    Machine,
}

impl Beside {
    /// The key of its name.
    pub fn key(self) -> &'static str {
        match self {
            Self::Library => "tool.library",
            Self::Machine => "machine.file",
        }
    }
}

/// Gives the content of a file that a job is completed with, or says why there is none.
pub type Load<'a> = dyn FnMut(Beside, &str) -> Result<Vec<u8>, Fault> + 'a;
