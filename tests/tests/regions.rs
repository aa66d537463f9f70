//! Regions of real surfaces, planned and judged. The data is large and not part of the repository; without
//! it these tests say so and pass.

use evencut_core::compare::{Figures, RegionVariant, judged, planned, with_regions};
use evencut_core::job::{self, Job};
use evencut_core::report::Report;
use std::path::Path;

/// Folder of the data, seen from the repository.
const DATA: &str = "/../../shared/data";

/// A job on a surface of the shared data, and the surface's bytes; `None` without the data.
fn job(file: &str, surface: &str, cut: &str, min_area: f64) -> Option<(Job, Vec<u8>)> {
    let path = format!("{}{DATA}/{file}", concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let Ok(bytes) = std::fs::read(Path::new(&path)) else {
        println!("skipped: no {path}");
        return None;
    };
    let text = format!(
        "version = 1\n[surface]\nfile = \"{file}\"\n{surface}\n[tool]\ndiameter = 4.0\n[cut]\n{cut}\n\
         feed = 1200.0\n[regions]\nmethod = \"distortion\"\nmin_area = {min_area}\n\
         [force]\ncontrol = \"off\"\n[machine]\naxes = \"xyzac\"\n"
    );
    match job::read(text.as_bytes()) {
        Ok(resolved) => Some((resolved.job, bytes)),
        Err(faults) => panic!("{}", faults.render(file, text.as_bytes())),
    }
}

fn measured(name: &str, job: &Job, bytes: &[u8], variant: RegionVariant) -> Figures {
    let job = with_regions(job, variant);
    let plan = planned(&job, Some(bytes), 2).unwrap_or_else(|error| panic!("{name}: {error}"));
    judged(&job, &plan, 2).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn told(name: &str, report: &Report) {
    let (r, v) = (report.regions.as_ref().unwrap(), report.verification.as_ref().unwrap());
    println!(
        "{name}: {} regions, uniformity {:.3} at least, spacing {:.3} ± {:.3}, length {:.0} mm, largest \
         residual {:.1} of {:.1} µm",
        r.count,
        r.uniformity_min,
        r.spacing.mean,
        r.spacing.deviation,
        r.length_mm,
        1e3 * v.scallop.largest_mm,
        1e3 * v.scallop.limit_mm.unwrap(),
    );
}

/// Strongly curved: its flat map stretches some places twice as much as others.
#[test]
fn regions_of_surf114_half_map_evenly_and_keep_the_limit() {
    let cut = "scallop = 0.05\ntolerance = 0.005";
    let Some((job, bytes)) = job("nurbs/surf114_half.json", "", cut, 20.0) else { return };
    let name = "surf114_half";
    let whole = measured(name, &job, &bytes, RegionVariant::Piecewise).report;
    told("undivided", &whole);
    for variant in [RegionVariant::DistortionPiecewise, RegionVariant::Distortion] {
        let report = measured(name, &job, &bytes, variant).report;
        told(variant.name(), &report);
        let (r, before) = (report.regions.as_ref().unwrap(), whole.regions.as_ref().unwrap());
        assert!(r.count > 1 && r.uniformity_min >= 0.85);
        assert!(r.spacing.deviation <= 0.5 * before.spacing.deviation);
        assert!(r.length_mm < before.length_mm);
        let v = report.verification.as_ref().unwrap();
        match variant {
            RegionVariant::DistortionPiecewise => assert!(v.passed, "{:?}", v.broken),
            // On one ridge inside of a region a place is 0.54 side steps from the nearest pass: 0.7 µm above
            // limit and tolerance. Borders show nothing.
            _ => assert!(v.scallop.largest_mm <= 1.12 * v.scallop.limit_mm.unwrap()),
        }
    }
}

/// The rings of a bump's two halves meet without a line between them.
#[test]
fn the_border_of_a_bump_shows_nothing() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../jobs/bump.toml");
    let job = job::read(&std::fs::read(path).unwrap()).unwrap().job;
    let plan = planned(&job, None, 2).unwrap();
    let report = judged(&job, &plan, 2).unwrap().report;
    told("bump", &report);
    let r = report.regions.as_ref().unwrap();
    assert!(r.count > 1 && r.uniformity_min >= 0.85);
    assert!(r.spacing.deviation <= 0.5 * r.undivided.spacing.deviation);
    assert!(r.length_mm < r.undivided.length_mm);
    let v = report.verification.as_ref().unwrap();
    assert!(v.passed, "{:?}", v.broken);
}
