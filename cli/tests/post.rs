//! Programs by post-processors, those that come along and a copied one, as they are asked for.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{empty, evencut, streams};

const DOME: &str = "version = 1\nname = \"dome\"\n[surface.analytic]\nkind = \"sphere-cap\"\n\
                    size = 16.0\nradius = 20.0\nresolution = 0.75\n[tool]\ndiameter = 4.0\nnumber = 5\n[cut]\n\
                    stepover = 1.2\nfeed = 600.0\n[output]\nsvg = []\n";

fn scratch(test: &str) -> PathBuf {
    let path = empty(&format!("post-{test}"));
    fs::write(path.join("dome.toml"), DOME).unwrap();
    path
}

/// The program in a directory of results.
fn program(directory: &Path) -> (String, String) {
    let of = |e: std::io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    let mut names = fs::read_dir(directory).unwrap().map(of);
    let name = names.find(|name| name.starts_with("program.")).unwrap();
    let text = fs::read_to_string(directory.join(&name)).unwrap();
    (name, text)
}

#[test]
fn every_post_writes_a_program_that_is_verified() {
    let directory = scratch("every");
    let output = evencut(&directory, &["post"]);
    let (code, names, _) = streams(&output);
    assert_eq!(code, 0);
    let names: Vec<String> = names.lines().map(str::to_owned).collect();
    assert_eq!(names.len(), 7);
    for name in names {
        let plan = ["plan", "dome.toml", "--post", &name, "-o", &name, "--no-verify", "-q"];
        let output = evencut(&directory, &plan);
        assert_eq!(streams(&output).0, 0, "{name}: {}", streams(&output).2);
        let (file, text) = program(&directory.join(&name));
        assert!(text.is_ascii() && text.contains("dome"), "{name}");
        let path = format!("{name}/{file}");
        let output = evencut(&directory, &["verify", &path, "--job", "dome.toml"]);
        let (code, data, messages) = streams(&output);
        assert_eq!(code, 0, "{name}: {data}{messages}");
    }
    // As in the job.
    let job = format!("{DOME}gcode = {{ post = \"fanuc\", program_number = 12 }}\n");
    fs::write(directory.join("fanuc.toml"), job).unwrap();
    let output = evencut(&directory, &["plan", "fanuc.toml", "--no-verify", "-q"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    let (file, text) = program(&directory.join("results/fanuc"));
    assert_eq!(file, "program.nc");
    assert!(text.starts_with("%\nO0012 (dome)\n") && text.contains("\nT5 M6\n"), "{text}");
}

#[test]
fn a_copied_post_is_named_by_the_job_or_by_the_run() {
    let directory = scratch("own");
    let output = evencut(&directory, &["post", "grbl"]);
    let (code, source, _) = streams(&output);
    assert_eq!(code, 0);
    let own = source.replace("name = \"grbl\"", "name = \"shop\"").replace("M2", "M30");
    fs::write(directory.join("shop.post.toml"), &own).unwrap();
    let job = format!("{DOME}gcode = {{ post_file = \"shop.post.toml\" }}\n");
    fs::write(directory.join("own.toml"), job).unwrap();
    let run = |arguments: &[&str]| {
        let output = evencut(&directory, arguments);
        let (code, data, messages) = streams(&output);
        (code, data.to_owned(), messages.to_owned())
    };
    assert_eq!(run(&["plan", "own.toml", "--no-verify", "-q"]).0, 0);
    let by_run = ["plan", "dome.toml", "--post", "shop.post.toml", "--no-verify", "-q"];
    assert_eq!(run(&by_run).0, 0);
    let [a, b] = ["own", "dome"].map(|name| program(&directory.join("results").join(name)).1);
    assert!(a == b && a.ends_with("\nM30\n"));

    fs::write(directory.join("shop.post.toml"), own + "colour = \"red\"\n").unwrap();
    for command in ["plan", "check"] {
        let (code, _, messages) = run(&[command, "own.toml"]);
        assert_eq!(code, 2, "{command}");
        assert!(messages.contains("colour: there is no such key"), "{messages}");
        assert!(messages.contains("--> own.toml:16:"), "{messages}");
    }
    fs::remove_file(directory.join("shop.post.toml")).unwrap();
    for command in ["plan", "check"] {
        let (code, _, messages) = run(&[command, "own.toml"]);
        assert_ne!(code, 0);
        assert!(messages.contains("there is no file shop.post.toml"), "{messages}");
    }
    fs::create_dir(directory.join("shop.post.toml")).unwrap();
    let (code, _, messages) = run(&["plan", "own.toml"]);
    assert!(code != 0 && messages.contains("shop.post.toml is no file"), "{messages}");
    let (code, _, messages) = run(&["plan", "dome.toml", "--post", "shop.post.toml"]);
    assert!(code == 2 && messages.contains("this is no file"), "{messages}");
    let (code, _, messages) = run(&["plan", "dome.toml", "--post", "fagor"]);
    assert_eq!(code, 2);
    assert!(messages.contains("there is no post \"fagor\"; there are linuxcnc,"), "{messages}");
}

/// Simulated or not, a program that is another path is no success.
#[test]
fn a_program_that_is_not_the_path_fails_the_run() {
    let directory = scratch("wrong");
    let output = evencut(&directory, &["post", "linuxcnc"]);
    let source = streams(&output).1.to_owned();
    for (from, to, wanted) in [
        ("x = \"X{}\"\ny = \"Y{}\"", "x = \"Y{}\"\ny = \"X{}\"", "leaves the planned path by"),
        ("T{tool}", "T1", "cuts with tool 1; the job has 5"),
        ("clockwise = \"M3\"", "clockwise = \"M4\"", "the spindle turns the other way"),
        ("    \"G43 H{length_offset}\",\n", "", "without the length of the tool"),
        ("T{tool} M6\",\n", "T{tool} M6\",\n\"G92 X0\",\n", "an offset set by the program"),
    ] {
        let wrong = source.replacen(from, to, 1);
        assert_ne!(wrong, source);
        fs::write(directory.join("shop.post.toml"), wrong).unwrap();
        for more in [&["--no-verify"][..], &[]] {
            let arguments = [&["plan", "dome.toml", "--post", "shop.post.toml"], more].concat();
            let output = evencut(&directory, &arguments);
            let (code, _, messages) = streams(&output);
            assert_eq!(code, 5, "{messages}");
            assert!(messages.contains(wanted), "{messages}");
        }
    }
}

/// So is one that displaces what follows between two operations.
#[test]
fn what_is_written_between_operations_is_read_too() {
    let directory = scratch("between");
    let two = "[[operation]]\nname = \"first\"\n[[operation]]\nname = \"second\"\ntool.diameter = 3.0\n\
               tool.number = 6\n";
    fs::write(directory.join("two.toml"), format!("{DOME}{two}")).unwrap();
    let output = evencut(&directory, &["post", "linuxcnc"]);
    let source = streams(&output).1.to_owned();
    let (from, wrong) = ("change = [\"{coolant_off}\", \"M5\"]", "change = [\"M5\", \"G92 X1\"]");
    assert!(source.contains(from));
    for (source, wanted) in [(source.replace(from, wrong), 5), (source.clone(), 0)] {
        fs::write(directory.join("shop.post.toml"), source).unwrap();
        let output = evencut(&directory, &["plan", "two.toml", "--post", "shop.post.toml"]);
        let (code, _, messages) = streams(&output);
        assert_eq!(code, wanted, "{messages}");
        assert_eq!(messages.contains("an offset set by the program"), wanted == 5, "{messages}");
    }
}

#[test]
fn what_a_post_cannot_write_is_refused_before_the_work() {
    let directory = scratch("refused");
    let job = DOME.replace("[output]", "coolant = \"mist\"\n[output]");
    fs::write(directory.join("mist.toml"), job).unwrap();
    let output = evencut(&directory, &["plan", "mist.toml", "--post", "grbl"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, data), (2, ""));
    assert!(messages.contains("grbl has no coolant \"mist\"; it has flood, off"), "{messages}");
    assert!(messages.contains("mist.toml:14:11"), "{messages}");
    assert!(!messages.contains("locating"), "{messages}");
}
