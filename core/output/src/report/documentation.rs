//! Holds the tables of keys in docs/results.md and docs/operations.md equal to the types.

use super::{OperationsReport, Report, samples};
use schemars::JsonSchema;
use serde_json::Value;
use std::fmt::Write;

const START: &str = "<!-- report keys -->\n";
const END: &str = "<!-- end of report keys -->\n";

/// Key paths of pretty JSON in the order in which they stand, each once; `[]` stands for a list.
fn key_paths(json: &str) -> Vec<String> {
    let mut stack: Vec<(usize, String)> = Vec::new();
    let mut paths = Vec::new();
    for line in json.lines() {
        let indent = line.len() - line.trim_start().len();
        while stack.last().is_some_and(|(depth, _)| *depth >= indent) {
            stack.pop();
        }
        let content = line.trim_start();
        if content == "{" && indent > 0 {
            stack.push((indent, "[]".to_owned()));
        } else if let Some((key, _)) = content.split_once("\": ") {
            stack.push((indent, key.trim_start_matches('"').to_owned()));
            let path: Vec<&str> = stack.iter().map(|(_, key)| key.as_str()).collect();
            let path = path.join(".").replace(".[]", "[]");
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
    }
    paths
}

/// Schema of the value at a key path.
fn schema_at<'a>(schema: &'a Value, path: &str) -> &'a Value {
    path.split('.').fold(schema, |at, key| {
        let (name, list) = key.strip_suffix("[]").map_or((key, false), |name| (name, true));
        let value = &at["properties"][name];
        if list { &value["items"] } else { value }
    })
}

fn kind(schema: &Value) -> String {
    let name = |value: &Value| match value.as_str() {
        Some("array") => match kind(&schema["items"]).strip_prefix("list ") {
            Some(rest) => format!("list of lists {rest}"),
            None => format!("list of {}s", kind(&schema["items"])),
        },
        Some(other) => other.to_owned(),
        None => String::new(),
    };
    match &schema["type"] {
        Value::Array(kinds) => kinds.iter().map(name).collect::<Vec<_>>().join(" or "),
        single => name(single),
    }
}

fn schema_of<T: JsonSchema>() -> Value {
    let settings =
        schemars::generate::SchemaSettings::default().with(|s| s.inline_subschemas = true);
    serde_json::to_value(settings.into_generator().into_root_schema_for::<T>()).unwrap()
}

fn table<T: JsonSchema>(json: &str) -> String {
    let schema = schema_of::<T>();
    let mut table = String::from("| key | type | meaning |\n|---|---|---|\n");
    for path in key_paths(json) {
        let value = schema_at(&schema, &path);
        let meaning = value["description"].as_str().unwrap().replace('\n', " ");
        writeln!(table, "| `{path}` | {} | {meaning} |", kind(value)).unwrap();
    }
    table
}

#[test]
fn results_page_lists_the_keys() {
    assert_lists("results.md", &table::<Report>(&samples::report().to_json()));
}

#[test]
fn operations_page_lists_the_keys() {
    assert_lists("operations.md", &table::<OperationsReport>(&samples::operations().to_json()));
}

fn assert_lists(name: &str, wanted: &str) {
    let path = format!("{}/../../docs/{name}", env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(START).unwrap();
    let (listed, after) = rest.split_once(END).unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(path, [before, START, wanted, END, after].concat()).unwrap();
        return;
    }
    assert!(
        listed == wanted,
        "docs/{name} must list the report's keys; run with UPDATE_GOLDEN=1 and read the difference:\n{wanted}"
    );
}

#[test]
fn every_key_of_the_types_is_in_the_sample() {
    fn count(schema: &Value) -> usize {
        let own = schema["properties"]
            .as_object()
            .map_or(0, |p| p.len() + p.values().map(count).sum::<usize>());
        own + if schema["items"].is_object() { count(&schema["items"]) } else { 0 }
    }
    let count_in = |json: &str| key_paths(json).len();
    assert_eq!(count_in(&samples::report().to_json()), count(&schema_of::<Report>()));
    assert_eq!(count_in(&samples::operations().to_json()), count(&schema_of::<OperationsReport>()));
}
