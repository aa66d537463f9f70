//! Project tasks: `cargo xtask test` runs all tests but the long ones of `cargo xtask accept`, `cargo xtask fuzz` looks for
//! inputs that readers fall over, `cargo xtask page` builds the page for the browser, `cargo xtask serve` shows it, `cargo
//! xtask patterns` compares the patterns, `cargo xtask parts` plans every shared file, `cargo xtask growth` ever finer meshes
//! and ever lower limits, `cargo xtask texture` simulates the textures of two tilts, `cargo xtask surfaces` writes the surfaces
//! that `jobs/` machines.

mod accept;
mod fuzz;
mod growth;
mod mesh_file;
mod page;
mod parts;
mod patterns;
mod serve;
mod surfaces;
mod test;
mod texture;
mod triangulate;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask test        runs the tests, natively and of the page
       cargo xtask accept      runs the tests that last long and writes docs/ledger.md, asked and measured figures
       cargo xtask test page   runs the tests of the page only
       cargo xtask test parity compares native with WebAssembly in node, as the page's tests do in a browser
       cargo xtask fuzz [READER [SECONDS]]  looks for inputs that a reader falls over, 60 s each unless told
       cargo xtask page        builds the page for the browser into web/dist
       cargo xtask serve [PORT]  builds it and serves it on this machine, port 8080 unless given
       cargo xtask speed       plans all jobs in the page and natively, and compares the times
       cargo xtask patterns    writes docs/patterns.md, every pattern on every surface
       cargo xtask parts [NAME] writes docs/parts.md, every shared file through `evencut new` and `evencut plan`
       cargo xtask growth      writes docs/growth.md, time and memory with ever more faces and ever lower limits
       cargo xtask texture     writes table and picture of docs/texture.md
       cargo xtask surfaces    writes jobs/surfaces/*";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["test"] => report(test::test(&project())),
        ["test", "page"] => report(test::page(&project())),
        ["test", "parity"] => report(test::parity(&project())),
        ["fuzz"] => report(fuzz::fuzz(&project(), None, None)),
        ["fuzz", target] => report(fuzz::fuzz(&project(), Some(target), None)),
        ["fuzz", target, seconds] => report(fuzz::fuzz(&project(), Some(target), Some(seconds))),
        ["accept"] => report(accept::accept(&project())),
        ["page"] => report(page::page(&project()).map(|_| ())),
        ["serve"] => report(serve("8080")),
        ["serve", port] => report(serve(port)),
        ["speed"] => report(test::speed(&project())),
        ["patterns"] => report(patterns::patterns(&project())),
        ["parts"] => report(parts::parts(&project(), None)),
        ["parts", only] => report(parts::parts(&project(), Some(only))),
        ["growth"] => report(growth::growth(&project())),
        ["texture"] => report(texture::texture(&project())),
        ["surfaces"] => report(write_surfaces(&surfaces_folder())),
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn report(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn serve(port: &str) -> Result<(), String> {
    let port = port.parse().map_err(|_| format!("{port:?} is no port; give a number"))?;
    let folder = page::page(&project())?;
    let (listener, address) = serve::listen(port)?;
    println!("{address}");
    serve::serve(&folder, &listener);
    Ok(())
}

fn project() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

fn surfaces_folder() -> PathBuf {
    project().join("jobs/surfaces")
}

fn write_surfaces(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, bytes) in surfaces::all()? {
        let path = folder.join(name);
        std::fs::write(&path, &bytes).map_err(|e| format!("{}: {e}", path.display()))?;
        println!("{name}: {} bytes", bytes.len());
    }
    Ok(())
}
