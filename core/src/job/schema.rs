//! JSON Schema of the job file: `schema.json`, which a test makes of the types in [`super::file`]
//! and holds against them. Made at run time its code would be a twelfth of the page's module.

use std::sync::LazyLock;

use schemars::Schema;
use schemars::transform::{RecursiveTransform, Transform};
use serde_json::Value;

/// Made by `UPDATE_GOLDEN=1 cargo test -p evencut-core job::schema`.
const SHIPPED: &str = include_str!("schema.json");

/// The job file's JSON Schema (draft 2020-12) as text, for editors and for checking.
///
/// Lengths are described for jobs in millimetres; every description ends with the key's unit and
/// default.
pub fn schema() -> String {
    let mut schema = Schema::try_from(described().clone()).unwrap_or_default();
    RecursiveTransform(explain).transform(&mut schema);
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}

/// The schema as the reader of job files walks it: no references, no nulls.
pub(super) fn described() -> &'static Value {
    static DESCRIBED: LazyLock<Value> =
        LazyLock::new(|| serde_json::from_str(SHIPPED).unwrap_or_default());
    &DESCRIBED
}

/// Appends unit and default to the description, where editors show them.
fn explain(schema: &mut Schema) {
    let Some(object) = schema.as_object_mut() else { return };
    let mut facts = Vec::new();
    if let Some(unit) = unit_of(object) {
        facts.push(format!("Unit: {unit}."));
    }
    if let Some(Value::String(default)) = object.get("x-default") {
        facts.push(format!("Default: {default}."));
    } else if let Some(default) = object.get("default") {
        facts.push(format!("Default: {default}."));
    }
    if let (Some(Value::String(text)), false) = (object.get_mut("description"), facts.is_empty()) {
        text.push(' ');
        text.push_str(&facts.join(" "));
    }
}

/// The unit of a key, or of the innermost items of an array.
pub(super) fn unit_of(schema: &serde_json::Map<String, Value>) -> Option<&str> {
    match (schema.get("x-unit"), schema.get("items")) {
        (Some(Value::String(unit)), _) => Some(unit),
        (_, Some(Value::Object(items))) => unit_of(items),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use schemars::generate::SchemaSettings;

    use super::super::file::JobFile;
    use super::*;

    fn generated() -> Schema {
        let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
        let mut schema = settings.into_generator().into_root_schema_for::<JobFile>();
        RecursiveTransform(drop_null).transform(&mut schema);
        RecursiveTransform(tidy).transform(&mut schema);
        schema
    }

    /// TOML has no null: an optional key is one that may be left out.
    fn drop_null(schema: &mut Schema) {
        let Some(object) = schema.as_object_mut() else { return };
        if let Some(Value::Array(types)) = object.get_mut("type") {
            types.retain(|t| t != "null");
            if let [only] = types.as_slice() {
                let only = only.clone();
                object.insert("type".into(), only);
            }
        }
        let Some(Value::Array(mut branches)) = object.remove("anyOf") else { return };
        branches.retain(|b| b.get("type").is_none_or(|t| t != "null"));
        match branches.as_slice() {
            [Value::Object(only)] => {
                for (key, value) in only {
                    if !object.contains_key(key) {
                        object.insert(key.clone(), value.clone());
                    }
                }
            }
            _ => {
                object.insert("anyOf".into(), Value::Array(branches));
            }
        }
    }

    /// Removes what says nothing: number formats, defaults of whole tables, line breaks of comments.
    fn tidy(schema: &mut Schema) {
        let Some(object) = schema.as_object_mut() else { return };
        object.remove("format");
        object.remove("writeOnly");
        if object.get("default").is_some_and(|d| d.is_object() || d.is_null()) {
            object.remove("default");
        }
        if let Some(Value::String(text)) = object.get_mut("description") {
            *text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        }
    }

    #[test]
    fn the_shipped_schema_is_that_of_the_types() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/job/schema.json");
        let text = serde_json::to_string_pretty(&generated()).unwrap() + "\n";
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(path, text).unwrap();
            return;
        }
        assert!(text == SHIPPED, "{path} must be made again; run with UPDATE_GOLDEN=1");
    }
}
