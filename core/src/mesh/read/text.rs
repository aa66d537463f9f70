//! Tokens of a text file, with the line numbers of what goes wrong.

use super::check::finite;
use super::error::{Place, ReadError};
use super::format::MeshFormat;
use crate::geometry::DVec3;

/// A reader of whitespace-separated tokens.
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
    format: MeshFormat,
    /// Whether `#` hides the rest of its line.
    comments: bool,
}

/// A token and where it starts.
#[derive(Copy, Clone)]
pub(super) struct Token<'a> {
    pub text: &'a [u8],
    pub start: usize,
}

impl Token<'_> {
    /// Whether it is `word`, in any case.
    pub fn is(&self, word: &str) -> bool {
        self.text.eq_ignore_ascii_case(word.as_bytes())
    }
}

impl<'a> Tokens<'a> {
    /// Tokens from byte `at` on; a UTF-8 byte-order mark at the very start is skipped.
    pub fn new(bytes: &'a [u8], at: usize, format: MeshFormat, comments: bool) -> Self {
        let mark = at == 0 && bytes.starts_with(&[0xef, 0xbb, 0xbf]);
        Self { bytes, at: if mark { 3 } else { at }, format, comments }
    }

    /// Bytes not yet consumed.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Where the next token is looked for.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Continues reading at byte `at`.
    pub fn seek(&mut self, at: usize) {
        self.at = at;
    }

    /// The next token, over line ends.
    pub fn next(&mut self) -> Option<Token<'a>> {
        loop {
            let skip = self.bytes[self.at..].iter().position(|b| !is_space(*b))?;
            self.at += skip;
            if self.comments && self.bytes[self.at] == b'#' {
                self.skip_line();
                continue;
            }
            return Some(self.take());
        }
    }

    /// The next token of this line; `None` at its end or at a comment.
    ///
    /// A backslash as the last character of a line joins the next line to it.
    pub fn next_in_line(&mut self) -> Option<Token<'a>> {
        loop {
            let &b = self.bytes.get(self.at)?;
            if b == b'\n' || (self.comments && b == b'#') {
                return None;
            }
            if is_space(b) {
                self.at += 1;
            } else if b == b'\\' {
                match self.continuation() {
                    Some(next_line) => self.at = next_line,
                    None => return Some(self.take()),
                }
            } else {
                return Some(self.take());
            }
        }
    }

    /// Where the next line starts if the backslash here ends its line.
    fn continuation(&self) -> Option<usize> {
        let rest = &self.bytes[self.at + 1..];
        let end = rest.iter().position(|b| *b != b'\r').unwrap_or(rest.len());
        match rest.get(end) {
            Some(b'\n') => Some(self.at + end + 2),
            None => Some(self.bytes.len()),
            Some(_) => None,
        }
    }

    fn take(&mut self) -> Token<'a> {
        let start = self.at;
        let ends = |b: &u8| is_space(*b) || (self.comments && *b == b'#');
        let length = self.bytes[start..].iter().position(ends).unwrap_or(self.remaining());
        // A token may end in a line continuation.
        let text = &self.bytes[start..start + length];
        let length = if text.len() > 1 && text.ends_with(b"\\") { length - 1 } else { length };
        self.at = start + length;
        Token { text: &self.bytes[start..self.at], start }
    }

    /// Moves to the next token without consuming it.
    pub fn skip_blank(&mut self) {
        self.at = self.next().map_or(self.bytes.len(), |token| token.start);
    }

    /// Moves to the start of the next line.
    pub fn skip_line(&mut self) {
        let end = self.bytes[self.at..].iter().position(|b| *b == b'\n');
        self.at = end.map_or(self.bytes.len(), |e| self.at + e + 1);
    }

    /// A finite number.
    pub fn number(&self, token: Option<Token>, what: &str) -> Result<f64, ReadError> {
        let value = token.and_then(|t| parse_float(t.text));
        match value {
            Some(v) if v.is_finite() => Ok(v),
            _ => Err(self.unexpected(token, what)),
        }
    }

    /// Three finite numbers, the next tokens of this line.
    pub fn position_in_line(&mut self) -> Result<DVec3, ReadError> {
        let mut p = [0.0; 3];
        for (axis, value) in p.iter_mut().enumerate() {
            let token = self.next_in_line();
            *value = match token.and_then(|t| parse_float(t.text)) {
                Some(v) => v,
                None => {
                    let axis = ["x", "y", "z"][axis];
                    return Err(
                        self.unexpected(token, &format!("a number (the {axis} coordinate)"))
                    );
                }
            };
        }
        finite(DVec3::from_array(p))
            .map_err(|found| self.error(self.at.min(self.bytes.len()), found, "finite numbers"))
    }

    /// A whole number that is not negative.
    pub fn count(&self, token: Option<Token>, what: &str) -> Result<u64, ReadError> {
        token.and_then(|t| parse_whole(t.text)).ok_or_else(|| self.unexpected(token, what))
    }

    /// The error of a token (or the end of the line or file) in the wrong place.
    pub fn unexpected(&self, token: Option<Token>, expected: &str) -> ReadError {
        match token {
            Some(t) => self.error(t.start, quote(t.text), expected),
            None if self.at >= self.bytes.len() => {
                self.error(self.at, "the end of the file".into(), expected)
            }
            None => self.error(self.at, "the end of the line".into(), expected),
        }
    }

    /// The line of a byte.
    pub fn line(&self, at: usize) -> Place {
        let before = &self.bytes[..at.min(self.bytes.len())];
        Place::Line(1 + before.iter().filter(|b| **b == b'\n').count())
    }

    /// An error at a byte, which becomes a line number.
    pub fn error(&self, at: usize, found: String, expected: &str) -> ReadError {
        let (format, place) = (self.format, self.line(at));
        ReadError { format, place, found, expected: expected.to_owned() }
    }
}

fn is_space(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\r' | b'\n' | 0x0b | 0x0c)
}

/// The token for a message: quoted, cut to a readable length, without control characters.
pub(super) fn quote(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown = &text[..text.len().min(LONGEST)];
    let dots = if text.len() > LONGEST { "…" } else { "" };
    format!("\"{}{dots}\"", String::from_utf8_lossy(shown).escape_debug())
}

fn parse_float(text: &[u8]) -> Option<f64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

fn parse_whole(text: &[u8]) -> Option<u64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

/// A whole number with a sign.
pub(super) fn parse_index(text: &[u8]) -> Option<i64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}
