//! A line of Heidenhain's conversational format → the words that a block would have.
//!
//! Source: HEIDENHAIN, "TNC 640 User's Manual for Conversational Programming" (line L, LN with the direction of the
//! tool, TOOL CALL, FUNCTION TCPM, M128, cycle 247).

use super::block::{Block, Line, number};
use super::error::Fault;

/// A line without its number.
pub(super) fn unnumbered(line: &str) -> &str {
    let rest = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit());
    if rest.starts_with([' ', '\t']) || rest.is_empty() { rest.trim_start() } else { line }
}

/// Reads a line.
pub(super) fn scan(block: &mut Block, text: &str) -> Result<Line, Fault> {
    block.clear();
    let code = text.split(';').next().unwrap_or_default().to_ascii_uppercase();
    let words: Vec<&str> = unnumbered(code.trim_end()).split_ascii_whitespace().collect();
    match words[..] {
        [] | ["*", ..] | ["BLK", ..] | ["TOOL", "DEF", ..] => return Ok(Line::Empty),
        ["BEGIN", "PGM", .., unit] => block.g.push(if unit == "INCH" { 200 } else { 210 }),
        ["END", "PGM", ..] => block.m.push(300),
        ["TOOL", "CALL", ref rest @ ..] => {
            block.m.push(60);
            // Its length comes with the tool.
            block.set('D', 1.0, "TOOL CALL")?;
            if let Some((number, "")) = rest.first().and_then(|word| number(word)) {
                block.set('T', number, rest[0])?;
            }
            for word in rest.iter().filter(|word| word.starts_with(['S', 'F'])) {
                value(block, word)?;
            }
        }
        ["CYCL", "DEF", "247", ref rest @ ..] => {
            let datum = rest.iter().find_map(|word| word.strip_prefix("Q339="));
            let (datum, _) = datum.and_then(number).ok_or_else(|| refused(words[0], DATUM))?;
            block.g.push(541);
            block.set('P', datum, words[0])?;
        }
        ["FUNCTION", "TCPM", ..] => block.control = Some(true),
        ["FUNCTION", "RESET", "TCPM", ..] => block.control = Some(false),
        ["L" | "LN", ref rest @ ..] => {
            let is_rapid = rest.contains(&"FMAX");
            block.g.push(if is_rapid { 0 } else { 10 });
            rest.iter().try_for_each(|word| of_line(block, word))?;
        }
        ["STOP", ref rest @ ..] => rest.iter().try_for_each(|word| of_line(block, word))?,
        [first, ..] if first.starts_with('M') => {
            words.iter().try_for_each(|word| of_line(block, word))?;
        }
        [first, ..] => return Err(refused(first, STATEMENT)),
    }
    Ok(Line::Words)
}

const DATUM: &str = "a datum without its number; give Q339 on the same line";
const STATEMENT: &str = "straight lines (L, LN), TOOL CALL, FUNCTION TCPM, cycle 247 and M functions are read; have the program \
                         written of these";

/// A word of a straight line.
fn of_line(block: &mut Block, word: &str) -> Result<(), Fault> {
    match word {
        // The normal of the surface moves nothing.
        "FMAX" | "R0" => return Ok(()),
        "M128" => block.control = Some(true),
        "M129" => block.control = Some(false),
        "RL" | "RR" | "R+" | "R-" => {
            let remedy =
                "cutter compensation; have the path of the cutter's centre written, with R0";
            return Err(refused(word, remedy));
        }
        _ => {
            for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
                if word.strip_prefix('N').is_some_and(|rest| rest.starts_with(letter)) {
                    return Ok(());
                }
                let Some(text) = word.strip_prefix('T').and_then(|rest| rest.strip_prefix(letter))
                else {
                    continue;
                };
                let value = whole_number(text).ok_or_else(|| Fault::Word(word.to_string()))?;
                if block.vector[i].replace(value).is_some() {
                    return Err(Fault::Twice(format!("T{letter}")));
                }
                return Ok(());
            }
            return value(block, word);
        }
    }
    Ok(())
}

/// A letter and a number.
fn value(block: &mut Block, word: &str) -> Result<(), Fault> {
    let letter = word.chars().next().unwrap_or_default();
    let known = "XYZABCFSM".contains(letter);
    let value = word.get(1..).filter(|_| known).and_then(whole_number);
    let value = value.ok_or_else(|| Fault::Word(word.chars().take(12).collect()))?;
    block.set(letter, value, word)
}

fn whole_number(text: &str) -> Option<f64> {
    number(text).filter(|(_, rest)| rest.is_empty()).map(|(value, _)| value)
}

fn refused(word: &str, remedy: &'static str) -> Fault {
    Fault::Refused { word: word.chars().take(12).collect(), remedy, displaces: false }
}
