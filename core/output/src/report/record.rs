//! What identifies the files and programs that a result was made from.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// What a later run reads of the report of a plan; what it does not know it leaves out.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Recorded {
    /// The files that the plan was made from.
    pub inputs: Vec<FileRecord>,
    /// The files that were written with it.
    pub outputs: Vec<FileRecord>,
    /// What it says of its coverage.
    pub coverage: RecordedCoverage,
}

/// What a later run reads of the coverage in a report.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct RecordedCoverage {
    /// Spheres around inaccessible places: centre and radius, mm.
    pub inaccessible_places: Vec<[f64; 4]>,
}

/// Why a report cannot be read.
#[derive(Debug, Error)]
#[error("the report cannot be read: {0}; plan the job again")]
pub struct BadReport(#[from] serde_json::Error);

impl Recorded {
    /// Reads a report.
    ///
    /// # Errors
    /// [`BadReport`] where it is no JSON, or one of these values is not what it should be.
    pub fn read(json: &[u8]) -> Result<Self, BadReport> {
        Ok(serde_json::from_slice(json)?)
    }

    /// The record of a file that the plan was made from.
    pub fn input(&self, name: &str) -> Option<&FileRecord> {
        self.inputs.iter().find(|file| file.name == name)
    }

    /// The record of a file that was written with it.
    pub fn output(&self, name: &str) -> Option<&FileRecord> {
        self.outputs.iter().find(|file| file.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_read_for_what_a_later_run_needs() {
        let json = br#"{"inputs":[{"name":"a.stl","bytes":3,"sha256":"00"}],"new":1,
            "coverage":{"area_mm2":2.0,"inaccessible_places":[[1,2,3,0.5]]}}"#;
        let read = Recorded::read(json).unwrap();
        assert_eq!(read.input("a.stl").map(|file| file.bytes), Some(3));
        assert_eq!(read.output("a.stl"), None);
        assert_eq!(read.coverage.inaccessible_places, [[1.0, 2.0, 3.0, 0.5]]);
        assert_eq!(Recorded::read(b"{}").unwrap(), Recorded::default());
        for bad in [&b"[1"[..], br#"{"coverage":{"inaccessible_places":[[1,2,3]]}}"#] {
            assert!(Recorded::read(bad).unwrap_err().to_string().contains("plan the job again"));
        }
    }

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
