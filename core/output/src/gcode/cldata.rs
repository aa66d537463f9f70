//! A statement of APT cutter location data → the words that a block would have.
//!
//! Source: ISO 4343:2000, "Numerical control of machines. NC processor output. Post processor commands"; ISO 3592:2000,
//! "NC processor output. File structure and language format".

use super::block::{Block, Line, number};
use super::error::Fault;

/// What holds from one statement to the next.
#[derive(Default)]
pub(super) struct Cldata {
    /// The next motion is a rapid.
    rapid: bool,
}

impl Cldata {
    /// Reads a statement.
    pub fn scan(&mut self, block: &mut Block, text: &str) -> Result<Line, Fault> {
        block.clear();
        let code = text.split("$$").next().unwrap_or_default().to_ascii_uppercase();
        let (word, rest) = code.trim().split_once('/').unwrap_or((code.trim(), ""));
        let word = word.trim_end();
        let given: Vec<&str> = rest.split(',').map(str::trim).filter(|a| !a.is_empty()).collect();
        match word {
            "FINI" | "END" => block.m.push(300),
            "UNITS" => {
                block.g.push(if given.iter().any(|a| a.starts_with("IN")) { 200 } else { 210 })
            }
            "MULTAX" => block.control = Some(given.first() != Some(&"OFF")),
            "LOADTL" => {
                block.m.push(60);
                // Its length comes with the tool.
                block.set('D', 1.0, "LOADTL")?;
                let after = given.iter().skip_while(|word| **word != "ADJUST").nth(1);
                for (letter, text) in [('T', given.first()), ('H', after)] {
                    // A tool may have a name instead.
                    if let Some((text, (value, ""))) = text.and_then(|t| Some((t, number(t)?))) {
                        block.set(letter, value, text)?;
                    }
                }
            }
            "COOLNT" => block.m.push(if given.first() == Some(&"OFF") { 90 } else { 80 }),
            "RAPID" => {
                self.rapid = true;
                return Ok(Line::Empty);
            }
            "SPINDL" => spindle(block, &given)?,
            "FEDRAT" => feed(block, &given)?,
            "GOTO" | "FROM" => {
                block.g.push(if std::mem::take(&mut self.rapid) || word == "FROM" {
                    0
                } else {
                    10
                });
                point(block, &given)?;
            }
            "" | "CUTTER" | "ORIGIN" | "MACHIN" | "TOOLNO" => return Ok(Line::Empty),
            _ if word.starts_with("PARTNO") || word.starts_with("PPRINT") => {
                return Ok(Line::Empty);
            }
            _ => {
                let remedy = "GOTO, FROM, RAPID, FEDRAT, SPINDL, LOADTL, COOLNT, MULTAX, UNITS and FINI are read; have the path written \
                              of these";
                return Err(Fault::Refused {
                    word: word.chars().take(12).collect(),
                    remedy,
                    displaces: false,
                });
            }
        }
        Ok(Line::Words)
    }
}

/// The tip, and the direction of the tool axis if it is given.
fn point(block: &mut Block, given: &[&str]) -> Result<(), Fault> {
    if !matches!(given.len(), 3 | 6) {
        let remedy = "a point has three numbers, or six with the direction of the tool axis";
        return Err(Fault::Refused { word: "GOTO".to_string(), remedy, displaces: false });
    }
    for (letter, text) in ['X', 'Y', 'Z'].into_iter().zip(given) {
        block.set(letter, whole_number(text)?, text)?;
    }
    for (value, text) in block.vector.iter_mut().zip(&given[3..]) {
        *value = Some(whole_number(text)?);
    }
    if given.len() == 6 {
        block.control = Some(true);
    }
    Ok(())
}

fn spindle(block: &mut Block, given: &[&str]) -> Result<(), Fault> {
    if given.contains(&"OFF") {
        block.m.push(50);
        return Ok(());
    }
    block.m.push(if given.contains(&"CCLW") { 40 } else { 30 });
    match given.iter().find(|a| a.starts_with(|c: char| c.is_ascii_digit())) {
        Some(text) => block.set('S', whole_number(text)?, text),
        None => Ok(()),
    }
}

fn feed(block: &mut Block, given: &[&str]) -> Result<(), Fault> {
    if given.iter().any(|a| matches!(*a, "MMPR" | "IPR")) {
        let remedy = "a feed by the turn; have the feed by the minute written";
        return Err(Fault::Refused { word: "FEDRAT".to_string(), remedy, displaces: true });
    }
    match given.iter().find(|a| a.starts_with(|c: char| c.is_ascii_digit())) {
        Some(text) => block.set('F', whole_number(text)?, text),
        None => Err(Fault::Word("FEDRAT".to_string())),
    }
}

fn whole_number(text: &str) -> Result<f64, Fault> {
    let whole = number(text).filter(|(_, rest)| rest.is_empty());
    whole.map(|(value, _)| value).ok_or_else(|| Fault::Word(text.chars().take(12).collect()))
}
