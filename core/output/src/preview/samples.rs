//! A bump with rings and loops on it, for the tests of the pictures.

use evencut_core::flatten::Chart;
use evencut_core::geometry::{DVec2, DVec3, math};
use evencut_core::mesh::{Connectivity, VertexId};
use evencut_core::surface::Surface;
use evencut_core::toolpath::{MoveKind, PathPoint, Toolpath};

pub const LIMIT: f64 = 40.0;
const SIZE: f64 = 100.0;
const POINTS_A_LOOP: f64 = 32.0;

pub struct Sample {
    pub surface: Surface,
    pub chart: Chart,
}

fn height(p: DVec2) -> f64 {
    let square = |t: f64| t * t;
    let r = (square(p.x - 35.0) + square(p.y - 40.0)) / 400.0;
    let q = (square(p.x - 75.0) + square(p.y - 70.0)) / 150.0;
    35.0 * math::exp(-r) + 18.0 * math::exp(-q)
}

/// A square with two hills on `n` by `n` cells, its chart the view from above.
pub fn bump(n: u32) -> Sample {
    let at = |i: u32, j: u32| DVec2::new(f64::from(i), f64::from(j)) * SIZE / f64::from(n);
    let flat: Vec<DVec2> = (0..=n).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
    let faces = (0..n * n)
        .flat_map(|cell| {
            let a = cell / n * (n + 1) + cell % n;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            [[a, b, c], [a, c, d]]
        })
        .map(|f| f.map(VertexId))
        .collect();
    let connectivity = Connectivity::new(flat.len(), faces).unwrap();
    let surface = Surface::new(connectivity, flat.iter().map(|p| p.extend(height(*p))).collect());
    let chart = Chart::new(&surface, flat);
    Sample { surface, chart }
}

impl Sample {
    /// From the view from above to flat mm.
    fn factor(&self) -> f64 {
        self.chart.uv()[self.chart.uv().len() - 1].x / SIZE
    }

    pub fn contacts(&self, path: &Toolpath) -> Vec<Option<DVec3>> {
        let on = |p: DVec2| (p / self.factor()).extend(height(p / self.factor()));
        path.points.iter().map(|p| p.flat.map(on)).collect()
    }
}

/// A looping first ring, then shrinking square rings with a dear corner each, `count` points.
pub fn rings(sample: &Sample, count: usize) -> Toolpath {
    let around = |t: f64, inset: f64| {
        let side = SIZE - 2.0 * inset;
        let s = 4.0 * (t - t.floor());
        let low = DVec2::splat(inset);
        low + side
            * match s as u32 {
                0 => DVec2::new(s, 0.0),
                1 => DVec2::new(1.0, s - 1.0),
                2 => DVec2::new(3.0 - s, 1.0),
                _ => DVec2::new(0.0, 4.0 - s),
            }
    };
    let looping = count * 3 / 4;
    let turns = 20.0;
    let mut time = 0.0;
    let points = (0..count).map(|i| {
        let (plan, kind, share) = if i < looping {
            let t = i as f64 / looping as f64;
            let phase = i as f64 / POINTS_A_LOOP * std::f64::consts::TAU;
            let offset = DVec2::new(math::cos(phase), math::sin(phase)) * 2.5;
            let cutting = math::sin(phase);
            let kind = if cutting > 0.0 { MoveKind::Trochoid } else { MoveKind::Return };
            (around(t, 4.0) + offset, kind, cutting.max(0.0))
        } else {
            let t = (i - looping) as f64 / (count - looping) as f64 * turns;
            let corner = (4.0 * t).fract();
            let share = if corner < 0.04 { 1.3 } else { 0.55 + 0.3 * math::sin(7.0 * t) };
            let kind = if t.fract() < 0.02 { MoveKind::Link } else { MoveKind::Cut };
            (around(t, 8.0 + 2.0 * t.floor()), kind, share)
        };
        time += 0.02;
        PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: plan.extend(height(plan)),
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: Some(plan * sample.factor()),
            feed: 20.0,
            mrr: share * LIMIT,
            alpha: 1.0,
            time,
        }
    });
    Toolpath { points: points.collect() }
}
