//! Reading of a job file's text: every key and value held against the schema, all faults at once.
//!
//! Terms: a *place* is where a key and its value stand in the source; a *clean* table holds only
//! what the schema allows, so that [`JobFile`] can be made of it without further checks.
//!
//! 1. Decode the bytes and parse the TOML with the place of each key and value. Syntax errors end
//!    the reading; a key given twice does not.
//! 2. Walk document and schema together; what does not fit becomes a fault and is left out of the
//!    clean table, its place kept.
//! 3. Make the [`JobFile`] of the clean table.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use serde_json::Value as Schema;
use toml::Spanned;
use toml::de::{DeArray, DeInteger, DeTable, DeValue};

use super::fault::{Fault, Faults};
use super::file::JobFile;
use super::merged::{Written, merged};
use super::schema::described;
use super::units::INCH;
use super::words::{choices, expectation, keys, kind, names, quoted};

/// Largest job file that is read, bytes. Jobs are a few kilobytes; a mesh given by mistake is not.
const LARGEST: usize = 1 << 20;
/// Most operations of a job.
const MOST_OPERATIONS: usize = 20;
/// Keys that have other names now.
const RENAMED: [(&str, &str); 2] =
    [("cut.stock", "cut.allowance"), ("cut.too_tight", "cut.inaccessible")];

/// Keys that are gone, and what to write instead.
const REPLACED: [(&str, &str); 1] = [(
    "path.wall_file",
    "write a table `[[avoid]]` at the end of the file, with this mesh as its `file` and, if it is not to be \
     `tool.clearance`, the `distance` that the tool keeps from it",
)];

/// Where a key and its value stand in the source, bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    pub key: Range<usize>,
    pub value: Range<usize>,
}

/// Places of all keys that were found, by dotted key.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Places {
    by_key: BTreeMap<String, Place>,
    /// Keys that a misspelt key was taken for: their absence is the same slip, not a second one.
    misspelt: BTreeMap<String, Place>,
    /// Start of each line, bytes.
    lines: Vec<usize>,
}

impl Places {
    /// Place of the value of `key`, else of the nearest table around it.
    pub fn of(&self, key: &str) -> Option<Range<usize>> {
        if let Some(place) = self.by_key.get(key) {
            return Some(place.value.clone());
        }
        let (around, _) = key.rsplit_once('.')?;
        self.of(around)
    }

    /// Whether `key` was given, fitting or not, be it misspelt.
    pub fn has(&self, key: &str) -> bool {
        self.found(key) || self.misspelt.contains_key(key)
    }

    /// Whether `key` was given, fitting or not, and spelt right.
    pub fn found(&self, key: &str) -> bool {
        self.by_key.contains_key(key)
    }

    /// Makes the value of `key` that of `stand_in`, which it came by.
    pub fn came_by(&mut self, key: &str, stand_in: &str) {
        if let Some(place) = self.by_key.get(stand_in).cloned() {
            self.by_key.insert(key.to_owned(), place);
        }
    }

    /// Line of the value of `key`, from 1.
    pub fn line(&self, key: &str) -> Option<usize> {
        let start = self.by_key.get(key).or(self.misspelt.get(key))?.value.start;
        Some(self.lines.partition_point(|&line| line <= start))
    }
}

/// A job file with its places and the faults found so far.
pub(super) struct Document {
    pub file: JobFile,
    pub places: Places,
    pub faults: Faults,
}

impl Document {
    /// Notes a fault at the place of its key, unless it has one.
    pub fn note(&mut self, fault: Fault) {
        let place = fault.span.clone().or_else(|| self.places.of(&fault.key));
        self.faults.0.push(fault.at(place));
    }
}

/// A job file as a document for each of its operations.
pub(super) struct Documents {
    pub list: Vec<Document>,
    /// The operations; empty where the job is a single one.
    pub operations: Vec<Written>,
    /// Faults of their tables.
    pub faults: Faults,
}

/// Reads the bytes of a job file of a single operation.
///
/// # Errors
/// As of [`read_all`].
pub(super) fn read(bytes: &[u8]) -> Result<Document, Faults> {
    let Documents { list, .. } = read_all(bytes)?;
    list.into_iter().next().ok_or_else(Faults::default)
}

/// Reads a job file's bytes.
///
/// # Errors
/// Faults that leave nothing to walk: too long, not UTF-8, not TOML.
pub(super) fn read_all(bytes: &[u8]) -> Result<Documents, Faults> {
    let source = decode(bytes).map_err(|fault| Faults(vec![fault]))?;
    let (document, errors) = DeTable::parse_recoverable(source);
    let (duplicates, broken): (Vec<_>, Vec<_>) = errors.iter().partition(|e| is_duplicate(e));
    let mut faults: Vec<Fault> = duplicates.iter().map(|e| duplicate_fault(e, source)).collect();
    // What follows the first syntax error is often only its echo.
    if let Some(first) = broken.iter().min_by_key(|e| e.span().map_or(0, |s| s.start)) {
        faults.push(syntax_fault(first, source));
        let mut faults = Faults(faults);
        faults.sort();
        return Err(faults);
    }
    let lines = std::iter::once(0).chain(source.match_indices('\n').map(|(i, _)| i + 1)).collect();
    let walk = Walk {
        root: described(),
        unit: unit_of_length(document.get_ref()),
        faults,
        places: Places { lines, ..Places::default() },
    };
    let job = document.get_ref();
    match job.get("operation") {
        Some(operations) => Ok(of_operations(job, operations, walk)),
        None => Ok(Documents {
            list: vec![walk.document(job)],
            operations: Vec::new(),
            faults: Faults::default(),
        }),
    }
}

/// The documents of a job's operations; of the job alone where they cannot be used.
fn of_operations(job: &DeTable<'_>, operations: &Spanned<DeValue<'_>>, walk: Walk) -> Documents {
    let mut own = walk.clone();
    let schema = &own.root["properties"]["operation"];
    own.value("operation", operations, schema);
    let mut documents = Documents {
        list: Vec::new(),
        operations: Vec::new(),
        faults: Faults(core::mem::take(&mut own.faults)),
    };
    let tables = match operations.get_ref() {
        DeValue::Array(tables) => tables.iter().collect(),
        _ => Vec::new(),
    };
    for value in tables.iter().take(MOST_OPERATIONS) {
        let DeValue::Table(table) = value.get_ref() else { continue };
        let name = match table.get("name").map(Spanned::get_ref) {
            Some(DeValue::String(name)) => Some(name.clone().into_owned()),
            _ => None,
        };
        let is_rest =
            matches!(table.get("rest").map(Spanned::get_ref), Some(DeValue::Boolean(true)));
        // All tables of a list have the place of the first.
        let keys = table.iter().map(|(key, _)| key.span());
        let span = keys.min_by_key(|span| span.start).unwrap_or(value.span());
        documents.operations.push(Written { name, is_rest, span });
        documents.list.push(walk.clone().document(&merged(job, table)));
    }
    documents
}

/// A table of another file, held against that of the job of that name. `unit`: mm in its unit of length.
pub(super) fn read_table<T: for<'de> Deserialize<'de> + Default>(
    name: &str,
    table: &DeTable<'_>,
    unit: f64,
) -> (T, Faults) {
    let root = described();
    let mut walk = Walk { root, unit, faults: Vec::new(), places: Places::default() };
    let clean = walk.table(name, table, &root["properties"][name], None);
    let table = T::deserialize(toml::Value::Table(clean)).unwrap_or_else(|error| {
        walk.faults.push(Fault::new(name, error.message()));
        T::default()
    });
    (table, Faults(walk.faults))
}

/// mm in the unit that `units` names; ranges are in mm whatever the job's unit.
pub(super) fn unit_of_length(document: &DeTable<'_>) -> f64 {
    match document.get("units").map(|v| v.get_ref()) {
        Some(DeValue::String(unit)) if unit == "inch" => INCH,
        _ => 1.0,
    }
}

fn decode(bytes: &[u8]) -> Result<&str, Fault> {
    if bytes.len() > LARGEST {
        let message = format!("{} bytes; a job file has at most {LARGEST}", bytes.len());
        return Err(Fault::new("", message)
            .help("a mesh is named by `surface.file`; the job file itself is TOML text"));
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        let found = bytes.get(at).map_or(String::new(), |b| format!(": byte 0x{b:02X}"));
        Fault::new("", format!("not UTF-8 text{found}"))
            .help("save the file as UTF-8; names with accents often come in another encoding")
            .at(Some(at..at + 1))
    })
}

fn is_duplicate(error: &toml::de::Error) -> bool {
    error.message().starts_with("duplicate key")
}

fn duplicate_fault(error: &toml::de::Error, source: &str) -> Fault {
    let span = error.span();
    let word = span.as_ref().and_then(|s| source.get(s.clone())).unwrap_or_default();
    Fault::new(word, "given twice").help("remove one of the two").at(span)
}

fn syntax_fault(error: &toml::de::Error, source: &str) -> Fault {
    let span = error.span();
    let message = error.message().lines().collect::<Vec<_>>().join("; ");
    let fault = Fault::new("", format!("not TOML: {message}"));
    let fault = match span.as_ref().is_some_and(|s| is_decimal_comma(source, s.start)) {
        true => fault.help("decimals are written with a point, as in 10.5"),
        false => fault,
    };
    fault.at(span)
}

/// Whether `byte` is at, or right after, a comma between two digits.
fn is_decimal_comma(source: &str, byte: usize) -> bool {
    let bytes = source.as_bytes();
    let digit = |i: usize| bytes.get(i).is_some_and(u8::is_ascii_digit);
    [byte, byte.wrapping_sub(1)].into_iter().any(|comma| {
        bytes.get(comma) == Some(&b',') && comma > 0 && digit(comma - 1) && digit(comma + 1)
    })
}

#[derive(Clone)]
struct Walk {
    root: &'static Schema,
    /// mm in the job's unit of length.
    unit: f64,
    faults: Vec<Fault>,
    places: Places,
}

impl Walk {
    /// The document of a table that is a whole job.
    fn document(mut self, job: &DeTable<'_>) -> Document {
        let clean = self.table("", job, self.root, None);
        let file = match JobFile::deserialize(toml::Value::Table(clean)) {
            Ok(file) => file,
            Err(error) => {
                self.faults.push(Fault::new("", error.message()));
                JobFile::default()
            }
        };
        Document { file, places: self.places, faults: Faults(self.faults) }
    }

    fn fault(&mut self, fault: Fault) {
        self.faults.push(fault);
    }

    /// Holds a table against its schema; returns the clean table.
    ///
    /// `path`: dotted key of the table, empty at the top. `at`: where it is named.
    fn table(
        &mut self,
        path: &str,
        table: &DeTable<'_>,
        schema: &Schema,
        at: Option<Range<usize>>,
    ) -> toml::Table {
        let mut clean = toml::Table::new();
        for (key, value) in table {
            let name: &str = key.get_ref();
            let full = join(path, name);
            let Some(expected) = schema["properties"].get(name) else {
                let place = Place { key: key.span(), value: value.span() };
                self.unknown_key(path, name, schema, place);
                continue;
            };
            self.places.by_key.insert(full.clone(), Place { key: key.span(), value: value.span() });
            if let Some(value) = self.value(&full, value, expected) {
                clean.insert(name.to_owned(), value);
            }
        }
        // What an operation does not say, the job says.
        let is_part = path.starts_with("operation[");
        for name in names(&schema["required"]) {
            if !is_part && !self.places.has(&join(path, name)) {
                self.missing(path, name, &schema["properties"][name], at.clone());
            }
        }
        clean
    }

    fn missing(&mut self, path: &str, name: &str, schema: &Schema, at: Option<Range<usize>>) {
        let full = join(path, name);
        let mut fault = match schema["type"].as_str() {
            Some("object") => Fault::new(full, format!("the table [{name}] is missing")),
            _ => Fault::new(full, "missing; it has no default"),
        };
        fault = fault.help(format!("expected {}", expectation(schema)));
        self.fault(fault.at(at));
    }

    fn unknown_key(&mut self, path: &str, name: &str, schema: &Schema, place: Place) {
        let span = place.key.clone();
        let known: Vec<&str> = keys(schema).collect();
        let mut fault = Fault::new(join(path, name), "unknown key");
        let homes = self.homes(name);
        let full = join(path, name);
        if let Some((_, key)) = RENAMED.iter().find(|(old, _)| *old == full) {
            fault = fault.help(format!("it is called `{key}` now"));
            self.places.misspelt.insert((*key).to_owned(), place);
        } else if let Some((_, instead)) = REPLACED.iter().find(|(old, _)| *old == full) {
            fault = fault.help(*instead);
        } else if let Some(near) = nearest(name, known.iter().copied()) {
            fault = fault.help(format!("did you mean `{near}`?"));
            self.places.misspelt.insert(join(path, near), place);
        } else if let [home] = homes.as_slice() {
            fault = fault.help(match home.as_str() {
                "" => format!("`{name}` stands at the top of the file, before the first [table]"),
                home => format!("`{name}` belongs in [{home}]"),
            });
        }
        let table = if path.is_empty() { "at the top".into() } else { format!("in [{path}]") };
        fault = fault.help(format!("known {table}: {}", known.join(", ")));
        self.fault(fault.at(Some(span)));
    }

    /// The tables, one or two levels deep, that know `name`.
    fn homes(&self, name: &str) -> Vec<String> {
        let mut homes = Vec::new();
        let mut pending = vec![(String::new(), self.root)];
        while let Some((path, schema)) = pending.pop() {
            let Some(properties) = schema["properties"].as_object() else { continue };
            if properties.contains_key(name) {
                homes.push(path.clone());
            }
            pending.extend(properties.iter().map(|(key, inner)| (join(&path, key), inner)));
        }
        homes
    }

    /// Holds a value against its schema; `None`, with a fault noted, if it does not fit.
    fn value(
        &mut self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        schema: &Schema,
    ) -> Option<toml::Value> {
        if let Some(table) = schema["x-as"].as_str() {
            return self.value(key, value, &self.root["properties"][table]);
        }
        if let Some(branches) = schema["anyOf"].as_array() {
            let fitting = branches.iter().find(|b| fits_kind(value.get_ref(), b));
            return match fitting {
                Some(branch) => self.value(key, value, branch),
                None => self.wrong_type(key, value, schema),
            };
        }
        if let Some(choices) = choices(schema) {
            return self.choice(key, value, &choices);
        }
        match (schema["type"].as_str(), value.get_ref()) {
            (Some("object"), DeValue::Table(table)) => {
                Some(toml::Value::Table(self.table(key, table, schema, Some(value.span()))))
            }
            (Some("array"), DeValue::Array(array)) => self.array(key, array, schema, value.span()),
            (Some("number"), DeValue::Float(float)) => {
                let number = float.as_str().parse::<f64>().ok();
                self.number(key, float.as_str(), number, schema, value.span())
                    .map(toml::Value::Float)
            }
            (Some("number"), DeValue::Integer(integer)) => {
                let number = to_i64(integer).map(|i| i as f64);
                self.number(key, &integer.to_string(), number, schema, value.span())
                    .map(toml::Value::Float)
            }
            (Some("integer"), DeValue::Integer(integer)) => {
                let exact = to_i64(integer);
                let number = exact.map(|i| i as f64);
                self.number(key, &integer.to_string(), number, schema, value.span())?;
                exact.map(toml::Value::Integer)
            }
            (Some("string"), DeValue::String(text)) => self.string(key, text, schema, value.span()),
            (Some("boolean"), DeValue::Boolean(flag)) => Some(toml::Value::Boolean(*flag)),
            _ => self.wrong_type(key, value, schema),
        }
    }

    fn wrong_type(
        &mut self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        schema: &Schema,
    ) -> Option<toml::Value> {
        let message = format!("found {}, expected {}", kind(value.get_ref()), expectation(schema));
        let mut fault = Fault::new(key, message).at(Some(value.span()));
        match value.get_ref() {
            DeValue::String(text) if text.trim().parse::<f64>().is_ok() && is_number(schema) => {
                fault = fault.help(format!("write {} without quotes", text.trim()));
            }
            DeValue::Array(_) if schema["type"] == "object" => {
                fault = fault.help(format!("write [{key}], with single brackets"));
            }
            DeValue::Table(_) if schema["items"]["type"] == "object" => {
                fault = fault.help(format!("write [[{key}]], with double brackets"));
            }
            _ => {}
        }
        self.fault(fault);
        None
    }

    fn choice(
        &mut self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        choices: &[&str],
    ) -> Option<toml::Value> {
        let available = quoted(choices);
        let fault = match value.get_ref() {
            DeValue::String(text) if choices.contains(&text.as_ref()) => {
                return Some(toml::Value::String(text.clone().into_owned()));
            }
            DeValue::String(text) => Fault::new(key, format!("{text:?} is not available")),
            DeValue::Integer(number) if choices.contains(&number.as_str()) => {
                Fault::new(key, "found an integer, expected a string")
                    .help(format!("write \"{number}\", in quotes"))
            }
            other => Fault::new(key, format!("found {}, expected a string", kind(other))),
        };
        self.fault(fault.help(format!("available: {available}")).at(Some(value.span())));
        None
    }

    /// A finite number within the schema's range.
    fn number(
        &mut self,
        key: &str,
        written: &str,
        number: Option<f64>,
        schema: &Schema,
        span: Range<usize>,
    ) -> Option<f64> {
        let factor = self.factor(schema);
        match number.filter(|n| n.is_finite() && in_range(*n * factor, schema)) {
            Some(number) => Some(number),
            None => {
                let message = format!("{written} is out of range");
                let mut fault = Fault::new(key, message).at(Some(span));
                fault = fault.help(format!("expected {}", expectation(schema)));
                if factor != 1.0 {
                    fault = fault.help("the range is in mm, the job in inches");
                }
                self.fault(fault);
                None
            }
        }
    }

    /// What a number in the job's unit is multiplied with to have the schema's unit.
    fn factor(&self, schema: &Schema) -> f64 {
        match schema["x-unit"].as_str() {
            Some("mm" | "mm/min" | "mm/s²") => self.unit,
            Some("mm³/min") => self.unit * self.unit * self.unit,
            _ => 1.0,
        }
    }

    fn string(
        &mut self,
        key: &str,
        text: &str,
        schema: &Schema,
        span: Range<usize>,
    ) -> Option<toml::Value> {
        let count = text.chars().count() as u64;
        let least = schema["minLength"].as_u64().unwrap_or(0);
        let most = schema["maxLength"].as_u64().unwrap_or(u64::MAX);
        if (least..=most).contains(&count) {
            return Some(toml::Value::String(text.to_owned()));
        }
        let message = format!("{count} characters; expected {least} to {most}");
        self.fault(Fault::new(key, message).at(Some(span)));
        None
    }

    fn array(
        &mut self,
        key: &str,
        array: &DeArray<'_>,
        schema: &Schema,
        span: Range<usize>,
    ) -> Option<toml::Value> {
        let least = schema["minItems"].as_u64().unwrap_or(0) as usize;
        let most = schema["maxItems"].as_u64().map_or(usize::MAX, |n| n as usize);
        if !(least..=most).contains(&array.len()) {
            let message = {
                let (count, expected) = (array.len(), expectation(schema));
                format!("{count} item{}, expected {expected}", if count == 1 { "" } else { "s" })
            };
            self.fault(Fault::new(key, message).at(Some(span)));
            return None;
        }
        let mut item = |(i, item): (usize, &Spanned<DeValue<'_>>)| match item.get_ref() {
            // Tables have keys of their own, whose places are told apart.
            DeValue::Table(_) => {
                let key = format!("{key}[{i}]");
                self.places
                    .by_key
                    .insert(key.clone(), Place { key: item.span(), value: item.span() });
                self.value(&key, item, &schema["items"])
            }
            _ => self.value(key, item, &schema["items"]),
        };
        let items: Vec<Option<toml::Value>> = array.iter().enumerate().map(&mut item).collect();
        let items: Vec<toml::Value> = items.into_iter().collect::<Option<_>>()?;
        let repeats = (1..items.len()).any(|i| items[..i].contains(&items[i]));
        if schema["uniqueItems"] == true && repeats {
            self.fault(Fault::new(key, "an item is given twice").at(Some(span)));
            return None;
        }
        Some(toml::Value::Array(items))
    }
}

/// `path.name`, or `name` at the top.
pub(super) fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

fn to_i64(integer: &DeInteger<'_>) -> Option<i64> {
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn is_number(schema: &Schema) -> bool {
    matches!(schema["type"].as_str(), Some("number" | "integer"))
}

/// Whether a value is of the TOML type that a schema describes, whatever its size.
fn fits_kind(value: &DeValue<'_>, schema: &Schema) -> bool {
    match value {
        DeValue::String(_) => choices(schema).is_some() || schema["type"] == "string",
        DeValue::Integer(_) => is_number(schema),
        DeValue::Float(_) => schema["type"] == "number",
        DeValue::Array(_) => schema["type"] == "array",
        _ => false,
    }
}

fn in_range(number: f64, schema: &Schema) -> bool {
    let bound = |name: &str| schema[name].as_f64();
    bound("minimum").is_none_or(|least| number >= least)
        && bound("maximum").is_none_or(|most| number <= most)
        && bound("exclusiveMinimum").is_none_or(|least| number > least)
}

/// The known word nearest to `word`, if it is near enough to be a slip.
fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (word.chars().count() / 3).max(1);
    known
        .map(|k| (strsim::osa_distance(word, k), k))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, k)| k)
}
