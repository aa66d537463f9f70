//! `cargo xtask patterns`: writes the tables of docs/patterns.md, every pattern on every surface.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::test::{cargo, native, run};

const PATH: &str = "docs/patterns.md";
const HEAD: &str = "\
# Every pattern on every surface

Written by `cargo xtask patterns`, which runs `evencut compare` on two of `jobs`, on the entry of a \
drawing die (`docs/patterns`) and on the jobs of `tests/patches` (real surfaces, where `../shared` is present). All plans of a table share surface, cutter, limit and \
machine, and are judged alike, by simulation.

- */ floor*: length of the passes over the length floor, which no path can go below.
- *largest*: highest place that is left, over the limit; *kept*: not above 1 by more than the tolerance, \
and no gouge. The tolerance, a tenth to a fiftieth of the limit, is in the job.
- *cusps*: height of the crests between two passes, over the limit, fifth and 95th percentile of their length; \
*in 0.9 to 1*: the part of their length that is within 0.90 and 1.00 of the limit.
- *even area*: the part of the surface on which passes are at least 0.90 of the allowed side step apart.
- *s*: computing on one thread, without the judge and without reading and flattening the surface, on a machine that \
does other work too.
";

/// Plans every job with every pattern, and writes the tables.
pub fn patterns(project: &Path) -> Result<(), String> {
    run(cargo(project).args(["build", "--release", "--package", "evencut-cli"]))?;
    let mut text = HEAD.to_owned();
    let path = project.join(PATH);
    for job in jobs(project)? {
        println!("{}", job.display());
        text += &table(project, &job)?;
        std::fs::write(&path, &text).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

fn jobs(project: &Path) -> Result<Vec<PathBuf>, String> {
    let own = ["jobs/saddle", "jobs/lens", "docs/patterns/die-entry"];
    let mut jobs: Vec<PathBuf> = own.map(|name| project.join(format!("{name}.toml"))).into();
    let folder = project.join("tests/patches");
    if !project.join("../shared/data").is_dir() {
        println!("skipped: tables of real surfaces, since there is no ../shared/data");
        return Ok(jobs);
    }
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut real: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    real.sort();
    jobs.append(&mut real);
    Ok(jobs)
}

/// The section of a job: what it is, and its table.
fn table(project: &Path, job: &Path) -> Result<String, String> {
    let mut command = Command::new(native(project, "release"));
    command.arg("compare").arg("--csv").arg(job);
    let output = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    let csv = String::from_utf8_lossy(&output.stdout);
    let mut lines = csv.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let rows: Vec<Row> = lines.map(|line| Row { header: &header, line }).collect();
    if rows.is_empty() {
        return Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let name = job.file_stem().unwrap_or_default().to_string_lossy();
    let mut out = format!("\n## {name}\n\n{}", about(job)?);
    out += "\n| pattern | passes | mm | / floor | largest | kept | cusps | in 0.9 to 1 | even area | min:s | s |\n";
    out += "|---|--:|--:|--:|--:|---|--:|--:|--:|--:|--:|\n";
    // Writing to a string cannot fail.
    rows.iter().for_each(|row| {
        let _ = writeln!(out, "{}", row.markdown());
    });
    Ok(out)
}

/// The comment at the head of a job file.
fn about(job: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(job).map_err(|e| format!("{}: {e}", job.display()))?;
    let comments = text.lines().map_while(|line| line.strip_prefix('#'));
    Ok(comments.map(|line| format!("{}\n", line.trim())).collect())
}

struct Row<'a> {
    header: &'a [&'a str],
    line: &'a str,
}

impl Row<'_> {
    fn field(&self, name: &str) -> &str {
        let at = self.header.iter().position(|h| *h == name);
        at.and_then(|i| self.line.split(',').nth(i)).unwrap_or_default()
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.field(name).parse().ok()
    }

    fn of_limit(&self, name: &str) -> String {
        let part = self.number(name).zip(self.number("limit_mm")).map(|(h, limit)| h / limit);
        part.map_or_else(String::new, |part| format!("{part:.3}"))
    }

    fn markdown(&self) -> String {
        let pattern = self.field("pattern");
        if self.number("length_mm").is_none() {
            return format!("| {pattern} | not possible here | | | | | | | | | |");
        }
        let fixed = |name: &str, digits: usize| {
            self.number(name).map_or_else(String::new, |value| format!("{value:.digits$}"))
        };
        let time = self.number("machine_time_s").unwrap_or_default().round() as u64;
        let kept = if self.field("kept") == "true" { "yes" } else { "no" };
        let cells = [
            pattern.to_owned(),
            fixed("passes", 0),
            fixed("length_mm", 0),
            fixed("length_over_floor", 3),
            self.of_limit("largest_mm"),
            kept.to_owned(),
            format!("{} to {}", self.of_limit("cusp_p5_mm"), self.of_limit("cusp_p95_mm")),
            fixed("cusps_within_percent", 1) + " %",
            fixed("even_area_percent", 1) + " %",
            format!("{}:{:02}", time / 60, time % 60),
            fixed("computing_s", 1),
        ];
        format!("| {} |", cells.join(" | "))
    }
}
