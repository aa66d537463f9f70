//! Keys of a post's file, one after another; what is left over is refused with its line.
//!
//! Not by serde: for so few keys its code would add a tenth to what the page loads.

use std::collections::BTreeMap;
use thiserror::Error;
use toml::de::{DeTable, DeValue};

/// Largest file that is read, bytes.
const LARGEST: usize = 1 << 16;
/// Longest message of the TOML reader, characters.
const LONGEST_MESSAGE: usize = 350;

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum KeysError {
    /// It is too large.
    #[error("the file has {bytes} bytes; at most {most} are read")]
    Large {
        /// How many it has.
        bytes: usize,
        /// How many are read.
        most: usize,
    },
    /// It is no text.
    #[error("the file is no text (UTF-8)")]
    NotText,
    /// A key that is unknown or missing, or a value of another kind.
    #[error("{line}{key}: {rule}")]
    Key {
        /// Line of the file and a colon, if it is there.
        line: String,
        /// Which.
        key: String,
        /// What is wrong with it.
        rule: String,
    },
    /// It is no TOML.
    #[error("{0}")]
    Toml(String),
}

/// Reads a file with `read`.
///
/// # Errors
/// [`KeysError`]: no TOML, or what `read` refuses.
pub(super) fn read_keys<T, E: From<KeysError>>(
    bytes: &[u8],
    read: impl FnOnce(&mut Keys) -> Result<T, E>,
) -> Result<T, E> {
    if bytes.len() > LARGEST {
        return Err(KeysError::Large { bytes: bytes.len(), most: LARGEST }.into());
    }
    let text = core::str::from_utf8(bytes).map_err(|_| KeysError::NotText)?;
    let text = text.trim_start_matches('\u{feff}');
    let syntax = |error: toml::de::Error| {
        let lines = |at: usize| text.bytes().take(at).filter(|b| *b == b'\n').count();
        let line = error.span().map_or(1, |span| 1 + lines(span.start));
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        let message = format!("line {line}: {message}");
        KeysError::Toml(message.chars().take(LONGEST_MESSAGE).collect())
    };
    let document = DeTable::parse(text).map_err(syntax)?;
    read(&mut Keys::of(document.get_ref(), "", text))
}

/// A table that is being read.
pub(super) struct Keys<'a> {
    table: &'a DeTable<'a>,
    /// The table's own key and a point; empty at the top.
    prefix: String,
    source: &'a str,
    /// Keys that were asked for.
    known: Vec<&'static str>,
}

impl<'a> Keys<'a> {
    /// `prefix`: the table's own key and a point; `source`: the whole file.
    fn of(table: &'a DeTable<'a>, prefix: &str, source: &'a str) -> Self {
        Self { table, prefix: prefix.to_string(), source, known: Vec::new() }
    }

    fn get(&mut self, key: &'static str) -> Option<&'a DeValue<'a>> {
        self.known.push(key);
        self.table.get(key).map(|value| value.get_ref())
    }

    /// What is wrong with the value of a key.
    pub fn fault(&self, key: &str, rule: &str) -> KeysError {
        let at = self.table.get(key).map(|value| self.line(value.span().start));
        self.said(at, key, rule)
    }

    fn said(&self, line: Option<usize>, key: &str, rule: &str) -> KeysError {
        let line = line.map_or_else(String::new, |line| format!("line {line}: "));
        KeysError::Key { line, key: format!("{}{key}", self.prefix), rule: rule.to_string() }
    }

    fn line(&self, at: usize) -> usize {
        1 + self.source.bytes().take(at).filter(|b| *b == b'\n').count()
    }

    /// A text that may be missing.
    pub fn optional(&mut self, key: &'static str) -> Result<Option<String>, KeysError> {
        match self.get(key) {
            None => Ok(None),
            Some(DeValue::String(text)) => Ok(Some(text.to_string())),
            Some(_) => Err(self.fault(key, "it must be a text in quotes")),
        }
    }

    /// A text.
    pub fn text(&mut self, key: &'static str) -> Result<String, KeysError> {
        self.optional(key)?.ok_or_else(|| self.fault(key, "it is missing; it must be a text"))
    }

    /// Texts; none where they are missing.
    pub fn texts(&mut self, key: &'static str) -> Result<Vec<String>, KeysError> {
        let rule = "it must be a list of texts in quotes";
        let array = match self.get(key) {
            None => return Ok(Vec::new()),
            Some(DeValue::Array(array)) => array,
            Some(_) => return Err(self.fault(key, rule)),
        };
        let text = |value: &toml::Spanned<DeValue>| match value.get_ref() {
            DeValue::String(text) => Ok(text.to_string()),
            _ => Err(self.fault(key, rule)),
        };
        array.iter().map(text).collect()
    }

    /// A whole number; `default`: where it is missing.
    pub fn number(&mut self, key: &'static str, default: Option<u32>) -> Result<u32, KeysError> {
        let number = match self.get(key) {
            None => default,
            Some(DeValue::Integer(number)) => {
                u32::from_str_radix(number.as_str(), number.radix()).ok()
            }
            Some(_) => None,
        };
        number.ok_or_else(|| self.fault(key, "it must be a whole number from 0"))
    }

    /// A flag; false where it is missing.
    pub fn flag(&mut self, key: &'static str) -> Result<bool, KeysError> {
        match self.get(key) {
            None => Ok(false),
            Some(DeValue::Boolean(flag)) => Ok(*flag),
            Some(_) => Err(self.fault(key, "it must be true or false")),
        }
    }

    /// One of several names; the first where it is missing.
    pub fn choice<T: Copy>(
        &mut self,
        key: &'static str,
        all: &[(&'static str, T)],
    ) -> Result<T, KeysError> {
        let asked = self.optional(key)?;
        let asked = asked.as_deref().unwrap_or(all[0].0);
        all.iter().find(|(name, _)| *name == asked).map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
            self.fault(key, &format!("it must be one of {}", names.join(", ")))
        })
    }

    /// A table that may be missing.
    pub fn table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Keys) -> Result<T, KeysError>,
    ) -> Result<Option<T>, KeysError> {
        match self.get(key) {
            None => Ok(None),
            Some(DeValue::Table(table)) => {
                let prefix = format!("{}{key}.", self.prefix);
                read(&mut Keys::of(table, &prefix, self.source)).map(Some)
            }
            Some(_) => Err(self.fault(key, "it must be a table")),
        }
    }

    /// A table.
    pub fn required<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Keys) -> Result<T, KeysError>,
    ) -> Result<T, KeysError> {
        self.table(key, read)?.ok_or_else(|| self.fault(key, "it is missing; it must be a table"))
    }

    /// All keys of a table of texts.
    pub fn all_texts(&mut self) -> Result<BTreeMap<String, String>, KeysError> {
        let text = |(key, value): (&toml::Spanned<toml::de::DeString>, &toml::Spanned<DeValue>)| {
            match value.get_ref() {
                DeValue::String(text) => Ok((key.get_ref().to_string(), text.to_string())),
                _ => Err(self.fault(key.get_ref(), "it must be a text in quotes")),
            }
        };
        self.table.iter().map(text).collect()
    }

    /// No key but those that were asked for.
    pub fn nothing_left(&self) -> Result<(), KeysError> {
        let is_unknown = |key: &&toml::Spanned<toml::de::DeString>| {
            !self.known.contains(&key.get_ref().as_ref())
        };
        match self.table.keys().find(is_unknown) {
            None => Ok(()),
            Some(key) => {
                let name: String = key.get_ref().chars().take(40).collect();
                let rule = format!("there is no such key; there are {}", self.known.join(", "));
                Err(self.said(Some(self.line(key.span().start)), &name, &rule))
            }
        }
    }
}
