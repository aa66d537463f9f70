//! Times of dropping cutters on a smooth mesh of 200 000 faces: one raise, and a pass by contact.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use evencut_core::cutter_location::{
    CheckMesh, Contact, Obstacles, PassOptions, ToolAxis, locate_pass, tip, tool_axes,
};
use evencut_core::geometry::DVec3;
use evencut_core::geometry::math::{cos, sin};
use evencut_core::tool::Tool;
use evencut_core::toolpath::MoveKind;

/// Two crossing waves with ripples, mm.
fn height(x: f64, y: f64) -> f64 {
    4.0 * sin(x / 15.0) * cos(y / 18.0) + 0.5 * sin(x / 5.0 + y / 7.0)
}

fn normal(x: f64, y: f64) -> DVec3 {
    let ripple = 0.5 * cos(x / 5.0 + y / 7.0);
    let dx = 4.0 / 15.0 * cos(x / 15.0) * cos(y / 18.0) + ripple / 5.0;
    let dy = -4.0 / 18.0 * sin(x / 15.0) * sin(y / 18.0) + ripple / 7.0;
    DVec3::new(-dx, -dy, 1.0).normalize()
}

/// `n` by `n` quads over 100 x 100 mm.
fn part(n: u32) -> CheckMesh {
    let at = |i: u32| 100.0 * (f64::from(i) / f64::from(n) - 0.5);
    let corners = (0..=n).flat_map(|j| (0..=n).map(move |i| (at(i), at(j))));
    let positions = corners.map(|(x, y)| DVec3::new(x, y, height(x, y))).collect();
    let faces = (0..n)
        .flat_map(|j| (0..n).map(move |i| j * (n + 1) + i))
        .flat_map(|v| [[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]])
        .collect();
    CheckMesh::new(positions, faces)
}

/// A winding pass of 2000 contacts.
fn pass() -> Vec<Contact> {
    let contact = |key: usize| {
        let x = -42.0 + 0.042 * key as f64;
        let y = 0.31 * x + 3.0 * sin(x / 9.0);
        Contact {
            position: DVec3::new(x, y, height(x, y)),
            normal: normal(x, y),
            feed_direction: DVec3::new(1.0, 0.31, 0.0),
            key,
            feed: 10.0,
            kind: MoveKind::Cut,
            facet_error: 0.0,
        }
    };
    (0..2000).map(contact).collect()
}

fn cutters(criterion: &mut Criterion) {
    let (mesh, contacts) = (part(316), pass());
    let obstacles = Obstacles::of_part(mesh.clone());
    for (name, corner) in [("ball", 5.0), ("flat", 0.0), ("bull", 1.0)] {
        let tool = Tool::new(5.0, corner).expect("a cutter of radius 5 mm");
        let mut group = criterion.benchmark_group(name);
        group.sample_size(20).throughput(Throughput::Elements(contacts.len() as u64));
        let tips: Vec<DVec3> =
            contacts.iter().map(|c| tip(&tool, c.position, c.normal, DVec3::Z, 0.0)).collect();
        let raises = || tips.iter().map(|&t| mesh.raise(&tool, t, DVec3::Z, 40.0)).sum::<f64>();
        group.bench_function("raise", |b| b.iter(|| black_box(raises())));
        for (kind, axis) in [("fixed", ToolAxis::Fixed(DVec3::Z)), ("lead", ToolAxis::Lead(0.1))] {
            let options = PassOptions {
                tool,
                axis,
                axis_rate: f64::INFINITY,
                largest_tilt: 0.0,
                allowance: 0.0,
                tolerance: 0.005,
                reach: 40.0,
            };
            group.bench_function(format!("pass/{kind}"), |b| {
                b.iter(|| {
                    let contacts = black_box(&contacts);
                    let axes = tool_axes(contacts, None, &options, &obstacles);
                    locate_pass(contacts, &axes, &options, &obstacles)
                })
            });
        }
        group.finish();
    }
    criterion.bench_function("tree", |b| {
        b.iter_batched(|| 316, part, BatchSize::PerIteration);
    });
}

criterion_group!(benches, cutters);
criterion_main!(benches);
