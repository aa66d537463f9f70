//! `evencut post`: the post-processors that come along, as files to copy and change.

use std::path::PathBuf;

use clap::Args;
use evencut_core::job::PostSource;
use evencut_core::machine::Post as Builtin;
use evencut_output::post::Dialect;

use crate::plan::Failed;
use crate::{Exit, Streams};

/// Arguments of `evencut post`.
#[derive(Args)]
pub struct Post {
    /// Post-processor whose file is printed; without it, all names
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

impl Post {
    /// Prints the file of a post, or the names of all.
    pub fn run(&self, streams: &mut Streams<'_>) -> Exit {
        let Some(name) = &self.name else {
            Builtin::ALL.iter().for_each(|post| streams.data(&format!("{}\n", post.name())));
            return Exit::Done;
        };
        match named(name) {
            Ok(post) => {
                streams.data(Dialect::source(post));
                Exit::Done
            }
            Err(Failed(exit, message)) => {
                streams.message(&message);
                exit
            }
        }
    }
}

fn named(name: &str) -> Result<Builtin, Failed> {
    Builtin::ALL.into_iter().find(|post| post.name() == name).ok_or_else(|| {
        let known: Vec<&str> = Builtin::ALL.iter().map(|post| post.name()).collect();
        let message = format!(
            "error: there is no post {name:?}; there are {}, or give a post file (.toml)\n",
            known.join(", ")
        );
        Failed(Exit::BadJob, message)
    })
}

/// The post that was asked for, and path and content of its file if it is one.
pub(crate) type Chosen = (Option<PostSource>, Option<(PathBuf, Vec<u8>)>);

/// A post by its name, `none`, or by its file, relative to the current directory.
pub(crate) fn chosen(asked: &str) -> Result<Chosen, Failed> {
    if asked == "none" {
        return Ok((None, None));
    }
    if !asked.ends_with(".toml") {
        return Ok((Some(PostSource::Named(named(asked)?)), None));
    }
    let path = PathBuf::from(asked);
    let failed = |message: String| Failed::file(Exit::BadJob, message, &path);
    if path.exists() && !path.is_file() {
        return Err(failed("post: this is no file".to_owned()));
    }
    let bytes = std::fs::read(&path).map_err(|error| failed(format!("post: {error}")))?;
    Dialect::read(&bytes).map_err(|error| failed(error.to_string()))?;
    Ok((Some(PostSource::File(asked.to_owned())), Some((path, bytes))))
}
