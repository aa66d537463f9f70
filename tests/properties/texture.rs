//! Files of a texture as others read them.

use evencut_core::job;
use evencut_core::plan::Files;
use evencut_service::results::texture::{TextureResults, texture_results};
use evencut_service::results::{Input, Results, ResultsOptions, results};
use std::process::Command;

/// The most that parameters may be off, as a part of them.
const OFF: f64 = 1e-6;

const JOB: &str = "version = 1
surface.analytic = { kind = \"plane\", size = 8.0, resolution = 1.0 }
tool = { diameter = 10.0, flutes = 2, helix = 30.0 }
cut = { stepover = 0.5, axial_depth = 0.2, feed = 1200.0, spindle = 6000.0, lead = 10.0 }
path = { pattern = \"iso-planar\", angle = 20.0 }
force.control = \"off\"
machine.axes = \"xyzac\"
texture = { at = [0.2, 0.1, 0.0], size = [0.6, 1.5], runout = 0.002 }
";

/// All of a round surface, whose grid has gaps.
const WHOLE: &str = "version = 1
surface.analytic = { kind = \"sphere-cap\", radius = 40.0, size = 4.0, resolution = 0.2 }
tool = { diameter = 10.0, flutes = 2, helix = 30.0 }
cut = { stepover = 0.5, axial_depth = 0.2, feed = 1200.0, spindle = 6000.0 }
texture = { whole = true, spacing = 0.02 }
";

fn made(job: &str) -> TextureResults {
    let job = job::read(job.as_bytes()).unwrap().job;
    texture_results(&job, Files::default(), 2, &mut |_, _| {}).unwrap()
}

/// The Python that has the package: `EVENCUT_PYTHON`, or the usual one.
fn python() -> Option<String> {
    let name = std::env::var("EVENCUT_PYTHON").unwrap_or_else(|_| "python3".into());
    let probe = Command::new(&name).args(["-c", "import SurfaceTopography"]).output();
    let has = probe.is_ok_and(|output| output.status.success());
    if !has {
        assert!(
            std::env::var_os("CI").is_none(),
            "no SurfaceTopography in {name}, which CI must have"
        );
        println!("skipped: {name} has no SurfaceTopography (pip install SurfaceTopography)");
    }
    has.then_some(name)
}

/// The parameters that SurfaceTopography finds in both files are those that are told.
#[test]
fn surface_topography_reads_the_same_parameters() {
    let Some(python) = python() else { return };
    for (name, job) in [("window", JOB), ("whole", WHOLE)] {
        parameters_are_those_that_are_read(&python, name, made(job));
    }
}

fn parameters_are_those_that_are_read(python: &str, name: &str, made: TextureResults) {
    let TextureResults { files, figures } = made;
    let folder = format!("evencut-texture-{name}-{}", std::process::id());
    let folder = std::env::temp_dir().join(folder);
    std::fs::create_dir_all(&folder).unwrap();
    let names = ["texture.x3p", "texture.asc"];
    for name in names {
        let file = files.iter().find(|file| file.name == name).unwrap();
        std::fs::write(folder.join(name), &file.bytes).unwrap();
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/texture/surface_topography.py");
    let output =
        Command::new(python).arg(script).args(names).current_dir(&folder).output().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    let read: serde_json::Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{complaint}"));
    let areal = &figures.areal;
    for (name, read) in names.iter().zip(read.as_array().unwrap()) {
        let window = &figures.window;
        assert_eq!(read["nodes"], serde_json::json!(window.nodes), "{name}");
        let on_surface = window.nodes[0] * window.nodes[1] - window.beyond;
        assert_eq!(read["on_surface"], serde_json::json!(on_surface), "{name}");
        let told = [
            ("sq_um", areal.sq_um),
            ("sa_um", areal.sa_um),
            ("sz_um", areal.sz_um),
            ("ssk", areal.ssk),
            ("sku", areal.sku),
            ("rq_along_um", figures.along.rq_um),
        ];
        for (key, told) in told {
            // The package has no Rq along lines with gaps.
            let Some(read) = read[key].as_f64() else {
                assert!(key == "rq_along_um" && window.beyond > 0);
                continue;
            };
            println!("{name} {key}: {read} read, {told} told");
            assert!((read - told).abs() <= OFF * told.abs(), "{name} {key}: {read} of {told}");
        }
    }
}

/// Passes of a ball of radius 5 mm over a surface, so slow that the marks along the feed, `f_z² / (8 r)`, are 0.01 µm high.
fn slow(surface: &str, pattern: &str) -> Results {
    let text = format!(
        "version = 1
surface.analytic = {{ {surface}, size = 5.0 }}
tool = {{ diameter = 10.0, flutes = 2, helix = 30.0 }}
cut = {{ scallop = 0.006, tolerance = 0.0001, axial_depth = 0.2, feed = 240.0, spindle = 6000.0 }}
path.pattern = \"{pattern}\"
force.control = \"off\"
texture = {{ at = [0.0, 0.0, 0.0], size = [0.04, 2.6], spacing = 0.002 }}
"
    );
    let job = job::read(text.as_bytes()).unwrap().job;
    let input = Input { name: "job.toml", bytes: text.as_bytes() };
    let options = ResultsOptions { threads: 2, verify: true };
    results(&job, input, Files::default(), options, &mut |_, _| {}).unwrap()
}

/// Heights of the cusps on the lines across the feed, mm, in ascending order: the highest node among those that are
/// nearer than a good part of a side step.
fn cusps(results: &Results) -> Vec<f64> {
    let texture = results.report.texture.as_ref().unwrap();
    let file = results.files.iter().find(|file| file.name == "texture.csv").unwrap();
    let text = std::str::from_utf8(&file.bytes).unwrap();
    let height = |line: &str| line.rsplit(',').next().unwrap().parse::<f64>().unwrap() / 1e3;
    let heights: Vec<f64> = text.lines().skip(1).map(height).collect();
    let [along, across] = texture.window.nodes.map(|n| n as usize);
    let near = (0.4 * texture.cutting.side_step_mm / texture.window.spacing_mm[1]) as usize;
    let mut cusps = Vec::new();
    for i in 0..along {
        let line: Vec<f64> = (0..across).map(|j| heights[j * along + i]).collect();
        let is_cusp = |j: &usize| line[j - near..=j + near].iter().all(|h| *h <= line[*j]);
        cusps.extend((near..across - near).filter(is_cusp).map(|j| line[j]));
    }
    cusps.sort_by(f64::total_cmp);
    cusps
}

/// The teeth leave the cusps between the passes that the judge finds from the cutter's body alone.
#[test]
fn cusps_across_the_feed_are_those_of_the_judge() {
    let surfaces = [
        ("kind = \"plane\"", "iso-planar"),
        ("kind = \"sphere-cap\", radius = 40.0, resolution = 0.1", "iso-scallop"),
        ("kind = \"cylinder\", radius = 40.0, resolution = 0.1", "iso-scallop"),
    ];
    for (surface, pattern) in surfaces {
        let results = slow(surface, pattern);
        let judged = results.report.verification.as_ref().unwrap().cusps.as_ref().unwrap();
        let cusps = cusps(&results);
        let median = cusps[cusps.len() / 2];
        println!(
            "{surface}: {} cusps of {:.4} µm in the window; the judge's {:.4} µm, P5 {:.4}, P95 {:.4}",
            cusps.len(),
            1e3 * median,
            1e3 * judged.p50_mm,
            1e3 * judged.p5_mm,
            1e3 * judged.p95_mm
        );
        // All are alike, so that those of the window are to be compared with those of the whole.
        assert!(judged.p95_mm - judged.p5_mm < 0.02 * judged.p50_mm);
        assert!(cusps.len() > 60 && (median / judged.p50_mm - 1.0).abs() < 0.02);
    }
}
