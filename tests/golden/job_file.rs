//! The job file: its diagnostics, its schema, its reference, and the way back from the job.

use std::fs;
use std::path::{Path, PathBuf};

use evencut_core::geometry::{DVec3, rotation};
use evencut_core::job::{self, ForceControl, Outside};

fn project(path: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}

/// Holds `text` against a file of the project; with `UPDATE_GOLDEN` set, writes the file.
fn assert_same_as_file(path: &Path, text: &str) {
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(path, text).unwrap();
    }
    let expected = fs::read_to_string(path).unwrap_or_default();
    assert!(
        expected == text,
        "{} differs; run with UPDATE_GOLDEN=1 and read the difference\n--- is\n{text}",
        path.display()
    );
}

fn diagnostics(name: &str, source: &[u8]) -> String {
    match job::read(source) {
        Ok(read) => panic!("{name} was accepted: {read:?}"),
        Err(faults) => {
            for fault in &faults.0 {
                assert!(!fault.message.is_empty());
            }
            faults.render(name, source)
        }
    }
}

#[test]
fn faulty_jobs_are_explained() {
    let mut seen = 0;
    let mut jobs: Vec<PathBuf> =
        fs::read_dir(project("tests/golden/job")).unwrap().map(|e| e.unwrap().path()).collect();
    jobs.sort();
    for path in jobs.iter().filter(|p| p.extension().is_some_and(|e| e == "toml")) {
        let name = path.file_name().unwrap().to_str().unwrap();
        let text = diagnostics(name, &fs::read(path).unwrap());
        assert_same_as_file(&path.with_extension("txt"), &text);
        seen += 1;
    }
    assert!(seen >= 15, "only {seen} faulty jobs");
}

const SMALLEST: &str = "version = 1\n[surface]\nfile = \"part.stl\"\n[tool]\ndiameter = 10.0\n\
                        [cut]\nscallop = 0.01\nfeed = 1200.0\n";

/// A 64-bit linear congruential generator (Knuth, MMIX), so that every run draws the same.
struct Draw(u64);

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % n as u64) as usize
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.below(1 << 30) as f64 / (1u64 << 30) as f64
    }

    fn of<'a>(&mut self, choices: &[&'a str]) -> &'a str {
        choices[self.below(choices.len())]
    }
}

/// A valid job with many of its keys drawn.
fn drawn_job(draw: &mut Draw) -> String {
    let unit = draw.of(&["mm", "inch"]);
    let inch = if unit == "inch" { 25.4 } else { 1.0 };
    let diameter = draw.between(1.0, 50.0) / inch;
    let mut text = format!("version = 1\nunits = \"{unit}\"\n");
    if draw.below(2) == 0 {
        text += "name = \"Schaufel – größer\"\n";
    }
    text += "[surface]\n";
    if draw.below(2) == 0 {
        text += &format!(
            "file = \"a/part.STL\"\nscale = {}\nrotate = [{}, {}, 90]\nflip = true\nunits = \"{}\"\n",
            draw.between(0.1, 10.0),
            draw.between(-180.0, 180.0),
            draw.between(-180.0, 180.0),
            draw.of(&["mm", "inch"]),
        );
        text += &format!(
            "select = {{ normal_within = {}, of = [{}, {}, 1], box = [[-1, -2, -3], [{}, 5, 6]], component = {} }}\n",
            draw.between(1.0, 179.0),
            draw.between(-3.0, 3.0),
            draw.between(-3.0, 3.0),
            draw.between(0.0, 9.0),
            draw.of(&["\"only\"", "\"largest\"", "3"]),
        );
    } else {
        text += &format!(
            "[surface.analytic]\nkind = \"{}\"\nsize = {}\n",
            draw.of(&[
                "plane",
                "sphere-cap",
                "cylinder",
                "torus-patch",
                "saddle",
                "monkey-saddle",
                "bump"
            ]),
            draw.between(20.0, 150.0) / inch,
        );
    }
    let (axes, lead) = (draw.of(&["3", "xyzac"]), draw.between(0.5, 30.0));
    text += &format!("[tool]\ndiameter = {diameter}\nkind = \"{}\"\n", draw.of(&["ball", "bull"]));
    text += &format!("helix = {}\n[cut]\n", draw.between(0.0, 60.0));
    text += &match draw.below(2) {
        0 => format!("scallop = {}\n", draw.between(0.001, 0.05) / inch),
        _ => format!("stepover = {}\n", draw.between(0.01, 0.9) * diameter),
    };
    text += &format!("feed = {}\n", draw.between(10.0, 5000.0) / inch);
    if axes == "xyzac" {
        text += &format!("lead = {lead}\n");
    }
    text += &match draw.below(5) {
        0 => format!("[force]\nmrr_limit = {}\n", draw.between(10.0, 5000.0) / inch),
        1 => format!("[force]\nrelative = {}\n", draw.between(1.0, 3.0)),
        2 => {
            let power = draw.between(10.0, 900.0);
            format!("[force]\npower = {power}\n[material]\ngroup = \"S\"\n")
        }
        3 => format!(
            "[force]\ncutting_force = {}\nmax_engagement = 180.0\nmin_chip = {}\n[material]\nkc11 = {}\n",
            draw.between(10.0, 900.0),
            1e-5 / inch,
            draw.between(300.0, 3000.0)
        ),
        _ => String::new(),
    };
    text += &format!(
        "[machine]\naxes = \"{axes}\"\ntravel = {{ z = [-50, {}] }}\n",
        draw.between(1.0, 99.0)
    );
    text += &format!("[output]\ngcode = {{ post = \"{}\" }}\n", draw.of(&["linuxcnc", "none"]));
    text
}

#[test]
fn resolved_jobs_read_back_equal() {
    let mut draw = Draw(1);
    for _ in 0..2000 {
        let text = drawn_job(&mut draw);
        let first = job::read(text.as_bytes())
            .unwrap_or_else(|f| panic!("{text}\n{}", f.render("drawn", text.as_bytes())))
            .job;
        let written = first.to_toml();
        let again = job::read(written.as_bytes())
            .unwrap_or_else(|f| panic!("{}", f.render("written", written.as_bytes())))
            .job;
        assert_eq!(first, again, "{text}\n{written}");
        assert_eq!(written, again.to_toml());
        assert_eq!(first.to_file().resolve().unwrap().job, first);
    }
}

#[test]
fn the_smallest_job_is_resolved_as_documented() {
    let read = job::read(SMALLEST.as_bytes()).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    assert_same_as_file(&project("tests/golden/job/smallest.resolved.txt"), &read.job.to_toml());
}

#[test]
fn warnings_stand_beside_the_job() {
    let source = format!(
        "{SMALLEST}tolerance = 0.02\naxial_depth = 12.0\nspindle = 100\n\
                          [force]\nrelative = 0.5\n[machine]\nclearance = 0.001\n"
    );
    let read = job::read(source.as_bytes()).unwrap();
    let text = read.warnings.render_as(job::Severity::Warning, "job.toml", source.as_bytes());
    assert_same_as_file(&project("tests/golden/job/warnings.expected"), &text);
}

#[test]
fn bytes_that_are_no_job_are_refused() {
    let latin1 = b"version = 1\nname = \"gr\xF6\xDFer\"\n";
    let text = diagnostics("latin1.toml", latin1);
    assert_same_as_file(&project("tests/golden/job/latin1.expected"), &text);
    let huge = vec![b'#'; (1 << 20) + 1];
    let text = diagnostics("huge.toml", &huge);
    assert_same_as_file(&project("tests/golden/job/huge.expected"), &text);
    let nested = format!("name = {}", "[".repeat(100_000));
    assert!(job::read(nested.as_bytes()).is_err());
    let many = "x = 1\n[[x]]\n".repeat(50_000);
    assert!(job::read(many.as_bytes()).is_err());
    let unknown: String = (0..60_000).map(|i| format!("key{i} = 1\n")).collect();
    assert!(diagnostics("many.toml", unknown.as_bytes()).ends_with("and 59904 more\n"));
}

#[test]
fn a_byte_order_mark_is_no_fault() {
    assert!(job::read(format!("\u{feff}{SMALLEST}").as_bytes()).is_ok());
    let text = diagnostics("marked.toml", "\u{feff}version = 2\n".as_bytes());
    assert!(text.contains("marked.toml:1:11\n  |\n1 | version = 2\n  |           ^\n"), "{text}");
    let text = diagnostics("marked.toml", "\u{feff}\u{feff}".as_bytes());
    assert!(text.contains("marked.toml:1:"), "{text}");
}

#[test]
fn the_shipped_schema_and_reference_are_current() {
    assert_same_as_file(&project("docs/evencut.schema.json"), &job::schema());
    assert_same_as_file(&project("docs/job-file.md"), &job::reference());
}

/// All keys of a schema, dotted, with the schema of each.
fn keys<'a>(
    path: &str,
    schema: &'a serde_json::Value,
    out: &mut Vec<(String, &'a serde_json::Value)>,
) {
    for (name, value) in schema["properties"].as_object().into_iter().flatten() {
        let full = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        keys(&full, value, out);
        out.push((full, value));
    }
}

/// The value of a dotted key.
fn lookup<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    match key.split_once('.') {
        Some((head, rest)) => lookup(table.get(head)?.as_table()?, rest),
        None => table.get(key),
    }
}

#[test]
fn the_schema_and_the_reader_know_the_same_keys() {
    let schema: serde_json::Value = serde_json::from_str(&job::schema()).unwrap();
    let mut known = Vec::new();
    keys("", &schema, &mut known);
    assert!(known.len() > 60, "{} keys", known.len());
    // What the schema knows is not unknown to the reader, whatever is wrong with the value.
    for (key, value) in &known {
        let source =
            format!("{key} = {}\n", if value["type"] == "object" { "{}" } else { "{ x = 1 }" });
        let faults = job::read(source.as_bytes()).unwrap_err();
        let unknown = faults.0.iter().any(|f| f.key == *key && f.message == "unknown key");
        assert!(!unknown, "{key} is in the schema but not read");
    }
    // What the reader writes is in the schema.
    let mut draw = Draw(3);
    for _ in 0..200 {
        let job = job::read(drawn_job(&mut draw).as_bytes()).unwrap().job;
        let table: toml::Table = job.to_toml().parse().unwrap();
        let as_json = serde_json::to_value(&table).unwrap();
        assert_within(&schema, &as_json, "");
    }
}

/// Every key of `value` is a property of `schema`, whose required keys are all there.
fn assert_within(schema: &serde_json::Value, value: &serde_json::Value, path: &str) {
    let Some(table) = value.as_object() else { return };
    for required in schema["required"].as_array().into_iter().flatten() {
        assert!(table.contains_key(required.as_str().unwrap()), "{path}: {required} missing");
    }
    for (name, inner) in table {
        let property = schema["properties"].get(name);
        let property = property.unwrap_or_else(|| panic!("{path}.{name} is not in the schema"));
        assert_within(property, inner, &format!("{path}.{name}"));
    }
}

#[test]
fn documented_defaults_are_the_ones_filled_in() {
    let schema: serde_json::Value = serde_json::from_str(&job::schema()).unwrap();
    let mut known = Vec::new();
    keys("", &schema, &mut known);
    let formulas = ["sphere-cap", "torus-patch", "saddle"];
    let resolved: Vec<toml::Table> = formulas
        .iter()
        .map(|kind| {
            SMALLEST.replace("file = \"part.stl\"", &format!("analytic = {{ kind = \"{kind}\" }}"))
        })
        .chain([SMALLEST.replace("\"part.stl\"", "\"part.stl\"\nselect = { normal_within = 9 }")])
        .chain(
            ["distortion", "tensor"].map(|m| format!("{SMALLEST}\n[regions]\nmethod = \"{m}\"\n")),
        )
        .chain([format!("{SMALLEST}\n[texture]\nat = [0, 0, 0]\n")])
        .chain([SMALLEST.replace("part.stl", "hub.json")
            + "[path]\npattern = \"hub\"\n[machine]\naxes = \"xyzac\"\n[hub]\nblades = 9\nblade = [\"b.json\"]\n"])
        .map(|text| job::read(text.as_bytes()).unwrap().job.to_toml().parse().unwrap())
        .collect();
    let mut compared = 0;
    for (key, schema) in known {
        let Some(default) = schema.get("default") else { continue };
        let found = resolved.iter().find_map(|table| lookup(table, &key));
        let found = found.unwrap_or_else(|| panic!("{key} is not written out"));
        assert_eq!(&serde_json::to_value(found).unwrap(), default, "{key}");
        compared += 1;
    }
    assert!(compared > 25, "{compared} defaults");
}

#[test]
fn side_steps_follow_from_the_scallop() {
    let side_step = |tool: &str, cut: &str, machine: &str| {
        let text = format!(
            "version = 1\nsurface.file = \"p.stl\"\n[tool]\ndiameter = 10\n{tool}\n\
             [cut]\nfeed = 600\naxial_depth = 0.5\n{cut}\n[machine]\n{machine}\n[force]\nrelative = 2.0\n"
        );
        let job = job::read(text.as_bytes())
            .unwrap_or_else(|f| panic!("{}", f.render("job", text.as_bytes())))
            .job;
        // D H V_f with H 0.5 mm and V_f 10 mm/s.
        assert!((job.mrr_limit() - 2.0 * job.nominal_side_step() * 5.0).abs() < 1e-12);
        job.nominal_side_step()
    };
    // A cusp as high as the radius: half circles beside each other.
    assert_eq!(side_step("kind = \"ball\"", "scallop = 5.0\ntolerance = 0.1", ""), 10.0);
    // Pythagoras: 3-4-5 with r 5, h 1 gives half a step of 3.
    assert_eq!(side_step("kind = \"ball\"", "scallop = 1.0", ""), 6.0);
    assert_eq!(side_step("corner_radius = 1", "scallop = 0.4", ""), 1.6);
    assert_eq!(side_step("kind = \"flat\"", "stepover = 0.7", ""), 0.7);
    // Flat end at 30 deg: k = sin 30 / 5, w = sqrt(8 h / k) = sqrt(80 h).
    let w = side_step("kind = \"flat\"", "scallop = 0.05\nlead = 30", "axes = \"xyzac\"");
    assert!((w - 2.0).abs() < 1e-12, "{w}");
}

#[test]
fn inches_are_inches_throughout() {
    let text = "version = 1\nunits = \"inch\"\n[surface]\nfile = \"p.stl\"\ntranslate = [1, 0, 0]\n\
                curvature_radius = 0.1\n[tool]\ndiameter = 0.5\n[cut]\nstepover = 0.1\nfeed = 60.0\n\
                [force]\nmrr_limit = 60.0\n[machine]\nmax_acceleration = 100.0\ntravel = { x = [0, 10] }\n";
    let job = job::read(text.as_bytes()).unwrap().job;
    assert_eq!(job.surface.scale, 25.4);
    assert_eq!(job.surface.translate.x, 25.4);
    assert_eq!(job.surface.curvature_radius, Some(2.54));
    assert_eq!(job.tool.radius(), 6.35);
    assert_eq!(job.cut.feed, 25.4);
    assert_eq!(job.mrr_limit(), 25.4 * 25.4 * 25.4 * 60.0 / 60.0);
    assert_eq!(job.machine.max_acceleration, 2540.0);
    assert_eq!(job.machine.travel.x, Some((0.0, 254.0)));
}

#[test]
fn templates_are_valid_jobs() {
    let mut draw = Draw(5);
    for _ in 0..500 {
        let largest = [0.5, 4.0, 900.0][draw.below(3)];
        let radius =
            |draw: &mut Draw| (draw.below(2) == 0).then_some(draw.between(0.01, 0.05 * largest));
        let facts = job::SurfaceFacts {
            size: [largest, draw.between(0.1, 1.0) * largest, draw.between(0.0, 0.1) * largest],
            middle: [
                [1e4, 5e9][draw.below(2)] * draw.between(-1.0, 1.0),
                draw.between(-1.0, 1.0),
                0.0,
            ],
            smallest_concave_radius: radius(&mut draw),
            smallest_convex_radius: radius(&mut draw),
            solid: [Some(Outside::Outward), Some(Outside::Inward), None][draw.below(3)],
            looks_down: draw.below(2) == 0,
            off_smooth: draw.between(-0.01, 0.1),
            cad_faces: None,
            is_part: draw.below(2) == 0,
            mean_normal: [(0.6, 0.0, 0.8), (0.0, 0.8, -0.6), (0.0, 0.0, 0.0)][draw.below(3)].into(),
            from_mean: draw.between(0.0, 3.0),
            most_from_mean: draw.between(0.0, 3.0),
            most_from_up: draw.between(0.0, 3.0),
            most_from_down: draw.between(0.0, 3.0),
            sharpest: [draw.between(0.0, 1.0), draw.between(0.0, 1.0)],
            seen_from: [None, Some([[0.0, 0.6, -0.8], [0.0, 0.0, -1.0]][draw.below(2)])],
        };
        let text = job::template("sub dir/a \"quoted\" 'part'.stl", &facts);
        let read = job::read(text.as_bytes())
            .unwrap_or_else(|f| panic!("{text}\n{}", f.render("template", text.as_bytes())));
        assert!(read.warnings.is_empty(), "{text}\n{:?}", read.warnings);
        let (job, size) = (read.job, facts.size[1]);
        assert!(job.surface.steepest.is_some() || !facts.is_part, "{text}");
        // A part that no machine reaches is brought there, as it is turned.
        let middle = rotation(job.surface.rotate) * DVec3::from_array(facts.middle);
        let off = job.surface.scale * middle + job.surface.translate;
        let can_be_moved = job.surface.scale * facts.middle[0].abs() < 1e9;
        assert!(off.length() < 5e5 || !can_be_moved, "{off} {text}");
        let unit = job.surface.scale;
        assert_eq!(
            unit,
            if largest < 1.0 {
                1000.0
            } else if largest < 5.0 {
                25.4
            } else {
                1.0
            }
        );
        let concave = if job.surface.flip {
            facts.smallest_convex_radius
        } else {
            facts.smallest_concave_radius
        };
        let fits =
            job.surface.steepest.is_some() || concave.is_none_or(|r| job.tool.radius() < r * unit);
        let smallest = (0.025 * size * unit).max(0.25);
        assert!(fits || job.tool.radius() <= smallest, "{text}");
    }
}

/// A cutter that ends where the holder begins has no shank, and yet a stickout.
#[test]
fn a_stickout_as_long_as_the_cutter_is_kept() {
    let lengths = "length = 30.0\nstickout = 30.0\n[machine]\naxes = \"xyzac\"\n[cut]";
    let text = SMALLEST.replace("[cut]", lengths);
    let job = job::read(text.as_bytes()).unwrap().job;
    assert!(job.to_toml().contains("stickout = 30.0"), "{}", job.to_toml());
    assert_eq!(job.cutter_length(), 30.0);
    assert_eq!(job::read(job.to_toml().as_bytes()).unwrap().job, job);
}

/// What follows from a fault of the axes is no second fault.
#[test]
fn a_fault_of_the_machine_is_one_fault() {
    for machine in [
        "axes = \"xyzab-head\"\npivot_length = -1.0\n",
        "pivot_length = 100.0\n[[machine.rotary]]\nletter = \"A\"\ncarries = \"spindle\"\n[[machine.rotary]]\nletter = \"B\"\ncarries = \"head\"\n",
        "axes = \"xyzuv\"\n",
    ] {
        let text = format!("{SMALLEST}lead = 5.0\n[machine]\n{machine}");
        let faults = job::read(text.as_bytes()).unwrap_err();
        assert_eq!(faults.0.len(), 1, "{}", faults.render("job", text.as_bytes()));
    }
}

/// A limit that a job states is kept, or refused: it is not left alone because the pattern is not the usual one.
#[test]
fn a_limit_without_a_control_is_not_dropped() {
    let text = |pattern: &str, force: &str| {
        format!(
            "version = 1\n[surface.analytic]\nkind = \"plane\"\nsize = 30.0\n[tool]\nkind = \"ball\"\ndiameter = 6.0\n[cut]\n\
             scallop = 0.02\nfeed = 900.0\n[path]\npattern = \"{pattern}\"\n[material]\ngroup = \"P\"\n[force]\n{force}"
        )
    };
    let rates = ["mrr_limit = 900.0", "relative = 1.2", "power = 60.0", "cutting_force = 80.0"];
    let loads = ["min_chip = 0.005", "max_engagement = 150.0"];
    for limit in rates.into_iter().chain(loads) {
        // Slowing keeps no limit on engagement or feed per tooth.
        let open = match loads.contains(&limit) {
            true => ForceControl::Fastest,
            false => ForceControl::Feed,
        };
        for (pattern, control) in [
            ("contour", ForceControl::Fastest),
            ("iso-scallop", open),
            ("mpf", open),
            ("spiral", ForceControl::Feed),
        ] {
            let read = job::read(text(pattern, limit).as_bytes()).unwrap();
            assert_eq!(read.job.force.control, control, "{pattern}, {limit}");
        }
        let off =
            job::read(text("iso-scallop", &format!("{limit}\ncontrol = \"off\"\n")).as_bytes());
        let off = off.unwrap();
        assert_eq!(off.job.force.control, ForceControl::Off);
        // Every resolved job has a factor, `off` or not.
        let is_said = off.warnings.0.iter().any(|w| w.message.contains("neither kept nor judged"));
        assert_eq!(is_said, !limit.starts_with("relative"), "{limit}");
        let key = format!("force.{}", limit.split(' ').next().unwrap());
        let hub = job::read(text("hub", limit).as_bytes()).unwrap_err();
        assert!(hub.0.iter().any(|fault| fault.key == key), "{limit}");
    }
    let free = job::read(text("iso-scallop", "").as_bytes()).unwrap();
    assert_eq!(free.job.force.control, ForceControl::Off);
}
