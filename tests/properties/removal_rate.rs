//! The removal rate by a map of heights: the material over a formula's surface stands on a grid of upright columns, whose
//! tops are those of all balls of the layer's depth about the surface, and the delivered path lowers them to the cutter.
//! It shares nothing with the planner and its simulation, which measure along the normals of the surface.

use std::collections::VecDeque;

use evencut_core::geometry::{DVec3, math};
use evencut_core::job;
use evencut_core::plan::{Files, plan};
use evencut_core::tool::Tool;
use evencut_core::toolpath::{MoveKind, Toolpath};

/// Side of a cell, mm.
const CELL: f64 = 0.08;
/// Extent of the surface, mm.
const SIZE: f64 = 30.0;
/// What a window's rate may be off by as cells enter and leave it as wholes.
const GRAIN: f64 = 0.02;

/// Columns over a square.
struct HeightMap {
    count: usize,
    tops: Vec<f64>,
}

impl HeightMap {
    /// A layer over `z(x, y)`, mm.
    fn new(surface: impl Fn(f64, f64) -> f64, depth: f64) -> Self {
        let count = (SIZE / CELL) as usize;
        let reach = (depth / CELL) as i64;
        let z = |i: i64, j: i64| surface(Self::middle(i), Self::middle(j));
        let all = 0..count as i64;
        let heights: Vec<f64> = all
            .clone()
            .flat_map(|i| all.clone().map(move |j| (i, j)))
            .map(|(i, j)| z(i, j))
            .collect();
        let mut ball = Vec::new();
        for i in -reach..=reach {
            for j in -reach..=reach {
                let square = depth * depth - ((i * i + j * j) as f64) * CELL * CELL;
                if square >= 0.0 {
                    ball.push((i, j, square.sqrt()));
                }
            }
        }
        let top = |(i, j): (i64, i64)| {
            let beside = |&(di, dj, up): &(i64, i64, f64)| {
                let (i, j) = (i + di, j + dj);
                let inside = all.contains(&i) && all.contains(&j);
                inside.then(|| heights[i as usize * count + j as usize] + up)
            };
            ball.iter().filter_map(beside).fold(f64::MIN, f64::max)
        };
        let tops = all.clone().flat_map(|i| all.clone().map(move |j| (i, j))).map(top).collect();
        Self { count, tops }
    }

    /// Coordinate of the middle of a row, mm.
    fn middle(i: i64) -> f64 {
        (i as f64 + 0.5) * CELL - 0.5 * SIZE
    }

    /// Volume that an upright cutter takes, mm³.
    fn cut(&mut self, tool: &Tool, tip: DVec3) -> f64 {
        let (radius, corner) = (tool.radius(), tool.corner_radius());
        let range = |x: f64| {
            let at = |x: f64| ((x + 0.5 * SIZE) / CELL).clamp(0.0, self.count as f64) as usize;
            at(x - radius)..at(x + radius)
        };
        let mut volume = 0.0;
        for i in range(tip.x) {
            let dx = Self::middle(i as i64) - tip.x;
            for j in range(tip.y) {
                let dy = Self::middle(j as i64) - tip.y;
                let across = (dx * dx + dy * dy).sqrt();
                if across > radius {
                    continue;
                }
                let out = (across - tool.bottom_radius()).max(0.0);
                let lower = tip.z + corner - (corner * corner - out * out).max(0.0).sqrt();
                let top = &mut self.tops[i * self.count + j];
                volume += (*top - lower).max(0.0) * CELL * CELL;
                *top = top.min(lower);
            }
        }
        volume
    }

    /// The highest rate over windows of a fifth of the cutter's radius whose tip is farther than a margin inside the
    /// surface, mm³/s.
    fn peak(&mut self, tool: &Tool, path: &Toolpath, margin: f64) -> f64 {
        let (window, step) = (0.2 * tool.radius(), 0.05 * tool.radius());
        let (mut recent, mut peak) = (VecDeque::<[f64; 3]>::new(), 0.0_f64);
        let sum =
            |recent: &VecDeque<[f64; 3]>, of: usize| recent.iter().map(|p| p[of]).sum::<f64>();
        for ends in path.points.windows(2) {
            let [from, to] = [ends[0].tip, ends[1].tip];
            if ends[1].kind == MoveKind::Rapid {
                recent.clear();
                continue;
            }
            let (length, time) = (from.distance(to), ends[1].time - ends[0].time);
            let pieces = (length / step).ceil().max(1.0);
            for k in 1..=pieces as u32 {
                let tip = from.lerp(to, f64::from(k) / pieces);
                recent.push_back([length / pieces, time / pieces, self.cut(tool, tip)]);
                while sum(&recent, 0) - recent[0][0] >= window {
                    recent.pop_front();
                }
                let is_inside = tip.x.abs().max(tip.y.abs()) < 0.5 * SIZE - margin;
                if is_inside && sum(&recent, 0) >= 0.999 * window {
                    peak = peak.max(sum(&recent, 2) / sum(&recent, 1));
                }
            }
        }
        peak
    }
}

/// The highest removal rate of a plan, over its limit, of windows that end farther than `margin` inside the surface.
fn peak_over_limit(
    (kind, tool): (&str, &str),
    depth: f64,
    margin: f64,
    surface: impl Fn(f64, f64) -> f64,
) -> f64 {
    let text = format!(
        "version = 1\n[surface.analytic]\nsize = {SIZE}\n{kind}\n[tool]\nkind = {tool}\ndiameter = 8.0\n\
         [cut]\nscallop = 0.03\naxial_depth = {depth}\nfeed = 1000.0\ntolerance = 0.005\n\
         [path]\npattern = \"contour\"\n[force]\nrelative = 1.1\n"
    );
    let job = job::read(text.as_bytes()).unwrap().job;
    let planned = plan(&job, Files::of_surface(None), 2, &mut |_, _| {}).unwrap();
    let mut map = HeightMap::new(surface, depth);
    map.peak(&job.tool, &planned.toolpath, margin) / job.mrr_limit()
}

/// Over a hill columns along the normals spread, and in a hollow they meet: a layer thick enough to matter is cut within
/// the limit on both.
#[test]
fn limits_are_kept_in_thick_layers_on_hills_and_in_hollows() {
    let (depth, spread) = (2.5, 6.0);
    for (height, tool) in [(6.0, "\"ball\""), (-6.0, "\"bull\"\ncorner_radius = 2.0")] {
        let kind = format!("kind = \"bump\"\nheight = {height}\nradius = {spread}");
        let surface =
            |x: f64, y: f64| height * math::exp(-(x * x + y * y) / (2.0 * spread * spread));
        // The cutter lies wholly over the surface.
        let peak = peak_over_limit((&kind, tool), depth, 4.0 + depth + 1.0, surface);
        assert!(peak > 0.9, "{height}: it is nowhere near the limit, {peak}");
        assert!(peak < 1.0 + GRAIN, "{height}: {peak} of the limit");
    }
}

/// Where a surface rises toward its edge, stock that goes straight up there reaches beyond the normals of the edge: the
/// first pass, along the edge, keeps the limit in it.
#[test]
fn limits_are_kept_at_edges_to_which_the_surface_rises() {
    let half = 0.5 * SIZE;
    let surface = |x: f64, y: f64| 6.0 * (x * x - y * y) / (half * half);
    let kind = "kind = \"saddle\"\nheight = 6.0";
    let peak = peak_over_limit((kind, "\"ball\""), 2.5, -SIZE, surface);
    assert!(peak > 0.9, "it is nowhere near the limit, {peak}");
    assert!(peak < 1.0 + GRAIN, "{peak} of the limit");
}
