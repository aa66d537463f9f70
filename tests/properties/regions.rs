//! Regions of real surfaces, planned and judged. The data is large and not part of the repository; without
//! it these tests say so and pass.

use evencut_core::job::{self, Job};
use evencut_core::plan::{Files, plan};
use evencut_output::report::Report;
use evencut_service::compare::{Figures, RegionVariant, judged, with_regions};
use evencut_tests::shared_data;

/// A surface of the shared data and how it is cut with a ball on five axes.
struct Case {
    file: &'static str,
    /// Lines of the surface's table, beside the file.
    surface: &'static str,
    diameter: f64,
    cut: &'static str,
    min_area: f64,
    /// Spread of the spacing with one stepover a region, at most, as a part of the undivided map's.
    piecewise_spread: f64,
}

/// A smooth bulb; a NURBS surface.
const BULB: Case = Case {
    file: "nurbs/surf114_half.json",
    surface: "",
    diameter: 4.0,
    cut: "scallop = 0.05\ntolerance = 0.005",
    min_area: 20.0,
    piecewise_spread: 0.5,
};

/// The head without horns and ears, in which no cutter of a sensible size fits. At this scale edges are
/// 1 mm long and leave the surface by up to 0.05 mm: strips are wider than that, and the tolerance is
/// about as large.
const COW: Case = Case {
    file: "mesh/cowhead.ply",
    surface: "scale = 100.0\nselect.component = \"largest\"\n\
              select.box = [[-45.0, -45.0, -100.0], [45.0, 10.0, 100.0]]",
    diameter: 3.0,
    cut: "scallop = 0.15\ntolerance = 0.04\naxial_depth = 0.4",
    min_area: 15.0,
    piecewise_spread: 0.5,
};

/// The muzzle above the lips: eyes, ears and throat have creases of 40 degrees and more. The folds of the
/// nostrils want a small cutter.
const CAMEL: Case = Case {
    file: "mesh/camelhead.off",
    surface: "scale = 100.0\nselect.component = \"largest\"\n\
              select.box = [[-30.0, -11.0, 8.0], [30.0, 30.0, 60.0]]",
    diameter: 2.0,
    cut: "scallop = 0.15\ntolerance = 0.04\naxial_depth = 0.4",
    min_area: 15.0,
    // Single places that are stretched the most set the stepover of a whole region.
    piecewise_spread: 1.05,
};

/// The job of a case, and the surface's bytes; `None` without the data.
fn job(case: &Case) -> Option<(Job, Vec<u8>)> {
    let Case { file, surface, diameter, cut, min_area, .. } = case;
    let bytes = std::fs::read(shared_data()?.join(file)).unwrap();
    let text = format!(
        "version = 1\n[surface]\nfile = \"{file}\"\n{surface}\n[tool]\nkind = \"ball\"\n\
         diameter = {diameter:?}\n[cut]\n{cut}\nfeed = 1200.0\n[regions]\nmethod = \"distortion\"\n\
         min_area = {min_area:?}\n[force]\ncontrol = \"off\"\n[machine]\naxes = \"xyzac\"\n"
    );
    match job::read(text.as_bytes()) {
        Ok(resolved) => Some((resolved.job, bytes)),
        Err(faults) => panic!("{}", faults.render(file, text.as_bytes())),
    }
}

fn measured(name: &str, job: &Job, bytes: &[u8], variant: RegionVariant) -> Figures {
    let job = with_regions(job, variant);
    let plan = plan(&job, Files::of_surface(Some(bytes)), 2, &mut |_, _| {})
        .unwrap_or_else(|error| panic!("{name}: {error}"));
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

/// Regions of a strongly curved surface against one region with one flat stepover.
fn map_evenly_and_keep_the_limit(case: &Case) {
    let Some((job, bytes)) = job(case) else { return };
    let name = case.file;
    let whole = measured(name, &job, &bytes, RegionVariant::Piecewise).report;
    told(&format!("{name} undivided"), &whole);
    let variants = [
        (RegionVariant::DistortionPiecewise, case.piecewise_spread),
        (RegionVariant::Distortion, 0.5),
    ];
    for (variant, spread) in variants {
        let report = measured(name, &job, &bytes, variant).report;
        told(&format!("{name} {}", variant.name()), &report);
        let (r, before) = (report.regions.as_ref().unwrap(), whole.regions.as_ref().unwrap());
        assert!(before.uniformity_min < 0.7);
        assert!(r.count > 1 && r.uniformity_min >= 0.85);
        assert!(r.spacing.deviation <= spread * before.spacing.deviation);
        assert!(r.length_mm < before.length_mm);
        let v = report.verification.as_ref().unwrap();
        assert!(v.passed, "{:?}", v.broken);
        // Nothing is left out of the judgement.
        assert_eq!(v.inaccessible_mm2, 0.0);
    }
}

#[test]
#[ignore = "long: cargo xtask accept"]
fn a_bulb_maps_evenly_and_keeps_the_limit() {
    map_evenly_and_keep_the_limit(&BULB);
}

#[test]
#[ignore = "long: cargo xtask accept"]
fn a_cows_head_maps_evenly_and_keeps_the_limit() {
    map_evenly_and_keep_the_limit(&COW);
}

#[test]
fn a_camels_muzzle_maps_evenly_and_keeps_the_limit() {
    map_evenly_and_keep_the_limit(&CAMEL);
}

/// The rings of a bump's two halves meet without a line between them.
#[test]
fn the_border_of_a_bump_shows_nothing() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../jobs/bump.toml");
    let job = job::read(&std::fs::read(path).unwrap()).unwrap().job;
    let plan = plan(&job, Files::default(), 2, &mut |_, _| {}).unwrap();
    let report = judged(&job, &plan, 2).unwrap().report;
    told("bump", &report);
    let r = report.regions.as_ref().unwrap();
    assert!(r.count > 1 && r.uniformity_min >= 0.85);
    assert!(r.spacing.deviation <= 0.5 * r.undivided.spacing.deviation);
    assert!(r.length_mm < r.undivided.length_mm);
    let v = report.verification.as_ref().unwrap();
    assert!(v.passed, "{:?}", v.broken);
}
