//! Files of a texture as others read them.

use evencut_core::job;
use evencut_core::plan::Files;
use evencut_core::results::texture::{TextureResults, texture_results};
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

fn made() -> TextureResults {
    let job = job::read(JOB.as_bytes()).unwrap().job;
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
    let TextureResults { files, figures } = made();
    let folder = std::env::temp_dir().join(format!("evencut-texture-{}", std::process::id()));
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
        assert_eq!(read["nodes"], serde_json::json!(figures.window.nodes), "{name}");
        let told = [
            ("sq_um", areal.sq_um),
            ("sa_um", areal.sa_um),
            ("sz_um", areal.sz_um),
            ("ssk", areal.ssk),
            ("sku", areal.sku),
            ("rq_along_um", figures.along.rq_um),
        ];
        for (key, told) in told {
            let read = read[key].as_f64().unwrap();
            println!("{name} {key}: {read} read, {told} told");
            assert!((read - told).abs() <= OFF * told.abs(), "{name} {key}: {read} of {told}");
        }
    }
}
