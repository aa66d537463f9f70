//! Looking at a mesh, and starting a job from it.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{empty, evencut, streams};

fn project(path: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).canonicalize().unwrap().join(path)
}

fn scratch(test: &str) -> PathBuf {
    empty(&format!("mesh-{test}"))
}

/// A quarter of a bowl of radius 20 over a square of 12 by 12 in steps of 1, times `scale`.
fn write_bowl(path: &Path, scale: f64) {
    let mut text = String::new();
    for (x, y) in (0..169).map(|i| (f64::from(i % 13), f64::from(i / 13))) {
        let z = 20.0 - (400.0 - x * x - y * y).sqrt();
        text += &format!("v {} {} {}\n", scale * x, scale * y, scale * z);
    }
    for a in (1..=156).filter(|a| a % 13 != 0) {
        text += &format!("f {} {} {}\nf {} {} {}\n", a, a + 1, a + 14, a, a + 14, a + 13);
    }
    fs::write(path, text).unwrap();
}

#[test]
fn shipped_jobs_are_good() {
    let mut seen = 0;
    for entry in fs::read_dir(project("jobs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let output = evencut(Path::new("."), &["check", path.to_str().unwrap()]);
            let (code, _, messages) = streams(&output);
            assert_eq!(code, 0, "{messages}");
            assert!(messages.ends_with(": good\n"), "{messages}");
            seen += 1;
        }
    }
    assert!(seen >= 5, "only {seen} jobs");
}

#[test]
fn a_mesh_is_inspected_as_text_and_as_json() {
    let directory = scratch("inspect");
    write_bowl(&directory.join("bowl.obj"), 1.0);
    let output = evencut(&directory, &["inspect", "bowl.obj"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, messages), (0, ""));
    assert!(data.contains("288 faces") && data.contains("boundary loops 1"), "{data}");
    let output = evencut(&directory, &["inspect", "bowl.obj", "--json", "--scale", "25.4"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, messages), (0, ""));
    let figures: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(figures["faces"], 288);
    let radius = figures["smallest_concave_radius_mm"].as_f64().unwrap();
    assert!((radius / (20.0 * 25.4) - 1.0).abs() < 0.03, "{radius}");
}

#[test]
fn what_cannot_be_inspected_is_refused() {
    let directory = scratch("refused");
    fs::write(directory.join("part.iges"), "").unwrap();
    fs::write(directory.join("empty.stl"), "").unwrap();
    for (file, part) in [("part.iges", ".stl"), ("empty.stl", "empty"), ("none.stl", "none.stl")] {
        for command in ["inspect", "new"] {
            let output = evencut(&directory, &[command, file]);
            let (code, data, messages) = streams(&output);
            assert_eq!((code, data), (3, ""), "{messages}");
            assert!(messages.starts_with("error: ") && messages.contains(part), "{messages}");
        }
    }
    for scale in ["0", "-1", "nan", "x"] {
        let output = evencut(&directory, &["inspect", "empty.stl", "--scale", scale]);
        assert_eq!(output.status.code(), Some(2), "{scale}");
    }
}

#[test]
fn a_new_job_is_good_and_can_be_planned() {
    let directory = scratch("new");
    fs::create_dir_all(directory.join("parts")).unwrap();
    fs::create_dir_all(directory.join("jobs")).unwrap();
    write_bowl(&directory.join("parts/bowl.obj"), 1.0);
    let output = evencut(&directory, &["new", "parts/bowl.obj", "-o", "jobs/bowl.toml"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, data), (0, ""), "{messages}");
    assert!(messages.contains("evencut plan jobs/bowl.toml"), "{messages}");
    let job = fs::read_to_string(directory.join("jobs/bowl.toml")).unwrap();
    assert!(job.contains("file = \"../parts/bowl.obj\""), "{job}");
    // Nothing in it has to be removed for another pattern.
    for pattern in
        ["iso-scallop", "iso-planar", "iso-parametric", "direction-field", "mpf", "spiral"]
    {
        let other = job.replace("\"contour\"", &format!("\"{pattern}\""));
        fs::write(directory.join("jobs/other.toml"), other).unwrap();
        let output = evencut(&directory, &["check", "jobs/other.toml"]);
        assert_eq!(output.status.code(), Some(0), "{pattern}: {}", streams(&output).2);
    }
    assert_eq!(evencut(&directory, &["check", "jobs/bowl.toml"]).status.code(), Some(0));
    let output = evencut(&directory, &["plan", "jobs/bowl.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", streams(&output).2);
}

#[test]
fn a_new_job_for_a_solid_machines_it_from_above() {
    let directory = scratch("solid");
    let mut text = String::new();
    for z in [-10, 0] {
        for (x, y) in [(0, 0), (20, 0), (20, 20), (0, 20)] {
            text += &format!("v {x} {y} {z}\n");
        }
    }
    text += "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    fs::write(directory.join("block.obj"), text).unwrap();
    let output = evencut(&directory, &["new", "block.obj"]);
    let (code, _, messages) = streams(&output);
    assert_eq!(code, 0, "{messages}");
    // Its edges are meant.
    assert!(!messages.contains("facets are about"), "{messages}");
    let job = fs::read_to_string(directory.join("block.toml")).unwrap();
    assert!(job.contains("steepest = 80.0") && job.contains("control = \"off\""), "{job}");
    let output = evencut(&directory, &["plan", "block.toml"]);
    let (code, summary, messages) = streams(&output);
    assert_eq!(code, 0, "{messages}");
    assert!(summary.contains("face away from +Z"), "{summary}");
}

#[test]
fn a_new_job_for_coarse_facets_says_what_they_cost() {
    let directory = scratch("facets");
    write_bowl(&directory.join("bowl.obj"), 4.0);
    let output = evencut(&directory, &["new", "bowl.obj"]);
    let (code, _, messages) = streams(&output);
    assert_eq!(code, 0, "{messages}");
    assert!(messages.contains("facets are about 0."), "{messages}");
}

#[test]
fn a_new_job_never_replaces_a_file() {
    let directory = scratch("never");
    write_bowl(&directory.join("bowl.obj"), 1.0);
    fs::write(directory.join("bowl.toml"), "mine").unwrap();
    let output = evencut(&directory, &["new", "bowl.obj"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, data), (2, ""));
    assert!(messages.contains("bowl.toml") && messages.contains("-o"), "{messages}");
    assert_eq!(fs::read_to_string(directory.join("bowl.toml")).unwrap(), "mine");
}

#[test]
fn small_numbers_are_taken_as_other_units() {
    let directory = scratch("units");
    for (scale, line) in [(0.001, "scale = 1000.0"), (0.1, "units = \"inch\"")] {
        write_bowl(&directory.join("bowl.obj"), scale);
        let _ = fs::remove_file(directory.join("bowl.toml"));
        assert_eq!(evencut(&directory, &["new", "bowl.obj"]).status.code(), Some(0));
        let job = fs::read_to_string(directory.join("bowl.toml")).unwrap();
        assert!(job.contains(line) && job.contains("a guess"), "{job}");
    }
}

/// Where the concave places of a scan are much smaller than a useful cutter, what the cutter reaches is machined, though
/// all of it looks up.
#[test]
fn a_new_job_for_a_rough_relief_machines_what_is_reached() {
    let directory = scratch("rough");
    let side = 60;
    let mut text = String::new();
    for (i, j) in (0..=side).flat_map(|i| (0..=side).map(move |j| (i, j))) {
        // A trough, and on it what looks like noise.
        let noise = (f64::from(i * i * 7919 + j * j * 104_729 + i * j) * 0.618_034).fract() - 0.5;
        let trough = f64::from((i - 30) * (i - 30)) * 0.004;
        text += &format!(
            "v {} {} {:.4}\n",
            0.5 * f64::from(i),
            0.5 * f64::from(j),
            trough + 0.3 * noise
        );
    }
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let a = i * (side + 1) + j + 1;
        let (b, c, d) = (a + side + 1, a + side + 2, a + 1);
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    fs::write(directory.join("scan.obj"), text).unwrap();
    let output = evencut(&directory, &["new", "scan.obj"]);
    assert_eq!(output.status.code(), Some(0), "{}", streams(&output).2);
    let job = fs::read_to_string(directory.join("scan.toml")).unwrap();
    assert!(job.contains("steepest = 80.0"), "{job}");
    let output = evencut(&directory, &["plan", "scan.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", streams(&output).2);
}
