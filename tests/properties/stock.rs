//! Stock whose end the job gives: no thicker over the surface than is cut at once, above it the rapids, and what the cutter
//! does to it beside the surface is measured.

use std::fmt::Write;

use evencut_core::geometry::DVec3;
use evencut_core::job::{self, Job, Resolved};
use evencut_core::plan::{Files, PlanError, Planned, plan};
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::verify::{Broken, Verification, VerifyOptions, verify};
use evencut_output::report::{StockCutFigures, VerificationFigures};
use evencut_service::compare::judged;
use evencut_service::results::{Input, ResultsOptions, operations_results, verify_options};
use evencut_service::verdict::Workpiece;

const PLANE: &str = "[surface.analytic]\nkind = \"plane\"\nsize = 50.0\nresolution = 2.0\n";
const FLAT: &str = "[tool]\nkind = \"flat\"\ndiameter = 10.0\n[cut]\nstepover = 2.0\nfeed = 1200.0\n\
                    axial_depth = 0.5\ntolerance = 0.01\n[force]\ncontrol = \"off\"\n";
const BALL: &str = "[tool]\nkind = \"ball\"\ndiameter = 8.0\n[cut]\nscallop = 0.05\nfeed = 1200.0\n\
                    axial_depth = 0.5\ntolerance = 0.01\n[force]\ncontrol = \"off\"\n";
/// A plate under the plane with half a millimetre on it, on which nothing else stands.
const PLATE: [[f64; 3]; 2] = [[-25.0, -25.0, -10.0], [25.0, 25.0, 0.5]];

fn resolved(text: &str) -> Resolved {
    let text = format!("version = 1\n{text}");
    match job::read(text.as_bytes()) {
        Ok(resolved) => resolved,
        Err(faults) => panic!("{}", faults.render("stock", text.as_bytes())),
    }
}

fn in_box(cutter: &str, [low, high]: [[f64; 3]; 2]) -> Job {
    let job = resolved(&format!("{PLANE}{cutter}[stock]\nbox = [{low:?}, {high:?}]\n")).job;
    assert_eq!(job::read(job.to_toml().as_bytes()).unwrap().job, job);
    job
}

/// Boxes as OBJ, outward.
fn blocks(all: &[[[f64; 3]; 2]]) -> Vec<u8> {
    let mut text = String::new();
    for [low, high] in all {
        for z in [low[2], high[2]] {
            let (x, y) = ([low[0], high[0]], [low[1], high[1]]);
            for (i, j) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                writeln!(text, "v {} {} {z}", x[i], y[j]).unwrap();
            }
        }
        text.push_str("f -5 -6 -7 -8\nf -4 -3 -2 -1\nf -8 -7 -3 -4\nf -7 -6 -2 -3\nf -6 -5 -1 -2\nf -5 -8 -4 -1\n");
    }
    text.into_bytes()
}

fn planned(job: &Job, files: Files) -> (Planned, VerificationFigures) {
    let plan = plan(job, files, 2, &mut |_, _| {}).unwrap_or_else(|error| panic!("{error}"));
    let figures = judged(job, &plan, 2).unwrap();
    let verification = figures.verification().unwrap().clone();
    (plan, verification)
}

fn refused(job: &Job, files: Files) -> PlanError {
    match plan(job, files, 2, &mut |_, _| {}) {
        Ok(_) => panic!("planned"),
        Err(error) => error,
    }
}

/// A path judged in the stock of a job.
fn found(job: &Job, files: Files, path: &Toolpath) -> Verification {
    let (workpiece, cusps) = Workpiece::of_job(job, files, 1).unwrap();
    let options = VerifyOptions { stock: workpiece.stock.clone(), ..verify_options(job, cusps, 2) };
    verify(path, workpiece.design(), workpiece.rest(), &options, &mut |_| {}).unwrap()
}

/// What is on the surface is taken, and no more where the stock goes on beside it.
#[test]
fn stock_as_thick_as_the_cut_is_machined_wherever_it_ends() {
    for (name, cutter) in [("flat", FLAT), ("ball", BALL)] {
        for beside in [0.0, 0.3, 2.0, 30.0] {
            let [mut low, mut high] = PLATE;
            for axis in 0..2 {
                low[axis] -= beside;
                high[axis] += beside;
            }
            let (plan, v) = planned(&in_box(cutter, [low, high]), Files::default());
            assert!(v.passed, "{name}, {beside} mm beside: {:?}", v.broken);
            let StockCutFigures { allowed_mm, deepest_mm, .. } = v.stock.unwrap();
            println!(
                "{name:5}{beside:5} mm beside: {deepest_mm:.4} mm deep, {allowed_mm:.4} allowed"
            );
            assert!((allowed_mm - 0.51).abs() < 1e-12, "{allowed_mm}");
            assert!((0.49..=0.51).contains(&deepest_mm), "{name}, {beside}: {deepest_mm}");
            let clearance = in_box(cutter, PLATE).machine.clearance;
            assert!(plan.rapid_plane >= high[2] + clearance, "{}", plan.rapid_plane);
        }
    }
}

#[test]
fn stock_thicker_than_the_cut_is_refused_with_place_and_thickness() {
    let [low, _] = PLATE;
    let too_thick = in_box(BALL, [low, [25.0, 25.0, 0.8]]);
    let error = refused(&too_thick, Files::default());
    let PlanError::StockTooThick { place, thickness, allowed } = error else { panic!("{error}") };
    assert!((thickness - 0.8).abs() < 1e-9 && allowed == 0.5 && place.z == 0.0, "{error}");
    // Only over a corner of it.
    let step = [[10.0, 10.0, 0.2], [24.0, 24.0, 3.0]];
    let files = [("rough.obj".to_owned(), blocks(&[PLATE, step]))];
    let files = Files { meshes: &files, ..Files::default() };
    let of_mesh = resolved(&format!("{PLANE}{BALL}[stock]\nfile = \"rough.obj\"\n")).job;
    assert_eq!(job::read(of_mesh.to_toml().as_bytes()).unwrap().job, of_mesh);
    let error = refused(&of_mesh, files);
    let PlanError::StockTooThick { place, thickness, .. } = error else { panic!("{error}") };
    assert!((thickness - 3.0).abs() < 1e-9, "{error}");
    let within = |x: f64| (10.0..=24.0).contains(&x);
    assert!(within(place.x) && within(place.y), "{error}");
}

/// Some programs write bodies inside out.
#[test]
fn stock_that_is_inside_out_is_turned() {
    let [low, _] = PLATE;
    let text = String::from_utf8(blocks(&[[low, [25.0, 25.0, 0.8]]])).unwrap();
    let turned = |line: &str| match line.strip_prefix("f ") {
        Some(corners) => {
            let corners: Vec<&str> = corners.split(' ').rev().collect();
            format!("f {}\n", corners.join(" "))
        }
        None => format!("{line}\n"),
    };
    let inward: String = text.lines().map(turned).collect();
    let files = [("in.obj".to_owned(), inward.into_bytes())];
    let of_mesh = resolved(&format!("{PLANE}{BALL}[stock]\nfile = \"in.obj\"\n")).job;
    let error = refused(&of_mesh, Files { meshes: &files, ..Files::default() });
    let PlanError::StockTooThick { thickness, .. } = error else { panic!("{error}") };
    assert!((thickness - 0.8).abs() < 1e-9, "{error}");
}

#[test]
fn a_mesh_with_openings_is_no_stock() {
    let open = b"v -30 -30 1\nv 30 -30 1\nv 30 30 1\nv -30 30 1\nf 1 2 3 4\n".to_vec();
    let files = [("sheet.obj".to_owned(), open)];
    let of_mesh = resolved(&format!("{PLANE}{BALL}[stock]\nfile = \"sheet.obj\"\n")).job;
    let error = refused(&of_mesh, Files { meshes: &files, ..Files::default() });
    assert!(matches!(error, PlanError::OpenStock), "{error}");
}

/// A block stands beside the plate: the cutter, whose passes run along the edge, cuts into its side.
#[test]
fn what_the_cutter_does_to_stock_beside_the_surface_is_found() {
    let block = [[26.0, -20.0, -10.0], [60.0, 20.0, 12.0]];
    let files = [("stock.obj".to_owned(), blocks(&[PLATE, block]))];
    let files = Files { meshes: &files, ..Files::default() };
    let job = resolved(&format!("{PLANE}{FLAT}[stock]\nfile = \"stock.obj\"\n")).job;
    let (plan, v) = planned(&job, files);
    assert!(plan.rapid_plane >= 12.0 + job.machine.clearance, "{}", plan.rapid_plane);
    let points = plan.toolpath.points.iter();
    let cuts = points.filter(|p| p.kind != MoveKind::Rapid);
    let farthest = cuts.map(|p| p.tip.x).fold(f64::MIN, f64::max);
    let expected = farthest + 5.0 - 26.0;
    let stock = v.stock.as_ref().unwrap();
    println!("{:.4} mm deep in the block's side, {expected:.4} expected", stock.deepest_mm);
    assert!(
        !v.passed && v.broken.iter().any(|b| b.contains("into the stock at")),
        "{:?}",
        v.broken
    );
    assert!(expected > 1.0 && (stock.deepest_mm - expected).abs() < 0.05, "{stock:?}");
    // The judge that does not know it finds nothing.
    let bare = Job { stock: None, ..job };
    let found = found(&bare, Files::default(), &plan.toolpath);
    assert_eq!(found.figures.broken, []);
}

/// A rapid through stock beside the surface is found, unless a cut was there before.
#[test]
fn rapids_through_stock_beside_the_surface_are_found() {
    let [low, high] = PLATE;
    let wide = [[low[0] - 30.0, low[1], low[2]], [high[0] + 30.0, high[1], high[2]]];
    let job = in_box(BALL, wide);
    let plan = plan(&job, Files::default(), 2, &mut |_, _| {}).unwrap();
    let high = plan.rapid_plane;
    let with = |kinds: &[MoveKind]| {
        let mut path = plan.toolpath.clone();
        let last = *path.points.last().unwrap();
        let mut push = |kind, x, z| {
            path.points.push(PathPoint {
                kind,
                tip: DVec3::new(x, 0.0, z),
                flat: None,
                feed: if kind == MoveKind::Rapid { 100.0 } else { 10.0 },
                ..last
            });
        };
        for &kind in kinds {
            push(MoveKind::Rapid, 40.0, high);
            push(kind, 40.0, 0.2);
            push(MoveKind::Rapid, 40.0, high);
        }
        let broken = found(&job, Files::default(), &path).figures.broken;
        broken.into_iter().find_map(|b| match b {
            Broken::Rapid { worst, .. } => Some(worst.depth),
            _ => None,
        })
    };
    let depth = with(&[MoveKind::Rapid]).unwrap();
    assert!((depth - 0.3).abs() < 0.02, "{depth}");
    assert_eq!(with(&[MoveKind::Link, MoveKind::Rapid]), None);
    assert_eq!(with(&[]), None);
}

/// A holder that goes over the surface alone meets what stands beside it.
#[test]
fn a_holder_that_meets_stock_beside_the_surface_is_found() {
    let text = "[tool]\nkind = \"ball\"\ndiameter = 8.0\nlength = 15.0\nstickout = 20.0\n\
                holder = [{ diameter = 40.0, length = 30.0 }]\n[cut]\nscallop = 0.05\nfeed = 1200.0\n\
                axial_depth = 0.5\ntolerance = 0.01\n[force]\ncontrol = \"off\"\n";
    let wall = |top: f64| {
        let files =
            [("stock.obj".to_owned(), blocks(&[PLATE, [[31.0, -20.0, -10.0], [60.0, 20.0, top]]]))];
        let files = Files { meshes: &files, ..Files::default() };
        let job = resolved(&format!("{PLANE}{text}[stock]\nfile = \"stock.obj\"\n")).job;
        planned(&job, files).1
    };
    let clear = wall(15.0);
    assert!(clear.passed, "{:?}", clear.broken);
    let holder = |v: &VerificationFigures| {
        v.above_cutter.iter().find(|n| n.part == "holder").map(|n| n.clearance_mm)
    };
    assert!((holder(&clear).unwrap() - 5.0).abs() < 0.05, "{:?}", clear.above_cutter);
    let met = wall(25.0);
    assert!(met.broken.iter().any(|b| b.contains("the holder cuts")), "{:?}", met.broken);
}

/// The second operation meets the stock as the first one has left it.
#[test]
fn operations_cut_what_those_before_left() {
    let [low, high] = PLATE.map(|c| [c[0] * 2.0, c[1] * 2.0, c[2]]);
    let text = format!(
        "version = 1\n{PLANE}{FLAT}[stock]\nbox = [{low:?}, {high:?}]\n\
         [[operation]]\n[operation.cut]\nallowance = 0.2\naxial_depth = 0.3\n\
         [[operation]]\n[operation.cut]\naxial_depth = 0.2\n"
    );
    let resolved = job::read(text.as_bytes())
        .unwrap_or_else(|faults| panic!("{}", faults.render("stock", text.as_bytes())));
    let input = Input { name: "stock.toml", bytes: text.as_bytes() };
    let options = ResultsOptions { threads: 2, verify: true };
    let results =
        operations_results(&resolved, input, Files::default(), options, &mut |_, _, _| {})
            .unwrap_or_else(|error| panic!("{error:?}"));
    assert_eq!(results.report.passed, Some(true), "{:?}", results.report.broken());
    let deepest = |i: usize| {
        let v = results.operations[i].report.verification.as_ref().unwrap();
        v.stock.as_ref().unwrap().deepest_mm
    };
    assert!((deepest(0) - 0.3).abs() < 0.01 && (deepest(1) - 0.5).abs() < 0.01);
}

/// A plate with a pocket, as a rougher leaves it: half a millimetre on all sides, in a pocket whose walls are steep.
#[test]
fn roughed_stock_with_a_pocket_is_as_thick_as_what_was_left() {
    let left = 0.5;
    // Outside and pocket at each height of the part; walls lean by a tenth.
    let rings = |by: f64| {
        let outer = |z: f64| (14.0 + by, z);
        [outer(-12.0 - by), outer(by), (8.0 - 0.9 * by, by), (7.2 - 0.9 * by, -8.0 + by)]
    };
    let part = |by: f64| {
        let mut text = String::new();
        for (half, z) in rings(by) {
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                writeln!(text, "v {} {} {z}", half * x, half * y).unwrap();
            }
        }
        text.push_str("f 4 3 2 1\n");
        for ring in 0..3 {
            for (i, j) in [(1, 2), (2, 3), (3, 4), (4, 1)] {
                let at = |k: usize, up: usize| 4 * (ring + up) + k;
                writeln!(text, "f {} {} {} {}", at(i, 0), at(j, 0), at(j, 1), at(i, 1)).unwrap();
            }
        }
        text.push_str("f 13 14 15 16\n");
        text.into_bytes()
    };
    let job = |stock: &str, depth: f64| {
        resolved(&format!(
            "[surface]\nfile = \"part.obj\"\nsteepest = 80.0\n[tool]\nkind = \"ball\"\ndiameter = 4.0\n[cut]\n\
             scallop = 0.05\nfeed = 1200.0\naxial_depth = {depth}\ntolerance = 0.02\n[force]\ncontrol = \"off\"\n\
             [stock]\n{stock}"
        ))
        .job
    };
    let meshes = [("rough.obj".to_owned(), part(left))];
    let surface = part(0.0);
    let files = Files { surface: Some(&surface), meshes: &meshes, ..Files::default() };
    let roughed = job("file = \"rough.obj\"\n", left);
    let (_, figures) = planned(&roughed, files);
    assert!(figures.passed, "{figures:?}");
    let PlanError::StockTooThick { thickness, .. } =
        refused(&job("file = \"rough.obj\"\n", 0.4), files)
    else {
        panic!("another error")
    };
    assert!((thickness - left).abs() < 0.05, "{thickness}");
    // A whole block is as thick as the pocket is deep, at most.
    let block = job("box = [[-20.5, -20.5, -12.5], [20.5, 20.5, 0.5]]\n", left);
    let PlanError::StockTooThick { thickness, .. } = refused(&block, files) else {
        panic!("another error")
    };
    assert!((thickness - 8.5).abs() < 0.05, "{thickness}");
}
