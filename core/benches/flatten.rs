//! Times of both flattening methods on a bumpy saddle of 10 000 and 100 000 faces.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use evencut_core::flatten;
use evencut_core::geometry::DVec3;
use evencut_core::geometry::math::{cos, exp, sin};
use evencut_core::mesh::{Connectivity, VertexId};
use evencut_core::surface::Surface;

/// `n` by `n` quads over `-1..1` squared, diagonals alternating: a saddle with a bump and ripples.
fn saddle(n: u32) -> Surface {
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let height = |x: f64, y: f64| {
        let bump = exp(-((x - 0.3) * (x - 0.3) + (y + 0.2) * (y + 0.2)) / 0.08);
        0.4 * (x * x - y * y) + 0.6 * bump + 0.05 * sin(7.0 * x) * cos(5.0 * y)
    };
    let corners = (0..=n).flat_map(|j| (0..=n).map(move |i| (at(i), at(j))));
    let positions: Vec<DVec3> = corners.map(|(x, y)| DVec3::new(x, y, height(x, y))).collect();
    let quad = |i: u32, j: u32| {
        let a = j * (n + 1) + i;
        let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
        if (i + j).is_multiple_of(2) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    };
    let faces: Vec<[VertexId; 3]> = (0..n)
        .flat_map(|j| (0..n).flat_map(move |i| quad(i, j)))
        .map(|f| f.map(VertexId))
        .collect();
    let connectivity = Connectivity::new(positions.len(), faces);
    Surface::new(connectivity.expect("a grid is a manifold"), positions)
}

fn methods(criterion: &mut Criterion) {
    for (name, n) in [("10k", 71), ("100k", 224)] {
        let surface = saddle(n);
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        group.bench_function("bff", |b| b.iter(|| flatten::bff(black_box(&surface))));
        group.bench_function("abf", |b| b.iter(|| flatten::abf(black_box(&surface))));
        group.finish();
    }
}

criterion_group!(benches, methods);
criterion_main!(benches);
