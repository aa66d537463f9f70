//! Times of judging a path of 10 m on 100 x 100 mm, samples 0.15 mm apart, on two threads.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use evencut_core::geometry::DVec3;
use evencut_core::tool::Tool;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};
use evencut_core::verify::{Facets, VerifyOptions, verify};

const PASSES: u32 = 100;
const FEED: f64 = 20.0;

/// Passes 1 mm apart over the plane, one continuous zigzag.
fn zigzag() -> Toolpath {
    let (mut points, mut time): (Vec<PathPoint>, f64) = (Vec::new(), 0.0);
    for i in 0..2 * PASSES {
        let x = if i.div_ceil(2).is_multiple_of(2) { 0.0 } else { 100.0 };
        let tip = DVec3::new(x, f64::from(i / 2), 0.0);
        time += points.last().map_or(0.0, |p: &PathPoint| p.tip.distance(tip) / FEED);
        points.push(PathPoint {
            kind: MoveKind::Cut,
            pass: i / 2,
            region: 0,
            tip,
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed: FEED,
            mrr: 0.0,
            alpha: 0.0,
            time,
        });
    }
    Toolpath { points }
}

/// 20 000 facets over 100 x 100 mm.
fn plane() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let positions = (0..=100u32)
        .flat_map(|j| (0..=100u32).map(move |i| DVec3::new(f64::from(i), f64::from(j), 0.0)));
    let faces = (0..100u32)
        .flat_map(|j| (0..100u32).map(move |i| j * 101 + i))
        .flat_map(|v| [[v, v + 1, v + 102], [v, v + 102, v + 101]]);
    (positions.collect(), faces.collect())
}

fn judge(c: &mut Criterion) {
    let path = zigzag();
    let (positions, faces) = plane();
    let design = Facets { positions: &positions, faces: &faces };
    let nothing = Facets { positions: &[], faces: &[] };
    let mut group = c.benchmark_group("verify 10 m");
    group.sample_size(10);
    for (name, corner) in [("ball", 5.0), ("bull", 1.0), ("flat", 0.0)] {
        let options = VerifyOptions {
            tool: Tool::new(5.0, corner).expect("a cutter"),
            length: f64::INFINITY,
            depth: 0.5,
            tells_rate: true,
            earlier: None,
            allowance: 0.0,
            scallop: Some(0.03),
            tolerance: 0.005,
            mrr_limit: None,
            load: None,
            spacing: 0.15,
            up: DVec3::Z,
            inaccessible: Vec::new(),
            bridges: Vec::new(),
            walls: None,
            above: None,
            stock: None,
            avoided: Vec::new(),
            threads: 2,
        };
        group.bench_function(name, |b| {
            b.iter(|| verify(black_box(&path), design, nothing, &options, &mut |_| {}));
        });
    }
    group.finish();
}

criterion_group!(benches, judge);
criterion_main!(benches);
