//! Passes are entered and left on arcs: tangentially, at the feed of the cut, and without touching what must stay.

use evencut_core::geometry::{DVec3, math};
use evencut_core::job::{self, Job};
use evencut_core::plan::{Files, plan};
use evencut_core::toolpath::{MoveKind, PathPoint};
use evencut_service::compare::judged;

/// Surfaces and passes: joined by retracts, so that there are many entries.
const JOBS: [(&str, &str); 4] = [
    (
        "bump, rings",
        "[surface.analytic]\nkind = \"bump\"\nsize = 40.0\nradius = 25.0\nheight = 6.0\n\
         [tool]\nkind = \"ball\"\ndiameter = 6.0\n[cut]\nscallop = 0.02\nfeed = 1200.0\n\
         [path]\nlinks = \"retract\"\nentry_radius = 2.0\n",
    ),
    (
        "hollow, planes, bull",
        "[surface.analytic]\nkind = \"bump\"\nsize = 40.0\nradius = 25.0\nheight = -6.0\n\
         [tool]\nkind = \"bull\"\ndiameter = 6.0\ncorner_radius = 2.0\n\
         [cut]\nscallop = 0.02\nfeed = 1200.0\n\
         [path]\npattern = \"iso-planar\"\ntraverse = \"one-way\"\nlinks = \"retract\"\nentry_radius = 2.0\n",
    ),
    (
        "saddle, five axes",
        "[surface.analytic]\nkind = \"saddle\"\nsize = 40.0\nheight = 5.0\n\
         [tool]\nkind = \"flat\"\ndiameter = 8.0\n[cut]\nscallop = 0.02\nfeed = 1200.0\nlead = 8.0\n\
         [machine]\naxes = \"xyzac\"\n\
         [path]\npattern = \"iso-scallop\"\nlinks = \"retract\"\nentry_radius = 2.0\n",
    ),
    (
        "walls",
        "[surface.analytic]\nkind = \"plane\"\nsize = 40.0\n\
         [tool]\nkind = \"flat\"\ndiameter = 8.0\n[cut]\nstepover = 3.0\nfeed = 1200.0\n\
         [path]\nboundary = \"wall\"\nlinks = \"retract\"\nentry_radius = 2.0\n[force]\nrelative = 1.5\n",
    ),
];

fn job(text: &str) -> Job {
    let text = format!("version = 1\n{text}");
    match job::read(text.as_bytes()) {
        Ok(resolved) => resolved.job,
        Err(faults) => panic!("{}", faults.render("entries", text.as_bytes())),
    }
}

/// Angle between the last chord toward a pass and its first one, degrees; `None` where it is not on an arc.
fn turn(points: &[PathPoint; 4]) -> Option<f64> {
    let ways = [0, 1, 2].map(|i| (points[i + 1].tip - points[i].tip).normalize_or(DVec3::ZERO));
    // Neither straight down the axis nor straight on.
    let axis = points[1].axis;
    let is_arc = ways[1].dot(axis).abs() < 0.99 && (ways[1] - ways[0]).dot(axis) > 0.02;
    let turn = math::atan2(ways[1].cross(ways[2]).length(), ways[1].dot(ways[2]));
    is_arc.then(|| turn.to_degrees())
}

#[test]
fn passes_are_entered_and_left_on_arcs() {
    for (name, text) in JOBS {
        let job = job(text);
        assert_eq!(job::read(job.to_toml().as_bytes()).unwrap().job, job);
        let planned = plan(&job, Files::default(), 2, &mut |_, _| {}).unwrap();
        let figures = judged(&job, &planned, 2).unwrap();
        let verification = figures.verification().unwrap();
        assert!(verification.passed, "{name}: {:?}", verification.broken);
        let points = &planned.toolpath.points;
        // Over the surface, not back along it.
        let is_over = |p: &PathPoint| p.kind == MoveKind::Link && p.flat.is_none();
        let is_cut = |p: &PathPoint| matches!(p.kind, MoveKind::Cut | MoveKind::Trochoid);
        let is_on = |p: &PathPoint| is_cut(p) || p.kind == MoveKind::Link && p.flat.is_some();
        let entry = |w: &[PathPoint]| w[..2].iter().all(is_over) && w[2..].iter().all(is_on);
        let exit = |w: &[PathPoint]| w[..2].iter().all(is_cut) && w[2..].iter().all(is_over);
        let (mut tangential, mut straight, mut beside) = ([0, 0], 0, 0);
        // Straight up is a single move.
        let is_straight_up =
            |w: &&[PathPoint]| is_on(&w[0]) && is_over(&w[1]) && w[2].kind == MoveKind::Rapid;
        straight += points.windows(3).filter(is_straight_up).count();
        for w in points.windows(4) {
            let mut of = [w[0], w[1], w[2], w[3]];
            let way = match (entry(w), exit(w)) {
                (true, _) => 0,
                (false, true) => {
                    of.reverse();
                    1
                }
                _ => continue,
            };
            match turn(&of) {
                Some(turn) if turn < 25.0 => {
                    tangential[way] += 1;
                    assert!(w[2].feed <= job.cut.feed * (1.0 + 1e-9), "{name}: {}", w[2].feed);
                }
                // Where a branch leaves at once.
                Some(_) => beside += 1,
                None => straight += 1,
            }
        }
        println!("{name:22} {tangential:?} on arcs, {straight} straight, {beside} before a branch");
        let [into, out_of] = tangential;
        assert!(into > 0 && out_of > 0, "{name}: {tangential:?}");
        // A helix has its own way in.
        assert!(
            10 * (straight + beside) <= (into + out_of).max(10),
            "{name}: {straight}, {beside}"
        );
    }
}
