//! The schema and values of the job file in words, for messages and for the reference.

use serde_json::Value as Schema;
use toml::de::DeValue;

pub(super) fn keys(schema: &Schema) -> impl Iterator<Item = &str> {
    schema["properties"].as_object().into_iter().flatten().map(|(key, _)| key.as_str())
}

pub(super) fn names(list: &Schema) -> impl Iterator<Item = &str> {
    list.as_array().into_iter().flatten().filter_map(Schema::as_str)
}

/// The strings that a schema of choices allows; `None` for other schemas.
pub(super) fn choices(schema: &Schema) -> Option<Vec<&str>> {
    if schema["enum"].is_array() {
        return Some(names(&schema["enum"]).collect());
    }
    if schema["type"] == "object" {
        return None;
    }
    let branches = schema["oneOf"].as_array()?;
    Some(branches.iter().filter_map(|b| b["const"].as_str()).collect())
}

pub(super) fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "an integer",
        DeValue::Float(_) => "a number with decimals",
        DeValue::Boolean(_) => "a boolean",
        DeValue::Datetime(_) => "a date or time",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

pub(super) fn quoted(choices: &[&str]) -> String {
    choices.iter().map(|c| format!("{c:?}")).collect::<Vec<_>>().join(", ")
}

/// What a schema allows, in words: "a number greater than 0 and at most 10 (mm)".
pub(super) fn expectation(schema: &Schema) -> String {
    let unit = schema["x-unit"].as_str().map_or(String::new(), |unit| format!(" ({unit})"));
    if let Some(branches) = schema["anyOf"].as_array() {
        return branches.iter().map(expectation).collect::<Vec<_>>().join(", or ");
    }
    if let Some(choices) = choices(schema) {
        return match choices.as_slice() {
            [only] => format!("{only:?}"),
            several => format!("one of {}", quoted(several)),
        };
    }
    if let Some(table) = schema["x-as"].as_str() {
        return format!("a table with keys of [{table}]");
    }
    match schema["type"].as_str() {
        Some("integer") if schema["minimum"] == schema["maximum"] => {
            format!("{}", schema["minimum"])
        }
        Some("number") => format!("a number{}{unit}", range_words(schema)),
        Some("integer") => format!("an integer{}{unit}", range_words(schema)),
        Some("boolean") => "true or false".into(),
        Some("string") => "a string".into(),
        Some("array") => array_words(schema, &unit),
        _ => table_words(schema),
    }
}

fn range_words(schema: &Schema) -> String {
    let least = schema["minimum"].as_f64();
    let above = schema["exclusiveMinimum"].as_f64();
    let most = schema["maximum"].as_f64();
    match (least, above, most) {
        (Some(least), _, Some(most)) => format!(" from {least} to {most}"),
        (None, Some(above), Some(most)) => format!(" greater than {above} and at most {most}"),
        (Some(least), _, None) => format!(" of at least {least}"),
        (None, Some(above), None) => format!(" greater than {above}"),
        (None, None, Some(most)) => format!(" of at most {most}"),
        (None, None, None) => String::new(),
    }
}

fn array_words(schema: &Schema, unit: &str) -> String {
    let count = match (schema["minItems"].as_u64(), schema["maxItems"].as_u64()) {
        (Some(least), Some(most)) if least == most => format!("of {least}"),
        (Some(least), Some(most)) => format!("of {least} to {most}"),
        (None, Some(most)) => format!("of at most {most}"),
        (Some(least), None) => format!("of at least {least}"),
        _ => "of any length".into(),
    };
    format!("an array {count}, each {}{unit}", expectation(&schema["items"]))
}

fn table_words(schema: &Schema) -> String {
    let known = keys(schema).collect::<Vec<_>>().join(", ");
    match names(&schema["required"]).collect::<Vec<_>>().as_slice() {
        [] => format!("a table with keys out of: {known}"),
        required => format!("a table with {} and keys out of: {known}", required.join(", ")),
    }
}
