//! The `evencut` command.

use std::io::{IsTerminal, stderr, stdout};
use std::process::ExitCode;

use evencut_cli::{Streams, guarded, run};

fn main() -> ExitCode {
    let code = guarded(|| {
        let terminal = stderr().is_terminal();
        let colour = terminal && std::env::var_os("NO_COLOR").is_none();
        // Not `lock()`: the panic handler writes to standard error too.
        run(std::env::args_os(), Streams::new(&mut stdout(), &mut stderr(), colour))
    });
    ExitCode::from(code.code())
}
