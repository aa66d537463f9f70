//! The reference of the job file, written from the schema.

use std::fmt::Write;

use serde_json::Value;

use super::document::join;
use super::schema::{described, unit_of};
use super::words::{choices, expectation};

const HEAD: &str = "\
# The job file

A job file is [TOML](https://toml.io). Paths in it are relative to it. Every key has a default,
apart from `version`, the surface, `tool.diameter` or `tool.library`, `cut.feed` and one of `cut.scallop` and
`cut.stepover`. Keys and values that are not listed here are errors. Ranges are in the unit of the
table, also for jobs in inches. Angles are in degrees.

`evencut check JOB` shows all faults of a job file at once; `evencut schema` prints a JSON Schema for
editors (also in [evencut.schema.json](evencut.schema.json); with the Taplo or Even Better TOML
extension, put `#:schema evencut.schema.json` in the first line).

The smallest job:

```toml
version = 1
[surface]
file = \"part.stl\"
[tool]
diameter = 10.0
[cut]
scallop = 0.01
feed = 1200.0
```
";

/// The reference of the job file as Markdown: every key with unit, default, range and meaning.
pub fn reference() -> String {
    let mut text = HEAD.to_owned();
    table(&mut text, "", described(), false);
    text
}

/// Writes the keys of a table, then the tables in it.
fn table(text: &mut String, path: &str, schema: &Value, is_in_array: bool) {
    let Some(properties) = schema["properties"].as_object() else { return };
    let heading = match path {
        "" => "Top of the file".to_owned(),
        _ if is_in_array => format!("`[[{path}]]`"),
        _ => format!("`[{path}]`"),
    };
    let description = schema["description"].as_str().unwrap_or_default();
    // Writing to a string cannot fail.
    let _ = write!(text, "\n## {heading}\n\n{description}\n\n");
    let (tables, keys): (Vec<_>, Vec<_>) =
        properties.iter().partition(|(_, value)| value["properties"].is_object());
    if !keys.is_empty() {
        text.push_str("| key | unit | default | allowed | meaning |\n|---|---|---|---|---|\n");
    }
    for (name, value) in &keys {
        row(text, name, value, schema);
    }
    for (name, value) in keys {
        table(text, &join(path, name), &value["items"], true);
    }
    for (name, value) in tables {
        table(text, &join(path, name), value, false);
    }
}

fn row(text: &mut String, name: &str, value: &Value, table: &Value) {
    let required = table["required"].as_array().is_some_and(|list| list.iter().any(|k| k == name));
    let default = match (value["x-default"].as_str(), value.get("default")) {
        _ if required => "required".to_owned(),
        (Some(words), _) => words.to_owned(),
        (None, Some(constant)) => format!("`{constant}`"),
        (None, None) => "none".to_owned(),
    };
    let unit = value.as_object().and_then(unit_of).unwrap_or_default();
    let meaning = value["description"].as_str().unwrap_or_default();
    let allowed = allowed(value);
    let _ = writeln!(text, "| `{name}` | {unit} | {default} | {allowed} | {meaning} |");
}

/// What is allowed, without the unit; choices with their meaning.
fn allowed(value: &Value) -> String {
    if let Some(choices) = choices(value) {
        let meanings = value["oneOf"].as_array().into_iter().flatten();
        let mut meanings = meanings.filter_map(|c| c["description"].as_str());
        return choices
            .iter()
            .map(|choice| match meanings.next() {
                Some(meaning) => format!("`\"{choice}\"`: {meaning}"),
                None => format!("`\"{choice}\"`"),
            })
            .collect::<Vec<_>>()
            .join("<br>");
    }
    let mut plain = value.clone();
    if let Some(object) = plain.as_object_mut() {
        object.remove("x-unit");
    }
    expectation(&plain)
}
