//! Why a program cannot be read.

use thiserror::Error;

/// Why a program cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GcodeError {
    /// An option out of range.
    #[error("reading a program: {name} is {value}; it must be {rule}")]
    Option {
        /// Which.
        name: &'static str,
        /// As given.
        value: f64,
        /// The rule.
        rule: &'static str,
    },
    /// A block that is not understood or not followed.
    #[error("program, line {line}, \"{block}\": {fault}")]
    Block {
        /// Line, from 1.
        line: u32,
        /// Its text, cut short.
        block: String,
        /// What is wrong with it.
        fault: Fault,
    },
}

impl GcodeError {
    /// Whether the program, which cannot be followed, says itself that the tool goes elsewhere, or at another feed, than
    /// its coordinates and feeds say.
    pub fn displaces(&self) -> bool {
        matches!(self, Self::Block { fault: Fault::Refused { displaces: true, .. }, .. })
    }
}

/// What is wrong with a block.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// Not a letter and a number.
    #[error("\"{0}\" is not a word; a word is a letter and a decimal number")]
    Word(String),
    /// A comment without its end.
    #[error("a comment is opened and not closed; close it with \")\" on the same line")]
    Comment,
    /// A code or a construct that changes what the program means in a way not followed here.
    #[error("{word} is not read: {remedy}")]
    Refused {
        /// What was found.
        word: String,
        /// What it is, and what to do instead.
        remedy: &'static str,
        /// Whether the tool goes elsewhere, or at another feed, than the coordinates and feeds say.
        displaces: bool,
    },
    /// An axis that the machine does not have.
    #[error(
        "{0} moves a rotary axis that {1} does not have; name the machine's axes (machine.axes of the job, or --axes), or write the program for those that it has"
    )]
    Rotary(char, String),
    /// A letter or a group of codes twice.
    #[error("{0} conflicts with another word of its kind; a block may hold only one")]
    Twice(String),
    /// A word that nothing in the block uses.
    #[error("{0} means nothing in this block; remove it, or name the code that it belongs to")]
    Unused(char),
    /// Coordinates without a motion code.
    #[error("coordinates while no motion is in force; write G0, G1, G2 or G3 first")]
    NoMotion,
    /// A move that cannot be made.
    #[error("the arc {0}")]
    Arc(&'static str),
    /// A position beyond reason.
    #[error("{axis} would go to {value:e}; at most {limit:e} mm or degrees either way are read")]
    TooFar {
        /// The axis.
        axis: char,
        /// Where to.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// The path goes on from a place that is not known.
    #[error(
        "continues from the position that line {since} reached, which depends on the machine; give machine zero in the program's coordinates (the reading option machine_zero), or replace G28, G30 and G53 by plain moves"
    )]
    Lost {
        /// The line that left for it.
        since: u32,
    },
    /// More points than allowed.
    #[error(
        "the path has more than {limit} points; allow more (max_points), or longer chords (chord_tolerance)"
    )]
    TooLong {
        /// How many are allowed.
        limit: usize,
    },
}
