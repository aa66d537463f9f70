//! Why a library cannot be read, and how large one may be.

use thiserror::Error;

/// Largest library that is read, bytes. Real ones have some kilobytes a tool; JSON takes many times its length once it is
/// read.
pub(super) const LARGEST: usize = 8 << 20;
/// The same of evencut's own, bytes: its reader takes half a minute for eight times as much.
pub(super) const LARGEST_TOML: usize = 1 << 20;
/// Most tools of a library; shops have some thousands.
const MOST_TOOLS: usize = 10_000;
/// Longest message of another reader, characters.
const LONGEST_MESSAGE: usize = 300;

/// Why a library cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LibraryError {
    /// It is too large.
    #[error("{bytes} bytes; a library of tools has at most {most}: export fewer tools")]
    Large {
        /// How many it has.
        bytes: usize,
        /// How many are read.
        most: usize,
    },
    /// It has too many tools.
    #[error("{count} tools; a library has at most {MOST_TOOLS}: export fewer")]
    TooMany {
        /// How many it has.
        count: usize,
    },
    /// It is packed.
    #[error("it is packed (zip), as Fusion's .tools files are: unpack it and give its tools.json")]
    Packed,
    /// It is no text.
    #[error("it is no text (UTF-8)")]
    NotText,
    /// It is neither JSON nor TOML, or not as libraries have it.
    #[error("{0}")]
    Syntax(String),
    /// JSON of something else.
    #[error(
        "it is JSON, but neither a library of Fusion (`data`) nor a bit (`shape`, `parameter`) or a list (`tools`) of FreeCAD"
    )]
    UnknownJson,
    /// It is empty.
    #[error("it holds no tools")]
    Empty,
}

impl LibraryError {
    /// What another reader says.
    pub(super) fn syntax(message: &str) -> Self {
        Self::Syntax(message.chars().take(LONGEST_MESSAGE).collect())
    }

    /// Refuses a library of too many tools.
    pub(super) fn unless_few(count: usize) -> Result<(), Self> {
        if count > MOST_TOOLS { Err(Self::TooMany { count }) } else { Ok(()) }
    }
}
