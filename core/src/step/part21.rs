//! The text of a STEP file (ISO 10303-21) → its instances.
//!
//! Our own: `ruststep` reads the same syntax, but builds in minutes with its schemas, and what is
//! needed here is one page.

use super::error::StepError;

/// Deepest nesting of lists; real files have four levels.
const DEEPEST: usize = 32;

/// Longest name of an entity; those of the standards have 70 letters at most.
const LONGEST_NAME: usize = 120;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// `$` or `*`.
    None,
    Number(f64),
    Text(String),
    /// `.NAME.`
    Word(String),
    /// `#12`
    Reference(u64),
    List(Vec<Value>),
    /// `NAME(value)`
    Typed(String, Vec<Value>),
}

/// A record `NAME(values)`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Record {
    pub name: String,
    pub values: Vec<Value>,
}

/// `#id = record`, or several records of a complex instance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Instance {
    pub id: u64,
    pub records: Vec<Record>,
}

/// All instances of the data sections, in the order of the file.
pub(super) fn parse(bytes: &[u8]) -> Result<Vec<Instance>, StepError> {
    let mut reader = Reader { bytes, at: 0 };
    reader.space()?;
    if !bytes[reader.at..].starts_with(b"ISO-10303-21") {
        return Err(reader.unexpected("ISO-10303-21 at the start of a STEP file"));
    }
    let mut instances = Vec::new();
    while reader.section(b"DATA")? {
        reader.instances(&mut instances)?;
    }
    if instances.is_empty() {
        return Err(reader.unexpected("a DATA section with instances"));
    }
    Ok(instances)
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn unexpected(&self, expected: &'static str) -> StepError {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let end = rest.len().min(24);
        let found = match end {
            0 => "the end of the file".to_owned(),
            _ => format!("{:?}", String::from_utf8_lossy(&rest[..end])),
        };
        let line =
            1 + self.bytes[..self.at.min(self.bytes.len())].iter().filter(|b| **b == b'\n').count();
        StepError::Syntax { line, found, expected }
    }

    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Skips blanks and comments.
    fn space(&mut self) -> Result<(), StepError> {
        loop {
            match self.peek() {
                Some(b) if b.is_ascii_whitespace() => self.at += 1,
                Some(b'/') if self.bytes.get(self.at + 1) == Some(&b'*') => {
                    let rest = &self.bytes[self.at + 2..];
                    match rest.windows(2).position(|w| w == b"*/") {
                        Some(end) => self.at += end + 4,
                        None => return Err(self.unexpected("*/ at the end of a comment")),
                    }
                }
                _ => return Ok(()),
            }
        }
    }

    fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), StepError> {
        self.space()?;
        if self.peek() != Some(byte) {
            return Err(self.unexpected(expected));
        }
        self.at += 1;
        Ok(())
    }

    fn eat(&mut self, byte: u8) -> Result<bool, StepError> {
        self.space()?;
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        Ok(there)
    }

    /// Goes past the next section header `name;`, skipping other statements; `false` at the end.
    fn section(&mut self, name: &[u8]) -> Result<bool, StepError> {
        loop {
            self.space()?;
            if self.peek().is_none() {
                return Ok(false);
            }
            let found = self.bytes[self.at..].starts_with(name);
            self.statement()?;
            if found {
                return Ok(true);
            }
        }
    }

    /// Goes past the next `;` outside strings.
    fn statement(&mut self) -> Result<(), StepError> {
        loop {
            self.space()?;
            match self.peek() {
                None => return Err(self.unexpected(";")),
                Some(b';') => {
                    self.at += 1;
                    return Ok(());
                }
                Some(b'\'') => drop(self.text()?),
                Some(_) => self.at += 1,
            }
        }
    }

    fn instances(&mut self, instances: &mut Vec<Instance>) -> Result<(), StepError> {
        loop {
            self.space()?;
            if self.bytes[self.at..].starts_with(b"ENDSEC") {
                return self.statement();
            }
            self.expect(b'#', "an instance such as #1=..., or ENDSEC;")?;
            let id = self.integer()?;
            self.expect(b'=', "=")?;
            let mut records = Vec::new();
            if self.eat(b'(')? {
                while !self.eat(b')')? {
                    records.push(self.record()?);
                }
            } else {
                records.push(self.record()?);
            }
            self.expect(b';', "; at the end of an instance")?;
            instances.push(Instance { id, records });
        }
    }

    fn integer(&mut self) -> Result<u64, StepError> {
        let digits = self.take(|b| b.is_ascii_digit());
        match digits.parse() {
            Ok(id) => Ok(id),
            Err(_) => Err(self.unexpected("a number of an instance")),
        }
    }

    fn take(&mut self, is_part: impl Fn(u8) -> bool) -> String {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|b| !is_part(*b)).unwrap_or(rest.len());
        self.at += end;
        String::from_utf8_lossy(&rest[..end]).into_owned()
    }

    fn name(&mut self) -> Result<String, StepError> {
        self.space()?;
        let name = self.take(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-' || b == b'!');
        if name.is_empty() || name.len() > LONGEST_NAME {
            Err(self.unexpected("the name of an entity, of 120 letters at most"))
        } else {
            Ok(name.to_ascii_uppercase())
        }
    }

    fn record(&mut self) -> Result<Record, StepError> {
        let name = self.name()?;
        self.expect(b'(', "(")?;
        Ok(Record { name, values: self.list(0)? })
    }

    /// Values up to the closing bracket.
    fn list(&mut self, depth: usize) -> Result<Vec<Value>, StepError> {
        if depth > DEEPEST {
            return Err(self.unexpected("lists nested less deeply"));
        }
        let mut values = Vec::new();
        if self.eat(b')')? {
            return Ok(values);
        }
        loop {
            values.push(self.value(depth)?);
            if self.eat(b')')? {
                return Ok(values);
            }
            self.expect(b',', ", or )")?;
        }
    }

    fn value(&mut self, depth: usize) -> Result<Value, StepError> {
        self.space()?;
        match self.peek() {
            Some(b'$' | b'*') => {
                self.at += 1;
                Ok(Value::None)
            }
            Some(b'\'') => Ok(Value::Text(self.text()?)),
            Some(b'"') => {
                self.at += 1;
                let text = self.take(|b| b.is_ascii_hexdigit());
                self.expect(b'"', "\"").map(|()| Value::Text(text))
            }
            Some(b'#') => {
                self.at += 1;
                self.integer().map(Value::Reference)
            }
            Some(b'(') => {
                self.at += 1;
                self.list(depth + 1).map(Value::List)
            }
            Some(b'.') if !self.bytes.get(self.at + 1).is_some_and(u8::is_ascii_digit) => {
                self.at += 1;
                let word = self.take(|b| b.is_ascii_alphanumeric() || b == b'_');
                self.expect(b'.', ". after a word").map(|()| Value::Word(word.to_ascii_uppercase()))
            }
            Some(b) if b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.') => self.number(),
            Some(b) if b.is_ascii_alphabetic() => {
                let name = self.name()?;
                self.expect(b'(', "( after a name")?;
                self.list(depth + 1).map(|values| Value::Typed(name, values))
            }
            _ => Err(self.unexpected("a value")),
        }
    }

    fn number(&mut self) -> Result<Value, StepError> {
        let start = self.at;
        let text =
            self.take(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'E' | b'e'));
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Value::Number(number)),
            _ => {
                self.at = start;
                Err(self.unexpected("a finite number"))
            }
        }
    }

    /// A string; doubled quotes stand for one.
    fn text(&mut self) -> Result<String, StepError> {
        let mut text = String::new();
        loop {
            self.at += 1;
            text.push_str(&self.take(|b| b != b'\''));
            if self.peek().is_none() {
                return Err(self.unexpected("' at the end of a string"));
            }
            self.at += 1;
            if self.peek() != Some(b'\'') {
                return Ok(text);
            }
            text.push('\'');
        }
    }
}
