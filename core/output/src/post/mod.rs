//! [`Toolpath`] → [`Program`]: a post-processor is data, the renderer is shared.
//!
//! | file | what |
//! |---|---|
//! | `dialect` | a post's file: what differs between controllers; those that come along are in `core/posts` |
//! | `keys` | keys of a file, with the line of what is wrong |
//! | `blocks` | lines of a program: `{name}`s filled in, numbers formatted, unchanged words left out |
//! | `render` | points → blocks |

mod blocks;
mod dialect;
mod error;
mod keys;
mod program;
mod render;
mod runs;

pub use dialect::Dialect;
pub use error::{DialectError, PostError};
pub use keys::KeysError;
pub use program::{OperationProgram, Program, ProgramOptions};

use evencut_core::machine::{Axes, Setup};
use evencut_core::toolpath::Toolpath;

/// Writes a path as a program.
///
/// Three-axis programs give the tip and feed per minute. Five-axis ones give what the post asks for: positions of the
/// machine's axes, or the tip in the workpiece with tool centre control on; the tool
/// axis by the positions of the rotary axes or by its direction. Moves are split until what the controller makes of them stays
/// within half the tolerance of the path; the feed holds at the contact, by inverse time or by the speed of the tip in
/// each block.
///
/// # Errors
/// [`PostError`]; nothing is written that would rapid below the rapid plane or feed at no speed.
pub fn program(
    path: &Toolpath,
    options: &ProgramOptions,
    dialect: &Dialect,
) -> Result<Program, PostError> {
    check(dialect, &options.machine.axes, &options.setup)?;
    render::render(path, options, dialect)
}

/// Writes operations in their order as one program, with a change of the tool between them.
///
/// # Errors
/// As [`program`]. Whether the post knows a change of tools says [`Dialect::changes_tools`].
pub fn program_of_operations(
    operations: &[OperationProgram],
    dialect: &Dialect,
) -> Result<Program, PostError> {
    for OperationProgram { options, .. } in operations {
        check(dialect, &options.machine.axes, &options.setup)?;
    }
    render::render_all(operations, dialect)
}

/// Whether a post can write programs for such a machine with such a setup.
///
/// # Errors
/// [`DialectError`]: no such axes or words for them, coolant or work offset.
pub fn check(dialect: &Dialect, axes: &Axes, setup: &Setup) -> Result<(), DialectError> {
    dialect.program(axes)?;
    dialect.rotary_words(axes)?;
    dialect.coolant(setup.coolant)?;
    dialect.work_offset(setup.work_offset)?;
    dialect.arcs(axes, setup.arcs)?;
    Ok(())
}
