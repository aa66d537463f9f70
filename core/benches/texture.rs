//! Times of simulating a window of 1 x 1 mm of a plane, cells 0.01 mm long, with the effective and with the full edge.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use evencut_core::geometry::math::{cos, sin};
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::texture::edge::Runout;
use evencut_core::texture::grid::{Discretisation, Grid, Node};
use evencut_core::texture::kinematics::{FeedMove, Spindle, feed_moves};
use evencut_core::texture::sweep::{Cutter, EdgePart, SweepOptions, sweep};
use evencut_core::tool::Tool;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};

const RADIUS: f64 = 5.0;
const FEED: f64 = 20.0;

/// Passes of 4 mm, 0.5 mm apart, the axis leaning forward by `tilt` rad.
fn moves(tilt: f64) -> Vec<FeedMove> {
    let axis = DVec3::new(sin(tilt), 0.0, cos(tilt));
    let point = |k: u32| {
        let (row, end) = (f64::from(k / 2), f64::from(k % 2));
        PathPoint {
            kind: if k.is_multiple_of(2) { MoveKind::Rapid } else { MoveKind::Cut },
            pass: 0,
            region: 0,
            tip: DVec3::new(4.0 * end - 2.0, 0.5 * row - 1.5, RADIUS) - axis * RADIUS,
            axis,
            normal: DVec3::Z,
            flat: Some(DVec2::ZERO),
            feed: FEED,
            mrr: 0.0,
            alpha: 0.0,
            time: (4.0 * (row + end) + 1e-3 * row) / FEED,
        }
    };
    feed_moves(&Toolpath { points: (0..14).map(point).collect() }, RADIUS)
}

fn window(c: &mut Criterion) {
    let cutter = Cutter {
        tool: Tool::new(RADIUS, RADIUS).expect("a cutter"),
        flutes: 2,
        helix: 0.5,
        runout: Runout::default(),
        spindle: Spindle { speed: 100.0, phase: 0.0 },
    };
    let plane = |at: DVec2| Some(Node { place: at.extend(0.0), normal: DVec3::Z });
    let grid = Grid::new(DVec2::ONE, 0.01, Discretisation::Uniform, 1, &plane).expect("a grid");
    let mut group = c.benchmark_group("texture 1 x 1 mm");
    group.sample_size(10);
    for degrees in [0.0, 15.0_f64] {
        let moves = moves(degrees.to_radians());
        for part in [EdgePart::Effective, EdgePart::Full] {
            let options = SweepOptions {
                start: 0.2,
                thickness: 0.2,
                slack: 1e-3,
                part,
                resolution: None,
                threads: 1,
            };
            let work = sweep(&grid, &cutter, &moves, &options).work;
            let name = format!("tilt {degrees}, {part:?}: {} tests", work.tests);
            group.bench_function(name, |b| {
                b.iter(|| black_box(sweep(&grid, &cutter, &moves, &options)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, window);
criterion_main!(benches);
