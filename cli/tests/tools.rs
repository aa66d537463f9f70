//! Tools from libraries: planned, checked and listed.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{empty, evencut, streams};

const DOME: &str = "version = 1\nname = \"dome\"\n[surface.analytic]\nkind = \"sphere-cap\"\nsize = 16.0\nradius = 20.0\n\
                    resolution = 0.75\n[cut]\nstepover = 1.2\naxial_depth = 0.2\nfeed = 600.0\nspindle = 9000\n[output]\n\
                    svg = []\n[tool]\n";

const TOML: &str = "[[tool]]\nname = \"Ball 4\"\nnumber = 5\nlength_offset = 15\ndiameter = 4.0\nflutes = 2\nlength = 9.0\n\
                    shank_diameter = 6.0\nstickout = 30.0\nholder = [{ diameter = 20.0, upper_diameter = 30.0, length = \
                    12.0 }]\n";

const FUSION: &str = r#"{ "data": [
  { "description": "Ball 4", "type": "ball end mill", "unit": "millimeters",
    "geometry": { "DC": 4, "RE": 2, "NOF": 2, "LCF": 9, "SFDM": 6, "LB": 30 },
    "post-process": { "number": 5, "length-offset": 15, "diameter-offset": 15 },
    "holder": { "unit": "millimeters", "segments": [{ "height": 12, "lower-diameter": 20, "upper-diameter": 30 }] } },
  { "description": "Drill with a very long name that nobody can read in a narrow column of a table", "type": "drill",
    "unit": "inches", "geometry": { "DC": 0.25 }, "post-process": { "number": 6 } } ], "version": 36 }"#;

const FREECAD: &str = r#"{ "name": "Ball 4", "shape": "ballend.fcstd", "parameter": { "Diameter": "4.0 mm",
  "CuttingEdgeHeight": "9.0 mm", "ShankDiameter": "6.0 mm", "Flutes": "2" }, "attribute": {} }"#;

fn scratch(test: &str) -> PathBuf {
    let path = empty(&format!("tools-{test}"));
    for (name, text) in [("a.toml", TOML), ("a.json", FUSION), ("a.fctb", FREECAD)] {
        fs::write(path.join(name), text).unwrap();
    }
    path
}

fn job(directory: &Path, name: &str, tool: &str) {
    fs::write(directory.join(name), format!("{DOME}{tool}")).unwrap();
}

fn run(directory: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = evencut(directory, arguments);
    let (code, data, messages) = streams(&output);
    (code, data.to_owned(), messages.to_owned())
}

#[test]
fn every_format_plans_the_path_of_the_written_values() {
    let directory = scratch("formats");
    let written = TOML.replace("[[tool]]\nname = \"Ball 4\"\n", "");
    job(&directory, "written.job.toml", &written);
    job(&directory, "toml.job.toml", "library = \"a.toml\"\nname = \"Ball 4\"\n");
    job(&directory, "json.job.toml", "library = \"a.json\"\nnumber = 5\n");
    let rest = "number = 5\nlength_offset = 15\nstickout = 30.0\nholder = [{ diameter = 20, upper_diameter = 30, length = 12 }]\n";
    job(&directory, "fctb.job.toml", &format!("library = \"a.fctb\"\n{rest}"));
    let read = |name: &str, file: &str| {
        fs::read_to_string(directory.join("results").join(format!("{name}.job")).join(file))
            .unwrap()
    };
    for name in ["written", "toml", "json", "fctb"] {
        let (code, _, messages) =
            run(&directory, &["plan", &format!("{name}.job.toml"), "--no-verify", "-q"]);
        assert_eq!(code, 0, "{name}: {messages}");
        for file in ["toolpath.csv", "program.ngc", "job.resolved.toml"] {
            assert!(read(name, file) == read("written", file), "{name}: {file}");
        }
    }
    // The report has the library's checksum, and the job as it was written reads alone.
    let report: serde_json::Value = serde_json::from_str(&read("json", "report.json")).unwrap();
    let inputs = report["inputs"].as_array().unwrap();
    let names: Vec<_> = inputs.iter().map(|input| input["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["json.job.toml", "a.json"]);
    assert_eq!(inputs[1]["sha256"].as_str().map(str::len), Some(64));
    fs::remove_file(directory.join("a.json")).unwrap();
    let again = "results/json.job/job.resolved.toml";
    assert_eq!(run(&directory, &["check", again]).0, 0);
    assert_eq!(run(&directory, &["verify", "results/json.job"]).0, 0);
}

#[test]
fn what_is_wrong_with_a_library_is_a_fault_of_the_job() {
    let directory = scratch("faults");
    job(&directory, "none.toml", "library = \"b.json\"\nnumber = 5\n");
    job(&directory, "name.toml", "library = \"a.json\"\nname = \"Ball4\"\n");
    job(&directory, "drill.toml", "library = \"a.json\"\nnumber = 6\n");
    job(&directory, "folder.toml", "library = \"folder.toml.d/x.json\"\nnumber = 6\n");
    fs::create_dir_all(directory.join("folder.toml.d/x.json")).unwrap();
    for (name, wanted) in [
        ("none.toml", "there is no file b.json"),
        ("name.toml", "the nearest name is \"Ball 4\" (T5)"),
        ("drill.toml", "cannot be used: drill: evencut cuts with ball, flat and bull"),
        ("folder.toml", "x.json is no file"),
    ] {
        for command in ["plan", "check", "compare", "texture"] {
            let (code, _, messages) = run(&directory, &[command, name]);
            assert_eq!(code, 2, "{command} {name}: {messages}");
            assert!(messages.contains(wanted), "{command} {name}: {messages}");
            assert!(messages.contains(&format!("--> {name}:1")), "{messages}");
        }
    }
}

#[test]
fn the_tools_of_a_library_are_listed() {
    let directory = scratch("list");
    for name in ["a.toml", "a.json", "a.fctb"] {
        let (code, data, messages) = run(&directory, &["tools", name]);
        assert_eq!(code, 0, "{messages}");
        assert!(data.lines().all(|line| line.chars().count() <= 104), "{data}");
        assert!(data.contains("Ball 4") && data.starts_with("T  name"), "{data}");
        assert_eq!(data.contains("cannot be used"), name == "a.json", "{data}");
    }
    let (_, data, _) = run(&directory, &["tools", "a.json"]);
    assert!(data.contains("12 x 30") && data.contains(" 6.35 "), "{data}");
    assert!(data.contains("  T6 Drill with a very long name"), "{data}");
    fs::write(directory.join("broken.json"), "{ \"data\": [").unwrap();
    for (name, wanted) in
        [("broken.json", "no JSON"), ("missing.json", "No such file"), (".", "no file")]
    {
        let (code, _, messages) = run(&directory, &["tools", name]);
        assert!(code == 2 && messages.contains(wanted), "{name}: {messages}");
    }
}
