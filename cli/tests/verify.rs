//! Verifying paths as it is called: results, tables and programs, sound and spoiled.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{empty, evencut, streams};

const STRIP: &str = "v 0 0 0\nv 20 0 0\nv 20 10 0\nv 0 10 0\nf 1 2 3\nf 1 3 4\n";
const JOB: &str = "version = 1\n[surface]\nfile = \"part.obj\"\n[tool]\ndiameter = 4.0\n[cut]\n\
                   stepover = 0.8\naxial_depth = 0.3\nfeed = 600.0\n[force]\nrelative = 1.5\n\
                   control = \"feed\"\n";

/// A directory with a job, its surface and its results.
fn planned(test: &str) -> PathBuf {
    let path = empty(&format!("verify-{test}"));
    fs::write(path.join("part.obj"), STRIP).unwrap();
    fs::write(path.join("part.toml"), JOB).unwrap();
    let output = evencut(&path, &["plan", "part.toml", "-o", "out"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    path
}

fn json(text: &[u8]) -> serde_json::Value {
    serde_json::from_slice(text).unwrap()
}

/// Rewrites `out/toolpath.csv` row by row: index among the rows and fields.
fn spoil(directory: &Path, change: impl Fn(usize, &mut Vec<String>)) {
    let file = directory.join("out/toolpath.csv");
    let text = fs::read_to_string(&file).unwrap();
    let row = |(i, line): (usize, &str)| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if i > 0 {
            change(i - 1, &mut fields);
        }
        fields.join(",")
    };
    let rows: Vec<String> = text.lines().enumerate().map(row).collect();
    fs::write(&file, rows.join("\n") + "\n").unwrap();
}

#[test]
fn a_plan_says_what_was_measured_unless_told_not_to() {
    let path = planned("plan");
    let report = json(&fs::read(path.join("out/report.json")).unwrap());
    assert_eq!(report["verification"]["passed"], true);
    assert!(report["verification"]["mrr"]["rms_difference_over_limit"].as_f64().unwrap() < 0.05);
    assert!(path.join("out/scallop.svg").exists() && path.join("out/removal.svg").exists());
    let output = evencut(&path, &["plan", "part.toml", "-o", "out", "--no-verify"]);
    let (exit, told, _) = streams(&output);
    assert_eq!(exit, 0);
    assert!(!told.contains("measured"), "{told}");
    let report = json(&fs::read(path.join("out/report.json")).unwrap());
    assert!(report["verification"].is_null() && !path.join("out/scallop.svg").exists());
}

#[test]
fn results_verify_as_the_plan_said() {
    let path = planned("results");
    let arguments = ["verify", "out", "--job", "part.toml", "--json", "-o", "verdict"];
    let output = evencut(&path, &arguments);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    let (verdict, plan) =
        (json(&output.stdout), json(&fs::read(path.join("out/report.json")).unwrap()));
    let close = |of: fn(&serde_json::Value) -> f64| {
        let (a, b) = (of(&verdict["verification"]), of(&plan["verification"]));
        // The table has six decimals, the plan all.
        assert!((a - b).abs() <= 1e-4 * b.abs().max(1e-2), "{a} {b}");
    };
    close(|v| v["scallop"]["largest_mm"].as_f64().unwrap());
    close(|v| v["mrr"]["peak_over_limit"].as_f64().unwrap());
    close(|v| v["area_mm2"].as_f64().unwrap());
    for name in ["verification.json", "scallop.svg", "removal.svg"] {
        assert!(path.join("verdict").join(name).exists(), "{name}");
    }
}

#[test]
fn a_program_is_judged_without_its_job() {
    let path = planned("program");
    let judge = |more: &[&str]| {
        let mut arguments =
            vec!["verify", "out/program.ngc", "--surface", "part.obj", "--tool", "ball:4"];
        arguments.extend(more);
        evencut(&path, &arguments)
    };
    let output = judge(&["--scallop", "0.05", "--depth", "0.3"]);
    let (exit, told, errors) = streams(&output);
    assert_eq!(exit, 0, "{told}{errors}");
    assert!(told.contains("of 50.0 µm allowed") && told.contains("peak"), "{told}");
    let output = judge(&["--scallop", "0.01"]);
    let (exit, told, errors) = streams(&output);
    assert_eq!(exit, 5);
    assert!(told.contains("rate      not measured"), "{told}");
    assert!(errors.contains("verification: scallop of 4") && errors.contains("line"), "{errors}");
}

#[test]
fn a_gouge_is_named_with_place_and_line() {
    let path = planned("gouge");
    let text = fs::read_to_string(path.join("out/toolpath.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split(',').collect()).collect();
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    let row = (rows.len() / 2..).find(|&i| rows[i][2] == "cut" && number(i, 5) < 1e-6).unwrap();
    spoil(&path, |i, fields| {
        if i == row {
            fields[5] = "-0.050000".into();
        }
    });
    let output = evencut(&path, &["verify", "out", "--job", "part.toml", "--json"]);
    let (exit, _, errors) = streams(&output);
    assert_eq!(exit, 5);
    assert!(errors.contains("gouge of"), "{errors}");
    assert_eq!(errors.matches("help: ").count(), 1, "{errors}");
    let v = &json(&output.stdout)["verification"];
    let remedies: Vec<&str> =
        v["remedies"].as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect();
    assert!(matches!(remedies[..], [one] if errors.contains(one)), "{remedies:?}");
    assert!((v["gouge_mm"].as_f64().unwrap() + 0.05).abs() < 0.002);
    let at: Vec<f64> =
        v["gouge_at_mm"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let (x, y) = (at[0] - number(row, 3), at[1] - number(row, 4));
    assert!(x * x + y * y < 1.0, "{at:?}");
    let line = v["gouge_by_line"].as_u64().unwrap() as usize;
    assert!(line.abs_diff(row + 2) <= 1, "{line} {row}");
}

#[test]
fn a_program_that_was_changed_is_not_passed_over() {
    let path = planned("changed");
    let program = path.join("out/program.ngc");
    let text = fs::read_to_string(&program).unwrap();
    fs::write(&program, text.replacen("M5", "M9\nM5", 1)).unwrap();
    let output = evencut(&path, &["verify", "out", "--job", "part.toml"]);
    let (exit, _, errors) = streams(&output);
    assert_eq!(exit, 0);
    assert!(errors.contains("warning: program.ngc is not the file"), "{errors}");
}

#[test]
fn bad_arguments_are_named_with_a_remedy() {
    let path = planned("arguments");
    let refused = |arguments: &[&str], exit: i32, says: &str| {
        let mut all = vec!["verify"];
        all.extend(arguments);
        let output = evencut(&path, &all);
        let (code, _, errors) = streams(&output);
        assert_eq!(code, exit, "{arguments:?}: {errors}");
        assert!(errors.contains(says), "{arguments:?}: {errors}");
    };
    refused(&["out/program.ngc"], 2, "--surface");
    refused(&["out", "--surface", "part.obj"], 2, "--tool");
    refused(&["out", "--surface", "part.obj", "--tool", "drill:3"], 2, "ball:10");
    refused(&["out", "--surface", "part.obj", "--tool", "bull:4:9"], 2, "corner radius");
    refused(&["nothing.ngc", "--job", "part.toml"], 2, "nothing.ngc");
    refused(&[".", "--job", "part.toml"], 2, "toolpath.csv");
    refused(&["part.obj", "--job", "part.toml"], 2, "line 1");
    refused(&["out", "--job", "part.toml", "--spacing", "0"], 2, "--spacing");
    refused(&["out", "--job", "part.toml", "--depth", "nan"], 2, "--depth");
    refused(&["out", "--job", "part.toml", "--depth", "1e9"], 2, "cutter radii");
    let part = ["out/toolpath.csv", "--surface", "part.obj"];
    refused(&[part[0], part[1], part[2], "--tool", "ball:0.00001"], 2, "the cutter's diameter");
    refused(&[part[0], part[1], part[2], "--tool", "ball:4", "--scale", "1e30"], 2, "--scale");
    let mesh =
        |more: [&'static str; 2]| [part[0], part[1], part[2], "--tool", "ball:4", more[0], more[1]];
    refused(&mesh(["--scale", "-1"]), 2, "--scale is -1; it must be from 0.000001 to 1000000");
    refused(&mesh(["--within", "-5"]), 2, "--within is -5; it must be from 0 to 180");
    refused(&mesh(["--within", "nan"]), 2, "--within is NaN");
    refused(&mesh(["--wall-height", "3"]), 2, "--wall");
    refused(&mesh(["--wall", "--wall-height=0"]), 2, "--wall-height is 0; it must be from 0.001");
    refused(&mesh(["--wall", "--wall-height=nan"]), 2, "--wall-height is NaN");
    refused(&["out", "--job", "part.toml", "--wall"], 2, "--wall");
    refused(&mesh(["--part", "no.stl"]), 3, "no.stl");
    refused(&["out", "--job", "part.toml", "--part", "part.toml"], 3, ".stl");
    refused(&["out", "--tool", "ball:4"], 2, "--surface");
    refused(&["out/toolpath.csv", "--surface", "no.stl", "--tool", "ball:4"], 3, "no.stl");
    refused(&["out/toolpath.csv", "--surface", "part.toml", "--tool", "ball:4"], 3, ".stl");
}

#[test]
fn results_bring_their_job_along() {
    let path = planned("own-job");
    let output = evencut(&path, &["verify", "out"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    // From elsewhere, and with another surface in the way.
    fs::create_dir_all(path.join("out/elsewhere")).unwrap();
    fs::write(path.join("out/part.obj"), STRIP.replace("20", "30")).unwrap();
    let output = evencut(&path.join("out/elsewhere"), &["verify", ".."]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    fs::write(path.join("part.obj"), STRIP.replace("20", "25")).unwrap();
    fs::remove_file(path.join("out/part.obj")).unwrap();
    let output = evencut(&path, &["verify", "out"]);
    let (exit, _, errors) = streams(&output);
    assert_eq!(exit, 3, "{errors}");
    assert!(errors.contains("there is no file") && errors.contains("--job"), "{errors}");
    fs::remove_file(path.join("out/job.resolved.toml")).unwrap();
    let output = evencut(&path, &["verify", "out"]);
    let (exit, _, errors) = streams(&output);
    assert_eq!(exit, 2);
    assert!(errors.contains("give --job, or --surface and --tool"), "{errors}");
}

#[test]
fn a_path_of_another_size_or_place_is_hinted_at() {
    let path = planned("mismatch");
    let hint = |surface: &str, arguments: &[&str], says: &str| {
        fs::write(path.join("other.obj"), surface).unwrap();
        let mut all = vec!["verify", "out/program.ngc", "--surface", "other.obj", "--tool"];
        all.extend(["ball:4", "--scallop", "0.05"]);
        all.extend(arguments);
        let output = evencut(&path, &all);
        let errors = streams(&output).2;
        let hints: Vec<&str> = errors.lines().filter(|l| l.starts_with("hint:")).collect();
        assert!(matches!(hints[..], [line] if line.contains(says)), "{says}: {errors}");
    };
    hint(STRIP, &["--scale", "0.03937"], "the surface may be in inches");
    hint(STRIP, &["--scale", "25.4"], "the path may be in inches");
    let moved = STRIP.replace("v 20", "v 120").replace("v 0", "v 100");
    hint(&moved, &[], "mm away from the surface");
    let sunk = STRIP.replace(" 0\nv", " -9\nv").replace(" 0\nf 1", " -9\nf 1");
    hint(&sunk, &[], "away from the surface");
}

#[test]
fn what_was_mended_of_a_mesh_is_told() {
    let path = planned("mended");
    // One facet is turned over, one is there twice.
    fs::write(path.join("torn.obj"), STRIP.replace("f 1 3 4", "f 1 4 3\nf 1 2 3")).unwrap();
    let arguments = ["verify", "out/toolpath.csv", "--surface", "torn.obj", "--tool", "ball:4"];
    let output = evencut(&path, &arguments);
    let (_, _, errors) = streams(&output);
    assert!(errors.contains("warning: surface: the mesh was repaired:"), "{errors}");
    assert!(errors.contains("1 duplicate") && errors.contains("1 faces turned over"), "{errors}");
}

#[test]
fn what_may_stand_between_samples_is_told() {
    let path = planned("unseen");
    let report = json(&fs::read(path.join("out/report.json")).unwrap());
    let largest = report["verification"]["scallop"]["largest_mm"].as_f64().unwrap();
    let told = |limit: f64| {
        let limit = format!("{limit}");
        let output = evencut(&path, &["verify", "out", "--scallop", &limit, "--tolerance", "0"]);
        streams(&output).1.to_owned()
    };
    // Half the distance of samples up the side of a cusp is less than 6 µm here.
    let near = told(largest + 4e-3);
    assert!(near.contains("; narrow places between samples may be"), "{near}");
    let far = told(1.0);
    assert!(!far.contains("narrow places between samples"), "{far}");
}

#[test]
fn a_limit_is_kept_or_broken_by_less_than_a_micrometre() {
    let path = planned("between");
    let largest = |file: &str| {
        let report = json(&fs::read(path.join(file)).unwrap());
        report["verification"]["scallop"]["largest_mm"].as_f64().unwrap()
    };
    // What stands between samples is looked for where a limit is near.
    let limit = format!("{}", largest("out/report.json"));
    evencut(&path, &["verify", "out", "--scallop", &limit, "--tolerance", "0", "-o", "near"]);
    let largest = largest("near/verification.json");
    for (more, expected) in [(5e-4, 0), (-5e-4, 5)] {
        let limit = format!("{}", largest + more);
        let arguments = ["verify", "out", "--scallop", &limit, "--tolerance", "0.0003"];
        let output = evencut(&path, &arguments);
        let (exit, told, _) = streams(&output);
        assert_eq!(exit, expected, "{told}");
    }
    let output = evencut(&path, &["verify", "out", "--spacing", "1.1"]);
    let (exit, _, errors) = streams(&output);
    assert!(exit == 2 && errors.contains("a quarter of the cutter's radius"), "{errors}");
}

#[test]
fn a_table_beyond_bounds_is_refused_with_its_place() {
    let path = planned("far");
    spoil(&path, |i, fields| {
        if i == 3 {
            fields[4] = "10000001".into();
        }
    });
    let output = evencut(&path, &["verify", "out", "--job", "part.toml"]);
    let (exit, _, errors) = streams(&output);
    assert_eq!(exit, 2, "{errors}");
    assert!(
        errors.contains("line 5, column y: \"10000001\"; it must be at most 10 km"),
        "{errors}"
    );
}

#[test]
fn every_fault_is_told_once() {
    let path = planned("once");
    // Every feed but the first is lost, and half of the path is missing.
    spoil(&path, |i, fields| {
        if i > 3 && fields[2] == "cut" {
            fields[12] = "0.0000".into();
        }
    });
    let output = evencut(&path, &["verify", "out", "--job", "part.toml", "--scallop", "0.001"]);
    let (exit, _, errors) = streams(&output);
    assert_eq!(exit, 5, "{errors}");
    let faults: Vec<&str> = errors.lines().filter(|l| l.contains("verification:")).collect();
    let mut distinct = faults.clone();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!((faults.len(), distinct.len()), (2, 2), "{errors}");
}

#[test]
fn cusps_and_samples_agree() {
    let path = empty("verify-cusps");
    fs::write(path.join("part.obj"), STRIP).unwrap();
    let job = JOB.replace("stepover = 0.8", "scallop = 0.02");
    let job = job.replace("relative = 1.5\ncontrol = \"feed\"", "control = \"off\"");
    fs::write(path.join("part.toml"), job + "[path]\npattern = \"iso-planar\"\n").unwrap();
    let output = evencut(&path, &["plan", "part.toml", "-o", "out"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    let v = &json(&fs::read(path.join("out/report.json")).unwrap())["verification"];
    let of = |keys: [&str; 2]| v[keys[0]][keys[1]].as_f64().unwrap();
    let (cusp, sample) = (of(["cusps", "largest_mm"]), of(["scallop", "largest_mm"]));
    assert!(cusp <= sample + of(["scallop", "sampling_bound_mm"]), "{cusp} {sample}");
    assert!((cusp / sample - 1.0).abs() < 0.02, "{cusp} {sample}");
    assert!(of(["cusps", "count"]) > 500.0, "{}", v["cusps"]);
}

/// A straight pass as a program: down at the first point, up at the second.
fn pass(from: [f64; 3], to: [f64; 2]) -> String {
    let ([x, y, z], [u, v]) = (from, to);
    format!(
        "G17 G21 G40 G49 G54 G80 G90 G94\nS8000 M3\nG0 Z60\nG0 X{x:.4} Y{y:.4}\nG1 Z{z:.4} F600\n\
         G1 X{u:.4} Y{v:.4}\nG0 Z60\nM5\nM30\n"
    )
}

/// Judges a program between walls; gives exit code, the figures and what was reported of faults.
fn between_walls(path: &Path, program: &str, more: &[&str]) -> (i32, serde_json::Value, String) {
    fs::write(path.join("pass.ngc"), program).unwrap();
    let mut arguments = vec!["verify", "pass.ngc", "--json", "--surface", "part.obj", "--tool"];
    arguments.extend(more);
    let output = evencut(path, &arguments);
    let (exit, _, errors) = streams(&output);
    (exit, json(&output.stdout)["verification"].clone(), errors.to_owned())
}

#[test]
fn cuts_into_the_wall_around_a_level_plane_are_told() {
    let path = empty("verify-wall-plane");
    fs::write(path.join("part.obj"), STRIP).unwrap();
    for (tool, depth) in [("flat:4", 0.0), ("flat:4", 0.3), ("ball:4", 1.25), ("bull:4:1", 3.5)] {
        let y = 2.0 - depth;
        let program = pass([5.0, y, 0.0], [15.0, y]);
        let (exit, v, errors) = between_walls(&path, &program, &[tool, "--wall"]);
        let deepest = v["walls"]["deepest_mm"].as_f64().unwrap();
        assert!((deepest - depth).abs() < 1.5e-3, "{tool}: {deepest}, {depth}");
        assert_eq!(exit, 5, "{errors}");
        let sentence = format!("cuts {depth:.2} mm into the wall at (");
        assert_eq!(errors.contains(&sentence), depth > 0.0, "{errors}");
        assert_eq!(errors.contains("the tolerance is 0.005 mm"), depth > 0.0, "{errors}");
        // Nobody asked for a wall.
        let (_, v, errors) = between_walls(&path, &program, &[tool]);
        assert!(v["walls"].is_null() && !errors.contains("wall"), "{errors}");
    }
    // Over a wall that is no higher.
    let program = pass([5.0, 0.0, 2.0], [15.0, 0.0]);
    for (height, deepest) in [("1.9", 0.0), ("2.1", 2.0)] {
        let more = ["flat:4", "--wall", "--wall-height", height];
        let (_, v, _) = between_walls(&path, &program, &more);
        let found = v["walls"]["deepest_mm"].as_f64().unwrap();
        assert!((found - deepest).abs() < 1.5e-3, "{found}");
    }
    let output = evencut(
        &path,
        &["verify", "pass.ngc", "--surface", "part.obj", "--tool", "ball:4", "--wall"],
    );
    assert!(
        streams(&output).1.contains("\n  walls     cut 2.00 mm at ("),
        "{}",
        streams(&output).1
    );
}

#[test]
fn cuts_into_the_wall_around_a_saddle_are_told() {
    let path = empty("verify-wall-saddle");
    let n = 40;
    let at = |i: usize| 50.0 * i as f64 / n as f64 - 25.0;
    let mut mesh = String::new();
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        let (x, y) = (at(i), at(j));
        mesh += &format!("v {x} {y} {}\n", 4.0 * (x * x - y * y) / 625.0);
    }
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let a = j * (n + 1) + i + 1;
        let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
        mesh += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    fs::write(path.join("part.obj"), mesh).unwrap();
    for (tool, depth) in [("flat:10", 5.2), ("bull:10:2", 4.4), ("ball:10", 1.4), ("flat:6", 0.05)]
    {
        let radius = if tool == "flat:6" { 3.0 } else { 5.0 };
        let y = -25.0 + radius - depth;
        let program = pass([-12.0, y, -1.0], [12.0, y]);
        let (exit, v, errors) =
            between_walls(&path, &program, &[tool, "--wall", "--spacing", "0.2"]);
        let deepest = v["walls"]["deepest_mm"].as_f64().unwrap();
        assert!(exit == 5 && (deepest - depth).abs() < 2e-3, "{tool}: {deepest}, {depth}");
        let place: Vec<f64> = v["walls"]["deepest_at_mm"]
            .as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect();
        assert_eq!(place[1], -25.0);
        assert!(errors.contains("into the wall at ("), "{errors}");
    }
}

#[test]
fn results_are_judged_between_the_walls_of_their_job() {
    let path = empty("verify-wall-job");
    fs::write(path.join("part.obj"), STRIP).unwrap();
    fs::write(path.join("part.toml"), format!("{JOB}[path]\nboundary = \"wall\"\n")).unwrap();
    let output = evencut(&path, &["plan", "part.toml", "-o", "out"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    let deepest = |v: &serde_json::Value| {
        v["verification"]["walls"]["deepest_mm"].as_f64().expect("there are walls")
    };
    assert!(deepest(&json(&fs::read(path.join("out/report.json")).unwrap())) <= 0.005);
    assert!(streams(&output).1.contains("walls     none cut (deepest"), "{}", streams(&output).1);
    let page = fs::read_to_string(path.join("out/report.html")).unwrap();
    assert!(page.contains("<th>walls</th><td>none cut"));
    spoil(&path, |_, fields| {
        let y: f64 = fields[4].parse().unwrap();
        fields[4] = format!("{:.6}", y - 0.5);
    });
    let output = evencut(&path, &["verify", "out", "--json"]);
    let (exit, _, errors) = streams(&output);
    assert_eq!(exit, 5, "{errors}");
    assert!((0.4..0.51).contains(&deepest(&json(&output.stdout))), "{errors}");
    assert!(errors.contains("mm into the wall at ("), "{errors}");
}

#[test]
fn a_further_mesh_of_the_part_is_guarded() {
    let path = planned("part");
    // A face across the strip, half as high as the cutter's radius.
    fs::write(path.join("clamp.obj"), "v 1 0 0\nv 1 10 0\nv 1 10 0.1\nv 1 0 0.1\nf 1 2 3 4\n")
        .unwrap();
    for own in [&["--job", "part.toml"][..], &["--surface", "part.obj", "--tool", "ball:4"]] {
        let judge = |more: &[&str]| {
            let mut arguments = vec!["verify", "out/toolpath.csv", "--json"];
            arguments.extend(own);
            arguments.extend(more);
            let output = evencut(&path, &arguments);
            let v = json(&output.stdout);
            let inputs = v["inputs"].as_array().unwrap().len();
            (inputs, v["verification"]["gouge_mm"].as_f64().unwrap())
        };
        let (inputs, gouge) = judge(&[]);
        assert!(inputs == 2 && gouge > -0.005, "{gouge}");
        let (inputs, gouge) = judge(&["--part", "clamp.obj"]);
        assert!(inputs == 3 && gouge < -0.5, "{gouge}");
    }
}
