//! The command as it is called: exit codes, and what goes to which stream.

mod common;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::{empty, evencut, streams};

const GOOD: &str = "version = 1\n[surface]\nfile = \"part.stl\"\n[tool]\ndiameter = 10.0\n\
                    [cut]\nscallop = 0.01\nfeed = 1200.0\n";

/// A directory with a good job, its surface file, and a faulty job.
fn scratch(test: &str) -> PathBuf {
    let path = empty(&format!("command-{test}"));
    fs::write(path.join("good.toml"), GOOD).unwrap();
    fs::write(path.join("part.stl"), "solid\nendsolid\n").unwrap();
    fs::write(path.join("bad.toml"), GOOD.replace("10.0", "-1").replace("feed", "fed")).unwrap();
    path
}

#[test]
fn a_good_job_is_good() {
    let output = evencut(&scratch("good"), &["check", "good.toml"]);
    assert_eq!(streams(&output), (0, "", "good.toml: good\n"));
}

#[test]
fn all_faults_of_a_bad_job_are_shown() {
    let output = evencut(&scratch("bad"), &["check", "good.toml", "bad.toml"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, data), (2, ""));
    for part in ["bad.toml:5:12", "bad.toml:8:1", "did you mean `feed`?", "bad.toml: 2 errors"] {
        assert!(messages.contains(part), "{part} not in\n{messages}");
    }
    assert!(!messages.contains('\x1b'), "no colours beside a terminal");
}

#[test]
fn a_missing_job_and_a_missing_surface_differ() {
    let directory = scratch("missing");
    let output = evencut(&directory, &["check", "none.toml"]);
    let (code, _, messages) = streams(&output);
    assert_eq!(code, 2);
    assert!(messages.starts_with("error: "), "{messages}");
    fs::remove_file(directory.join("part.stl")).unwrap();
    let output = evencut(&directory, &["check", "good.toml"]);
    let (code, _, messages) = streams(&output);
    assert_eq!(code, 3);
    assert!(messages.contains("surface: there is no file part.stl"), "{messages}");
    // The path is relative to the job, not to where the command runs.
    let above = directory.parent().unwrap();
    fs::write(directory.join("part.stl"), "").unwrap();
    let output = evencut(above, &["check", "command-missing/good.toml"]);
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn findings_are_given_as_json() {
    let output = evencut(&scratch("json"), &["check", "--json", "good.toml", "bad.toml"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, messages), (2, ""));
    let findings: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(findings[0]["good"], true);
    let error = &findings[1]["errors"][0];
    assert_eq!(error["key"], "tool.diameter");
    assert_eq!(error["place"]["line"], 5);
    assert_eq!(error["place"]["column"], 12);
    assert_eq!(error["place"]["end_column"], 14);
}

#[test]
fn the_resolved_job_is_data() {
    let directory = scratch("resolved");
    let output = evencut(&directory, &["check", "--resolved", "good.toml"]);
    let (code, data, _) = streams(&output);
    assert_eq!(code, 0);
    fs::write(directory.join("again.toml"), data).unwrap();
    let again = evencut(&directory, &["check", "--resolved", "again.toml"]);
    assert_eq!(streams(&again).1, data);
}

#[test]
fn standard_input_is_a_job_file() {
    let directory = scratch("stdin");
    let mut child = Command::new(env!("CARGO_BIN_EXE_evencut"))
        .current_dir(&directory)
        .args(["check", "-"])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(GOOD.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(streams(&output), (0, "", "standard input: good\n"));
}

#[test]
fn the_schema_is_the_shipped_one() {
    let output = evencut(Path::new("."), &["schema"]);
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/evencut.schema.json");
    assert_eq!(streams(&output), (0, fs::read_to_string(shipped).unwrap().as_str(), ""));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_evencut"))
        .arg("schema")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(streams(&output), (0, "", ""));
}

#[test]
fn bad_usage_is_told_from_help() {
    let here = Path::new(".");
    for arguments in [&[][..], &["chekc"], &["check"], &["check", "--nothing", "a"]] {
        let output = evencut(here, arguments);
        let (code, data, messages) = streams(&output);
        assert_eq!((code, data), (2, ""), "{arguments:?}");
        assert!(messages.contains("Usage: "), "{messages}");
    }
    let output = evencut(here, &["--help"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, messages), (0, ""));
    for part in ["Exit codes:", "check", "schema", "scallop = 0.01"] {
        assert!(data.contains(part), "{part} not in\n{data}");
    }
}
