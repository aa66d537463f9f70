//! Programs of our own dialects back to points in the workpiece: what the controller will do, judged
//! without the path that was written.

use super::xyzac::Rotary;
use crate::geometry::DVec3;
use thiserror::Error;

/// The end of a block that moves.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ReadPoint {
    /// Line of the program, from 1.
    pub line: usize,
    /// Whether the block is a rapid.
    pub rapid: bool,
    /// Tool tip in the workpiece, mm.
    pub tip: DVec3,
    /// Unit tool axis in the workpiece.
    pub axis: DVec3,
    /// Machine Z, mm.
    pub height: f64,
    /// Feed word that governs the block: mm/min, or 1/min under inverse time; 0 for a rapid.
    pub feed: f64,
    /// Whether that is inverse time.
    pub inverse_time: bool,
}

/// Why a program cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReadError {
    /// A word that our programs do not use, or no word at all.
    #[error("program, line {line}: \"{word}\" is not a word of the programs written here")]
    Word {
        /// Line, from 1.
        line: usize,
        /// The text.
        word: String,
    },
    /// A block moves at feed with no feed in force.
    #[error("program, line {line}: a move at feed without an F word{}", if *inverse_time { "; inverse time needs one on every block" } else { "" })]
    NoFeed {
        /// Line, from 1.
        line: usize,
        /// Whether under inverse time.
        inverse_time: bool,
    },
    /// Coordinates before any motion word.
    #[error("program, line {line}: coordinates before G0 or G1")]
    NoMotion {
        /// Line, from 1.
        line: usize,
    },
    /// The program does not end.
    #[error("program: no M2 or M30 at its end")]
    NoEnd,
}

#[derive(Default)]
struct State {
    rapid: Option<bool>,
    position: [Option<f64>; 5],
    feed: Option<f64>,
    inverse_time: bool,
    ended: bool,
}

/// Reads a program back: a point for each block that moves, once X, Y and Z are all known.
///
/// # Errors
/// [`ReadError`], naming the line.
pub fn read_back(text: &str) -> Result<Vec<ReadPoint>, ReadError> {
    let mut state = State::default();
    let mut points = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if state.ended {
            break;
        }
        points.extend(read_block(line, i + 1, &mut state)?);
    }
    if state.ended { Ok(points) } else { Err(ReadError::NoEnd) }
}

fn read_block(text: &str, line: usize, state: &mut State) -> Result<Option<ReadPoint>, ReadError> {
    let mut moved = false;
    let mut feed_word = None;
    let mut parameter_only = false;
    for word in words(text) {
        let bad = || ReadError::Word { line, word: word.to_string() };
        let letter = word.chars().next().ok_or_else(bad)?;
        let value: f64 = match word[letter.len_utf8()..].parse() {
            Ok(value) if f64::is_finite(value) => value,
            _ => return Err(bad()),
        };
        match letter {
            'G' if value == 0.0 || value == 1.0 => state.rapid = Some(value == 0.0),
            'G' if value == 93.0 || value == 94.0 => {
                state.inverse_time = value == 93.0;
                state.feed = None;
            }
            'G' if value == 64.0 => parameter_only = true,
            'G' if [17.0, 21.0, 40.0, 43.0, 49.0, 80.0, 90.0].contains(&value) => {}
            'M' if value == 2.0 || value == 30.0 => state.ended = true,
            'M' if [3.0, 5.0, 6.0].contains(&value) => {}
            'S' | 'T' => {}
            'P' if parameter_only => {}
            'F' => feed_word = Some(value),
            'X' | 'Y' | 'Z' | 'A' | 'C' => {
                let index = "XYZAC".find(letter).ok_or_else(bad)?;
                state.position[index] = Some(value);
                moved = true;
            }
            _ => return Err(bad()),
        }
    }
    state.feed = if state.inverse_time { feed_word } else { feed_word.or(state.feed) };
    if moved { end_point(state, line) } else { Ok(None) }
}

fn end_point(state: &State, line: usize) -> Result<Option<ReadPoint>, ReadError> {
    let rapid = state.rapid.ok_or(ReadError::NoMotion { line })?;
    let inverse_time = state.inverse_time;
    let feed = match state.feed.filter(|&feed| feed > 0.0) {
        _ if rapid => 0.0,
        Some(feed) => feed,
        None => return Err(ReadError::NoFeed { line, inverse_time }),
    };
    let [Some(x), Some(y), Some(z), a, c] = state.position else { return Ok(None) };
    let angle = |word: Option<f64>| word.unwrap_or(0.0).to_radians();
    let rotary = Rotary { a: angle(a), c: angle(c) };
    let tip = rotary.to_part(DVec3::new(x, y, z));
    let axis = rotary.axis();
    Ok(Some(ReadPoint { line, rapid, tip, axis, height: z, feed, inverse_time }))
}

/// The words of a block, comments left out: each starts at a letter.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let code = text.split(['(', ';']).next().unwrap_or_default();
    code.split_ascii_whitespace()
}
