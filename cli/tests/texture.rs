//! The texture of a window as it is called.

mod common;

use std::fs;
use std::path::PathBuf;

use common::{empty, evencut, streams};

const JOB: &str = "version = 1
surface.analytic = { kind = \"plane\", size = 6.0, resolution = 1.0 }
tool = { diameter = 10.0, flutes = 2 }
cut = { stepover = 0.5, axial_depth = 0.2, feed = 1200.0, spindle = 6000.0 }
path = { pattern = \"iso-planar\", angle = 0.0 }
texture = { at = [0.0, 0.0, 0.0], size = [0.4, 0.6], spacing = 0.02 }
";

/// A directory with a job.
fn with_job(test: &str) -> PathBuf {
    let path = empty(&format!("texture-{test}"));
    fs::write(path.join("part.toml"), JOB).unwrap();
    path
}

#[test]
fn the_files_of_a_window_are_written() {
    let path = with_job("files");
    let output = evencut(&path, &["texture", "part.toml", "-o", "out"]);
    let (exit, told, messages) = streams(&output);
    assert_eq!(exit, 0, "{messages}");
    assert!(told.contains("areal") && told.contains("note"), "{told}");
    for file in ["csv", "asc", "x3p", "svg", "png", "json"] {
        assert!(path.join(format!("out/texture.{file}")).exists(), "{file}");
    }
}

#[test]
fn a_whole_surface_needs_no_window() {
    let path = with_job("whole");
    let job = JOB.lines().filter(|line| !line.starts_with("texture"));
    fs::write(path.join("bare.toml"), job.collect::<Vec<_>>().join("\n")).unwrap();
    let arguments = ["texture", "bare.toml", "--whole", "--spacing", "0.05", "-o", "out"];
    let output = evencut(&path, &arguments);
    let (exit, told, messages) = streams(&output);
    assert_eq!(exit, 0, "{messages}");
    assert!(told.contains("121 x 121 nodes"), "{told}");
    let output = evencut(&path, &["texture", "bare.toml", "--whole", "--size", "1,1"]);
    assert_eq!(streams(&output).0, 2);
}

#[test]
fn errors_point_at_what_chose_the_window() {
    let path = with_job("errors");
    let told = |arguments: &[&str]| {
        let output = evencut(&path, &[&["texture", "part.toml"], arguments].concat());
        let (exit, _, messages) = streams(&output);
        assert_eq!(exit, 2, "{messages}");
        messages.to_owned()
    };
    let off = told(&["--at", "0,0,9"]);
    assert!(off.contains(" --> --at\n") && !off.contains("part.toml"), "{off}");
    assert!(told(&["--size", "20,1"]).contains(" --> --size\n"));
    assert!(told(&["--at", "2.9,0,0", "--size", "1,1"]).contains(" --> --at, --size\n"));
    let many = told(&["--spacing", "1e-5"]);
    assert!(many.contains("at most 20000000") && many.contains(" --> --spacing\n"), "{many}");
    for (name, value) in
        [("--size", "1e-9,1"), ("--size", "1,2000"), ("--spacing", "0"), ("--spacing", "nan")]
    {
        let range = told(&[name, value]);
        assert!(range.contains(&format!("error: {name} must be between")), "{range}");
    }
    // The job's own window is to be mended there.
    fs::write(path.join("part.toml"), JOB.replace("at = [0.0,", "at = [90.0,")).unwrap();
    assert!(told(&[]).contains("part.toml:6:"), "{}", told(&[]));
}

#[test]
fn a_file_that_is_not_there_is_told_with_what_to_give() {
    let path = with_job("missing");
    let output = evencut(&path, &["texture", "nothing.toml"]);
    let (exit, _, messages) = streams(&output);
    assert_eq!(exit, 2);
    assert!(messages.contains("there is no such file; give a job"), "{messages}");
    assert!(messages.contains("nothing.toml"), "{messages}");
}

/// Results of the job, in `results/part`.
fn planned(test: &str) -> PathBuf {
    let path = with_job(test);
    let output = evencut(&path, &["plan", "part.toml", "--no-verify", "-q"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    path
}

#[test]
fn files_that_the_plan_did_not_write_are_refused() {
    let path = planned("foreign");
    let results = path.join("results/part");
    let simulated = || {
        let output = evencut(&path, &["texture", "results/part", "-o", "out"]);
        let (exit, _, messages) = streams(&output);
        (exit, messages.to_owned())
    };
    assert_eq!(simulated().0, 0, "{}", simulated().1);
    let changed = |name: &str, by: &dyn Fn(&str) -> String| {
        let file = results.join(name);
        let whole = fs::read_to_string(&file).unwrap();
        fs::write(&file, by(&whole)).unwrap();
        let told = simulated();
        fs::write(&file, whole).unwrap();
        told
    };
    let half = |text: &str| {
        let lines: Vec<&str> = text.lines().collect();
        lines[..lines.len() / 2].join("\n") + "\n"
    };
    for (name, remedy, (exit, told)) in [
        ("toolpath.csv", "plan the job again", changed("toolpath.csv", &half)),
        ("job.resolved.toml", "--job", changed("job.resolved.toml", &|t| t.to_owned() + "#\n")),
    ] {
        assert_eq!(exit, 2, "{told}");
        assert!(told.contains("not what the plan wrote") && told.contains(remedy), "{told}");
        assert!(told.contains(name), "{told}");
    }
    // Without a record there is nothing to compare with.
    let no_records = |text: &str| text.replace("\"sha256\"", "\"other\"");
    assert_eq!(changed("report.json", &no_records).0, 0);
    fs::remove_file(results.join("report.json")).unwrap();
    assert_eq!(simulated().0, 0);
}

#[test]
fn the_directory_is_named_after_that_of_the_results() {
    let path = planned("named");
    let output = evencut(&path.join("results/part"), &["texture", ".", "-q"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    assert!(path.join("results/part/results/part-texture/texture.csv").exists());
}
