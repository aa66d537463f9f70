//! What may be written at a place of a job file, and what stands there: for editors.
//!
//! Terms: a *statement* is a key, `=` and its value; its value may *open* arrays and inline tables, in which the
//! place may lie. The text need not be a valid job, or even valid TOML: it is still being written.
//!
//! 1. The tokens before the place show which table, which key and which open brackets it is in (`Reading`).
//! 2. The schema under these keys says what may be written (`under`).

use super::schema::described;
use super::words::expectation;
use serde_json::Value as Schema;
use toml_parser::Source;
use toml_parser::lexer::{Token, TokenKind};

/// What a completion is.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum CompletionKind {
    /// A table.
    Table,
    /// A key with a value.
    Key,
    /// A value.
    Value,
}

/// Something that may be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Completion {
    /// What it is.
    pub kind: CompletionKind,
    /// The text.
    pub text: String,
    /// The unit of a key's value.
    pub unit: Option<String>,
    /// What it means.
    pub about: Option<String>,
}

/// What may be written at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Completions {
    /// Where the word that it replaces begins, bytes from the start.
    pub from: usize,
    /// All of it, whatever was begun.
    pub options: Vec<Completion>,
}

/// What a key means.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Its dotted name.
    pub key: String,
    /// What it means.
    pub about: String,
    /// What its value may be.
    pub expected: String,
}

/// What may be written where `offset` bytes of `source` are before it; empty in comments and beyond values.
pub fn completions(source: &str, offset: usize) -> Completions {
    let root = described();
    let Place { kind, keys, from } = place(before(source, offset));
    let schema = || under(root, &keys);
    let options = match kind {
        PlaceKind::Nothing => Vec::new(),
        PlaceKind::Header => tables(root, ""),
        PlaceKind::Key => schema().map_or_else(Vec::new, keys_of),
        PlaceKind::Value => schema().map_or_else(Vec::new, values_of),
    };
    Completions { from, options }
}

/// What the key means that ends, or whose value is, where `offset` bytes of `source` are before it.
pub fn explanation(source: &str, offset: usize) -> Option<Explanation> {
    let text = before(source, offset);
    let Place { kind, mut keys, from } = place(text);
    match kind {
        PlaceKind::Nothing => return None,
        PlaceKind::Key => keys.push(bare(&text[from..])),
        PlaceKind::Header => keys = text[from..].split('.').map(bare).collect(),
        PlaceKind::Value => {}
    }
    let schema = under(described(), &keys)?;
    let about = schema["description"].as_str()?.to_owned();
    Some(Explanation { key: keys.join("."), about, expected: expectation(schema) })
}

/// So many bytes of a text, or fewer where that is in a letter or beyond the end.
fn before(source: &str, offset: usize) -> &str {
    let mut end = offset.min(source.len());
    while !source.is_char_boundary(end) {
        end -= 1;
    }
    &source[..end]
}

/// A part of a key without its quotes.
fn bare(key: &str) -> String {
    key.trim().trim_matches(['"', '\'']).to_owned()
}

#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum PlaceKind {
    /// In the name of a table.
    Header,
    /// In a key.
    Key,
    /// In a value.
    Value,
    /// Where neither is written.
    Nothing,
}

/// A place in a job file.
#[derive(Clone, Debug, PartialEq)]
struct Place {
    kind: PlaceKind,
    /// Keys above the word; of a value all.
    keys: Vec<String>,
    /// Where the word begins that ends there.
    from: usize,
}

/// What brackets of a value hold.
enum Open {
    Array,
    /// A table with the keys above it.
    Table(Vec<String>),
}

/// What the tokens so far say.
struct Reading<'a> {
    text: &'a str,
    kind: PlaceKind,
    /// Keys of the table.
    table: Vec<String>,
    /// Keys of the statement's value, once there is `=`.
    keys: Vec<String>,
    /// Parts of the key before the last dot.
    parts: Vec<String>,
    open: Vec<Open>,
    /// Where the word that is being written began.
    word: Option<usize>,
}

/// The place at the end of a text.
fn place(text: &str) -> Place {
    let mut reading = Reading {
        text,
        kind: PlaceKind::Key,
        table: Vec::new(),
        keys: Vec::new(),
        parts: Vec::new(),
        open: Vec::new(),
        word: None,
    };
    for token in Source::new(text).lex() {
        reading.take(token);
    }
    reading.place()
}

impl Reading<'_> {
    fn place(self) -> Place {
        let keys = match self.kind {
            PlaceKind::Key => self.above().into_iter().chain(self.parts).collect(),
            PlaceKind::Header => Vec::new(),
            PlaceKind::Value | PlaceKind::Nothing => self.keys,
        };
        Place { kind: self.kind, keys, from: self.word.unwrap_or(self.text.len()) }
    }

    /// Keys above a key that is written here.
    fn above(&self) -> Vec<String> {
        match self.open.last() {
            Some(Open::Table(keys)) => keys.clone(),
            _ => self.table.clone(),
        }
    }

    /// The word so far, up to `end`, which ends.
    fn ended(&mut self, end: usize) -> String {
        self.word.take().map_or_else(String::new, |start| bare(&self.text[start..end]))
    }

    fn begin(&mut self, kind: PlaceKind) {
        (self.kind, self.word) = (kind, None);
        self.parts.clear();
    }

    fn take(&mut self, token: Token) {
        let (start, end) = (token.span().start(), token.span().end());
        match token.kind() {
            TokenKind::Eof => {}
            TokenKind::Newline if self.open.is_empty() => {
                self.keys.clear();
                self.begin(PlaceKind::Key);
            }
            TokenKind::Comment if end == self.text.len() => self.begin(PlaceKind::Nothing),
            TokenKind::Newline | TokenKind::Comment => self.word = None,
            // Spaces may stand around the dots of a key, but nothing else follows it.
            TokenKind::Whitespace => {
                if self.kind == PlaceKind::Value {
                    self.word = None;
                }
            }
            kind => match self.kind {
                PlaceKind::Key => self.in_key(kind, start),
                PlaceKind::Header => self.in_header(kind, start),
                PlaceKind::Value => self.in_value(kind, start),
                PlaceKind::Nothing => {}
            },
        }
    }

    fn in_key(&mut self, kind: TokenKind, start: usize) {
        match kind {
            TokenKind::Dot => {
                let part = self.ended(start);
                self.parts.push(part);
            }
            TokenKind::Equals => {
                let part = self.ended(start);
                self.keys = self.above();
                self.keys.append(&mut self.parts);
                self.keys.push(part);
                self.begin(PlaceKind::Value);
            }
            // A second one belongs to the header of a list of tables.
            TokenKind::LeftSquareBracket if self.open.is_empty() => self.begin(PlaceKind::Header),
            TokenKind::RightCurlyBracket => self.close(),
            _ => self.word = self.word.or(Some(start)),
        }
    }

    fn in_header(&mut self, kind: TokenKind, start: usize) {
        match kind {
            TokenKind::LeftSquareBracket => {}
            TokenKind::RightSquareBracket => {
                let name = self.word.take().map_or("", |word| &self.text[word..start]);
                self.table = name.split('.').map(bare).filter(|key| !key.is_empty()).collect();
                self.begin(PlaceKind::Nothing);
            }
            _ => self.word = self.word.or(Some(start)),
        }
    }

    fn in_value(&mut self, kind: TokenKind, start: usize) {
        match kind {
            TokenKind::LeftSquareBracket => {
                self.open.push(Open::Array);
                self.word = None;
            }
            TokenKind::LeftCurlyBracket => {
                self.open.push(Open::Table(self.keys.clone()));
                self.begin(PlaceKind::Key);
            }
            TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket => self.close(),
            TokenKind::Comma => match self.open.last() {
                Some(Open::Table(_)) => self.begin(PlaceKind::Key),
                _ => self.word = None,
            },
            _ => self.word = self.word.or(Some(start)),
        }
    }

    /// The innermost bracket ends, and with it a value.
    fn close(&mut self) {
        if let Some(Open::Table(keys)) = self.open.pop() {
            self.keys = keys;
        }
        // Nothing is written behind it but further values of a list.
        self.begin(if self.open.is_empty() { PlaceKind::Nothing } else { PlaceKind::Value });
    }
}

/// The schemas that may hold at a place: itself, its alternatives, and those of what it lists.
fn alternatives(schema: &Schema) -> Vec<&Schema> {
    let lists = ["anyOf", "oneOf"].into_iter().filter_map(|list| schema[list].as_array()).flatten();
    let inner = lists.chain(schema.get("items"));
    core::iter::once(schema).chain(inner.flat_map(alternatives)).collect()
}

/// The part of the schema under keys.
fn under<'a>(schema: &'a Schema, keys: &[String]) -> Option<&'a Schema> {
    keys.iter().try_fold(schema, |here, key| {
        let inner = |schema: &'a Schema| schema["properties"].get(key);
        alternatives(here).into_iter().find_map(inner).map(meant)
    })
}

/// The table whose keys a table of an operation has; any other itself.
fn meant(schema: &Schema) -> &Schema {
    match schema["x-as"].as_str() {
        Some(table) => &described()["properties"][table],
        None => schema,
    }
}

fn about(schema: &Schema) -> Option<String> {
    schema["description"].as_str().map(str::to_owned)
}

/// The tables of the schema and those of lists of tables, dotted.
fn tables(schema: &Schema, above: &str) -> Vec<Completion> {
    let all = schema["properties"].as_object().into_iter().flatten();
    let is_table = |inner: &Schema| inner["type"] == "object" || inner["items"]["type"] == "object";
    let all = all.filter(|(_, inner)| is_table(inner)).flat_map(|(key, inner)| {
        let text = if above.is_empty() { key.clone() } else { format!("{above}.{key}") };
        let is_list = inner["items"]["type"] == "object";
        let below = tables(if is_list { &inner["items"] } else { inner }, &text);
        let table =
            Completion { kind: CompletionKind::Table, text, unit: None, about: about(inner) };
        core::iter::once(table).chain(below)
    });
    all.collect()
}

/// The keys of a table.
fn keys_of(schema: &Schema) -> Vec<Completion> {
    let all = alternatives(schema).into_iter().filter_map(|s| s["properties"].as_object());
    let completion = |(key, schema): (&String, &Schema)| {
        let is_table = schema["type"] == "object";
        Completion {
            kind: if is_table { CompletionKind::Table } else { CompletionKind::Key },
            text: key.clone(),
            unit: schema["x-unit"].as_str().map(str::to_owned),
            about: about(schema),
        }
    };
    all.flatten().map(completion).collect()
}

/// The values of a key that can be named, else its default.
fn values_of(schema: &Schema) -> Vec<Completion> {
    let value = |value: &Schema, about: Option<String>| Completion {
        kind: CompletionKind::Value,
        text: value.to_string(),
        unit: None,
        about,
    };
    let mut all = Vec::new();
    for schema in alternatives(schema) {
        all.extend(schema.get("const").map(|v| value(v, about(schema))));
        all.extend(schema["enum"].as_array().into_iter().flatten().map(|v| value(v, None)));
        if schema["type"] == "boolean" {
            all.extend([true, false].map(|v| value(&v.into(), None)));
        }
    }
    if all.is_empty() {
        all.extend(schema.get("default").map(|v| value(v, Some("the default".into()))));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What may be written at the `|` of a text, and from where on.
    fn at(text: &str) -> (String, Vec<String>) {
        let offset = text.find('|').unwrap();
        let source = text.replace('|', "");
        let Completions { from, options } = completions(&source, offset);
        (source[from..offset].to_owned(), options.into_iter().map(|c| c.text).collect())
    }

    fn explained(text: &str) -> Option<String> {
        let offset = text.find('|').unwrap();
        explanation(&text.replace('|', ""), offset).map(|e| e.key)
    }

    #[test]
    fn keys_of_the_table_around_are_offered() {
        for (text, word, known) in [
            ("[cut]\nsc|", "sc", "scallop"),
            ("ver|", "ver", "version"),
            ("[cut]\nfeed = 3 # [tool]\nall|owance", "all", "allowance"),
            ("cut.fe|", "fe", "feed"),
            ("machine = { max_feed = 3.5, tra|", "tra", "travel"),
            ("machine = {\n  max_feed = 3.5, # {\n  tra|", "tra", "travel"),
            ("name = \"\"\"\n[cut]\n\"\"\"\n[tool]\nkin|", "kin", "kind"),
            ("[[tool]]\ndia|", "dia", "diameter"),
            ("[ surface . analytic ]\nki|", "ki", "kind"),
            ("[path]\ncurve = [[0, 0, 0],\n  [1, 0, 0]]\npat|", "pat", "pattern"),
        ] {
            let (found, options) = at(text);
            assert_eq!(found, word, "{text}");
            assert!(options.iter().any(|o| o == known), "{known} not in {options:?} of {text}");
        }
    }

    #[test]
    fn values_are_offered_where_they_can_be_named() {
        let (word, options) = at("[cut]\ndirection = |");
        assert_eq!(
            (word.as_str(), options),
            ("", vec!["\"climb\"".into(), "\"conventional\"".into()])
        );
        assert_eq!(at("[cut]\ndirection = \"cl|").0, "\"cl");
        let (word, options) = at("[output]\nsvg = [\"path\", \"sc|");
        assert_eq!(word, "\"sc");
        assert!(options.contains(&"\"scallop\"".to_owned()), "{options:?}");
        assert_eq!(at("[cut]\nfeed = 12.5|").0, "12.5");
    }

    #[test]
    fn tables_are_offered_in_headers() {
        let (_, options) = at("[operation.c|");
        assert!(options.contains(&"operation.cut".to_owned()), "{options:?}");
        let inside = ["[[operation]]\n[operation.cut]\nsc|", "[[operation]]\ncut = { sc|"];
        for text in inside {
            assert!(at(text).1.contains(&"scallop".to_owned()), "{text}");
        }
        for text in ["[su|", "[[su|"] {
            let (word, options) = at(text);
            assert_eq!(word, "su");
            assert!(options.contains(&"surface.analytic".to_owned()), "{options:?}");
        }
        assert_eq!(at("[surface.an|").0, "surface.an");
    }

    #[test]
    fn nothing_is_offered_in_comments_and_behind_values() {
        for text in ["# sc|", "[cut] |", "feed = 3 # s|", "x = { a = 1 } |", "x = [1] |"] {
            assert_eq!(at(text).1, Vec::<String>::new(), "{text}");
        }
    }

    #[test]
    fn keys_headers_and_values_are_explained() {
        for (text, key) in [
            ("[cut]\nfeed| = 3", Some("cut.feed")),
            ("[cut]\ndirection = \"climb\"|", Some("cut.direction")),
            ("[cut|]", Some("cut")),
            ("[surface.analytic|]", Some("surface.analytic")),
            ("[cut]\nspeed| = 3", None),
            ("# feed|", None),
        ] {
            assert_eq!(explained(text).as_deref(), key, "{text}");
        }
        let text = "[cut]\ndirection";
        let found = explanation(text, text.len()).unwrap();
        assert_eq!(found.expected, "one of \"climb\", \"conventional\"");
    }

    /// Whatever the text, and wherever the place: in the middle of a letter, too.
    #[test]
    fn any_text_is_taken() {
        let text = "[cut]\nfeed = \"ö📏\n]] }} = . , \"\"\" [[ { ''' # ä\n\r\t\\u12 = 3.5.[a.b";
        for offset in 0..=text.len() + 3 {
            let found = completions(text, offset);
            assert!(found.from <= offset && text.is_char_boundary(found.from));
            explanation(text, offset);
        }
    }
}
