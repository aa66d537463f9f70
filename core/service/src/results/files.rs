//! Input files and output files of results.

/// A file that was read.
#[derive(Copy, Clone, Debug)]
pub struct Input<'a> {
    /// Name as the job gives it.
    pub name: &'a str,
    /// Content.
    pub bytes: &'a [u8],
}

/// A file to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputFile {
    /// Name in the folder of the results.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}
