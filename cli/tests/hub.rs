//! What the command says of hubs and blades that cannot be machined as the job says.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{empty, evencut, streams};
use serde_json::Value;

/// The folder of jobs of this project.
fn jobs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../jobs")
}

/// A directory with the job for the blisk, with `from` replaced by `to`, and its surfaces.
fn scratch(test: &str, from: &str, to: &str) -> PathBuf {
    let path = empty(&format!("hub-{test}"));
    let text = fs::read_to_string(jobs().join("blisk.toml")).unwrap();
    assert!(text.contains(from), "{from} not in\n{text}");
    fs::write(path.join("blisk.toml"), text.replace(from, to)).unwrap();
    fs::create_dir_all(path.join("surfaces")).unwrap();
    for name in ["blisk-hub.json", "blisk-blade.json", "blisk-fillet.json"] {
        let name = Path::new("surfaces").join(name);
        fs::copy(jobs().join(&name), path.join(&name)).unwrap();
    }
    path
}

/// Asserts that planning the job ends with `code` and one error that holds `parts`, and writes nothing.
fn assert_refused(directory: &Path, code: i32, parts: &[&str]) {
    let output = evencut(directory, &["plan", "blisk.toml"]);
    let (found, data, messages) = streams(&output);
    assert_eq!((found, data), (code, ""), "{messages}");
    assert_eq!(messages.matches("error:").count(), 1, "{messages}");
    for part in parts {
        assert!(messages.contains(part), "{part} not in\n{messages}");
    }
    assert!(!directory.join("results").exists());
}

#[test]
fn a_cutter_too_large_for_the_channel_is_told_the_largest_that_passes() {
    let directory =
        scratch("large", "diameter = 6.0\nlength = 12.0\nshank_diameter = 5.8", "diameter = 20.0");
    assert_refused(
        &directory,
        4,
        &["does not pass between the blades", "the largest that does has"],
    );
}

#[test]
fn blades_too_many_for_the_hub_touch() {
    let directory = scratch("many", "blades = 20", "blades = 60");
    assert_refused(
        &directory,
        3,
        &["60 of these blades touch each other", "hub.blades", "blades = 60"],
    );
}

#[test]
fn a_splitter_on_a_blade_is_none() {
    let splitter = "clearance = 0.1\nsplitter = [\"surfaces/blisk-fillet.json\", \"surfaces/blisk-blade.json\"]";
    let directory = scratch("splitter", "clearance = 0.1", splitter);
    assert_refused(
        &directory,
        3,
        &["the splitter does not stand between the blades", "splitter = ["],
    );
}

#[test]
fn an_axis_off_the_hub_is_named() {
    for (test, axis) in
        [("origin", "axis = [0, 0, 1]\norigin = [5, 0, 0]"), ("tilt", "axis = [0, 1, 1]")]
    {
        let directory = scratch(test, "axis = [0, 0, 1]", axis);
        assert_refused(&directory, 3, &["off the hub", "hub.axis or hub.origin", "axis = ["]);
    }
}

#[test]
fn a_fillet_around_half_of_a_blade_is_no_ring() {
    let directory = scratch("ring", ", \"surfaces/blisk-blade.json\"]", "]");
    let file = directory.join("surfaces/blisk-fillet.json");
    let mut fillet: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    let rows = fillet["control_points"].as_array_mut().unwrap();
    let half = rows.len() / 2;
    rows.truncate(half);
    let degree = fillet["degree_u"].as_u64().unwrap() as usize;
    fillet["knots_u"].as_array_mut().unwrap().truncate(half + degree + 1);
    fs::write(&file, fillet.to_string()).unwrap();
    assert_refused(&directory, 3, &["the edge of the blade on the hub is no ring", "blade = ["]);
}

#[test]
fn a_missing_file_and_a_face_without_a_step_file_are_named() {
    let directory = scratch("missing", "blisk-fillet.json", "none.json");
    assert_refused(&directory, 3, &["surfaces/none.json", "relative to the job file"]);
    let directory = scratch("face", "blade = [\"surfaces/blisk-fillet.json\",", "blade = [3,");
    assert_refused(&directory, 2, &["3 is a face, but the hub is no STEP file"]);
}

#[test]
fn of_a_hub_nothing_is_compared_and_its_resolved_job_is_one() {
    let directory = scratch("resolved", "clearance = 0.1", "clearance = 0.11");
    let output = evencut(&directory, &["compare", "blisk.toml"]);
    let (code, _, messages) = streams(&output);
    assert_eq!(code, 2, "{messages}");
    assert!(messages.contains("of a hub there is one pattern"), "{messages}");
    let output = evencut(&directory, &["check", "--resolved", "blisk.toml"]);
    let (_, resolved, _) = streams(&output);
    fs::write(directory.join("again.toml"), resolved).unwrap();
    let output = evencut(&directory, &["check", "again.toml"]);
    let (code, _, messages) = streams(&output);
    assert_eq!((code, messages), (0, "again.toml: good\n"));
}

/// Shank and holder are measured, too: with a shorter stickout the holder of the same path meets the blades.
#[test]
fn a_path_is_verified_with_the_tool_of_another_job() {
    let directory = scratch("verified", "[path]", "[path]\n# One channel.");
    let text = fs::read_to_string(directory.join("blisk.toml")).unwrap();
    let text = text.replace("clearance = 0.1", "clearance = 0.1\nchannels = \"one\"");
    fs::write(directory.join("blisk.toml"), &text).unwrap();
    fs::write(directory.join("short.toml"), text.replace("stickout = 50.0", "stickout = 14.0"))
        .unwrap();
    let output = evencut(&directory, &["plan", "blisk.toml", "-o", "path"]);
    assert_eq!(streams(&output).0, 0, "{output:?}");
    for path in ["path", "path/program.ngc"] {
        let output = evencut(&directory, &["verify", path, "--job", "blisk.toml"]);
        let (code, data, messages) = streams(&output);
        assert_eq!(code, 0, "{messages}");
        assert!(data.contains("cutter at least 1.52"), "{data}");
        let output = evencut(&directory, &["verify", path, "--job", "short.toml", "--json"]);
        let (code, data, messages) = streams(&output);
        assert_eq!(code, 5, "{messages}");
        assert!(messages.contains("the holder cuts into what stands beside"), "{messages}");
        let report: Value = serde_json::from_str(data).unwrap();
        assert!(report["hub"]["measured"]["holder_mm"].as_f64().unwrap() < 0.0, "{data}");
    }
}
