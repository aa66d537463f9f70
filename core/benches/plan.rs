//! Times of the stages that follow flattening, and of a whole plan, on a bump of 100 mm.

use criterion::{Criterion, criterion_group, criterion_main};
use evencut_core::engagement::{Capsule, Cutting, Simulation, Stock, predicted};
use evencut_core::flatten::{Locator, bff};
use evencut_core::footprint::Footprint;
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::job::{
    self, Component, FeedComponent, Job, RingOrder, Selection, SurfaceOptions, SurfaceSource,
};
use evencut_core::level_set::{
    ClosingOptions, FieldTerrain, PassField, PassMesh, close, passes, ring_levels, strip_metric,
};
use evencut_core::outline::Outline;
use evencut_core::plan::{Files, plan};
use evencut_core::removal::{Columns, Cutter, Layer};
use evencut_core::surface::{AnalyticSurface, Surface, build};
use evencut_core::tool::Tool;
use std::hint::black_box;

/// About 20 000 faces at an edge of 1 mm, 200 000 at 0.316 mm.
fn bump(edge: f64) -> Surface {
    let bump = AnalyticSurface::Bump { size: 100.0, height: 12.0, width: 20.0 };
    let options = SurfaceOptions {
        source: SurfaceSource::File(String::new()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        select: Selection { component: Component::Only, ..Selection::default() },
        curvature_radius: None,
        steepest: None,
        flip: false,
        face: evencut_core::job::Faces::Only,
        chord: None,
    };
    match build(bump.mesh(edge), &options) {
        Ok(built) => built.surface,
        Err(error) => panic!("{error}"),
    }
}

fn job(control: &str, stepover: f64) -> Job {
    let text = format!(
        "version = 1\n[surface.analytic]\nkind = \"bump\"\nsize = 100.0\nradius = 20.0\n\
         height = 12.0\nresolution = 1.0\n[tool]\nkind = \"ball\"\ndiameter = 10.0\n[cut]\n\
         stepover = {stepover}\naxial_depth = 0.5\nfeed = 1200.0\n[force]\nrelative = 1.5\n\
         control = \"{control}\"\n"
    );
    match job::read(text.as_bytes()) {
        Ok(resolved) => resolved.job,
        Err(faults) => panic!("{}", faults.render("bench", text.as_bytes())),
    }
}

fn stages(c: &mut Criterion) {
    let surface = bump(1.0);
    let chart = match bff(&surface) {
        Ok(chart) => chart,
        Err(error) => panic!("{error}"),
    };
    c.bench_function("rings, 20k faces, side step 0.6 mm", |b| {
        b.iter(|| {
            let metric = vec![strip_metric::even(0.6); surface.positions().len()];
            let mesh = PassMesh::new(&surface, &chart, metric).ok();
            mesh.map(|mesh| {
                let field = PassField::from_boundary(&mesh);
                passes(&mesh, &field, &ring_levels(&field)).len()
            })
        });
    });
    let Ok(tool) = Tool::new(5.0, 5.0) else { return };
    let metric = vec![strip_metric::even(0.6); surface.positions().len()];
    if let Ok(mesh) = PassMesh::new(&surface, &chart, metric) {
        let field = PassField::from_boundary(&mesh);
        let locator = Locator::new(mesh.connectivity(), mesh.uv());
        let terrain = FieldTerrain::new(&mesh, &field, &locator);
        let plain = passes(&mesh, &field, &ring_levels(&field));
        for threads in [1, 2] {
            c.bench_function(&format!("gaps closed, side step 0.6 mm, threads {threads}"), |b| {
                let options = ClosingOptions {
                    order: RingOrder::OutsideIn,
                    on_levels: true,
                    beside: &[],
                    footprint: Footprint::new(tool, 0.0),
                    cusps: [1.0; 2],
                    threads,
                };
                b.iter(|| close(&mut plain.clone(), &mesh, &field, &terrain, &options).branches);
            });
        }
    }
    let region = Outline::of_chart(&surface, &chart);
    let (low, high) = region.bounds();
    let middle = 0.5 * (low + high);
    c.bench_function("engagement, 40 passes of 400 moves measured and swept", |b| {
        b.iter(|| {
            let mut stock = Stock::new(&region);
            let mut sum = 0.0;
            for pass in 0..40 {
                let y = -40.0 + 0.6 * f64::from(pass);
                for i in 0..400 {
                    let from = middle + DVec2::new(-45.0 + 0.225 * f64::from(i), y);
                    let to = from + DVec2::new(0.225, 0.0);
                    sum += stock.engagement(0.5 * (from + to), 5.0, DVec2::X).normal_feed;
                    stock.sweep(Capsule::new(from, 5.0, to, 5.0));
                }
            }
            black_box(sum)
        });
    });
}

fn whole(c: &mut Criterion) {
    let mut group = c.benchmark_group("plan, 20k faces, side step 0.6 mm");
    group.sample_size(10);
    for control in ["off", "feed", "trochoid"] {
        let job = job(control, 0.6);
        for threads in [1, 2] {
            group.bench_function(format!("{control}, threads {threads}"), |b| {
                b.iter(|| {
                    plan(&job, Files::default(), threads, &mut |_, _| {})
                        .map(|p| p.passes.count)
                        .ok()
                });
            });
        }
    }
    group.finish();
}

/// The removal rates of a whole path: predicted in the plane, and found in the columns of material.
fn rates(c: &mut Criterion) {
    let (job, radius, depth) = (job("feed", 0.6), 5.0, 0.5);
    let Ok(planned) = plan(&job, Files::default(), 1, &mut |_, _| {}) else { return };
    let (surface, chart) = (&planned.prepared.surface, &planned.prepared.chart);
    let metric = vec![strip_metric::even(0.6); surface.positions().len()];
    let Ok(mesh) = PassMesh::new(surface, chart, metric) else { return };
    let field = PassField::from_boundary(&mesh);
    let locator = Locator::new(mesh.connectivity(), mesh.uv());
    let terrain = FieldTerrain::new(&mesh, &field, &locator);
    let region = Outline::of_chart(surface, chart);
    let disc = Cutting {
        radius: job.tool.mean_radius(depth),
        depth,
        feed: job.cut.feed,
        vfc: FeedComponent::Mean,
        limit: f64::INFINITY,
    };
    let mut group = c.benchmark_group(format!("rates, {} moves", planned.toolpath.points.len()));
    group.sample_size(10);
    group.bench_function("in the plane", |b| {
        b.iter(|| {
            let simulation = Simulation::new(disc, &terrain, Stock::new(&region));
            predicted(&planned.toolpath, simulation).len()
        });
    });
    let layer = Layer { allowance: 0.0, depth, falls: false };
    let columns = Columns::new(surface, chart, 0.6, layer.top());
    let cutter = Cutter { tool: job.tool, length: 10.0 * radius };
    group.bench_function("in the material", |b| {
        b.iter(|| columns.cut(&planned.toolpath, cutter, layer, 1).pieces.len());
    });
    group.finish();
}

criterion_group!(benches, stages, whole, rates);
criterion_main!(benches);
