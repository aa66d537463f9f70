//! `evencut new`: a commented job file for a surface.

use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use clap::Args;

use crate::inspect::contents;
use crate::{Exit, Streams, input};

/// Arguments of `evencut new`.
#[derive(Args)]
pub struct New {
    /// Mesh file: stl, obj, ply or off; a NURBS surface: json; or CAD faces: step, stp
    #[arg(value_name = "SURFACE")]
    surface: PathBuf,
    /// Job file to write [default: the surface's name with .toml, in the current directory]
    #[arg(short, long, value_name = "JOB")]
    output: Option<PathBuf>,
}

impl New {
    /// Writes the job file; an existing one is not overwritten.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        let surface = input::shown(&self.surface);
        let contents = match contents(&self.surface, 1.0) {
            Ok(contents) => contents,
            Err(message) => {
                streams.message(&format!("error: {message}\n --> {surface}\n"));
                return Exit::BadSurface;
            }
        };
        let job = self.job();
        let text = relative(&self.surface, &job).map(|name| contents.job(&name));
        if let Err(error) = text.and_then(|text| write(&job, &text)) {
            let hint = match error.kind() {
                io::ErrorKind::AlreadyExists => "\n = not overwritten; give another name with -o",
                _ => "",
            };
            streams.message(&format!("error: {error}\n --> {}{hint}\n", input::shown(&job)));
            return Exit::BadJob;
        }
        for doubt in contents.doubts() {
            streams.message(&format!("warning: {doubt}\n"));
        }
        streams.message(&format!(
            "job in {job}; next: evencut plan {job}\n",
            job = input::shown(&job)
        ));
        Exit::Done
    }

    fn job(&self) -> PathBuf {
        let name =
            || Path::new(self.surface.file_stem().unwrap_or_default()).with_extension("toml");
        self.output.clone().unwrap_or_else(name)
    }
}

/// Writes a file that must not exist yet.
fn write(path: &Path, text: &str) -> io::Result<()> {
    std::fs::File::create_new(path)?.write_all(text.as_bytes())
}

/// The path of `file` as written in the job file `job`: relative to the job's directory, with `/`.
fn relative(file: &Path, job: &Path) -> io::Result<String> {
    let directory = match job.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let (file, directory) = (file.canonicalize()?, directory.canonicalize()?);
    let (to, from): (Vec<_>, Vec<_>) =
        (file.components().collect(), directory.components().collect());
    let shared = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    let names = up.chain(to[shared..].iter().copied());
    Ok(names.map(|c| c.as_os_str().to_string_lossy().into_owned()).collect::<Vec<_>>().join("/"))
}
