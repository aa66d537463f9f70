//! `cargo xtask page`: the page as one static folder.
//!
//! Steps: (1) npm packages as the lock file pins them; (2) the planner as a WebAssembly module with
//! its bindings, optimised; (3) scripts bundled; (4) plain files, examples; (5) the weights.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use wasm_bindgen_cli_support::Bindgen;

use crate::test::{WASM, cargo, install_target, jobs, run, target_folder};

/// Where the page is built, within the project.
const FOLDER: &str = "web/dist";
/// Plain files that are copied.
const PLAIN: [&str; 2] = ["index.html", "icon.svg"];
/// What a browser loads before somebody asks for an example, three dimensions or a zip.
const FIRST_LOAD: [&str; 7] = [
    "index.html",
    "style.css",
    "icon.svg",
    "main.js",
    "worker.js",
    "evencut.wasm",
    "examples.json",
];
/// Most that the first load may weigh, compressed, bytes. 1.5 million are wanted; the planner of hubs and the
/// simulation of textures are in it, until they are loaded when a job asks for them.
const MOST: usize = 1_600_000;

/// Builds the page; returns its folder.
pub fn page(project: &Path) -> Result<PathBuf, String> {
    install_packages(project)?;
    let folder = project.join(FOLDER);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    module(project, &folder)?;
    scripts(project, &folder)?;
    style(project, &folder)?;
    for name in PLAIN {
        copy(&project.join("web/page").join(name), &folder.join(name))?;
    }
    examples(project, &folder)?;
    weigh(project, &folder)?;
    Ok(folder)
}

/// Installs the npm packages, unless they are there as the lock file says.
pub fn install_packages(project: &Path) -> Result<(), String> {
    let web = project.join("web");
    let lock = read(&web.join("package-lock.json"))?;
    let mark = web.join("node_modules/.evencut-lock");
    if std::fs::read(&mark).is_ok_and(|installed| installed == lock) {
        return Ok(());
    }
    run(Command::new("npm").args(["ci", "--no-audit", "--no-fund"]).current_dir(&web))
        .map_err(|e| format!("{e}; the page needs node (20 or newer) with npm"))?;
    write(&mark, &lock)
}

/// The planner's module and its bindings.
fn module(project: &Path, folder: &Path) -> Result<(), String> {
    install_target(project)?;
    let build = ["build", "--package", "evencut-web", "--profile", "page", "--target", WASM];
    run(cargo(project).args(build))?;
    let target = target_folder(project);
    let bindings = target.join("page-bindings");
    let compiled = target.join(WASM).join("page/evencut_web.wasm");
    let small = bindings.join("small.wasm");
    // Both take a minute, and are done already after the tests' own start.
    let (done, bytes) = (bindings.join("made-from.wasm"), read(&compiled)?);
    if !(small.is_file() && std::fs::read(&done).is_ok_and(|from| from == bytes)) {
        Bindgen::new()
            .input_path(&compiled)
            .web(true)
            .and_then(|bindgen| bindgen.typescript(false).generate(&bindings))
            .map_err(|e| format!("wasm-bindgen: {e}"))?;
        optimise(project, &bindings.join("evencut_web_bg.wasm"), &small)?;
        write(&done, &bytes)?;
    }
    copy(&small, &folder.join("evencut.wasm"))
}

/// Optimises a module.
fn optimise(project: &Path, plain: &Path, small: &Path) -> Result<(), String> {
    let optimise = project.join("web/node_modules/binaryen/bin/wasm-opt");
    let mut node = Command::new("node");
    node.arg(optimise)
        .args(["-O1", "--enable-simd", "--enable-bulk-memory", "--enable-bulk-memory-opt"])
        .args(["--enable-nontrapping-float-to-int", "--enable-sign-ext"])
        .args(["--enable-mutable-globals", "--enable-reference-types", "--enable-multivalue"])
        // Code that generic functions have in common is there once: 35 kB less to load.
        .args(["--merge-similar-functions", "--vacuum", "--reorder-functions"])
        .arg("--strip-debug")
        .arg(plain)
        .arg("-o")
        .arg(small);
    run(&mut node)
}

/// The page's scripts, each with what it imports; what is loaded later is cut off.
fn scripts(project: &Path, folder: &Path) -> Result<(), String> {
    let bindings = target_folder(project).join("page-bindings/evencut_web.js");
    let mut esbuild = esbuild(project);
    esbuild
        .args(["page/src/main.js", "page/src/worker.js"])
        .args(["--bundle", "--minify", "--format=esm", "--splitting", "--target=es2022"])
        .args(["--charset=utf8", "--legal-comments=eof", "--log-level=warning"])
        .arg(format!("--alias:evencut-module={}", bindings.display()))
        .arg(format!("--outdir={}", folder.display()));
    run(&mut esbuild)
}

/// The style sheet, without comments and blanks.
fn style(project: &Path, folder: &Path) -> Result<(), String> {
    let mut esbuild = esbuild(project);
    esbuild
        .args([
            "page/style.css",
            "--minify",
            "--target=es2022",
            "--charset=utf8",
            "--log-level=warning",
        ])
        .arg(format!("--outfile={}", folder.join("style.css").display()));
    run(&mut esbuild)
}

fn esbuild(project: &Path) -> Command {
    let mut command = Command::new(project.join("web/node_modules/.bin/esbuild"));
    command.current_dir(project.join("web"));
    command
}

/// The jobs with their surfaces, and the list that fills the menu.
fn examples(project: &Path, folder: &Path) -> Result<(), String> {
    let mut list = Vec::new();
    for job in jobs(project)? {
        let text = String::from_utf8_lossy(&read(&project.join(&job))?).into_owned();
        let resolved = evencut_core::job::read(text.as_bytes())
            .map_err(|faults| faults.render(&job.display().to_string(), text.as_bytes()))?;
        // The page plans a single operation.
        if !resolved.operations.is_empty() {
            continue;
        }
        let stem = job.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut files = vec![job.strip_prefix("jobs").unwrap_or(&job).to_owned()];
        if let evencut_core::job::SurfaceSource::File(file) = &resolved.job.surface.source {
            files.push(file.into());
        }
        let job_files =
            resolved.job.blade_files().into_iter().map(PathBuf::from).collect::<Vec<_>>();
        files.extend(job_files);
        files.extend(resolved.job.mesh_files().map(PathBuf::from));
        for file in &files {
            copy(&project.join("jobs").join(file), &folder.join("examples").join(file))?;
        }
        let files: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        let about = about(&text);
        list.push(serde_json::json!({
            "id": stem, "name": resolved.job.name, "about": about, "files": files,
        }));
    }
    write(&folder.join("examples.json"), serde_json::Value::from(list).to_string().as_bytes())
}

/// The comment that a job opens with.
fn about(job: &str) -> String {
    let lines = job.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
    lines.collect::<Vec<_>>().join(" ")
}

/// Prints what the files weigh, and refuses a first load that is too heavy.
fn weigh(project: &Path, folder: &Path) -> Result<(), String> {
    let mut names = Vec::new();
    list(folder, Path::new(""), &mut names)?;
    names.sort();
    let first: Vec<&PathBuf> = names.iter().filter(|name| is_first(name, folder)).collect();
    println!("{:<34}{:>11}{:>11}{:>11}", "page, bytes", "plain", "gzip", "brotli");
    let mut sums = [0; 3];
    for name in &names {
        let weights = weights(project, &folder.join(name))?;
        let mark = if first.contains(&name) { "*" } else { "" };
        let name = format!("{}{mark}", name.display());
        println!("{name:<34}{:>11}{:>11}{:>11}", weights[0], weights[1], weights[2]);
        if mark == "*" {
            sums.iter_mut().zip(weights).for_each(|(sum, w)| *sum += w);
        }
    }
    println!("{:<34}{:>11}{:>11}{:>11}", "* first load", sums[0], sums[1], sums[2]);
    println!("page in {}", folder.display());
    match sums[1] {
        ..=MOST => Ok(()),
        gzip => Err(format!("page: the first load is {gzip} bytes with gzip; at most {MOST}")),
    }
}

/// Whether a file is part of the first load: chunks are, where the first scripts import them.
fn is_first(name: &Path, folder: &Path) -> bool {
    let text = name.to_string_lossy();
    if FIRST_LOAD.contains(&&*text) {
        return true;
    }
    let imported = |script: &str| {
        let source = std::fs::read_to_string(folder.join(script)).unwrap_or_default();
        source.contains(&format!("from\"./{text}\""))
            || source.contains(&format!("import\"./{text}\""))
    };
    imported("main.js") || imported("worker.js")
}

/// Bytes plain, with gzip and with brotli, as node compresses them.
fn weights(project: &Path, file: &Path) -> Result<[usize; 3], String> {
    const SCRIPT: &str = "const z = require('zlib'); const b = require('fs').readFileSync(0);\
        console.log(b.length, z.gzipSync(b, { level: 9 }).length, z.brotliCompressSync(b).length)";
    let mut node = Command::new("node");
    let mut child = node
        .args(["-e", SCRIPT])
        .current_dir(project)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| format!("node: {e}"))?;
    let bytes = read(file)?;
    if let Some(mut stdin) = child.stdin.take() {
        stdin.write_all(&bytes).map_err(|e| format!("node: {e}"))?;
    }
    let output = child.wait_with_output().map_err(|e| format!("node: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<usize> = text.split_whitespace().filter_map(|n| n.parse().ok()).collect();
    <[usize; 3]>::try_from(numbers).map_err(|_| format!("node: {text:?} are not three numbers"))
}

fn list(folder: &Path, under: &Path, names: &mut Vec<PathBuf>) -> Result<(), String> {
    let here = folder.join(under);
    for entry in std::fs::read_dir(&here).map_err(|e| format!("{}: {e}", here.display()))? {
        let entry = entry.map_err(|e| e.to_string())?;
        let name = under.join(entry.file_name());
        if entry.path().is_dir() { list(folder, &name, names)? } else { names.push(name) }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    std::fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    if let Some(parent) = to.parent() {
        std::fs::create_dir_all(parent).map_err(|e| format!("{}: {e}", parent.display()))?;
    }
    std::fs::copy(from, to).map(|_| ()).map_err(|e| format!("{}: {e}", from.display()))
}
