//! Faults of a job that can only be found with its files, and their place in the job file.

use std::fmt::Display;
use std::ops::Range;

use evencut_core::job::{Beside, Fault, Job};
use toml::de::DeTable;

/// A file that a job names.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum NamedFile {
    /// The surface.
    Surface,
    /// A mesh that the tool avoids, by the index of its table.
    Avoid(usize),
    /// The mesh of the stock.
    Stock,
    /// A surface of a blade.
    Blade,
    /// The post-processor.
    Post,
    /// One that it is completed with.
    Beside(Beside),
}

impl NamedFile {
    /// The meshes beside the surface of a job, as [`Job::mesh_files`].
    pub fn meshes(job: &Job) -> impl Iterator<Item = (Self, &str)> {
        let avoided = (0..job.avoid.len()).map(Self::Avoid);
        avoided.chain([Self::Stock]).zip(job.mesh_files())
    }

    /// The key of its name.
    pub fn key(self) -> String {
        match self {
            Self::Surface => "surface.file".into(),
            Self::Avoid(index) => format!("avoid[{index}].file"),
            Self::Stock => "stock.file".into(),
            Self::Blade => "hub.blade".into(),
            Self::Post => "output.gcode.post_file".into(),
            Self::Beside(file) => file.key().into(),
        }
    }

    /// Prefix of messages about it.
    fn subject(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Avoid(_) => "avoid",
            Self::Stock => "stock",
            Self::Blade => "hub",
            Self::Post => "post",
            Self::Beside(Beside::Library) => "tool",
            Self::Beside(Beside::Machine) => "machine",
        }
    }

    /// There is no such file; `name`: the path that was tried.
    pub fn missing(self, name: impl Display, job_source: &[u8]) -> Fault {
        let mut fault = self.fault(format_args!("there is no file {name}"), job_source);
        fault.help.push("paths in a job file are relative to the job file".into());
        fault
    }

    /// It is there but cannot be used.
    pub fn fault(self, message: impl Display, job_source: &[u8]) -> Fault {
        fault(format!("{}: {message}", self.subject()), place(job_source, &self.key()))
    }
}

/// A fault with a complete message, at a place of the job file if there is one.
pub fn fault(message: String, span: Option<Range<usize>>) -> Fault {
    Fault { key: String::new(), message, help: Vec::new(), span }
}

/// Where the value of a dotted key is written in a job file, in bytes; an index in brackets is that of an array.
pub fn place(source: &[u8], key: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(std::str::from_utf8(source).ok()?).ok()?;
    let mut table = document.get_ref();
    let mut keys = key.split('.').peekable();
    while let Some(key) = keys.next() {
        let (key, index) = match key.strip_suffix(']').and_then(|key| key.split_once('[')) {
            Some((key, index)) => (key, Some(index.parse::<usize>().ok()?)),
            None => (key, None),
        };
        let value = table.get(key)?;
        let value = match index {
            Some(index) => value.get_ref().as_array()?.get(index)?,
            None => value,
        };
        if keys.peek().is_none() {
            return Some(value.span());
        }
        table = value.get_ref().as_table()?;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_in_tables_and_inline_tables() {
        let source = b"[surface]\nfile = \"a\"\nselect = { component = 3 }\n";
        let at = |key| place(source, key).map(|span| &source[span]);
        assert_eq!(at("surface.file"), Some(&b"\"a\""[..]));
        assert_eq!(at("surface.select.component"), Some(&b"3"[..]));
        assert_eq!(at("surface.file.name"), None);
        assert_eq!(at("surface.scale"), None);
        assert_eq!(at("surface.select[0]"), None);
        let source = b"[[avoid]]\nfile = \"a\"\n[[avoid]]\nfile = \"b\"\n";
        let at = |key| place(source, key).map(|span| &source[span]);
        assert_eq!(at("avoid[1].file"), Some(&b"\"b\""[..]));
        assert_eq!(
            (at("avoid[2].file"), at("avoid[x].file"), at("avoid.file")),
            (None, None, None)
        );
    }
}
