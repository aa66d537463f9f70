//! How limits on the cut are kept: never slower than by slowing alone, and by trochoids where slowing breaks a limit.

use evencut_core::job::{self, Boundary, ForceControl, Job, Pattern, SurfaceSource};
use evencut_core::plan::{Files, PlanError, Prepared, SurfaceKeys, plan_on, stock_of};
use evencut_core::verify::{Facets, verify};
use evencut_output::report::{Report, Warning};
use evencut_service::compare::judged;
use evencut_service::results::verify_options;
use evencut_tests::{ledger, shared_data};
use std::path::Path;
use std::sync::Arc;

fn read(name: &str, text: &str) -> Job {
    match job::read(text.as_bytes()) {
        Ok(resolved) => resolved.job,
        Err(faults) => panic!("{}", faults.render(name, text.as_bytes())),
    }
}

fn prepared(job: &Job, folder: &str) -> Arc<Prepared> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let file = match &job.surface.source {
        SurfaceSource::File(name) => Some(std::fs::read(folder.join(name)).unwrap()),
        SurfaceSource::Analytic(_) => None,
    };
    let files = Files::of_surface(file.as_deref());
    Prepared::new(SurfaceKeys::of(job), files, 2, &mut |_, _| {}).unwrap()
}

fn job_of(folder: &str, name: &str) -> Job {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("{folder}/{name}.toml"));
    read(name, &std::fs::read_to_string(path).unwrap())
}

/// A square pocket of 30 mm, 2 mm deep, whose first ring is a slot along the wall.
fn pocket(force: &str) -> Job {
    walled("kind = \"plane\"\nsize = 30.0\n", 2.0, &format!("relative = 1.5\n{force}"))
}

/// A layer between walls.
fn walled(analytic: &str, depth: f64, force: &str) -> Job {
    let text = format!(
        "version = 1\nname = \"pocket\"\n[surface.analytic]\n{analytic}[tool]\nkind = \"flat\"\n\
         diameter = 6.0\nflutes = 3\n[cut]\nstepover = 1.2\naxial_depth = {depth}\nfeed = 900.0\nspindle = 6000.0\n\
         tolerance = 0.01\n[path]\npattern = \"contour\"\nboundary = \"wall\"\n[force]\n{force}"
    );
    read("pocket", &text)
}

/// The judged report of a job on its surface.
fn report(prepared: &Arc<Prepared>, job: &Job) -> Report {
    let planned = plan_on(prepared, job, &stock_of(job), 2, &mut |_, _| {}).unwrap();
    judged(job, &planned, 2).unwrap().report
}

/// Plans a job with each control; returns the report of the fastest.
fn assert_fastest(folder: &str, name: &str) -> Report {
    let job = job_of(folder, name);
    let prepared = prepared(&job, folder);
    let with = |control| {
        let mut job = job.clone();
        job.force.control = control;
        job.force.max_engagement = std::f64::consts::PI;
        report(&prepared, &job)
    };
    let controls = [ForceControl::Fastest, ForceControl::Feed, ForceControl::Trochoid];
    let [fastest, feed, trochoid] = controls.map(with);
    let time = |r: &Report| r.delivered.machine_time_s.total;
    let others = time(&feed).min(time(&trochoid));
    let asked = format!("{others:.0} s");
    ledger(&format!("steady load, time of {name}"), &asked, &format!("{:.0} s", time(&fastest)));
    assert!(time(&fastest) <= others, "{name}: {} s, not {others}", time(&fastest));
    let [delivered, plain] = variations(&fastest);
    let asked = format!("{plain:.3}");
    ledger(&format!("steady load, variation of {name}"), &asked, &format!("{delivered:.3}"));
    for report in [&fastest, &feed, &trochoid] {
        let verification = report.verification.as_ref().unwrap();
        let peak = verification.mrr.as_ref().and_then(|mrr| mrr.peak_over_limit).unwrap();
        let (name, control) = (&report.job, &report.force.control);
        ledger(
            &format!("steady load, judged peak of {name}, {control}"),
            "1.00",
            &format!("{peak:.3}"),
        );
        assert!(verification.passed && peak <= 1.0, "{name}, {control}: {peak}");
    }
    fastest
}

/// Variation of the rate of the delivered path and of the plain one.
fn variations(report: &Report) -> [f64; 2] {
    let plain = report.plain.as_ref().unwrap();
    [&report.delivered, plain].map(|path| path.rate.unwrap().variation)
}

fn assert_worth_it(name: &str) {
    let report = assert_fastest("../jobs", name);
    let slowed = report.slowed.as_ref().unwrap();
    let [time, throughout] = [&report.delivered, slowed].map(|path| path.machine_time_s.total);
    assert!(time <= 0.7 * throughout, "{name}: {time} of {throughout} s");
    let [delivered, plain] = variations(&report);
    assert!(delivered <= plain, "{name}: {delivered}, plain {plain}");
}

#[test]
fn the_fastest_control_is_no_slower_than_any_other() {
    assert_worth_it("island");
}

#[test]
#[ignore = "long"]
fn the_fastest_control_is_no_slower_than_any_other_on_larger_jobs() {
    for name in ["mould", "hull"] {
        assert_worth_it(name);
    }
}

#[test]
#[ignore = "long"]
fn the_fastest_control_is_no_slower_than_any_other_on_real_surfaces() {
    if shared_data().is_none() {
        return;
    }
    for name in ["aorta", "cowhead", "mask_face", "teapot_patch16", "train_station"] {
        assert_fastest("real", name);
    }
}

/// In the slot along the wall the limit on the rate would take less than the feed per tooth asked.
#[test]
fn trochoids_keep_limits_that_a_slower_feed_breaks() {
    for limit in ["max_engagement = 100.0", "min_chip = 0.03"] {
        let job = pocket(&format!("control = \"fastest\"\n{limit}\n"));
        let prepared = prepared(&job, "../jobs");
        let made = report(&prepared, &job);
        let verification = made.verification.as_ref().unwrap();
        assert!(verification.passed, "{limit}: {:?}", verification.broken);
        assert!(made.force.trochoid_loops > 10, "{limit}: {}", made.force.trochoid_loops);
        let load = verification.load.as_ref().unwrap();
        let rate = verification.mrr.as_ref().and_then(|mrr| mrr.peak_over_limit).unwrap();
        assert!(rate <= 1.0, "{limit}: {rate}");
        let most = load.engagement_limit_deg.unwrap_or(180.0);
        assert!(load.engagement_deg <= most + 2.0, "{limit}: {} of {most}", load.engagement_deg);
        // The simulation sees it where the limit is broken: without the limit the plan breaks it.
        let free = pocket("control = \"feed\"\n");
        let planned = plan_on(&prepared, &free, &stock_of(&free), 2, &mut |_, _| {}).unwrap();
        let options = verify_options(&job, planned.cusps.limit, 2);
        let (positions, faces) = planned.prepared.surface.triangles();
        let (design, rest) =
            (Facets { positions, faces: &faces }, Facets { positions: &[], faces: &[] });
        let found = verify(&planned.toolpath, design, rest, &options, &mut |_| {}).unwrap();
        assert!(!found.figures.broken.is_empty(), "{limit}: slowing keeps it");
    }
    let job = pocket("control = \"feed\"\nmin_chip = 0.03\n");
    let refused = plan_on(&prepared(&job, "../jobs"), &job, &stock_of(&job), 2, &mut |_, _| {});
    assert!(matches!(refused, Err(PlanError::TooThick { .. })), "{:?}", refused.err());
}

/// Open passes meet full stock where the first one runs; there a slower feed breaks the limits, too.
#[test]
fn trochoids_in_open_passes_keep_limits_that_a_slower_feed_breaks() {
    let job = |tool: &str, pattern: &str, force: &str| {
        let text = format!(
            "version = 1\nname = \"open\"\n[surface.analytic]\nkind = \"saddle\"\nsize = 24.0\nheight = 3.0\n\
             [tool]\n{tool}\ndiameter = 6.0\nflutes = 3\n[cut]\nscallop = 0.1\naxial_depth = 2.0\nfeed = 1500.0\n\
             spindle = 10000.0\ntolerance = 0.01\n[path]\npattern = \"{pattern}\"\n[force]\nmrr_limit = 3240.0\n{force}"
        );
        read("open", &text)
    };
    let bull = "kind = \"bull\"\ncorner_radius = 1.0";
    for (tool, pattern, limit) in [
        ("kind = \"ball\"", "iso-scallop", "min_chip = 0.03"),
        ("kind = \"ball\"", "mpf", "max_engagement = 90.0"),
        (bull, "iso-planar", "max_engagement = 90.0"),
    ] {
        let fastest = job(tool, pattern, limit);
        let prepared = prepared(&fastest, "../jobs");
        let made = report(&prepared, &fastest);
        let verification = made.verification.as_ref().unwrap();
        assert!(verification.passed, "{pattern}: {:?}", verification.broken);
        assert!(made.force.trochoid_loops > 10, "{pattern}: {}", made.force.trochoid_loops);
        let peak = verification.mrr.as_ref().and_then(|mrr| mrr.peak_over_limit).unwrap();
        assert!(peak <= 1.0, "{pattern}: {peak}");
        let slowed = job(tool, pattern, &format!("{limit}\ncontrol = \"feed\""));
        let refused = plan_on(&prepared, &slowed, &stock_of(&slowed), 2, &mut |_, _| {});
        assert!(
            matches!(refused, Err(PlanError::TooThick { .. })),
            "{pattern}: {:?}",
            refused.err()
        );
        assert!(!made.warnings.iter().any(is_of_small_loops), "{pattern}");
    }
}

fn is_of_small_loops(warning: &Warning) -> bool {
    warning.message.contains("no more than the full feed allows")
}

/// Where larger loops, slowed down, break a limit that smaller ones keep, these are taken, and it is said that they take longer.
#[test]
fn loops_that_had_to_be_small_are_warned_of() {
    let text = "version = 1\nname = \"small\"\n[surface.analytic]\nkind = \"cylinder\"\nsize = 16.0\nradius = 40.0\n\
                resolution = 1.0\n[tool]\nkind = \"flat\"\ndiameter = 10.0\nflutes = 3\n[cut]\nstepover = 1.5\n\
                axial_depth = 1.0\nfeed = 1500.0\nspindle = 6000.0\ntolerance = 0.02\n[path]\n\
                pattern = \"iso-parametric\"\n[force]\nrelative = 0.8\nmax_engagement = 70.0\n";
    let job = read("small", text);
    let made = report(&prepared(&job, "../jobs"), &job);
    let verification = made.verification.as_ref().unwrap();
    assert!(verification.passed, "{:?}", verification.broken);
    assert!(made.warnings.iter().any(is_of_small_loops), "{:?}", made.warnings);
}

/// Passes that engage the cutter over no more than may be need no trochoids for it, of any pattern; a slot along a wall,
/// which they would, is refused with its place.
#[test]
fn engagement_is_limited_without_trochoids_too() {
    let limit = "max_engagement = 100.0\ncontrol = \"feed\"\n";
    let contour = pocket(limit);
    let refused =
        plan_on(&prepared(&contour, "../jobs"), &contour, &stock_of(&contour), 2, &mut |_, _| {});
    let Err(PlanError::TooThick { engaged, most, .. }) = refused else {
        panic!("{:?}", refused.err())
    };
    assert!(engaged > 2.0 && (most.to_degrees() - 100.0).abs() < 1e-9, "{engaged} of {most}");
    let mut open = contour.clone();
    (open.path.pattern, open.path.boundary) = (Pattern::IsoPlanar, Boundary::Open);
    let report = report(&prepared(&open, "../jobs"), &open);
    let v = report.verification.as_ref().unwrap();
    let load = v.load.as_ref().unwrap();
    assert!(v.passed, "{:?}", v.broken);
    // A straight pass: acos(1 - 1.2 / 3).
    assert!(load.engagement_deg > 50.0 && load.engagement_deg <= 100.0, "{}", load.engagement_deg);
    assert_eq!(load.engagement_limit_deg, Some(100.0));
}

/// Power and force are kept, and their limit is what slows the cutter down.
#[test]
fn limits_on_power_and_force_are_kept() {
    let material = "control = \"feed\"\n[material]\ngroup = \"P\"\n";
    let free = pocket(material);
    let prepared = prepared(&free, "../jobs");
    let load = |job: &Job| {
        let made = report(&prepared, job);
        let verification = made.verification.unwrap();
        assert!(verification.passed, "{:?}", verification.broken);
        verification.load.unwrap()
    };
    let without = load(&free);
    let (power, force) = (without.power_w.unwrap(), without.force_n.unwrap());
    for key in ["power", "cutting_force"] {
        let limit = 0.6 * if key == "power" { power } else { force };
        let found = load(&pocket(&format!("{key} = {limit:.3}\n{material}")));
        let value = if key == "power" { found.power_w } else { found.force_n }.unwrap();
        assert!(value <= limit && value > 0.9 * limit, "{key}: {value} of {limit}");
    }
}

/// In a pocket slowing breaks the feed per tooth. At a constant feed, or one slowed within the limit, the layer has to be
/// cut in several: trochoids in one take less time.
#[test]
fn trochoids_take_less_time_than_layers_at_a_constant_feed() {
    let plane = "kind = \"plane\"\nsize = 30.0\n";
    let limits = "mrr_limit = 3240.0\nmin_chip = 0.03\n";
    let job = |depth, control| walled(plane, depth, &format!("{limits}control = \"{control}\"\n"));
    let (whole, depth) = (job(2.0, "fastest"), 2.0);
    let prepared = prepared(&whole, "../jobs");
    let made = report(&prepared, &whole);
    assert!(made.verification.as_ref().unwrap().passed && made.force.trochoid_loops > 10);
    let time = made.delivered.machine_time_s.total;
    let layered = |layers: u32| {
        let job = job(depth / f64::from(layers), "feed");
        let planned = plan_on(&prepared, &job, &stock_of(&job), 2, &mut |_, _| {}).ok()?;
        let report = judged(&job, &planned, 2).unwrap().report;
        let is_kept = report.verification.as_ref().unwrap().passed;
        is_kept.then(|| f64::from(layers) * report.delivered.machine_time_s.total)
    };
    assert_eq!(layered(1), None, "slowing is refused");
    let best = (2..=4).filter_map(layered).fold(f64::INFINITY, f64::min);
    ledger("steady load, pocket by trochoids", &format!("{best:.0} s"), &format!("{time:.0} s"));
    assert!(time < best, "{time} of {best} s");
}

/// Without a limit that slowing breaks, the wish for thick chips is no reason to take longer than slowing does: on the
/// blade loops for it would.
#[test]
fn a_wish_for_thick_chips_costs_no_time() {
    let pocket_with = |control: &str| {
        pocket(&format!("power = 120.0\ncontrol = \"{control}\"\n[material]\ngroup = \"S\"\n"))
    };
    let blade_with = |control: &str| {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../jobs/blade.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let shipped = "relative = 1.5\ncontrol = \"fastest\"\nvfc = \"mean\"\n";
        let own = format!("power = 40.0\ncontrol = \"{control}\"\n[material]\ngroup = \"S\"\n");
        assert!(text.contains(shipped));
        read("blade", &text.replace(shipped, &own))
    };
    let jobs: [&dyn Fn(&str) -> Job; 2] = [&pocket_with, &blade_with];
    for job in jobs {
        let prepared = prepared(&job("feed"), "../jobs");
        let [fastest, feed] = ["fastest", "feed"].map(|control| report(&prepared, &job(control)));
        let time = |r: &Report| r.delivered.machine_time_s.total;
        let verification = fastest.verification.as_ref();
        assert!(verification.is_some_and(|v| v.passed), "{:?}", fastest.verification);
        let (time, asked) = (time(&fastest), 1.001 * time(&feed));
        assert!(time <= asked, "{}: {time} s, not {asked}", job("feed").name);
    }
}
