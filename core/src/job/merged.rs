//! The job's tables with what an operation says instead: text that could stand alone, every key at its own place.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys of which an operation's own one replaces all of the job's.
const INSTEAD: [(&str, &[&str]); 2] =
    [("cut", &["scallop", "stepover"]), ("force", &["mrr_limit", "relative"])];
/// Tables of an operation.
const TABLES: [&str; 6] = ["tool", "cut", "regions", "path", "force", "trochoid"];
/// An operation as it is written.
#[derive(Clone, Debug, Default)]
pub(super) struct Written {
    pub name: Option<String>,
    pub is_rest: bool,
    /// Where it stands.
    pub span: Range<usize>,
}

/// The job's tables with those of an operation.
pub(super) fn merged<'a>(job: &DeTable<'a>, operation: &DeTable<'a>) -> DeTable<'a> {
    let mut whole = job.clone();
    whole.remove("operation");
    for (key, value) in operation {
        let name: &str = key.get_ref();
        if !TABLES.contains(&name) {
            continue;
        }
        let own = match (whole.get(name).map(Spanned::get_ref), value.get_ref()) {
            (Some(DeValue::Table(common)), DeValue::Table(own)) if name != "tool" => {
                Spanned::new(value.span(), DeValue::Table(with(name, common, own)))
            }
            _ => value.clone(),
        };
        // The place of the key is that in the operation.
        whole.remove(name);
        whole.insert(key.clone(), own);
    }
    whole
}

/// A table with the keys of an operation's.
fn with<'a>(name: &str, common: &DeTable<'a>, own: &DeTable<'a>) -> DeTable<'a> {
    let mut whole = common.clone();
    for (_, keys) in INSTEAD.iter().filter(|(table, _)| *table == name) {
        if keys.iter().any(|key| own.contains_key(*key)) {
            keys.iter().for_each(|key| drop(whole.remove(*key)));
        }
    }
    for (key, value) in own {
        whole.remove(&**key.get_ref());
        whole.insert(key.clone(), value.clone());
    }
    whole
}
