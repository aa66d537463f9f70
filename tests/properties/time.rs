//! The time on the machine that is reported, beside that of a controller's own planner.

use std::fs;
use std::path::Path;

use evencut_core::job::{self, Job};
use evencut_core::machine::Post;
use evencut_core::machine_time::machine_time;
use evencut_core::plan::{Files, plan};
use evencut_output::post::{Dialect, ProgramOptions, program};
use evencut_tests::grbl::timed;
use evencut_tests::ledger;

/// Largest difference from the controller's own time that was asked for.
const ASKED: f64 = 0.05;
/// Feed, mm/min, and acceleration, mm/s², of a machining centre and of a small router.
const MACHINES: [(u32, u32); 2] = [(15_000, 2_000), (3_000, 200)];

/// A job of this project with another pattern and machine.
fn read(name: &str, pattern: &str, (feed, acceleration): (u32, u32)) -> Job {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../jobs").join(name);
    let text = fs::read_to_string(path).unwrap();
    let kept = |line: &&str| {
        let key = line.split('=').next().unwrap_or_default().trim();
        !["pattern", "start", "traverse", "max_feed", "max_acceleration"].contains(&key)
    };
    let mut text = text.lines().filter(kept).collect::<Vec<&str>>().join("\n");
    text = text.replace("[path]", &format!("[path]\npattern = \"{pattern}\""));
    if !text.contains("[machine]") {
        text += "\n[machine]";
    }
    let limits = format!("[machine]\nmax_feed = {feed}\nmax_acceleration = {acceleration}");
    let text = text.replace("[machine]", &limits);
    job::read(text.as_bytes()).unwrap_or_else(|f| panic!("{}", f.render(name, text.as_bytes()))).job
}

#[test]
fn time_on_the_machine_is_that_of_a_controller() {
    let jobs = ["lens.toml", "saddle.toml"];
    let patterns = ["iso-planar", "iso-scallop", "contour"];
    let mut worst = (0.0, String::new());
    let mut programs = 0;
    for (file, pattern) in jobs.iter().flat_map(|j| patterns.map(|p| (*j, p))) {
        for machine in MACHINES {
            let job = read(file, pattern, machine);
            let planned = plan(&job, Files::of_surface(None), 2, &mut |_, _| {}).unwrap();
            let path = &planned.toolpath;
            let ours = machine_time(path, &job.tool, &job.machine, job.cut.tolerance).limited;
            let options = ProgramOptions {
                name: "time".into(),
                machine: job.machine,
                rapid_plane: planned.rapid_plane,
                tool: job.tool,
                setup: job.setup,
                spindle: job.cut.spindle,
                tolerance: job.cut.tolerance,
            };
            let dialect = Dialect::of(Post::Grbl).unwrap();
            let text = program(path, &options, &dialect).unwrap().text;
            let name = format!("{file}, {pattern}, {} mm/min", machine.0);
            let limits = [f64::from(machine.0), f64::from(machine.1), job.cut.tolerance];
            let Some(theirs) = timed(&text, "t", limits) else { return };
            let theirs = theirs.unwrap_or_else(|message| panic!("{name}: {message}"));
            let ratio = ours.total() / theirs;
            println!("{name}: {:.2} s, GRBL {theirs:.2} s, {ratio:.3}", ours.total());
            assert!((ratio - 1.0).abs() <= ASKED, "{name}: {ratio}");
            programs += 1;
            if (ratio - 1.0_f64).abs() >= worst.0 {
                worst = ((ratio - 1.0).abs(), name);
            }
        }
    }
    let found = format!("{:.1} % ({})", 100.0 * worst.0, worst.1);
    ledger(&format!("time beside GRBL's planner, worst of {programs} programs"), "5 %", &found);
}
