//! What stands beside the surface: the tool keeps its distance from it on every move, and a path that does not is found.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

use evencut_core::job::{self, Job};
use evencut_core::plan::{Files, Planned, plan};
use evencut_core::verify::{Broken, verify};
use evencut_output::report::{AvoidedFigures, TiltFigures, VerificationFigures};
use evencut_service::compare::judged;
use evencut_service::results::verify_options;
use evencut_service::verdict::Workpiece;

const PLANE: &str = "[surface.analytic]\nkind = \"plane\"\nsize = 50.0\nresolution = 2.0\n";
const FLAT: &str = "[tool]\nkind = \"flat\"\ndiameter = 10.0\n[cut]\nstepover = 2.0\nfeed = 1200.0\n\
                    axial_depth = 0.5\ntolerance = 0.01\n[force]\ncontrol = \"off\"\n";
const BALL: &str = "[tool]\nkind = \"ball\"\ndiameter = 8.0\n[cut]\nscallop = 0.05\nfeed = 1200.0\n\
                    axial_depth = 0.5\ntolerance = 0.01\n[force]\ncontrol = \"off\"\n";

fn job(text: &str) -> Job {
    let text = format!("version = 1\n{text}");
    match job::read(text.as_bytes()) {
        Ok(resolved) => resolved.job,
        Err(faults) => panic!("{}", faults.render("avoid", text.as_bytes())),
    }
}

/// A table for a clamp.
fn avoid(file: &str, distance: f64) -> String {
    format!("[[avoid]]\nfile = \"{file}.obj\"\ndistance = {distance}\n")
}

/// A box from `low` to `high` as OBJ, outward.
fn block(low: [f64; 3], high: [f64; 3]) -> Vec<u8> {
    let mut text = String::new();
    for z in [low[2], high[2]] {
        for (x, y) in [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])] {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
    }
    text.push_str("f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    text.into_bytes()
}

/// Meshes by their names.
fn held(meshes: &[(&str, Vec<u8>)]) -> Vec<(String, Vec<u8>)> {
    meshes.iter().map(|(name, bytes)| (format!("{name}.obj"), bytes.clone())).collect()
}

fn planned(job: &Job, files: Files) -> (Planned, VerificationFigures) {
    let plan = plan(job, files, 2, &mut |_, _| {}).unwrap_or_else(|error| panic!("{error}"));
    let figures = judged(job, &plan, 2).unwrap();
    let verification = figures.verification().unwrap().clone();
    (plan, verification)
}

/// A path through a box that stands at the edge of a plate is kept clear of it by the distance that is asked, and no
/// farther than by two tolerances more; what stays beside it is as large as the cutter and that distance make it.
fn check_clamp(name: &str, cutter: &str, lacks: f64, distance: f64) {
    let clamps = held(&[("clamp", block([-30.0, -10.0, -5.0], [-15.0, 10.0, 12.0]))]);
    let files = Files { meshes: &clamps, ..Files::default() };
    let job = job(&format!("{PLANE}{cutter}{}", avoid("clamp", distance)));
    assert_eq!(job::read(job.to_toml().as_bytes()).unwrap().job, job);
    let (_, v) = planned(&job, files);
    let [figures] = &v.avoided[..] else { panic!("{:?}", v.avoided) };
    let wide = distance + lacks;
    let expected = 200.0 + 40.0 * wide + FRAC_PI_2 * wide * wide;
    println!(
        "{name:16} {:8.4} mm clear of {distance} asked, rest {:8.3} of {expected:8.3} mm²",
        figures.clearance_mm, v.rest_mm2
    );
    assert!(v.passed, "{name}: {:?}", v.broken);
    assert_eq!(
        (&figures.name[..], &figures.part[..], figures.asked_mm),
        ("clamp", "cutter", distance)
    );
    let most = distance + 2.0 * job.cut.tolerance;
    assert!((distance..=most).contains(&figures.clearance_mm), "{name}: {figures:?}");
    assert!((v.rest_mm2 - expected).abs() <= 0.03 * expected, "{name}: {}", v.rest_mm2);

    // The path that knows nothing of the clamp cuts it, and the judge says so.
    let bare = Job { avoid: Vec::new(), ..job.clone() };
    let without = plan(&bare, Files::default(), 2, &mut |_, _| {}).unwrap();
    let (workpiece, _) = Workpiece::of_job(&job, files, 1).unwrap();
    let options = verify_options(&job, without.cusps.limit, 2);
    let options =
        evencut_core::verify::VerifyOptions { avoided: workpiece.avoided.clone(), ..options };
    let (design, rest) = (workpiece.design(), workpiece.rest());
    let found = verify(&without.toolpath, design, rest, &options, &mut |_| {}).unwrap();
    let depth = found.figures.broken.iter().find_map(|b| match b {
        Broken::Avoided { index: 0, nearest, .. } => Some(nearest.distance),
        _ => None,
    });
    assert!(depth.is_some_and(|depth| depth < -1.0), "{name}: {:?}", found.figures.broken);
    assert!(found.figures.gouge.is_none_or(|g| g.height >= -job.cut.tolerance), "{name}");
}

#[test]
fn a_flat_end_keeps_its_distance_from_a_clamp() {
    check_clamp("flat, touching", FLAT, 0.0, 0.0);
    check_clamp("flat", FLAT, 0.0, 1.5);
}

#[test]
fn a_ball_keeps_its_distance_from_a_clamp() {
    // As deep as the scallop is high, the ball is so far from its side.
    let lacks = 4.0 - (4.0f64 * 4.0 - 3.95 * 3.95).sqrt();
    check_clamp("ball, touching", BALL, lacks, 0.0);
    check_clamp("ball", BALL, lacks, 0.8);
}

/// Figures of one of several.
fn named<'a>(v: &'a VerificationFigures, name: &str) -> &'a AvoidedFigures {
    v.avoided.iter().find(|a| a.name == name).unwrap()
}

/// Each keeps its own distance, with passes of any kind, one farther than the rapids usually run over the part.
#[test]
fn several_are_kept_clear_of_each_by_its_own_distance() {
    let meshes = held(&[
        ("left", block([-30.0, -10.0, -5.0], [-20.0, 10.0, 12.0])),
        ("tower", block([-2.0, -2.0, -5.0], [2.0, 2.0, 60.0])),
        ("far", block([90.0, -9.0, -5.0], [99.0, 9.0, 9.0])),
    ]);
    let files = Files { meshes: &meshes, ..Files::default() };
    for pattern in ["contour", "iso-planar", "spiral"] {
        let tables = [avoid("left", 0.3), avoid("tower", 2.0), avoid("far", 3.0)].concat();
        let job = job(&format!("{PLANE}{BALL}[path]\npattern = \"{pattern}\"\n{tables}"));
        let (plan, v) = planned(&job, files);
        println!("{pattern}: {:?}", v.avoided);
        assert!(v.broken.is_empty(), "{pattern}: {:?}", v.broken);
        let most = 2.0 * job.cut.tolerance;
        for (name, distance) in [("left", 0.3), ("tower", 2.0)] {
            let a = named(&v, name);
            assert!((distance..=distance + most).contains(&a.clearance_mm), "{pattern}: {a:?}");
        }
        assert!(named(&v, "far").is_at_least, "{pattern}");
        // Over the tower the rapids have the machine's clearance and the distance.
        let over = 60.0 + 2.0 + job.machine.clearance;
        assert!(
            (over..=over + most).contains(&plan.rapid_plane),
            "{pattern}: {}",
            plan.rapid_plane
        );
    }
}

/// The same where the surface is what the cutter reaches of a part.
#[test]
fn what_is_reached_of_a_part_is_cut_clear_of_a_clamp() {
    let part = block([0.0, 0.0, -10.0], [40.0, 30.0, 0.0]);
    let clamps = held(&[("clamp", block([-10.0, 10.0, -10.0], [8.0, 20.0, 15.0]))]);
    let files = Files { surface: Some(&part), meshes: &clamps, ..Files::default() };
    let surface = "[surface]\nfile = \"part.obj\"\nsteepest = 60.0\n";
    let job = job(&format!("{surface}{BALL}{}", avoid("clamp", 0.7)));
    let (plan, v) = planned(&job, files);
    let clamp = named(&v, "clamp");
    assert!(v.passed, "{:?}", v.broken);
    assert!((0.7..=0.72).contains(&clamp.clearance_mm), "{clamp:?}");
    // What stays at the clamp is not for a smaller cutter.
    let figures = judged(&job, &plan, 2).unwrap();
    let warnings = &figures.report.warnings;
    assert!(warnings.iter().any(|w| w.remedy.contains("only another set-up")), "{warnings:?}");
}

/// A leaning ball keeps its distance, and so does what is above it where there is room.
#[test]
fn a_leaning_cutter_keeps_its_distance_from_a_clamp() {
    let cap = "[surface.analytic]\nkind = \"sphere-cap\"\nsize = 40.0\nradius = 50.0\n";
    let clamps = held(&[("clamp", block([-30.0, -8.0, -15.0], [-14.0, 8.0, 6.0]))]);
    let files = Files { meshes: &clamps, ..Files::default() };
    let cutter = BALL.replace("tolerance", "lead = 10.0\ntolerance");
    let job = job(&format!("{cap}{cutter}[machine]\naxes = \"xyzac\"\n{}", avoid("clamp", 0.5)));
    let (plan, v) = planned(&job, files);
    let clamp = named(&v, "clamp");
    println!("leaning: {clamp:?}, {:?}", v.broken);
    assert!(v.avoided.iter().all(|a| a.clearance_mm >= 0.5), "{:?}", v.broken);
    // Rapids run outside of the sphere about the rotary centre in which the clamp is.
    let farthest = (30.0f64 * 30.0 + 8.0 * 8.0 + 15.0 * 15.0).sqrt();
    assert!(plan.rapid_plane >= farthest + 0.5 + job.machine.clearance, "{}", plan.rapid_plane);
    let figures = judged(&job, &plan, 1).unwrap();
    assert_eq!(figures.verification().unwrap().avoided, v.avoided);
}

/// A holder of 40 mm over a clamp that is 12 mm high: it hits it where it begins 10 mm above the tip, and is clear of it
/// where it begins as much higher as the simulation says.
#[test]
fn a_holder_keeps_its_distance_from_a_clamp() {
    let clamps = held(&[("clamp", block([-30.0, -10.0, -5.0], [-15.0, 10.0, 12.0]))]);
    let files = Files { meshes: &clamps, ..Files::default() };
    let with_stickout = |stickout: f64| {
        let tool = format!(
            "[tool]\nkind = \"ball\"\ndiameter = 6.0\nlength = 8.0\nstickout = {stickout}\nholder = [{{ diameter = \
             40.0, length = 30.0 }}]\nclearance = 1.9\n[cut]\nscallop = 0.05\nfeed = 1000.0\ntolerance = 0.01\n[path]\n\
             pattern = \"iso-scallop\"\n[[avoid]]\nfile = \"clamp.obj\"\nname = \"left clamp\"\n"
        );
        let job = job(&format!("{PLANE}{tool}"));
        assert_eq!(job.avoid[0].distance, 1.9);
        planned(&job, files).1
    };
    let short = with_stickout(10.0);
    let [sentence] = &short.broken[..] else { panic!("{:?}", short.broken) };
    // A depth is known to a tenth.
    let is_deep = ["2.0", "2.1", "2.2"]
        .iter()
        .any(|depth| sentence.starts_with(&format!("the holder cuts up to {depth} mm into")));
    assert!(is_deep, "{sentence}");
    assert!(sentence.contains(" mm into \"left clamp\" at ("), "{sentence}");
    // Over the floor the holder has to begin 1.9 mm above the clamp.
    assert!(sentence.ends_with("; 4 mm more of stickout would clear it"), "{sentence}");
    let long = with_stickout(14.0);
    assert!(long.passed, "{:?}", long.broken);
    let clamp = named(&long, "left clamp");
    let is_near = |clearance: f64| (1.9..=2.0 + 0.02).contains(&clearance);
    assert!(is_near(clamp.clearance_mm), "{clamp:?}");
    assert!(long.to_text().contains(" mm from left clamp (1.900 asked)"), "{}", long.to_text());
}

#[test]
fn a_hundred_may_be_avoided_and_no_more() {
    let read = |count: usize| {
        let tables: Vec<String> = (0..count).map(|i| avoid(&format!("clamp{i}"), 0.5)).collect();
        let text = format!("version = 1\n{PLANE}{BALL}{}", tables.concat());
        job::read(text.as_bytes()).map(|resolved| resolved.job.avoid.len())
    };
    assert_eq!(read(100), Ok(100));
    let faults = read(101).unwrap_err();
    let text = faults.render("avoid", b"");
    assert!(text.contains("avoid: 101 items, expected an array of at most 100"), "{text}");
}

/// A plane with five axes, a tool with a holder that is much wider than the cutter, and a wall 6 mm beside the plane, far
/// higher than the tool stands out.
fn beside_a_wall(tool: &str, pattern: &str, tilt: &str) -> Job {
    job(&format!(
        "[surface.analytic]\nkind = \"bump\"\nsize = 50.0\nheight = 4.0\n[tool]\n{tool}\
         length = 16.0\nstickout = 24.0\n[[tool.holder]]\ndiameter = 30.0\nupper_diameter = 40.0\n\
         length = 20.0\n[cut]\nscallop = 0.1\nfeed = 1200.0\naxial_depth = 0.5\n{tilt}\
         [path]\npattern = \"{pattern}\"\n[force]\ncontrol = \"off\"\n[machine]\naxes = \"xyzac\"\n{}",
        avoid("wall", 0.5)
    ))
}

/// The axis is tilted, so that the holder clears the wall by what is asked; where it may not be, the judge finds that the
/// holder cuts into it.
#[test]
fn a_ball_is_tilted_for_its_holder_to_clear_a_wall() {
    let wall = held(&[("wall", block([31.0, -30.0, -5.0], [36.0, 30.0, 60.0]))]);
    let files = Files { meshes: &wall, ..Files::default() };
    let ball = "kind = \"ball\"\ndiameter = 8.0\n";
    for pattern in ["contour", "iso-planar", "iso-scallop"] {
        let job = beside_a_wall(ball, pattern, "");
        assert_eq!(job::read(job.to_toml().as_bytes()).unwrap().job, job);
        let (plan, v) = planned(&job, files);
        let tilt = TiltFigures::of(&plan.toolpath, job.cut.lead).unwrap();
        println!("{pattern}: {tilt:?}, {:?}", v.avoided);
        assert!(v.passed, "{pattern}: {:?}", v.broken);
        assert!(named(&v, "wall").clearance_mm >= 0.5, "{pattern}: {:?}", v.avoided);
        assert!(tilt.largest_deg < 46.0 && tilt.length_mm > 100.0, "{pattern}: {tilt:?}");
    }
    let job = beside_a_wall(ball, "iso-planar", "max_tilt = 0.0\n");
    let (plan, v) = planned(&job, files);
    assert_eq!(TiltFigures::of(&plan.toolpath, job.cut.lead), None);
    assert!(!v.passed && named(&v, "wall").clearance_mm < 0.0, "{:?}", v.avoided);
}

/// Away from everything the axis keeps the lead.
#[test]
fn nothing_is_tilted_where_nothing_is_near() {
    let wall = held(&[("wall", block([61.0, -30.0, -5.0], [66.0, 30.0, 60.0]))]);
    let files = Files { meshes: &wall, ..Files::default() };
    let job = beside_a_wall("kind = \"ball\"\ndiameter = 8.0\n", "iso-planar", "");
    let (plan, v) = planned(&job, files);
    assert!(v.passed, "{:?}", v.broken);
    assert_eq!(TiltFigures::of(&plan.toolpath, job.cut.lead), None);
}
