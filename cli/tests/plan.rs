//! Planning as it is called: exit codes, files, streams, and that results appear all or none.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use common::{empty, evencut, streams};

const DOME: &str = "version = 1\nname = \"dome\"\n[surface.analytic]\nkind = \"sphere-cap\"\n\
                    size = 16.0\nradius = 20.0\nresolution = 0.75\n[tool]\ndiameter = 4.0\n[cut]\n\
                    stepover = 1.2\nfeed = 600.0\n";

/// A strip of two triangles, 20 by 10 mm.
const STRIP: &str = "v 0 0 0\nv 20 0 0\nv 20 10 0\nv 0 10 0\nf 1 2 3\nf 1 3 4\n";

/// An empty directory with a job for a dome given by a formula.
fn scratch(test: &str) -> PathBuf {
    let path = empty(&format!("plan-{test}"));
    fs::write(path.join("dome.toml"), DOME).unwrap();
    path
}

/// Writes `part.toml` for the mesh `part.obj`.
fn write_mesh_job(directory: &Path, mesh: &str, more: &str) {
    let job = format!(
        "version = 1\n[surface]\nfile = \"part.obj\"\n[tool]\ndiameter = 4.0\n[cut]\n\
         stepover = 1.2\nfeed = 600.0\n{more}"
    );
    fs::write(directory.join("part.toml"), job).unwrap();
    fs::write(directory.join("part.obj"), mesh).unwrap();
}

/// Names and contents of the files in a directory.
fn contents(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(directory).unwrap().map(|e| e.unwrap());
    entries.map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap())).collect()
}

/// Asserts that planning `part.toml` ends with `code`, one error that holds `parts`, and no files.
fn assert_refused(directory: &Path, code: i32, parts: &[&str]) {
    let output = evencut(directory, &["plan", "part.toml"]);
    let (found, data, messages) = streams(&output);
    assert_eq!((found, data), (code, ""), "{messages}");
    assert_eq!(messages.matches("error:").count(), 1, "{messages}");
    for part in parts {
        assert!(messages.contains(part), "{part} not in\n{messages}");
    }
    assert!(!directory.join("results").exists());
}

#[test]
fn all_results_are_written_and_two_runs_write_the_same_bytes() {
    let directory = scratch("same");
    let output = evencut(&directory, &["plan", "dome.toml"]);
    let (code, data, messages) = streams(&output);
    let place = Path::new("results").join("dome");
    assert_eq!((code, messages), (0, format!("results in {}\n", place.display()).as_str()));
    assert!(data.starts_with("dome\n  surface "), "{data}");
    let first = contents(&directory.join(&place));
    let names: Vec<&str> = first.keys().map(String::as_str).collect();
    let expected = [
        ".evencut-results",
        "flat.svg",
        "job.resolved.toml",
        "mrr.svg",
        "program.ngc",
        "removal.svg",
        "report.html",
        "report.json",
        "scallop.svg",
        "surface.svg",
        "toolpath.csv",
    ];
    assert_eq!(names, expected);
    // From elsewhere, to elsewhere, on top of earlier results.
    for _ in 0..2 {
        let above = directory.parent().unwrap();
        let output =
            evencut(above, &["plan", "plan-same/dome.toml", "-o", "plan-same/again", "-q"]);
        assert_eq!(streams(&output), (0, "", ""));
        assert!(first == contents(&directory.join("again")), "other bytes");
    }
}

#[test]
fn the_report_is_printed_as_json() {
    let directory = scratch("json");
    let output = evencut(&directory, &["plan", "dome.toml", "--json", "-o", "there"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, messages), (0, "results in there\n"));
    let report: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(report["job"], "dome");
    assert!(report["delivered"]["peak_over_limit"].as_f64().unwrap() <= 1.0);
    assert_eq!(data.as_bytes(), fs::read(directory.join("there/report.json")).unwrap());
}

#[test]
fn a_resolved_job_plans_the_same_path() {
    let directory = scratch("resolved");
    assert_eq!(
        evencut(&directory, &["plan", "dome.toml", "-q", "-o", "first"]).status.code(),
        Some(0)
    );
    let again = ["plan", "first/job.resolved.toml", "-q", "-o", "second"];
    assert_eq!(evencut(&directory, &again).status.code(), Some(0));
    let path = |run: &str| fs::read(directory.join(run).join("toolpath.csv")).unwrap();
    assert!(path("first") == path("second"));
}

#[test]
fn a_run_that_fails_leaves_earlier_results() {
    let directory = scratch("fails");
    assert_eq!(evencut(&directory, &["plan", "dome.toml", "-q"]).status.code(), Some(0));
    let earlier = contents(&directory.join("results/dome"));
    let hopeless = format!("{DOME}[force]\nmrr_limit = 0.5\ncontrol = \"feed\"\n");
    for (job, code) in [(hopeless.as_str(), 4), ("version = 1\n", 2)] {
        fs::write(directory.join("dome.toml"), job).unwrap();
        assert_eq!(evencut(&directory, &["plan", "dome.toml"]).status.code(), Some(code));
        assert!(earlier == contents(&directory.join("results/dome")));
        assert_eq!(fs::read_dir(directory.join("results")).unwrap().count(), 1);
    }
}

#[test]
fn a_directory_with_other_files_is_not_taken() {
    let directory = scratch("foreign");
    fs::create_dir(directory.join("mine")).unwrap();
    fs::write(directory.join("mine/notes.txt"), "mine").unwrap();
    for (target, part) in [("mine", "notes.txt"), ("dome.toml", "is a file"), ("/", "a name")] {
        let output = evencut(&directory, &["plan", "dome.toml", "-o", target]);
        let (code, data, messages) = streams(&output);
        assert_eq!((code, data), (2, ""), "{messages}");
        assert!(messages.starts_with("error: output: ") && messages.contains(part), "{messages}");
    }
    assert_eq!(fs::read_dir(&directory).unwrap().count(), 2);
}

#[test]
fn bad_jobs_are_refused_with_all_their_faults() {
    let directory = scratch("bad-job");
    fs::write(directory.join("dome.toml"), DOME.replace("4.0", "-4").replace("feed", "fed"))
        .unwrap();
    let output = evencut(&directory, &["plan", "dome.toml"]);
    let (code, data, messages) = streams(&output);
    assert_eq!((code, data), (2, ""));
    for part in ["dome.toml:9:12", "dome.toml:12:1", "did you mean `feed`?"] {
        assert!(messages.contains(part), "{part} not in\n{messages}");
    }
    assert_eq!(evencut(&directory, &["plan", "none.toml"]).status.code(), Some(2));
}

#[test]
fn bad_surfaces_are_refused_where_the_job_names_them() {
    let directory = scratch("bad-surface");
    write_mesh_job(&directory, STRIP, "");
    fs::remove_file(directory.join("part.obj")).unwrap();
    assert_refused(&directory, 3, &["there is no file part.obj", "part.toml:3:8"]);
    write_mesh_job(&directory, "v 0 0 zero\n", "");
    assert_refused(&directory, 3, &["line 1", "part.toml:3:8"]);
    write_mesh_job(&directory, &format!("{STRIP}v 50 0 0\nv 60 0 0\nv 50 9 0\nf 5 6 7\n"), "");
    assert_refused(&directory, 3, &["2 connected pieces", "`evencut inspect part.obj`"]);
    write_mesh_job(&directory, STRIP, "[surface.select]\ncomponent = 7\n");
    assert_refused(&directory, 3, &["surface.select.component = 7", "part.toml:10:13"]);
    let vertical = STRIP.replace("10 0\n", "0 10\n");
    write_mesh_job(&directory, &vertical, "");
    assert_refused(&directory, 3, &["face away from the tool", "part.toml:3:8"]);
}

#[test]
fn limits_that_cannot_be_met_are_refused_at_the_limit() {
    let directory = scratch("limits");
    let limit = "[force]\nmrr_limit = 0.5\ncontrol = \"feed\"\n";
    fs::write(directory.join("part.toml"), format!("{DOME}{limit}")).unwrap();
    assert_refused(&directory, 4, &["the limit of 0.50", "part.toml:14:13"]);
    let travel = "[machine]\ntravel = { x = [-5.0, 5.0] }\n";
    fs::write(directory.join("part.toml"), format!("{DOME}{travel}")).unwrap();
    assert_refused(&directory, 4, &["axis X would go to", "-5 to 5 mm", "part.toml:14:"]);
    // A pit that a ball of 4 mm cannot enter.
    let pit = DOME
        .replace("sphere-cap", "bump")
        .replace("radius = 20.0", "radius = 1.5\nheight = -2.0")
        .replace("resolution = 0.75", "resolution = 0.5");
    fs::write(directory.join("part.toml"), pit + "inaccessible = \"refuse\"\n").unwrap();
    assert_refused(&directory, 4, &["it does not fit near", "part.toml:14:16"]);
}

#[test]
fn curves_from_afar_are_refused() {
    let directory = scratch("curve");
    let curve = "[path]\npattern = \"iso-scallop\"\ncurve = [[0, 0, 0], [1000, 0, 0]]\n";
    fs::write(directory.join("part.toml"), format!("{DOME}{curve}")).unwrap();
    assert_refused(&directory, 3, &["point 2 of path.curve", "lies 992 mm", "part.toml:15:"]);
}

#[test]
fn a_cutter_that_fits_nowhere_is_told() {
    let directory = scratch("nowhere");
    let dish = DOME.replace("sphere-cap", "saddle").replace("radius = 20.0", "height = 4.0");
    let job = dish.replace("diameter = 4.0", "diameter = 500.0");
    fs::write(directory.join("part.toml"), job).unwrap();
    let output = evencut(&directory, &["plan", "part.toml"]);
    let (code, _, messages) = streams(&output);
    assert_eq!(code, 5, "{messages}");
    assert!(messages.contains("the cutter fits nowhere"), "{messages}");
}

#[test]
fn slow_tables_are_told() {
    let directory = scratch("tables");
    let tables = "lead = 5.0\n[machine]\naxes = \"xyzac\"\nmax_rotary_speed = ";
    for (speed, is_told) in [(1e4, false), (10.0, true)] {
        fs::write(directory.join("part.toml"), format!("{DOME}{tables}{speed:.1}\n")).unwrap();
        let output = evencut(&directory, &["plan", "part.toml"]);
        let (_, data, messages) = streams(&output);
        let told = [data, messages].iter().any(|text| text.contains("the rotary axes make"));
        assert_eq!(told, is_told, "{data}{messages}");
    }
}

/// Every machine that comes along, and a described one: planned, judged, written, read back.
#[test]
fn machines_of_all_kinds_have_programs() {
    let directory = scratch("machines");
    let job = DOME.replace("diameter = 4.0", "diameter = 4.0\ngauge_length = 90.0");
    let described = "[[machine.rotary]]\nletter = \"B\"\ncarries = \"table\"\nrange = [-110.0, 110.0]\n\
                     centre = [0.0, 0.0, -60.0]\nmax_speed = 40.0\nmax_acceleration = 400.0\n\
                     [[machine.rotary]]\nletter = \"A\"\ncarries = \"head\"\n";
    let named = ["xyzac", "xyzbc", "xyzab-head", "xyzbc-head", "xyzbc-mixed"];
    let named = named.map(|name| (name, format!("axes = {name:?}\n")));
    let mut programs: Vec<String> = Vec::new();
    for (name, axes) in named.into_iter().chain([("own", described.to_string())]) {
        let job = format!("{job}lead = 5.0\n[machine]\npivot_length = 150.0\n{axes}");
        fs::write(directory.join("part.toml"), job).unwrap();
        let output = evencut(&directory, &["plan", "part.toml", "-q", "-o", name]);
        assert_eq!(streams(&output), (0, "", ""), "{name}");
        let program = fs::read_to_string(directory.join(name).join("program.ngc")).unwrap();
        let blocks: Vec<&str> = program.lines().filter(|l| !l.starts_with('(')).collect();
        let letters = [" A", " B", " C"].map(|word| blocks.iter().any(|l| l.contains(word)));
        assert_eq!(letters.iter().filter(|l| **l).count(), 2, "{name}: {letters:?}");
        // What was resolved says the same again.
        let resolved = format!("{name}/job.resolved.toml");
        let output = evencut(&directory, &["plan", &resolved, "-q", "-o", "again"]);
        assert_eq!(streams(&output), (0, "", ""), "{name}");
        let again = fs::read_to_string(directory.join("again/program.ngc")).unwrap();
        assert!(again == program, "{name}");
        fs::remove_dir_all(directory.join("again")).unwrap();
        assert!(!programs.contains(&program), "{name} has the program of another machine");
        programs.push(program);
    }
}

#[test]
fn a_range_that_is_too_narrow_names_axis_and_remedy() {
    let directory = scratch("range");
    let rotary = "[[machine.rotary]]\nletter = \"C\"\ncarries = \"table\"\nrange = [-180.0, 180.0]\n\
                  [[machine.rotary]]\nletter = \"A\"\ncarries = \"table\"\n";
    let job = format!("{DOME}lead = 5.0\n[machine]\n{rotary}");
    fs::write(directory.join("part.toml"), job).unwrap();
    assert_refused(
        &directory,
        4,
        &["axis C would turn to", "path.links = \"retract\"", "part.toml:"],
    );
}

#[test]
fn a_texture_that_was_asked_for_and_is_not_there_is_no_success() {
    let directory = scratch("texture");
    let window = "spindle = 6000.0\n[texture]\nat = [90.0, 0.0, 0.0]\n";
    fs::write(directory.join("dome.toml"), format!("{DOME}{window}")).unwrap();
    let output = evencut(&directory, &["plan", "dome.toml", "-q", "-o", "out"]);
    let (exit, _, messages) = streams(&output);
    assert_eq!(exit, 2, "{messages}");
    assert!(
        messages.contains("all else is written") && messages.contains("dome.toml:14"),
        "{messages}"
    );
    assert!(
        directory.join("out/toolpath.csv").exists() && !directory.join("out/texture.csv").exists()
    );
}

#[test]
fn quiet_runs_show_errors_only() {
    let directory = scratch("quiet");
    assert_eq!(streams(&evencut(&directory, &["plan", "dome.toml", "-q"])), (0, "", ""));
    let output = evencut(&directory, &["plan", "none.toml", "-q"]);
    assert!(streams(&output).2.starts_with("error: "));
}

#[test]
fn a_comparison_of_failures_ends_as_one_of_them_does() {
    let directory = empty("plan-compare");
    // Its faces look down.
    let mesh = STRIP.replace("f 1 2 3\nf 1 3 4", "f 1 3 2\nf 1 4 3");
    write_mesh_job(&directory, &mesh, "");
    let compared = |job| evencut(&directory, &["compare", job, "--patterns", "contour"]);
    let (plan, _, _) = streams(&evencut(&directory, &["plan", "part.toml"]));
    let output = compared("part.toml");
    let (code, table, _) = streams(&output);
    assert_eq!((plan, code), (3, 3), "{table}");
    fs::write(directory.join("dome.toml"), DOME).unwrap();
    assert_eq!(streams(&compared("dome.toml")).0, 0);
}

/// A box as OBJ that stands on the strip's edge.
const CLAMP: &str = "v 8 -5 -3\nv 12 -5 -3\nv 12 2 -3\nv 8 2 -3\nv 8 -5 9\nv 12 -5 9\nv 12 2 9\nv 8 2 9\n\
                     f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const CLAMPED: &str = "[[avoid]]\nfile = \"clamp.obj\"\ndistance = 0.2\n";

#[test]
fn a_mesh_beside_the_surface_that_cannot_be_used_is_refused_with_its_place() {
    let directory = empty("plan-clamp-bad");
    write_mesh_job(&directory, STRIP, CLAMPED);
    let place = "part.toml:10:8";
    assert_refused(&directory, 3, &["there is no file clamp.obj", place]);
    for (mesh, found) in
        [("", "an empty file"), ("clamp", "no face"), ("v 0 0 0\nf 1 1 1\n", "area")]
    {
        fs::write(directory.join("clamp.obj"), mesh).unwrap();
        assert_refused(&directory, 3, &["error: avoid: ", found, place]);
    }
    write_mesh_job(&directory, STRIP, "[[avoid]]\nfile = \"clamp.step\"\n");
    assert_refused(&directory, 2, &["avoid[0].file", "stl, obj, ply, off"]);
    write_mesh_job(&directory, STRIP, "[path]\nwall_file = \"clamp.obj\"\n");
    assert_refused(&directory, 2, &["path.wall_file", "write a table `[[avoid]]`"]);
}

#[test]
fn a_clamp_is_kept_clear_of_and_a_path_that_does_not_know_it_cuts_it() {
    let directory = empty("plan-clamp");
    write_mesh_job(&directory, STRIP, "");
    assert_eq!(streams(&evencut(&directory, &["plan", "part.toml", "-o", "bare"])).0, 0);
    write_mesh_job(&directory, STRIP, CLAMPED);
    fs::write(directory.join("clamp.obj"), CLAMP).unwrap();
    let output = evencut(&directory, &["plan", "part.toml", "-o", "clamped"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    let report = fs::read(directory.join("clamped/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["inputs"][2]["name"], "clamp.obj");
    assert!(report["verification"]["rest_mm2"].as_f64().unwrap() > 8.0);
    // The results know their clamp; an earlier path cuts it, however it is named.
    let verify = |arguments: &[&str]| {
        let output = evencut(&directory, arguments);
        let (code, _, messages) = streams(&output);
        (code, messages.to_owned())
    };
    assert_eq!(verify(&["verify", "clamped"]).0, 0);
    let surface = ["--surface", "part.obj", "--tool", "ball:4", "--part", "clamp.obj"];
    for (more, found) in [(&["--job", "part.toml"][..], "into \"clamp\""), (&surface, "gouge")] {
        let (code, messages) = verify(&[&["verify", "bare/toolpath.csv"][..], more].concat());
        assert_eq!(code, 5, "{messages}");
        assert!(messages.contains(found), "{messages}");
    }
    let clamp = &report["verification"]["avoided"][0];
    assert_eq!((&clamp["name"], &clamp["part"]), (&"clamp".into(), &"cutter".into()));
    assert!(clamp["clearance_mm"].as_f64().unwrap() >= 0.2, "{clamp}");
}

/// A pocket whose first ring is a slot: slowing breaks the limit on the feed per tooth, trochoids keep it.
const POCKET: &str = "version = 1\n[surface.analytic]\nkind = \"plane\"\nsize = 24.0\n[tool]\nkind = \"flat\"\n\
    diameter = 6.0\nflutes = 3\n[cut]\nstepover = 1.2\naxial_depth = 2.0\nfeed = 900.0\nspindle = 6000.0\n\
    tolerance = 0.01\n[path]\nboundary = \"wall\"\n[force]\nrelative = 1.5\nmin_chip = 0.03\n\
    [material]\ngroup = \"P\"\n";

#[test]
fn ways_of_keeping_limits_are_compared() {
    let directory = empty("plan-control");
    std::fs::write(directory.join("pocket.toml"), POCKET).unwrap();
    let output = evencut(&directory, &["compare", "pocket.toml", "--control", "--csv"]);
    let (code, data, messages) = streams(&output);
    let names: Vec<&str> = data.lines().map(|l| l.split(',').next().unwrap()).collect();
    let wanted = ["control", "plain", "slowed throughout", "feed", "trochoid", "fastest"];
    assert_eq!(names, wanted, "{messages}");
    let fields = |name: &str| {
        let line = data.lines().find(|l| l.starts_with(&format!("{name},"))).unwrap();
        line.split(',').collect::<Vec<_>>()
    };
    // A slower feed is refused; what is planned breaks no limit.
    assert_eq!(code, 4, "{messages}");
    assert!(fields("feed")[1..14].iter().all(|f| f.is_empty()), "{data}");
    assert!(fields("feed")[14].starts_with("\"force: near ("), "{data}");
    let fastest = fields("fastest");
    assert_eq!(fastest[13..], ["true", ""], "{data}");
    let number = |index: usize| fastest[index].parse::<f64>().unwrap();
    assert!(number(3) <= 1.0 && number(7) >= 0.03 * 0.99 && number(8) > 0.0, "{data}");
}

const TWO_CUTTERS: &str = "version = 1\nname = \"two\"\n[surface.analytic]\nkind = \"bump\"\nsize = 16.0\n\
                           radius = 2.0\nheight = 6.0\nresolution = 0.4\n[cut]\nscallop = 0.04\nfeed = 900.0\n\
                           [[operation]]\nname = \"finish\"\ntool = { diameter = 8.0 }\n[[operation]]\n\
                           name = \"rest\"\nrest = true\ntool = { diameter = 3.0, number = 2 }\n";

/// Operations have files of their own, and a program and a report together.
#[test]
fn operations_are_planned_one_after_the_other() {
    let directory = empty("plan-operations");
    fs::write(directory.join("two.toml"), TWO_CUTTERS).unwrap();
    let output = evencut(&directory, &["plan", "two.toml"]);
    let (code, data, messages) = streams(&output);
    assert_eq!(code, 0, "{messages}");
    assert!(data.contains("1 finish") && data.contains("2 rest (rest)"), "{data}");
    let files = contents(&directory.join("results/two"));
    for name in
        ["1-toolpath.csv", "2-toolpath.csv", "1-report.html", "2-report.json", "report.html"]
    {
        assert!(files.contains_key(name), "{name}: {:?}", files.keys());
    }
    assert!(!files.contains_key("toolpath.csv") && !files.contains_key("1-program.ngc"));
    let program = String::from_utf8(files["program.ngc"].clone()).unwrap();
    assert!(program.contains("(operation 2: rest)\n") && program.contains("T2 M6\nG43 H2\n"));
    assert_eq!(program.matches("M2\n").count(), 1);
    let report = String::from_utf8(files["report.json"].clone()).unwrap();
    assert!(report.contains("\"tool_changes\": 1") && report.contains("\"passed\": true"));
    // GRBL knows no tool change: each operation has its program.
    let output = evencut(&directory, &["plan", "-q", "--no-verify", "--post", "grbl", "two.toml"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
    let files = contents(&directory.join("results/two"));
    let programs: Vec<&String> = files.keys().filter(|name| name.contains("program.")).collect();
    assert_eq!(programs.len(), 2, "{programs:?}");
    // The resolved job is the same job.
    fs::copy(directory.join("results/two/job.resolved.toml"), directory.join("again.toml"))
        .unwrap();
    let output = evencut(&directory, &["check", "again.toml"]);
    assert_eq!(streams(&output).0, 0, "{}", streams(&output).2);
}

#[test]
fn what_takes_one_operation_refuses_several() {
    let directory = empty("plan-several");
    fs::write(directory.join("two.toml"), TWO_CUTTERS).unwrap();
    for arguments in [&["compare", "two.toml"][..], &["compare", "two.toml", "--control"]] {
        let (code, _, messages) = {
            let output = evencut(&directory, arguments);
            let (code, data, messages) = streams(&output);
            (code, data.to_owned(), messages.to_owned())
        };
        assert_eq!(code, 2, "{messages}");
        assert!(messages.contains("the job has 2 operations"), "{messages}");
    }
    // Nothing is left for the smaller cutter: the other operation is planned all the same.
    let gentle = TWO_CUTTERS.replace("height = 6.0", "height = 0.5");
    fs::write(directory.join("two.toml"), gentle).unwrap();
    let output = evencut(&directory, &["plan", "two.toml"]);
    let (code, data, messages) = streams(&output);
    assert_eq!(code, 0, "{messages}");
    assert!(data.contains("operation 2: rest:") && data.contains("there is no rest"), "{data}");
    let files = contents(&directory.join("results/two"));
    let program = String::from_utf8(files["program.ngc"].clone()).unwrap();
    assert!(program.contains("T1 M6") && !program.contains("T2 M6"));
    assert!(!files.contains_key("2-toolpath.csv"));
}
