//! What identifies the files and programs that a result was made from.

use serde::Serialize;
use sha2::{Digest, Sha256};

/// Versions of what made a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Versions {
    /// Version of evencut.
    pub evencut: String,
    /// Version of the job file's format.
    pub job_file: u32,
}

/// A file and what identifies it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileRecord {
    /// File name relative to the job, or to the folder of the results.
    pub name: String,
    /// Length, bytes.
    pub bytes: u64,
    /// SHA-256 of the content, hexadecimal.
    pub sha256: String,
}

impl FileRecord {
    /// The record of a file with this content.
    pub fn of(name: &str, content: &[u8]) -> Self {
        let digest = Sha256::digest(content);
        let sha256 = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        Self { name: name.to_owned(), bytes: content.len() as u64, sha256 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digest_of_the_standard_example() {
        let record = FileRecord::of("a", b"abc");
        assert_eq!(
            record.sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(record.bytes, 3);
    }
}
