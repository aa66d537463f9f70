//! The `evencut` command: arguments → core → files, exit codes.
//!
//! Messages go to standard error, data to standard output. What the commands share is public, so that it can be
//! tested without starting a process.

pub mod check;
pub mod compare;
pub mod input;
pub mod inspect;
pub mod new;
pub mod output;
pub mod plan;
pub mod post;
pub mod progress;
pub mod streams;
pub mod texture;
pub mod tools;
pub mod verify;

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};

use clap::{Parser, Subcommand};

pub use evencut_service::failure::Exit;
pub use streams::Streams;

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  internal error, or output that cannot be written
  2  bad usage or bad job file
  3  unreadable or unusable surface
  4  no path: a limit cannot be kept, or the cutter does not fit
  5  planned and written, but the simulation found a limit broken
  130  interrupted; nothing is written, earlier results are unchanged

Messages go to standard error, data to standard output.";

#[derive(Parser)]
#[command(
    name = "evencut",
    version,
    about = "Plans milling paths for freeform surfaces with even cusps and an even cut",
    long_about = "Plans milling paths for freeform surfaces so that the cusps are even (scallop \
                  height at, and never above, a limit) and the cut is even (material removal \
                  rate, and so the cutting force, never above a limit).\n\n\
                  A job file in TOML says what to machine and how. The smallest one:\n\n    \
                  version = 1\n    [surface]\n    file = \"part.stl\"\n    [tool]\n    \
                  diameter = 10.0\n    [cut]\n    scallop = 0.01\n    feed = 1200.0",
    after_help = EXIT_CODES,
    arg_required_else_help = true
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Plan a job and write its results
    #[command(long_about = "Plans a job and writes its results: program, toolpath, pictures, \
                            report and the job with all defaults filled in. Results are written \
                            completely or not at all; a run that fails leaves earlier ones \
                            unchanged. Prints the report's summary.")]
    Plan(plan::Plan),
    /// Measure what a path leaves and removes
    #[command(
        long_about = "Simulates a path, made here or elsewhere, against the surface: scallop \
                            heights by slope, gouges, what no move reached, removal rate, rapids \
                            through stock, faults of the program. Independent of planning.\n\n    \
                            evencut verify results/mould --job jobs/mould.toml\n    \
                            evencut verify part.ngc --surface part.stl --tool ball:10 --scallop 0.01"
    )]
    Verify(verify::Verify),
    /// Plan a job with several patterns and print a table
    #[command(long_about = "Plans a job once for every pattern, checks every path by simulation \
                            and prints a table: passes, length on the surface in mm and as a \
                            multiple of the shortest possible, length of all moves at feed, time on \
                            the machine, computing time in s, largest and P99 residual, deepest \
                            gouge and heights of the cusps in µm, and whether every limit was kept. \
                            The removal rate is not limited.\n\n    \
                            evencut compare part.toml --patterns contour,iso-scallop,spiral")]
    Compare(compare::Compare),
    /// Simulate the texture that the teeth leave in a window
    #[command(
        long_about = "Plans a job and simulates what the teeth of its cutter leave in the window \
                            of its [texture] table: heights as CSV, ASCII matrix and X3P (ISO \
                            25178-72), a picture, and the parameters Sa, Sq, Sz, Ssk, Sku, Ra, Rz. \
                            The path is not verified.\n\n    \
                            evencut texture part.toml -o results/part-texture"
    )]
    Texture(texture::Texture),
    /// Write a commented job file for a surface
    #[command(long_about = "Writes a job file with values to start from: cutter, cusp height and \
                            feeds follow from the surface's size and curvature. Never \
                            overwrites a file.")]
    New(new::New),
    /// Show what a mesh file holds
    #[command(long_about = "Shows what a mesh file holds: pieces, boundary loops, size, smallest \
                            concave radius, directions of normals, repairs and faults.")]
    Inspect(inspect::Inspect),
    /// Check job files and show all their faults
    #[command(long_about = "Checks job files without planning them. All faults of a file are \
                            shown at once, each with its line, what was found and what is \
                            allowed. Also checks that the surface file is there.")]
    Check(check::Check),
    /// List the post-processors, or print one to copy and change
    #[command(
        long_about = "Lists the post-processors that come along, or prints the file of one, to be \
                            copied and changed. A job names its own with output.gcode.post_file, a \
                            run with --post.\n\n    \
                            evencut post fanuc > shop.post.toml\n    \
                            evencut plan part.toml --post shop.post.toml"
    )]
    Post(post::Post),
    /// List the tools of a library
    #[command(
        long_about = "Lists the tools of a library: evencut's own (toml), a tool bit of FreeCAD (fctb) or a library \
                            of Fusion (json), lengths in mm; then those that cannot be used, and why. A job takes its \
                            tool from a library with\n\n    \
                            [tool]\n    library = \"shop.tools.toml\"\n    number = 7"
    )]
    Tools(tools::Tools),
    /// Print the JSON Schema of the job file
    #[command(long_about = "Prints the JSON Schema (draft 2020-12) of the job file, with which \
                            editors complete and check job files.\n\n    \
                            evencut schema > evencut.schema.json\n\n\
                            In editors with the Taplo or Even Better TOML extension, name it in \
                            the first line of a job file:\n\n    #:schema evencut.schema.json")]
    Schema,
}

/// Runs the command with the given arguments, the first of which is the program's name.
pub fn run(arguments: impl IntoIterator<Item = OsString>, mut streams: Streams<'_>) -> Exit {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => return usage(&error, &mut streams),
    };
    let exit = match arguments.command {
        Command::Plan(plan) => plan.run(&mut streams),
        Command::Compare(compare) => compare.run(&mut streams),
        Command::Verify(verify) => verify.run(&mut streams),
        Command::Texture(texture) => texture.run(&mut streams),
        Command::New(new) => new.run(&mut streams),
        Command::Inspect(inspect) => inspect.run(&mut streams),
        Command::Check(check) => check.run(&mut streams),
        Command::Post(post) => post.run(&mut streams),
        Command::Tools(tools) => tools.run(&mut streams),
        Command::Schema => {
            streams.data(&evencut_core::job::schema());
            Exit::Done
        }
    };
    streams.finish(exit)
}

/// Help and version are data; every other output of clap is a usage error.
fn usage(error: &clap::Error, streams: &mut Streams<'_>) -> Exit {
    let text = error.render().to_string();
    if error.use_stderr() {
        streams.message(&text);
        return Exit::BadJob;
    }
    streams.data(&text);
    streams.finish(Exit::Done)
}

/// Runs `command`; a panic becomes a message that asks for a bug report, and [`Exit::Internal`].
pub fn guarded(command: impl FnOnce() -> Exit) -> Exit {
    std::panic::set_hook(Box::new(|panic| {
        use std::io::Write;
        let text = format!(
            "internal error: {panic}\nThis is a bug in evencut {}. Please report it with the job \
             file and the surface file.\n",
            env!("CARGO_PKG_VERSION")
        );
        // Where standard error is closed there is nobody to tell.
        let _ = std::io::stderr().write_all(text.as_bytes());
    }));
    catch_unwind(AssertUnwindSafe(command)).unwrap_or(Exit::Internal)
}
