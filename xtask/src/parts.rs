//! `cargo xtask parts`: writes docs/parts.md, every shared surface file through `evencut new` and `evencut plan`.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::accept::commit;
use crate::test::{cargo, native, run, target_folder};

const PATH: &str = "docs/parts.md";
/// Folders of files, and endings that are surfaces of their own: copies of the same surface as coarser or finer meshes
/// are left out.
const FOLDERS: [(&str, &[&str]); 3] =
    [("mesh", &["stl", "obj", "ply", "off"]), ("nurbs", &["json"]), ("step", &["step", "stp"])];
/// A plan that takes longer is ended.
const LONGEST: Duration = Duration::from_secs(150);
/// How often the memory of a plan is looked at.
const LOOK: Duration = Duration::from_millis(50);
/// Characters of a message that are shown.
const SHOWN: usize = 180;
const HEAD: &str = "\
# Every shared file through `evencut new` and `evencut plan`

Written by `cargo xtask parts` where `../shared/data` is present: real meshes, NURBS surfaces and STEP bodies, each with \
the job that `evencut new` writes for it, unchanged, and judged by the simulation. Failures are in the table; files that \
are missing at its end were not reached before the run was ended.

- *exit*: 0 all limits kept; 5 planned, but the simulation found a limit broken; 3 and 4 refused.
- *s*, *MB*: wall time and largest memory of `evencut plan` with its judge, on a machine that does other work too.
- *largest*: highest place that is left on what the cutter reaches, over limit and tolerance together; *gouge*: deepest \
cut into the part, over the tolerance. Above 1 is broken.
- *rest*: area that stays too high because the cutter does not fit there, of the surface that is machined.
- *aside*: area of the selection that is not machined from this side: faces away, too steep, in shadow.
- */ floor*: length of the passes over the length that none can go below.
";
const TABLE: &str = "\
| file | exit | s | MB | cutter | largest | gouge | rest | aside | m | / floor |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|
";

/// Plans every shared file, or those whose name contains `only`, and writes the table; of some it is only printed.
pub fn parts(project: &Path, only: Option<&str>) -> Result<(), String> {
    let data = project.join("../shared/data");
    if !data.is_dir() {
        println!("skipped: there is no ../shared/data");
        return Ok(());
    }
    run(cargo(project).args(["build", "--release", "--package", "evencut-cli"]))?;
    let work = target_folder(project).join("parts");
    let _ = std::fs::remove_dir_all(&work);
    std::fs::create_dir_all(&work).map_err(|e| format!("{}: {e}", work.display()))?;
    let (mut text, mut notes) = (format!("{HEAD}\n{}\n\n{TABLE}", commit(project)?), String::new());
    for file in files(&data)? {
        let name = file.strip_prefix(&data).unwrap_or(&file).to_string_lossy().into_owned();
        if only.is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let Row { cells, note } = part(&native(project, "release"), &work, &file);
        let row = format!("| {name} | {} |", cells.join(" | "));
        println!("{row} {note}");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{row}");
        if !note.is_empty() {
            let _ = writeln!(notes, "- {name}: {note}");
        }
        if only.is_none() {
            let said = if notes.is_empty() {
                "Nothing was refused, and no limit broken.\n"
            } else {
                &notes
            };
            let all = format!("{text}\n## What was said\n\n{said}");
            let path = project.join(PATH);
            std::fs::write(&path, all).map_err(|e| format!("{}: {e}", path.display()))?;
        }
    }
    Ok(())
}

fn files(data: &Path) -> Result<Vec<PathBuf>, String> {
    let mut all = Vec::new();
    for (folder, endings) in FOLDERS {
        let folder = data.join(folder);
        let entries =
            std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let is_surface = |path: &PathBuf| {
            path.extension()
                .is_some_and(|e| endings.iter().any(|known| e.eq_ignore_ascii_case(known)))
        };
        let mut of: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(is_surface).collect();
        of.sort();
        all.append(&mut of);
    }
    Ok(all)
}

/// The cells of a file's row after its name, and what was said.
struct Row {
    cells: Vec<String>,
    note: String,
}

impl Row {
    fn failed(exit: &str, seconds: f64, memory: u64, note: String) -> Self {
        let mut cells = vec![exit.to_owned(), format!("{seconds:.1}"), memory.to_string()];
        cells.resize(10, String::new());
        Self { cells, note }
    }
}

fn part(command: &Path, work: &Path, file: &Path) -> Row {
    let job = work.join(file.file_name().unwrap_or_default()).with_added_extension("toml");
    let new = Command::new(command).arg("new").arg(file).arg("-o").arg(&job).output();
    match new {
        Ok(output) if output.status.success() => {}
        Ok(output) => {
            let exit = output.status.code().map_or("killed".to_owned(), |c| c.to_string());
            return Row::failed(&format!("{exit} (new)"), 0.0, 0, said(&output.stderr));
        }
        Err(error) => return Row::failed("", 0.0, 0, error.to_string()),
    }
    let results = work.join("results").join(job.file_stem().unwrap_or_default());
    let messages = work.join("messages");
    let mut plan = Command::new(command);
    plan.arg("plan").arg(&job).arg("--quiet").current_dir(work).stdout(Stdio::null());
    match std::fs::File::create(&messages) {
        Ok(file) => plan.stderr(file),
        Err(error) => return Row::failed("", 0.0, 0, error.to_string()),
    };
    let began = Instant::now();
    let (exit, memory) = match plan.spawn() {
        Ok(child) => watched(child, began, LONGEST),
        Err(error) => return Row::failed("", 0.0, 0, error.to_string()),
    };
    let seconds = began.elapsed().as_secs_f64();
    let message = said(&std::fs::read(&messages).unwrap_or_default());
    let report = std::fs::read(results.join("report.json")).unwrap_or_default();
    let Some(exit) = exit else {
        return Row::failed(
            "none",
            seconds,
            memory,
            format!("ended after {} s", LONGEST.as_secs()),
        );
    };
    match serde_json::from_slice::<Value>(&report) {
        Ok(report) => {
            let cells = [exit.to_string(), format!("{seconds:.1}"), memory.to_string()];
            let cells = cells.into_iter().chain(figures(&report)).collect();
            Row { cells, note: message }
        }
        Err(_) => Row::failed(&exit.to_string(), seconds, memory, message),
    }
}

/// Waits for a plan, at most `longest`: its exit code, and the largest memory that the system tells of it, MB.
pub fn watched(mut child: Child, began: Instant, longest: Duration) -> (Option<i32>, u64) {
    let status = format!("/proc/{}/status", child.id());
    let mut memory = 0;
    loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let peak = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
        let peak = peak.and_then(|l| l.trim().trim_end_matches(" kB").parse::<u64>().ok());
        memory = peak.unwrap_or(0).max(memory);
        match child.try_wait() {
            Ok(Some(status)) => return (status.code(), memory / 1024),
            Ok(None) if began.elapsed() < longest => std::thread::sleep(LOOK),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return (None, memory / 1024);
            }
        }
    }
}

/// The error in a command's messages, shortened.
fn said(messages: &[u8]) -> String {
    let text = String::from_utf8_lossy(messages);
    let error = text.lines().find_map(|line| line.strip_prefix("error: ")).unwrap_or_default();
    let mut shown: String = error.chars().take(SHOWN).collect();
    if shown.len() < error.len() {
        shown.push('…');
    }
    shown.replace('|', "/")
}

/// The figures of a report.
fn figures(report: &Value) -> [String; 7] {
    let at = |path: &str| report.pointer(path).and_then(Value::as_f64);
    let percent = |part: Option<f64>, of: Option<f64>| {
        let share = part.zip(of).map(|(part, of)| 100.0 * part / of);
        share.map_or_else(String::new, |share| format!("{share:.2} %"))
    };
    let tolerance = at("/verification/scallop/tolerance_mm");
    let ratio = |value: Option<f64>, of: Option<f64>, digits: usize| {
        let ratio = value.zip(of).map(|(value, of)| value / of);
        ratio.map_or_else(String::new, |ratio| format!("{ratio:.digits$}"))
    };
    let limit = at("/verification/scallop/limit_mm").zip(tolerance).map(|(a, b)| a + b);
    let aside = ["away", "steep", "shadowed", "small"];
    let aside = aside.iter().filter_map(|c| at(&format!("/surface/set_aside/{c}_mm2")));
    let selected = at("/surface/set_aside/selected_mm2");
    [
        ratio(at("/stepover/nominal_mm").map(|step| 2.0 * step), at("/stepover/over_radius"), 1),
        ratio(at("/verification/scallop/largest_mm"), limit, 2),
        ratio(at("/verification/gouge_mm").map(|low| -low), tolerance, 2),
        percent(at("/verification/rest_mm2"), at("/surface/area_mm2")),
        percent(selected.map(|_| aside.sum()), selected),
        at("/passes/length_mm").map_or_else(String::new, |mm| format!("{:.1}", 1e-3 * mm)),
        ratio(at("/passes/length_over_floor"), Some(1.0), 2),
    ]
}
