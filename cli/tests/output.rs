//! Results replace earlier results as a whole, and nothing else.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use evencut_cli::output::{LIST, OutputError, ResultDirectory};

/// An empty directory for one test.
fn scratch(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("output-{test}"));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn write_results(target: &Path, files: &[(&str, &str)]) -> Result<PathBuf, OutputError> {
    let mut results = ResultDirectory::begin(target)?;
    for (name, text) in files {
        results.write(name, text.as_bytes())?;
    }
    results.commit()
}

/// Names and contents of the results in a directory.
fn contents(directory: &Path) -> BTreeMap<String, String> {
    fs::read_dir(directory)
        .unwrap()
        .map(|e| e.unwrap())
        .filter(|e| e.file_name() != LIST)
        .map(|e| (e.file_name().into_string().unwrap(), fs::read_to_string(e.path()).unwrap()))
        .collect()
}

fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(directory)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn results_replace_earlier_results_as_a_whole() {
    let scratch = scratch("replace");
    let target = scratch.join("deep/results");
    write_results(&target, &[("report.json", "1"), ("old.svg", "x")]).unwrap();
    write_results(&target, &[("report.json", "2")]).unwrap();
    assert_eq!(contents(&target), BTreeMap::from([("report.json".into(), "2".into())]));
    assert_eq!(names(&scratch.join("deep")), ["results"], "nothing is left beside");
}

#[test]
fn an_empty_directory_is_taken() {
    let target = scratch("empty");
    write_results(&target, &[("a", "1")]).unwrap();
    assert_eq!(contents(&target).len(), 1);
}

#[test]
fn a_run_that_fails_leaves_earlier_results() {
    let scratch = scratch("fail");
    let target = scratch.join("results");
    write_results(&target, &[("report.json", "1")]).unwrap();
    let mut results = ResultDirectory::begin(&target).unwrap();
    results.write("report.json", b"2").unwrap();
    drop(results);
    assert_eq!(contents(&target)["report.json"], "1");
    assert_eq!(names(&scratch), ["results"]);
}

#[test]
fn what_is_not_ours_is_not_replaced() {
    let scratch = scratch("foreign");
    let target = scratch.join("results");
    write_results(&target, &[("report.json", "1")]).unwrap();
    fs::write(target.join("notes.txt"), "mine").unwrap();
    let error = ResultDirectory::begin(&target).unwrap_err();
    assert!(matches!(&error, OutputError::Foreign { example, .. } if example == "notes.txt"));
    assert!(error.to_string().contains("notes.txt"));

    // Also where it was put there during the run.
    let late = scratch.join("late");
    let results = ResultDirectory::begin(&late).unwrap();
    fs::create_dir(&late).unwrap();
    fs::write(late.join("mine.txt"), "mine").unwrap();
    assert!(matches!(results.commit(), Err(OutputError::Foreign { .. })));
    assert_eq!(contents(&late)["mine.txt"], "mine");
    assert_eq!(names(&scratch), ["late", "results"]);
}

#[test]
fn targets_and_names_are_checked() {
    let scratch = scratch("names");
    let file = scratch.join("file");
    fs::write(&file, "").unwrap();
    assert!(matches!(ResultDirectory::begin(&file), Err(OutputError::NotADirectory(_))));
    assert!(matches!(ResultDirectory::begin(Path::new("/")), Err(OutputError::Nameless(_))));
    assert!(matches!(ResultDirectory::begin(&file.join("x")), Err(OutputError::Io { .. })));
    let mut results = ResultDirectory::begin(&scratch.join("results")).unwrap();
    for name in ["", "..", "a/b", "/etc/x", LIST, "a\nb"] {
        assert!(matches!(results.write(name, b""), Err(OutputError::FileName(_))), "{name:?}");
    }
}

#[cfg(unix)]
#[test]
fn a_link_to_results_stays_a_link() {
    let scratch = scratch("link");
    let (real, link) = (scratch.join("real"), scratch.join("link"));
    fs::create_dir(&real).unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    write_results(&link, &[("a", "1")]).unwrap();
    assert!(link.is_symlink());
    assert_eq!(contents(&real)["a"], "1");
}
