//! Job files and the surface files they name.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use evencut_core::job::{self, Fault, Faults, Job, Resolved, SurfaceSource};
use evencut_core::plan::Files;
use evencut_output::report::{FileRecord, Recorded};
use evencut_service::faults::{NamedFile, fault};

/// Longest part of a job file that is read, bytes: enough for `job::read` to reject a longer one.
const LONGEST_JOB: u64 = (1 << 20) + 1;

/// Directories above results in which their surface is searched, including the results' own.
const MOST_ABOVE: usize = 4;

/// Whether a path stands for standard input.
pub fn is_standard_input(path: &Path) -> bool {
    path == Path::new("-")
}

/// A job file's name in messages.
pub fn name(path: &Path) -> String {
    if is_standard_input(path) { "standard input".into() } else { shown(path) }
}

/// A path in messages.
pub fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// The bytes of a job file, or why it cannot be read.
pub fn read_job(path: &Path) -> Result<Vec<u8>, Fault> {
    let read = || -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        if is_standard_input(path) {
            io::stdin().take(LONGEST_JOB).read_to_end(&mut bytes)?;
        } else {
            std::fs::File::open(path)?.take(LONGEST_JOB).read_to_end(&mut bytes)?;
        }
        Ok(bytes)
    };
    read().map_err(|error| fault(error.to_string(), None))
}

/// The job of a job file, completed with the files that it names for that, relative to the job file.
///
/// # Errors
/// All faults of the job.
pub fn resolved(path: &Path, source: &[u8]) -> Result<Resolved, Faults> {
    let folder = path.parent().unwrap_or(Path::new(""));
    job::read_with(source, &mut |file, name| {
        read_named(&folder.join(name), NamedFile::Beside(file), source)
    })
}

/// Paths of the files that a job names, apart from those that complete it.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// That of the surface.
    pub surface: Option<PathBuf>,
    /// Those of the meshes beside the surface, with their names in the job.
    pub meshes: Vec<(NamedFile, String, PathBuf)>,
    /// That of the post-processor.
    pub post: Option<PathBuf>,
    /// Those of the surfaces of blades, with their names in the job.
    pub blades: Vec<(String, PathBuf)>,
}

impl Paths {
    /// Relative to the job file.
    pub fn of_job(job_path: &Path, job: &Job) -> Self {
        let folder = job_path.parent().unwrap_or(Path::new(""));
        Self::found(job, |name| folder.join(name))
    }

    /// Of the job of results in a directory.
    pub fn of_results(directory: &Path, job: &Job) -> Self {
        Self::found(job, |name| file_of_results(directory, name))
    }

    fn found(job: &Job, found: impl Fn(&str) -> PathBuf) -> Self {
        let surface = match &job.surface.source {
            SurfaceSource::File(name) => Some(found(name)),
            SurfaceSource::Analytic(_) => None,
        };
        let with_path = |name: &str| (name.to_owned(), found(name));
        Self {
            surface,
            meshes: NamedFile::meshes(job)
                .map(|(file, name)| (file, name.to_owned(), found(name)))
                .collect(),
            post: job.post_file().map(&found),
            blades: job.blade_files().into_iter().map(with_path).collect(),
        }
    }

    /// All of them, with what they are.
    pub fn all(&self) -> impl Iterator<Item = (NamedFile, &PathBuf)> {
        let surface = self.surface.iter().map(|path| (NamedFile::Surface, path));
        let meshes = self.meshes.iter().map(|(file, _, path)| (*file, path));
        let blades = self.blades.iter().map(|(_, path)| (NamedFile::Blade, path));
        let post = self.post.iter().map(|path| (NamedFile::Post, path));
        surface.chain(meshes).chain(blades).chain(post)
    }
}

/// The report of the results in a directory; `None` where there is no readable one.
pub fn recorded(directory: &Path) -> Option<Recorded> {
    Recorded::read(&std::fs::read(directory.join("report.json")).ok()?).ok()
}

/// A file from which the results in a directory were made: searched under its name in the job from that directory,
/// one above it or the current one, with the content that the report recorded. If there is none, the path given by
/// the job, so that its absence is reported.
fn file_of_results(directory: &Path, name: &str) -> PathBuf {
    let report = recorded(directory);
    let sha256 = report.as_ref().and_then(|report| report.input(name)).map(|file| &file.sha256);
    let absolute = std::fs::canonicalize(directory).unwrap_or_default();
    let above = absolute.ancestors().take(MOST_ABOVE).map(Path::to_owned);
    let places = above.chain([PathBuf::new()]).map(|place| place.join(name));
    let is_it = |file: &PathBuf| {
        let content = std::fs::read(file).ok();
        content.is_some_and(|c| Some(&FileRecord::of(name, &c).sha256) == sha256)
    };
    places.into_iter().find(is_it).unwrap_or_else(|| directory.join(name))
}

/// Contents of the files that a job names.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// Path and content of the surface file.
    pub surface: Option<(PathBuf, Vec<u8>)>,
    /// Names in the job and contents of the meshes beside the surface.
    pub meshes: Vec<(String, Vec<u8>)>,
    /// Path and content of the post-processor's file.
    pub post: Option<(PathBuf, Vec<u8>)>,
    /// Names in the job and contents of the surfaces of blades.
    pub blades: Vec<(String, Vec<u8>)>,
    /// Names in the job and contents of the files that it was completed with.
    pub beside: Vec<(String, Vec<u8>)>,
}

impl Contents {
    /// Reads the files at these paths, or returns why one cannot be read.
    pub fn read(paths: Paths, job_source: &[u8]) -> Result<Self, Fault> {
        let read = |path: Option<PathBuf>, file| match path {
            None => Ok(None),
            Some(path) => read_named(&path, file, job_source).map(|bytes| Some((path, bytes))),
        };
        let surface = read(paths.surface, NamedFile::Surface)?;
        let named = |(name, path): (String, PathBuf), file| {
            read_named(&path, file, job_source).map(|bytes| (name, bytes))
        };
        let meshes = paths.meshes.into_iter().map(|(file, name, path)| named((name, path), file));
        let meshes = meshes.collect::<Result<_, _>>()?;
        let blades = paths.blades.into_iter().map(|file| named(file, NamedFile::Blade));
        let blades = blades.collect::<Result<_, _>>()?;
        let post = read(paths.post, NamedFile::Post)?;
        Ok(Self { surface, meshes, post, blades, beside: Vec::new() })
    }

    /// The same, with the files that the job was completed with.
    pub fn beside(self, beside: Vec<(String, Vec<u8>)>) -> Self {
        Self { beside, ..self }
    }

    /// Reads the files that a job names, relative to the job file.
    pub fn of_job(job_path: &Path, job: &Job, job_source: &[u8]) -> Result<Self, Fault> {
        Self::read(Paths::of_job(job_path, job), job_source)
    }

    /// The contents.
    pub fn files(&self) -> Files<'_> {
        Files {
            surface: self.surface.as_ref().map(|(_, bytes)| &bytes[..]),
            meshes: &self.meshes,
            post: self.post.as_ref().map(|(_, bytes)| &bytes[..]),
            beside: &self.beside,
            blades: &self.blades,
        }
    }
}

/// The bytes of a file that a job names, or why it cannot be read.
fn read_named(path: &Path, file: NamedFile, job_source: &[u8]) -> Result<Vec<u8>, Fault> {
    if !path.exists() {
        return Err(file.missing(shown(path), job_source));
    }
    // A pipe or a device may never end.
    if !path.is_file() {
        return Err(file.fault(format_args!("{} is no file", shown(path)), job_source));
    }
    let failed = |error| file.fault(format_args!("{}: {error}", shown(path)), job_source);
    std::fs::read(path).map_err(failed)
}
