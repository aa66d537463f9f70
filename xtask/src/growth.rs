//! `cargo xtask growth`: writes docs/growth.md, time and memory of plans of ever finer meshes and ever lower limits.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use evencut_core::geometry::{DVec3, math};
use evencut_core::mesh::TriangleSoup;
use serde_json::Value;

use crate::accept::commit;
use crate::mesh_file;
use crate::parts::watched;
use crate::test::{cargo, native, run, target_folder};

const PATH: &str = "docs/growth.md";
/// Quads along a side of the meshes, two faces each.
const SIDES: [usize; 6] = [50, 100, 200, 400, 775, 1581];
/// The mesh that the limits are planned on.
const MIDDLE: usize = 775;
/// Scallop limits, mm.
const LIMITS: [f64; 5] = [0.1, 0.03, 0.01, 0.003, 0.001];
/// Half the side of the square, mm.
const HALF: f64 = 50.0;
/// A plan that takes longer is ended.
const LONGEST: Duration = Duration::from_secs(900);
const HEAD: &str = "\
# Growth with faces and limits

Written by `cargo xtask growth`: a square of 100 mm with a saddle, a bump and ripples, meshed finer and finer, with the job \
that `evencut new` writes for it; then one of its meshes with lower and lower limits of the scallop, the tolerance a tenth of \
them. Wall time and largest memory are of `evencut plan` with its judge. *Exponent*: of \
time and memory from the row above to this one, against the number of faces, or against one over the limit.
";
const COLUMNS: &str =
    "exit | s | exponent | MB | exponent | m | largest |\n|--:|--:|--:|--:|--:|--:|--:|--:|\n";

/// Plans all and writes the tables.
pub fn growth(project: &Path) -> Result<(), String> {
    run(cargo(project).args(["build", "--release", "--package", "evencut-cli"]))?;
    let work = target_folder(project).join("growth");
    let _ = std::fs::remove_dir_all(&work);
    std::fs::create_dir_all(&work).map_err(|e| format!("{}: {e}", work.display()))?;
    let command = native(project, "release");
    let mut text = format!("{HEAD}\n{}\n\n| faces | {COLUMNS}", commit(project)?);
    let mut above = None;
    for side in SIDES {
        let row = Row::of(&command, &work, side, None)?;
        add(&mut text, &row.cells(&format!("{}", 2 * side * side), above.as_ref()));
        above = Some(row);
    }
    let _ = write!(text, "\nThe mesh of {} faces:\n\n| limit, um | {COLUMNS}", 2 * MIDDLE * MIDDLE);
    let mut above = None;
    for limit in LIMITS {
        let row = Row::of(&command, &work, MIDDLE, Some(limit))?;
        add(&mut text, &row.cells(&format!("{:.0}", 1e3 * limit), above.as_ref()));
        above = Some(row);
    }
    let path = project.join(PATH);
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}

fn add(text: &mut String, row: &str) {
    println!("{row}");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{row}");
}

/// A plan.
struct Row {
    /// What it grows with.
    size: f64,
    exit: String,
    seconds: f64,
    megabytes: u64,
    report: Value,
}

impl Row {
    fn of(command: &Path, work: &Path, side: usize, limit: Option<f64>) -> Result<Self, String> {
        let mesh = work.join("square.ply");
        std::fs::write(&mesh, mesh_file::ply(&square(side)))
            .map_err(|e| format!("{}: {e}", mesh.display()))?;
        let job = work.join("square.toml");
        let _ = std::fs::remove_file(&job);
        run(Command::new(command).arg("new").arg(&mesh).arg("-o").arg(&job))?;
        if let Some(limit) = limit {
            set(&job, &[("scallop", limit), ("tolerance", 0.1 * limit)])?;
        }
        let results = work.join("results/square");
        let _ = std::fs::remove_dir_all(&results);
        let mut plan = Command::new(command);
        plan.arg("plan").arg(&job).arg("--quiet").arg("-o").arg(&results);
        let began = Instant::now();
        let child = plan.stdout(Stdio::null()).spawn().map_err(|e| e.to_string())?;
        let (exit, megabytes) = watched(child, began, LONGEST);
        let seconds = began.elapsed().as_secs_f64();
        let report = std::fs::read(results.join("report.json")).unwrap_or_default();
        Ok(Self {
            size: limit.map_or((2 * side * side) as f64, |limit| 1.0 / limit),
            exit: exit.map_or_else(|| "none".to_owned(), |exit| exit.to_string()),
            seconds,
            megabytes,
            report: serde_json::from_slice(&report).unwrap_or_default(),
        })
    }

    fn cells(&self, name: &str, above: Option<&Self>) -> String {
        let exponent = |of: fn(&Self) -> f64| {
            let grown =
                |above: &Self| math::ln(of(self) / of(above)) / math::ln(self.size / above.size);
            above.map_or_else(String::new, |above| format!("{:.2}", grown(above)))
        };
        let at = |path: &str| self.report.pointer(path).and_then(Value::as_f64);
        let limit =
            at("/verification/scallop/limit_mm").zip(at("/verification/scallop/tolerance_mm"));
        let largest = at("/verification/scallop/largest_mm").zip(limit);
        let largest = largest.map_or_else(String::new, |(mm, (limit, tolerance))| {
            format!("{:.2} of {:.1} + {:.1} um", 1e3 * mm, 1e3 * limit, 1e3 * tolerance)
        });
        let length =
            at("/passes/length_mm").map_or_else(String::new, |mm| format!("{:.1}", 1e-3 * mm));
        let (time, memory) = (exponent(|row| row.seconds), exponent(|row| row.megabytes as f64));
        let Self { exit, seconds, megabytes, .. } = self;
        format!(
            "| {name} | {exit} | {seconds:.1} | {time} | {megabytes} | {memory} | {length} | {largest} |"
        )
    }
}

/// Gives keys of a job file, each on a line of its own, other values.
fn set(job: &Path, values: &[(&str, f64)]) -> Result<(), String> {
    let text = std::fs::read_to_string(job).map_err(|e| format!("{}: {e}", job.display()))?;
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for (key, value) in values {
        let line = lines.iter_mut().find(|line| line.starts_with(&format!("{key} = ")));
        *line.ok_or_else(|| format!("{}: there is no {key}", job.display()))? =
            format!("{key} = {value}");
    }
    std::fs::write(job, lines.join("\n") + "\n").map_err(|e| format!("{}: {e}", job.display()))
}

/// `side` by `side` quads, diagonals alternating.
fn square(side: usize) -> TriangleSoup {
    let at = |i: usize| 2.0 * i as f64 / side as f64 - 1.0;
    let height = |x: f64, y: f64| {
        let bump = math::exp(-((x - 0.3) * (x - 0.3) + (y + 0.2) * (y + 0.2)) / 0.08);
        let ripples = math::sin(7.0 * x) * math::cos(5.0 * y);
        0.2 * (x * x - y * y) + 0.2 * bump + 0.025 * ripples
    };
    let places = (0..=side).flat_map(|j| (0..=side).map(move |i| (at(i), at(j))));
    let positions = places.map(|(x, y)| HALF * DVec3::new(x, y, height(x, y))).collect();
    let quads = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
    let faces = quads.flat_map(|(i, j)| {
        let a = (j * (side + 1) + i) as u32;
        let (b, c, d) = (a + 1, a + side as u32 + 2, a + side as u32 + 1);
        if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    });
    TriangleSoup { positions, faces: faces.collect(), texture: None }
}
