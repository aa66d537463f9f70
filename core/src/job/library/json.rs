//! Values out of JSON that others wrote: what is missing is no fault, what is something else is.

use serde_json::Value;

/// Longest piece of a value that is shown in a message, characters.
const SHOWN: usize = 40;

/// A text that is not empty.
pub(super) fn text<'a>(object: &'a Value, key: &str) -> Option<&'a str> {
    object[key].as_str().map(str::trim).filter(|text| !text.is_empty())
}

/// A number.
pub(super) fn number(object: &Value, key: &str) -> Result<Option<f64>, String> {
    match &object[key] {
        Value::Null => Ok(None),
        Value::Number(number) => Ok(number.as_f64()),
        other => Err(format!("{key} is {}, which is no number", shown(other))),
    }
}

/// A number greater than 0; 0 stands for none.
pub(super) fn above_zero(object: &Value, key: &str) -> Result<Option<f64>, String> {
    Ok(number(object, key)?.filter(|number| *number != 0.0))
}

/// A whole number, which may stand in quotes.
pub(super) fn whole(object: &Value, key: &str) -> Result<Option<u32>, String> {
    let value = &object[key];
    let found = match value {
        Value::Null => return Ok(None),
        Value::Number(number) => number.as_f64(),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    };
    let fits = |number: &f64| number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(number);
    match found.filter(fits) {
        Some(number) => Ok(Some(number as u32)),
        None => Err(format!("{key} is {}, which is no whole number", shown(value))),
    }
}

/// A value in messages.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::Array(_) => "a list".to_owned(),
        Value::Object(_) => "an object".to_owned(),
        Value::String(text) => format!("{:?}", text.chars().take(SHOWN).collect::<String>()),
        plain => plain.to_string(),
    }
}

/// Why there is no cutter for a kind of tool.
pub(super) fn no_cutter(kind: &str) -> String {
    let kind: String = kind.chars().take(SHOWN).collect();
    format!("{kind}: evencut cuts with ball, flat and bull (corner radius) ends only")
}
