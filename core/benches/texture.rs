//! How fast a window of 2 x 2 mm is simulated, against all of the edges and against a plain model, and the tests of a
//! node's line against a quadrilateral that each takes: `cargo bench --bench texture`.
//!
//! A plane under a ball of radius 5 mm with two teeth, helix 30 degrees, 0.1 mm a tooth, passes 0.5 mm apart, 0.2 mm of
//! material, cells of 0.01 mm, one thread. Rows, each with the time steps of the effective edge (*its steps*) or with
//! those that the step rule asks for where the whole edge is simulated, whose outermost point is 5 mm out (*full
//! steps*):
//!
//! - *delivered*: what `evencut texture` does.
//! - *full, pruned*: the whole edge, but only what comes near a tile is looked at.
//! - *effective* and *full*, *buckets*: all elements in all steps, each tested with the nodes in its box along the grid.
//! - *plain*: all elements in all steps against all nodes. It would last for hours: it is timed over a few steps that
//!   are spread over the path, and taken times its number of tests, which is known.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::hint::black_box;
use std::time::Instant;

use evencut_core::geometry::math::{cos, sin, tan};
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::texture::edge::Runout;
use evencut_core::texture::grid::{Discretisation, Grid, Node};
use evencut_core::texture::kinematics::{Spindle, feed_moves};
use evencut_core::texture::sweep::{Cutter, EdgePart, Search, SweepOptions, Work, sweep};
use evencut_core::tool::Tool;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};

#[path = "../src/texture/sweep/tests/plain.rs"]
mod plain;

use plain::Plain;

const RADIUS: f64 = 5.0;
const FEED: f64 = 20.0;
const CELL: f64 = 0.01;
const START: f64 = 0.2;
/// Half the length of a pass, mm, and passes: all that comes to the window.
const HALF: f64 = 2.5;
const PASSES: u32 = 11;
/// Steps over which the plain model is timed.
const LOOKS: u32 = 5;

/// Passes 0.5 mm apart, the axis leaning forward by `tilt` rad.
fn path(tilt: f64) -> Toolpath {
    let axis = DVec3::new(sin(tilt), 0.0, cos(tilt));
    let point = |k: u32| {
        let (row, end) = (f64::from(k / 2), f64::from(k % 2));
        PathPoint {
            kind: if k.is_multiple_of(2) { MoveKind::Rapid } else { MoveKind::Cut },
            pass: 0,
            region: 0,
            tip: DVec3::new(2.0 * HALF * end - HALF, 0.5 * row - HALF, RADIUS) - axis * RADIUS,
            axis,
            normal: DVec3::Z,
            flat: Some(DVec2::ZERO),
            feed: FEED,
            mrr: 0.0,
            alpha: 0.0,
            time: (2.0 * HALF * (row + end) + 1e-3 * row) / FEED,
        }
    };
    Toolpath { points: (0..2 * PASSES).map(point).collect() }
}

fn cutter() -> Cutter {
    Cutter {
        tool: Tool::new(RADIUS, RADIUS).expect("a cutter"),
        flutes: 2,
        helix: PI / 6.0,
        runout: Runout::default(),
        spindle: Spindle { speed: 100.0, phase: 0.0 },
    }
}

/// What a row took.
struct Row {
    name: &'static str,
    work: Work,
    seconds: f64,
}

fn simulated(
    name: &'static str,
    (path, grid): (&Toolpath, &Grid),
    (search, part, pace): (Search, EdgePart, EdgePart),
) -> Row {
    let moves = feed_moves(path, RADIUS);
    let options = SweepOptions {
        start: START,
        thickness: START,
        slack: 1e-3,
        part,
        pace,
        search,
        resolution: None,
        threads: 1,
    };
    let begin = Instant::now();
    let map = black_box(sweep(grid, &cutter(), &moves, &options, &mut |_| {}));
    Row { name, work: map.work, seconds: begin.elapsed().as_secs_f64() }
}

/// The plain model with as many time steps as `like`.
fn plain(name: &'static str, path: &Toolpath, grid: &Grid, like: Work) -> Row {
    let cutter = cutter();
    let steps = like.steps / u64::from(PASSES);
    let end = RADIUS * FRAC_PI_2 + START;
    let model = Plain::new(&cutter, START, steps as u32, (CELL, end));
    let mut heights = vec![START; grid.nodes().len()];
    let pass = path.points.as_chunks::<2>().0;
    let begin = Instant::now();
    let mut timed = 0;
    for look in 0..LOOKS {
        // The passes over the window, at different places and turns.
        let [from, to] = &pass[(3 + look) as usize];
        let step = (model.steps / 3) + look * (model.steps / (3 * LOOKS));
        timed += model.step([from, to], step, grid.nodes(), &mut heights);
    }
    let seconds = begin.elapsed().as_secs_f64();
    black_box(heights);
    let tests = timed / u64::from(LOOKS) * like.steps;
    let quads = tests / grid.nodes().len() as u64;
    let work = Work { tests, quads, edge_points: (end / CELL).ceil() as u64 + 1, ..like };
    Row { name, work, seconds: seconds * tests as f64 / timed as f64 }
}

fn rows(path: &Toolpath, grid: &Grid) -> Vec<Row> {
    use EdgePart::{Effective, Full};
    use Search::{Buckets, Near};
    let of = |name, how| simulated(name, (path, grid), how);
    let mut rows = vec![
        of("delivered, its steps", (Near, Effective, Effective)),
        of("full, pruned, its steps", (Near, Full, Effective)),
        of("effective, buckets, its steps", (Buckets, Effective, Effective)),
        of("full, buckets, its steps", (Buckets, Full, Effective)),
        of("full, buckets, full steps", (Buckets, Full, Full)),
    ];
    let [its, full] = [rows[0].work, rows[4].work];
    rows.push(plain("plain, its steps (scaled)", path, grid, its));
    rows.push(plain("plain, full steps (scaled)", path, grid, full));
    rows
}

fn main() {
    // Tests of all targets start this too.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let plane = |at: DVec2| Some(Node { place: at.extend(0.0), normal: DVec3::Z });
    let size = DVec2::splat(2.0);
    let grid = Grid::new(size, CELL, Discretisation::Uniform, 1, &plane).expect("a grid");
    let nodes = grid.nodes().len() as f64;
    println!(
        "{:>5}  {:<30}{:>9}{:>8}{:>15}{:>16}{:>12}{:>10}",
        "tilt", "", "steps", "points", "quadrilaterals", "tests a node", "s", "times"
    );
    for degrees in [0.0, 15.0_f64] {
        let rows = rows(&path(degrees.to_radians()), &grid);
        for Row { name, work, seconds } in &rows {
            println!(
                "{degrees:>4}°  {name:<30}{:>9}{:>8}{:>15}{:>16.1}{seconds:>12.3}{:>10.1}",
                work.steps,
                work.edge_points,
                work.quads,
                work.tests as f64 / nodes,
                seconds / rows[0].seconds
            );
        }
    }
}
