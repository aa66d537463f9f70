//! Libraries of tools, and jobs that take each of their tools.

use crate::{Outcome, refused};
use evencut_core::job::{self, LibraryTool, ToolLibrary};

/// Most tools of a library that are taken.
const MOST: usize = 8;

/// A library of tools.
pub fn tools(bytes: &[u8]) -> Outcome {
    let library = match ToolLibrary::read(bytes) {
        Ok(library) => library,
        Err(error) => return refused(&error.to_string()),
    };
    assert!(!library.tools.is_empty());
    for tool in library.tools.iter().take(MOST) {
        let faults = tool.faults();
        assert!(faults.iter().all(|fault| !fault.trim().is_empty()));
        take(tool, bytes);
    }
    Outcome::Read
}

/// A job takes the tool, by its name or number.
fn take(tool: &LibraryTool, library: &[u8]) {
    let choice = match (tool.number(), tool.name()) {
        (Some(number), _) => format!("number = {number}"),
        (None, "") => String::new(),
        (None, name) => format!("name = {name:?}"),
    };
    let text = format!(
        "version = 1\n[surface.analytic]\nkind = \"plane\"\n[tool]\nlibrary = \"a.json\"\n{choice}\n\
         [cut]\nstepover = 0.001\nfeed = 100\naxial_depth = 0.001\n"
    );
    let read = |text: &str| job::read_with(text.as_bytes(), &mut |_, _| Ok(library.to_vec()));
    match read(&text) {
        Ok(resolved) => {
            let written = resolved.job.to_toml();
            let again = job::read(written.as_bytes())
                .unwrap_or_else(|f| panic!("{}\n{written}", f.render("job", written.as_bytes())));
            assert_eq!(written, again.job.to_toml());
        }
        Err(faults) => assert!(faults.render("job.toml", text.as_bytes()).contains("error: ")),
    }
}
