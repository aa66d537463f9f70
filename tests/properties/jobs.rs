//! Every job, shipped and on real surfaces: what a plan promises holds for it.

use evencut_core::geometry::DVec3;
use evencut_core::job::{self, ForceControl, Job, Resolved, Stepover, SurfaceSource};
use evencut_core::link::DeliverError;
use evencut_core::machine::Axes;
use evencut_core::plan::{Files, PlanError, plan};
use evencut_core::toolpath::{MoveKind, Toolpath};
use evencut_core::verify::MRR_NOISE;
use evencut_output::gcode::{self, CheckOptions};
use evencut_output::report::Report;
use evencut_service::results::{Input, Results, ResultsOptions, operations_results, results};
use evencut_tests::follow::{assert_follows, met, read_for};
use evencut_tests::ledger;
use evencut_tests::linuxcnc::{in_part, interpreted};
use evencut_tests::shared_data;
use std::path::{Path, PathBuf};

/// Largest share of the area that may be left uncovered where the cutter fits, percent.
const UNCOVERED: f64 = 0.1;
/// The plain rings of every job exceed the limit at least so many times.
const PLAIN_EXCESS: f64 = 1.3;

/// Largest measured removal rate, over the limit. On facets that are coarse for the cutter windows scatter more: the
/// verdict allows for it.
const MEASURED_PEAK: f64 = 1.0;
/// Largest difference of predicted and measured removal rate, RMS over the limit.
const AGREEMENT: f64 = 0.03;

fn jobs_in(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path());
    let mut jobs: Vec<_> = entries.filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
    jobs.sort();
    jobs
}

/// A job file as it is read.
fn read(path: &Path) -> (Vec<u8>, Resolved) {
    let source = std::fs::read(path).unwrap();
    let resolved = job::read(&source)
        .unwrap_or_else(|faults| panic!("{}", faults.render(&path.display().to_string(), &source)));
    (source, resolved)
}

fn planned(path: &Path, threads: usize) -> (Job, Results) {
    let (source, resolved) = read(path);
    let job = resolved.only().unwrap().job;
    let file = match &job.surface.source {
        SurfaceSource::File(name) => {
            let bytes = std::fs::read(path.parent().unwrap().join(name)).unwrap();
            Some(bytes)
        }
        SurfaceSource::Analytic(_) => None,
    };
    let named =
        |name: &str| (name.to_owned(), std::fs::read(path.parent().unwrap().join(name)).unwrap());
    let blades: Vec<_> = job.blade_files().into_iter().map(named).collect();
    let files = Files { blades: &blades, ..Files::of_surface(file.as_deref()) };
    let input = Input { name: "job.toml", bytes: &source };
    let results =
        results(&job, input, files, ResultsOptions { threads, verify: true }, &mut |_, _| {})
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    (job, results)
}

fn text<'a>(results: &'a Results, name: &str) -> &'a str {
    let file = results.files.iter().find(|f| f.name == name).unwrap();
    std::str::from_utf8(&file.bytes).unwrap()
}

/// The limit is kept, the plain passes break it, nothing is left, and the table says the same.
fn check_promises(name: &str, results: &Results) {
    let Report { plain, slowed, delivered, coverage, force, gouge, .. } = &results.report;
    let (Some(plain), Some(slowed)) = (plain, slowed) else { panic!("{name}: no plain passes") };
    let [plain_rate, slowed_rate, rate] = [plain, slowed, delivered].map(|p| p.rate.unwrap());
    println!(
        "{name:34} plain {:6.3} delivered {:6.4} of the limit; {:7.0} {:7.0} {:7.0} mm; \
         {:6.0} {:6.0} {:6.0} s; uncovered {:.4} % inaccessible {:.1} mm2 lifted {}",
        plain_rate.peak_over_limit,
        rate.peak_over_limit,
        plain.length_mm.total,
        slowed.length_mm.total,
        delivered.length_mm.total,
        plain.time_s.total,
        slowed.time_s.total,
        delivered.time_s.total,
        coverage.never_covered_percent,
        coverage.inaccessible_mm2,
        gouge.lifted.len(),
    );
    assert!(rate.peak_over_limit <= 1.0, "{name}: {}", rate.peak_over_limit);
    assert!(plain_rate.peak_over_limit >= PLAIN_EXCESS, "{name}: {}", plain_rate.peak_over_limit);
    assert!(slowed_rate.peak_over_limit <= 1.0 + 1e-9, "{name}");
    assert!(coverage.never_covered_percent <= UNCOVERED, "{name}");
    let path = Toolpath::from_csv(text(results, "toolpath.csv")).unwrap();
    let peak = path.points.iter().map(|p| 60.0 * p.mrr).fold(0.0, f64::max);
    assert!(peak <= force.limit_mm3_per_min * (1.0 + 1e-6), "{name}: the table peaks at {peak}");
    assert!(path.points.windows(2).all(|w| w[1].time >= w[0].time), "{name}: time runs back");
    assert!(path.points.iter().all(|p| p.feed > 0.0), "{name}: a move without feed");
}

/// What the simulation measured keeps every limit and agrees with what was predicted.
fn check_verdict(name: &str, job: &Job, results: &Results, most: f64) {
    let Some(v) = &results.report.verification else { panic!("{name}: not verified") };
    let s = &v.scallop;
    let limit = s.limit_mm.unwrap();
    println!(
        "{:34} scallop {:6.1} of {:6.1} µm (+ {:4.1}, sampling {:4.1}); gouge {:5.1} µm; untouched \
         {:.3} mm2; inaccessible {:.2} %",
        "  measured",
        1e3 * s.largest_mm,
        1e3 * limit,
        1e3 * s.tolerance_mm,
        1e3 * s.sampling_bound_mm,
        1e3 * v.gouge_mm,
        v.untouched_mm2,
        100.0 * v.inaccessible_mm2 / (v.area_mm2 + v.inaccessible_mm2),
    );
    assert!(s.largest_mm <= limit + s.tolerance_mm, "{name}: {:?}", v.broken);
    assert!(v.gouge_mm >= -s.tolerance_mm, "{name}: {:?}", v.broken);
    assert_eq!(v.untouched_mm2, 0.0, "{name}: {:?}", v.broken);
    // Only finishing jobs, which ask for a scallop, go without a limit on the rate.
    let is_finish = matches!(job.cut.stepover, Stepover::Scallop(_));
    assert!(is_finish || job.force.control != ForceControl::Off, "{name}: no limit at all");
    if job.force.control != ForceControl::Off {
        let Some(mrr) = &v.mrr else { panic!("{name}: no removal rate") };
        let (peak, rms) = (mrr.peak_over_limit.unwrap(), mrr.rms_difference_over_limit.unwrap());
        println!("{:34} peak {peak:.4}, RMS {rms:.4} of the limit", "");
        ledger(&format!("judged peak of {name}"), "1.00", &format!("{peak:.3}"));
        assert!(peak <= most, "{name}: {peak}");
        assert!(rms <= AGREEMENT, "{name}: {rms}");
    }
    assert!(v.passed && v.program.is_empty(), "{name}: {:?} {:?}", v.broken, v.program);
}

/// The program, read back and interpreted, is the path.
fn check_program(name: &str, job: &Job, results: &Results) {
    let path = Toolpath::from_csv(text(results, "toolpath.csv")).unwrap();
    let program = text(results, "program.ngc");
    let rapids = || path.points.iter().filter(|p| p.kind == MoveKind::Rapid);
    let plane = rapids().map(|p| p.tip.dot(p.axis)).fold(f64::INFINITY, f64::min) - 0.001;
    let read = read_for(&job.machine, program);
    assert_follows(&path, &met(&read), plane, job.cut.tolerance, job.tool.radius());
    let limits = CheckOptions {
        // The table of points holds six decimals, the program four.
        clearance_plane: rapids().next().map(|_| plane + 0.001),
        travel: job.machine.travel,
        max_feed: Some(job.machine.max_feed),
    };
    assert_eq!(gcode::check(&read, &limits), [], "{name}");
    if job.machine.axes == Axes::ThreeAxis
        && let Some(verdict) = interpreted(program, name)
    {
        let moves = verdict.unwrap_or_else(|why| panic!("{name}: LinuxCNC rejects it: {why}"));
        let read: Vec<(bool, DVec3, DVec3)> =
            moves.iter().map(|&(rapid, p)| (rapid, in_part(p).0, in_part(p).1)).collect();
        assert_follows(&path, &read[1..], plane, job.cut.tolerance, job.tool.radius());
    }
}

/// `most`: the largest measured removal rate, over the limit.
fn check(path: &Path, job: &Job, results: &Results, most: f64) {
    let name = path.file_stem().unwrap().to_string_lossy();
    if job.force.control != ForceControl::Off {
        check_promises(&name, results);
    }
    check_verdict(&name, job, results, most);
    check_program(&name, job, results);
}

/// What they promise. By several threads: the page's tests compare each of them with the one thread of WebAssembly.
#[test]
fn shipped_jobs_keep_their_promises() {
    let jobs = jobs_in("../jobs");
    assert!(jobs.len() >= 4);
    for path in jobs {
        if read(&path).1.operations.is_empty() {
            let (job, results) = planned(&path, 3);
            check(&path, &job, &results, MEASURED_PEAK);
        } else {
            check_operations(&path);
        }
    }
}

/// Every operation keeps its limits; what the first cutter cannot reach is there after it and gone after the last.
fn check_operations(path: &Path) {
    let (source, resolved) = read(path);
    let input = Input { name: "job.toml", bytes: &source };
    let planned = |threads| {
        let options = ResultsOptions { threads, verify: true };
        operations_results(&resolved, input, Files::default(), options, &mut |_, _, _| {}).unwrap()
    };
    let results = planned(3);
    let report = &results.report;
    println!("{}", report.summary());
    assert_eq!((report.passed, report.broken()), (Some(true), Vec::new()));
    let rest: Vec<f64> = report.operations.iter().map(|o| o.rest_mm2.unwrap()).collect();
    let (first, last) = (rest[0], rest[rest.len() - 1]);
    assert!(first > 100.0 && last == 0.0, "{rest:?}");
    // It goes over what was left, and not over all.
    assert!(report.operations[1].length_mm < 0.5 * report.operations[0].length_mm);
    for (results, operation) in results.operations.iter().zip(&resolved.operations) {
        check_verdict(&operation.name, &operation.job, results, MEASURED_PEAK);
    }
    assert!(planned(1).files == results.files, "{}: threads change something", path.display());
    let program = results.files.iter().find(|f| f.name == "program.ngc").unwrap();
    let program = std::str::from_utf8(&program.bytes).unwrap();
    assert!(program.contains("T1 M6") && program.contains("T2 M6") && program.contains("G43 H2"));
    if let Some(moves) = interpreted(program, "operations") {
        let moves = moves.unwrap_or_else(|error| panic!("LinuxCNC refuses the program: {error}"));
        assert!(moves.len() > 5000, "{} moves", moves.len());
    }
}

/// The same bytes by any number of threads, on a job with trochoids and on one with regions.
#[test]
fn threads_change_no_byte() {
    for name in ["saddle", "bump"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../jobs/{name}.toml"));
        let [(_, one), (_, three)] = [1, 3].map(|threads| planned(&path, threads));
        assert_eq!(one.files.len(), three.files.len());
        for (a, b) in one.files.iter().zip(&three.files) {
            assert!(a == b, "{name}: {} differs", a.name);
        }
    }
}

fn jobs_keep_their_promises(folder: &str, at_least: usize, most: f64) {
    if shared_data().is_none() {
        return;
    }
    let jobs = jobs_in(folder);
    assert!(jobs.len() >= at_least);
    for path in jobs {
        let (job, results) = planned(&path, 2);
        check(&path, &job, &results, most);
    }
}

#[test]
fn jobs_on_real_surfaces_keep_their_promises() {
    jobs_keep_their_promises("real", 5, MEASURED_PEAK);
}

/// Larger meshes, and coarse ones as fine ones.
#[test]
#[ignore = "long: cargo xtask accept"]
fn jobs_on_large_real_surfaces_keep_their_promises() {
    jobs_keep_their_promises("real/long", 4, MRR_NOISE);
}

/// A job with nothing but what must be said, for any file.
fn bare_job(file: &str, control: &str) -> Job {
    let text = format!(
        "version = 1\n[surface]\nfile = \"{file}\"\n[tool]\ndiameter = 10.0\n[cut]\nstepover = 4.0\n\
         feed = 1000.0\n[force]\ncontrol = \"{control}\"\n"
    );
    job::read(text.as_bytes()).unwrap().job
}

/// No file, however bad, ends in a fault of our own.
#[test]
fn nasty_files_are_planned_or_refused() {
    plan_nasty_files("feed");
}

#[test]
#[ignore = "long: cargo xtask accept"]
fn nasty_files_are_planned_with_trochoids_or_refused() {
    plan_nasty_files("trochoid");
}

fn plan_nasty_files(control: &str) {
    let Some(data) = shared_data() else { return };
    let mut files: Vec<_> =
        std::fs::read_dir(data.join("nasty")).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 60);
    let mut planned = 0;
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy().to_lowercase();
        let bytes = std::fs::read(&file).unwrap();
        match plan(&bare_job(&name, control), Files::of_surface(Some(&bytes)), 2, &mut |_, _| {}) {
            Ok(plan) => {
                planned += 1;
                let peak = plan.toolpath.points.iter().map(|p| p.mrr).fold(0.0, f64::max);
                assert!(peak <= bare_job(&name, control).mrr_limit(), "{name}: {peak}");
            }
            Err(PlanError::Deliver(error @ DeliverError::Outside(_))) => panic!("{name}: {error}"),
            Err(error) => assert!(error.to_string().len() > 20, "{name}: {error}"),
        }
    }
    assert!(planned >= 14, "only {planned} were planned");
}
