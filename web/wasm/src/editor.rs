//! What an editor asks while a job is written, in JSON, with places in UTF-16 units from the start.

use evencut_core::job::{self, CompletionKind};
use serde_json::{Value, json};

/// What may be written at a place: `from` where the begun word stands, and `options` with `text`, `kind` (`table`, `key` or
/// `value`), `unit` and `about`.
pub fn completions(source: &str, at: usize) -> Value {
    let found = job::completions(source, byte(source, at));
    let option = |o: &job::Completion| {
        let kind = match o.kind {
            CompletionKind::Table => "table",
            CompletionKind::Key => "key",
            CompletionKind::Value => "value",
        };
        json!({ "text": o.text, "kind": kind, "unit": o.unit, "about": o.about })
    };
    let options: Vec<Value> = found.options.iter().map(option).collect();
    json!({ "from": units(source, found.from), "options": options })
}

/// What the key that ends at a place means: `key`, `about` and `expected`; null where none does.
pub fn explanation(source: &str, at: usize) -> Value {
    job::explanation(source, byte(source, at))
        .map_or(Value::Null, |e| json!({ "key": e.key, "about": e.about, "expected": e.expected }))
}

/// UTF-16 units before a byte.
pub fn units(source: &str, byte: usize) -> usize {
    let mut byte = byte.min(source.len());
    while !source.is_char_boundary(byte) {
        byte -= 1;
    }
    source[..byte].encode_utf16().count()
}

/// The byte before which there are so many UTF-16 units.
fn byte(source: &str, units: usize) -> usize {
    let mut left = units;
    let letter = source.char_indices().find(|(_, letter)| {
        let is_there = left == 0;
        left = left.saturating_sub(letter.len_utf16());
        is_there
    });
    letter.map_or(source.len(), |(byte, _)| byte)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_counted_as_the_page_does() {
        let source = "name = \"ä📏\"\n[cut]\nfe";
        let end = source.encode_utf16().count();
        let found = completions(source, end);
        assert_eq!(found["from"], json!(end - 2));
        let feed = found["options"].as_array().unwrap().iter().find(|o| o["text"] == "feed");
        assert_eq!(feed.unwrap()["unit"], "mm/min");
        assert_eq!(explanation(&format!("{source}ed"), end + 2)["key"], "cut.feed");
        assert_eq!(explanation(source, 3)["key"], Value::Null);
        for units in 0..=end {
            assert!(source.is_char_boundary(byte(source, units)));
        }
    }
}
