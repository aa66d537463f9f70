//! The `evencut` command.

use std::io::{IsTerminal, stderr, stdout};
use std::process::ExitCode;

use evencut_cli::{Streams, guarded, output, run};

/// Exit code of an interrupted run, as shells report it.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    // Without a handler an interrupted run leaves a hidden directory; it is no reason not to run.
    let _ = ctrlc::set_handler(|| {
        let _until_the_end = output::remove_unfinished();
        std::process::exit(INTERRUPTED);
    });
    let code = guarded(|| {
        let terminal = stderr().is_terminal();
        let colour = terminal && std::env::var_os("NO_COLOR").is_none();
        // Not `lock()`: the panic handler writes to standard error too.
        run(std::env::args_os(), Streams::new(&mut stdout(), &mut stderr(), colour))
    });
    ExitCode::from(code.code())
}
