//! A directory of results that is replaced completely or not at all.
//!
//! Files are written into a temporary directory beside the target, which replaces the target by a rename once all of
//! them are there. A run that fails leaves earlier results unchanged. Only a directory that contains nothing but
//! earlier results is replaced: each contains a list of its files.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use thiserror::Error;

/// Name of the list of files that marks a directory of results.
pub const LIST: &str = ".evencut-results";

/// Directories that are being written, to be removed if the run is interrupted. Locked while results are put in place.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes results that are not complete, for a run that is interrupted. Nothing is put in place afterwards: the
/// returned guard is to be held until the process ends.
pub fn remove_unfinished() -> impl Drop {
    let unfinished = unfinished();
    for directory in unfinished.iter() {
        let _ = fs::remove_dir_all(directory);
    }
    unfinished
}

/// Why results cannot be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The target is a file.
    #[error("output: {0} is a file; give a directory with -o")]
    NotADirectory(PathBuf),
    /// The target contains something other than results.
    #[error(
        "output: {directory} holds {example}, which is not a result of evencut; give another \
         directory with -o, or move it away"
    )]
    Foreign {
        /// The target.
        directory: PathBuf,
        /// One file or directory in it that is not a result.
        example: String,
    },
    /// The target has no name after which a directory beside it could be named.
    #[error("output: {0} cannot be replaced; give a directory with a name with -o")]
    Nameless(PathBuf),
    /// The name of a result is not a plain file name.
    #[error("output: {0:?} is not a plain file name")]
    FileName(String),
    /// The operating system reported an error.
    #[error("output: {path}: {source}")]
    Io {
        /// What was written, read or renamed.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
}

trait At<T> {
    fn at(self, path: &Path) -> Result<T, OutputError>;
}

impl<T> At<T> for io::Result<T> {
    fn at(self, path: &Path) -> Result<T, OutputError> {
        self.map_err(|source| OutputError::Io { path: path.to_owned(), source })
    }
}

/// Whether results may be written to `target`, replacing earlier ones.
///
/// # Errors
/// [`OutputError`] if `target` is a file, contains other files, or has no name.
pub fn check(target: &Path) -> Result<(), OutputError> {
    check_replaceable(&resolved(target)?)
}

/// Results being written; if dropped without [`ResultDirectory::commit`], they are removed.
#[derive(Debug)]
pub struct ResultDirectory {
    target: PathBuf,
    partial: PathBuf,
    names: BTreeSet<String>,
}

impl ResultDirectory {
    /// Begins results that are to replace `target`.
    ///
    /// # Errors
    /// [`OutputError`] if `target` is a file, contains other files, or no directory can be created beside it.
    pub fn begin(target: &Path) -> Result<Self, OutputError> {
        let target = resolved(target)?;
        check_replaceable(&target)?;
        fs::create_dir_all(parent(&target)).at(parent(&target))?;
        let mut unfinished = unfinished();
        let partial = create_beside(&target, "partial")?;
        unfinished.insert(partial.clone());
        Ok(Self { target, partial, names: BTreeSet::new() })
    }

    /// Writes one result to the disk.
    ///
    /// # Errors
    /// [`OutputError`] if `name` is not a plain file name or the file cannot be written.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let plain = Path::new(name).file_name().is_some_and(|n| n == name);
        if !plain || name == LIST || name.contains('\n') {
            return Err(OutputError::FileName(name.to_owned()));
        }
        self.store(name, bytes)?;
        self.names.insert(name.to_owned());
        Ok(())
    }

    fn store(&self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let path = self.partial.join(name);
        let mut file = fs::File::create(&path).at(&path)?;
        file.write_all(bytes).at(&path)?;
        file.sync_all().at(&path)
    }

    /// Puts the results in the target's place; returns their path.
    ///
    /// # Errors
    /// [`OutputError`]; earlier results are then still in place.
    pub fn commit(self) -> Result<PathBuf, OutputError> {
        let list: String = self.names.iter().map(|name| format!("{name}\n")).collect();
        self.store(LIST, list.as_bytes())?;
        // An interruption waits until they are in place.
        let _whole = unfinished();
        // Somebody may have put a file there during the run.
        check_replaceable(&self.target)?;
        if !self.target.exists() {
            fs::rename(&self.partial, &self.target).at(&self.target)?;
            return Ok(self.target.clone());
        }
        let earlier = create_beside(&self.target, "earlier")?;
        // A directory may be renamed onto an empty one.
        fs::rename(&self.target, &earlier).at(&self.target)?;
        if let Err(error) = fs::rename(&self.partial, &self.target) {
            fs::rename(&earlier, &self.target).at(&earlier)?;
            return Err(error).at(&self.target);
        }
        // The new results are in place; what may stay of the old ones is a hidden directory.
        let _ = fs::remove_dir_all(&earlier);
        Ok(self.target.clone())
    }
}

impl Drop for ResultDirectory {
    fn drop(&mut self) {
        // After a commit it is no longer there.
        let _ = fs::remove_dir_all(&self.partial);
        unfinished().remove(&self.partial);
    }
}

/// The directory itself if `target` is a link to one.
fn resolved(target: &Path) -> Result<PathBuf, OutputError> {
    let target = if target.exists() {
        fs::canonicalize(target).at(target)?
    } else {
        std::path::absolute(target).at(target)?
    };
    match target.file_name() {
        Some(_) => Ok(target),
        None => Err(OutputError::Nameless(target)),
    }
}

fn parent(target: &Path) -> &Path {
    target.parent().unwrap_or(target)
}

/// A new, empty, hidden directory beside `target`.
fn create_beside(target: &Path, purpose: &str) -> Result<PathBuf, OutputError> {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let mut attempt = 0;
    loop {
        let hidden = format!(".{name}.{purpose}-{}-{attempt}", std::process::id());
        let path = target.with_file_name(hidden);
        match fs::create_dir(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 1000 => {
                attempt += 1;
            }
            result => return result.at(&path).map(|()| path),
        }
    }
}

/// A directory may be replaced if it does not exist, is empty, or contains only what its list names.
fn check_replaceable(target: &Path) -> Result<(), OutputError> {
    if !target.exists() {
        return Ok(());
    }
    if !target.is_dir() {
        return Err(OutputError::NotADirectory(target.to_owned()));
    }
    let list = fs::read_to_string(target.join(LIST)).unwrap_or_default();
    let ours: BTreeSet<&str> = list.lines().chain([LIST]).collect();
    let mut foreign = None;
    for entry in fs::read_dir(target).at(target)? {
        let name = entry.at(target)?.file_name().to_string_lossy().into_owned();
        if !ours.contains(name.as_str()) && foreign.as_ref().is_none_or(|f| name < *f) {
            foreign = Some(name);
        }
    }
    match foreign {
        None => Ok(()),
        Some(example) => Err(OutputError::Foreign { directory: target.to_owned(), example }),
    }
}
