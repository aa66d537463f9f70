//! A line of a program → its words.

use super::error::Fault;

/// The words of a block.
#[derive(Default)]
pub(super) struct Block {
    /// Tenths of the G codes, in the order written: G90.1 is 901.
    pub g: Vec<u32>,
    /// Tenths of the M codes.
    pub m: Vec<u32>,
    /// Values of the other letters.
    values: [Option<f64>; 26],
    /// Direction of the tool axis.
    pub vector: [Option<f64>; 3],
    /// Tool centre control goes on, or off, other than by a G code.
    pub control: Option<bool>,
    /// The line without comments and blanks, in capitals.
    code: String,
}

/// What a line is.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// Nothing to do.
    Empty,
    /// `%`: the tape begins or ends.
    Tape,
    /// Words.
    Words,
}

impl Block {
    /// Reads a line, leaving out blocks that start with `/` if `block_delete`.
    pub fn scan(&mut self, text: &str, block_delete: bool) -> Result<Line, Fault> {
        self.clear();
        if text.trim_start().starts_with('%') {
            return Ok(Line::Tape);
        }
        self.strip(text)?;
        let code = std::mem::take(&mut self.code);
        let line = self.words(&code, block_delete);
        self.code = code;
        line
    }

    /// Without words.
    pub fn clear(&mut self) {
        self.g.clear();
        self.m.clear();
        (self.values, self.vector, self.control) = ([None; 26], [None; 3], None);
    }

    /// Sets a word; `text`: how it is written, for messages.
    pub fn set(&mut self, letter: char, value: f64, text: &str) -> Result<(), Fault> {
        self.put(letter, value, text)
    }

    /// Takes the value of a letter out of the block.
    pub fn take(&mut self, letter: char) -> Option<f64> {
        self.values[slot(letter)].take()
    }

    /// The value of a letter.
    pub fn get(&self, letter: char) -> Option<f64> {
        self.values[slot(letter)]
    }

    /// A letter that is left.
    pub fn left(&self) -> Option<char> {
        let slot = self.values.iter().position(Option::is_some)?;
        Some(char::from(b'A' + slot as u8))
    }

    fn strip(&mut self, text: &str) -> Result<(), Fault> {
        self.code.clear();
        let mut comment = false;
        for c in text.chars() {
            match c {
                ')' if comment => comment = false,
                _ if comment => {}
                '(' => comment = true,
                ';' => break,
                _ if c.is_whitespace() => {}
                _ => self.code.push(c.to_ascii_uppercase()),
            }
        }
        if comment { Err(Fault::Comment) } else { Ok(()) }
    }

    fn words(&mut self, code: &str, block_delete: bool) -> Result<Line, Fault> {
        let mut rest = code;
        let mut first = true;
        while let Some(letter) = rest.chars().next() {
            let tail = &rest[letter.len_utf8()..];
            if letter == '/' && first {
                if block_delete {
                    self.values = [None; 26];
                    return Ok(Line::Empty);
                }
                // A number after it chooses one of several switches.
                rest = tail.trim_start_matches(|c: char| c.is_ascii_digit());
                continue;
            }
            if let Some(after) = self.keyword(rest)? {
                (rest, first) = (after, false);
                continue;
            }
            let (value, after) = number(tail).ok_or_else(|| bad(rest))?;
            self.put(letter, value, rest)?;
            first &= letter == 'N';
            rest = after;
        }
        Ok(if code.is_empty() { Line::Empty } else { Line::Words })
    }

    /// A word of SINUMERIK at the start of a text, and what follows it: the transformation for five axes, how
    /// orientations are interpolated, the direction of the tool axis.
    fn keyword<'t>(&mut self, text: &'t str) -> Result<Option<&'t str>, Fault> {
        for (word, control) in [("TRAORI", Some(true)), ("TRAFOOF", Some(false))] {
            if let Some(after) = text.strip_prefix(word) {
                self.control = control;
                return Ok(Some(after));
            }
        }
        for word in ["ORIWKS", "ORIVECT", "ORIPLANE"] {
            if let Some(after) = text.strip_prefix(word) {
                return Ok(Some(after));
            }
        }
        for (i, word) in ["A3=", "B3=", "C3="].into_iter().enumerate() {
            let Some(tail) = text.strip_prefix(word) else { continue };
            let (value, after) = number(tail).ok_or_else(|| bad(text))?;
            if self.vector[i].replace(value).is_some() {
                return Err(Fault::Twice(word.to_string()));
            }
            return Ok(Some(after));
        }
        Ok(None)
    }

    fn put(&mut self, letter: char, value: f64, rest: &str) -> Result<(), Fault> {
        match letter {
            'G' | 'M' => {
                let code = tenths(value).ok_or_else(|| bad(rest))?;
                if letter == 'G' { &mut self.g } else { &mut self.m }.push(code);
            }
            'N' => {}
            'A'..='Z' => {
                if self.values[slot(letter)].replace(value).is_some() {
                    return Err(Fault::Twice(letter.to_string()));
                }
            }
            _ => return Err(bad(rest)),
        }
        Ok(())
    }
}

fn slot(letter: char) -> usize {
    letter as usize - 'A' as usize
}

/// A code's number in tenths.
fn tenths(value: f64) -> Option<u32> {
    let scaled = 10.0 * value;
    let whole = scaled.round();
    ((scaled - whole).abs() < 1e-6 && (0.0..10_000.0).contains(&whole)).then_some(whole as u32)
}

/// A number at the start of a text, and what follows it.
pub(super) fn number(text: &str) -> Option<(f64, &str)> {
    let sign = usize::from(text.starts_with(['+', '-']));
    let digits = text[sign..].find(|c: char| !c.is_ascii_digit() && c != '.');
    let end = digits.map_or(text.len(), |n| sign + n);
    // Of the forms that `parse` knows only decimals are left; two points are none.
    let value: f64 = text[..end].parse().ok()?;
    value.is_finite().then(|| (value, &text[end..]))
}

/// What stands at the start of `rest` and is no word.
fn bad(rest: &str) -> Fault {
    let word: String = rest.chars().take(12).collect();
    if rest.starts_with('O') || rest.contains("SUB") || rest.contains("CALL") {
        return Fault::Refused { word, remedy: super::codes::SUBPROGRAM, displaces: true };
    }
    if rest.contains(['#', '[', ']', '=', '<', '>']) {
        let remedy =
            "variables and expressions are evaluated by the controller; have plain numbers written";
        return Fault::Refused { word, remedy, displaces: false };
    }
    Fault::Word(word)
}
