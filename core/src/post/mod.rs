//! [`Toolpath`] → [`Program`]: a dialect is data, the renderer is shared.
//!
//! | file | what |
//! |---|---|
//! | `dialect` | what differs between controllers |
//! | `linuxcnc` | that of LinuxCNC |
//! | `render` | blocks, modal words, feeds |

mod dialect;
mod error;
mod linuxcnc;
mod program;
mod render;

pub use error::PostError;
pub use program::{Program, ProgramOptions};

use crate::machine::Post;
use crate::toolpath::Toolpath;

/// Writes a path as a program.
///
/// Three-axis programs give the tip and feed per minute; five-axis ones the position of the tip in the
/// turned table (rotary centre at program zero) and inverse time, so that the feed holds at the
/// contact; rotary moves are split until the tip stays within half the tolerance of the straight line.
///
/// # Errors
/// [`PostError`]; nothing is written that would rapid below the rapid plane or feed at no speed.
pub fn program(path: &Toolpath, options: &ProgramOptions) -> Result<Program, PostError> {
    let dialect = match options.post {
        Post::LinuxCnc => &linuxcnc::DIALECT,
    };
    render::render(path, options, dialect)
}
