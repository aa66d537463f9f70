mod plain;

use super::*;
use crate::geometry::math::{cos, sin, tan};
use crate::geometry::{DVec2, DVec3};
use crate::surface::AnalyticSurface;
use crate::texture::edge::Runout;
use crate::texture::engagement::{Shape, thickness};
use crate::texture::grid::{Discretisation, Node};
use crate::texture::kinematics::{Spindle, feed_moves};
use crate::texture::parameters::Levelled;
use crate::tool::Tool;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};

use plain::Plain;
use std::f64::consts::{PI, TAU};

const R: f64 = 5.0;
const FZ: f64 = 0.1;
const AE: f64 = 0.5;
const AP: f64 = 0.2;
/// rev/s.
const SPEED: f64 = 100.0;

fn cutter(runout: Runout) -> Cutter {
    Cutter {
        tool: Tool::new(R, R).unwrap(),
        flutes: 2,
        helix: 30.0_f64.to_radians(),
        runout,
        spindle: Spindle { speed: SPEED, phase: 0.3 },
    }
}

fn options(thickness: f64) -> SweepOptions {
    SweepOptions {
        start: AP,
        thickness,
        slack: 1e-3,
        part: EdgePart::Effective,
        pace: EdgePart::Effective,
        search: Search::Near,
        resolution: None,
        threads: 2,
    }
}

/// Passes along `u` over a surface, `rows` of them about `v = 0`, each from `-half` to `half`, the axis leaning forward;
/// joined by rapids.
fn passes(
    surface: &AnalyticSurface,
    tilt: f64,
    side_step: f64,
    rows: i32,
    (half, pieces): (f64, u32),
) -> Toolpath {
    let feed = FZ * 2.0 * SPEED;
    let (mut points, mut time) = (Vec::new(), 0.0);
    for row in -rows..=rows {
        for i in 0..=pieces {
            let u = half * (2.0 * f64::from(i) / f64::from(pieces) - 1.0);
            let at = DVec2::new(u, f64::from(row) * side_step);
            let contact = surface.position(at);
            let normal = surface.curvature(at).normal();
            let forward = surface.position(at + DVec2::X * 1e-4) - contact;
            let forward = (forward - normal * forward.dot(normal)).normalize();
            let axis = (normal * cos(tilt) + forward * sin(tilt)).normalize();
            let tip = contact + R * (normal - axis);
            let before = points.last().map_or(tip, |p: &PathPoint| p.tip);
            time += tip.distance(before) / feed + 1e-12;
            let kind = if i == 0 { MoveKind::Rapid } else { MoveKind::Cut };
            points.push(PathPoint {
                kind,
                pass: 0,
                region: 0,
                tip,
                axis,
                normal,
                flat: (i == 0).then_some(DVec2::ZERO),
                feed,
                mrr: 0.0,
                alpha: 0.0,
                time,
            });
        }
    }
    Toolpath { points }
}

fn node(surface: &AnalyticSurface) -> impl Fn(DVec2) -> Option<Node> + Sync + '_ {
    |at| Some(Node { place: surface.position(at), normal: surface.curvature(at).normal() })
}

const PLANE: AnalyticSurface = AnalyticSurface::Plane { width: 100.0, depth: 100.0 };

fn grid(surface: &AnalyticSurface, size: [f64; 2], middle: [f64; 2], cell: f64) -> Grid {
    let place = node(surface);
    let shifted = |at: DVec2| place(at + DVec2::from(middle));
    Grid::new(DVec2::from(size), cell, Discretisation::Uniform, 1, &shifted).unwrap()
}

/// Heights on a plane.
fn on_plane(path: &Toolpath, grid: &Grid, runout: Runout, options: &SweepOptions) -> HeightMap {
    sweep(grid, &cutter(runout), &feed_moves(path, R), options, &mut |_| {})
}

/// Highest over lowest of a track of nodes along `u`.
fn swing(heights: &[f64]) -> f64 {
    let most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most - heights.iter().copied().fold(f64::INFINITY, f64::min)
}

#[test]
fn cusps_across_the_feed_have_the_known_height() {
    let path = passes(&PLANE, 15.0_f64.to_radians(), AE, 2, (1.5, 1));
    // Half way between two passes, where the other's is as high, along two feeds per tooth.
    let grid = grid(&PLANE, [0.2, AE], [0.0, 0.0], 0.005);
    let map = on_plane(&path, &grid, Runout::default(), &options(AP));
    let [nu, nv] = grid.counts();
    // The lowest of each row: the body of the cutter without the feed's cusps.
    let row = |j: usize| map.heights[j * nu..(j + 1) * nu].iter().copied().fold(AP, f64::min);
    let cusp = (0..nv).map(row).fold(0.0, f64::max) - (0..nv).map(row).fold(AP, f64::min);
    let known = AE * AE / (8.0 * R);
    println!("cross-feed cusp {cusp:.6} known {known:.6} ratio {:.5}", cusp / known);
    assert!((cusp / known - 1.0).abs() < 0.01);
}

#[test]
fn cusps_along_the_feed_have_the_known_height_on_the_track_and_are_larger_without_tilt() {
    let known = FZ * FZ / (8.0 * R);
    let of = |tilt: f64, v: f64| {
        let path = passes(&PLANE, tilt.to_radians(), AE, 0, (1.0, 1));
        // A crest is missed by half a cell at most: 0.4 % of its height.
        let grid = grid(&PLANE, [2.0 * FZ, 0.0002], [0.0, v + 0.0001], 0.0002);
        let options = SweepOptions { resolution: Some(0.002), ..options(AP) };
        let map = on_plane(&path, &grid, Runout::default(), &options);
        swing(&map.heights[..grid.counts()[0]]) / known
    };
    for tilt in [5.0, 15.0] {
        let ratio = of(tilt, 0.0);
        println!("feed cusp at tilt {tilt}: ratio {ratio:.5}");
        assert!((ratio - 1.0).abs() < 0.01);
    }
    // On one side the teeth turn the way in which the tip passes a node, and pass it more seldom.
    for beside in [0.2, 3.0] {
        let [left, right] = [1.0, -1.0].map(|side| of(0.0, side * beside * FZ));
        println!("feed cusp at tilt 0, {beside} f_z beside: left {left:.3}, right {right:.3}");
        assert!(left.max(right) > 1.0);
    }
}

#[test]
fn runout_doubles_the_period_of_two_teeth() {
    let path = passes(&PLANE, 15.0_f64.to_radians(), AE, 0, (2.0, 1));
    let grid = grid(&PLANE, [8.0 * FZ, 0.005], [0.0, 0.0025], 0.005);
    let period = |runout: Runout| {
        let map = on_plane(&path, &grid, runout, &options(AP));
        let row = &map.heights[..grid.counts()[0]];
        let differs = |lag: usize| {
            (0..row.len() - lag).map(|i| (row[i + lag] - row[i]).abs()).fold(0.0, f64::max)
        };
        // One and two teeth later, as parts of the swing.
        (differs(20) / swing(row), differs(40) / swing(row))
    };
    let even = period(Runout::default());
    let off = period(Runout { offset: 0.002, angle: 0.4, teeth: vec![] });
    println!("period: even {even:?}, with run-out {off:?}");
    assert!(even.0 < 0.03 && even.1 < 0.03);
    assert!(off.0 > 0.3 && off.1 < 0.03);
}

#[test]
fn the_effective_edge_gives_the_heights_of_the_full_one() {
    let surfaces = [
        (PLANE, Shape::Plane),
        (AnalyticSurface::SphereCap { radius: 40.0, diameter: 30.0 }, Shape::Convex),
        (
            AnalyticSurface::SphereCap { radius: -40.0, diameter: 30.0 },
            Shape::Concave { least_radius: 40.0 },
        ),
        (
            AnalyticSurface::Torus { major: 30.0, minor: 10.0, length: 20.0, width: 15.0 },
            Shape::Convex,
        ),
    ];
    for (surface, shape) in surfaces {
        for tilt in [0.0, 15.0_f64] {
            let path = passes(&surface, tilt.to_radians(), AE, 1, (0.8, 16));
            let grid = grid(&surface, [0.4, 0.6], [0.0, 0.0], 0.02);
            let thickness = thickness(shape, R, AP).unwrap();
            let effective = on_plane(&path, &grid, Runout::default(), &options(thickness));
            let full = SweepOptions { part: EdgePart::Full, ..options(thickness) };
            let full = on_plane(&path, &grid, Runout::default(), &full);
            println!("{tilt}: effective {:?} full {:?}", effective.work, full.work);
            assert_eq!(effective.heights, full.heights, "{surface:?} {tilt}");
            assert!(effective.work.tests <= full.work.tests);
            assert!(effective.heights.iter().all(|h| *h < AP), "all of it is cut");
        }
    }
}

#[test]
fn all_elements_in_all_steps_give_the_same_heights() {
    let surface = AnalyticSurface::SphereCap { radius: -40.0, diameter: 30.0 };
    let path = passes(&surface, 0.2, AE, 1, (0.4, 8));
    let grid = grid(&surface, [0.4, 0.6], [0.0, 0.0], 0.04);
    let near = on_plane(&path, &grid, Runout::default(), &options(0.25));
    let buckets = |part| {
        let all = SweepOptions { search: Search::Buckets, part, ..options(0.25) };
        on_plane(&path, &grid, Runout::default(), &all)
    };
    for all in [buckets(EdgePart::Effective), buckets(EdgePart::Full)] {
        assert_eq!(all.heights, near.heights);
        assert!(all.work.tests > near.work.tests && all.work.quads > near.work.quads);
    }
}

#[test]
fn plain_time_stepping_over_all_nodes_gives_the_same_heights() {
    let cutter = cutter(Runout::default());
    for tilt in [0.0, 15.0_f64] {
        // A move of a little more than half a turn, so that the oracle ends.
        let path = passes(&PLANE, tilt.to_radians(), AE, 0, (0.06, 1));
        let grid = grid(&PLANE, [0.16, 0.16], [0.02, 0.1], 0.04);
        let moves = feed_moves(&path, R);
        let options = SweepOptions { resolution: Some(0.02), ..options(AP) };
        let map = sweep(&grid, &cutter, &moves, &options, &mut |_| {});
        let plain = Plain::new(&cutter, AP, map.work.steps as u32, (0.02, 0.25 * PI * R));
        let mut brute = vec![AP; grid.nodes().len()];
        for pair in path.points.windows(2).filter(|pair| pair[1].kind == MoveKind::Cut) {
            for step in 0..plain.steps {
                plain.step([&pair[0], &pair[1]], step, grid.nodes(), &mut brute);
            }
        }
        let worst = map.heights.iter().zip(&brute).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let cut = brute.iter().filter(|h| **h < AP).count();
        println!("oracle at {tilt}: {} nodes, {cut} cut, worst {worst:e}", brute.len());
        assert!(worst < 1e-9 && cut > 4, "{worst:e} {cut}");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let surface = AnalyticSurface::SphereCap { radius: -40.0, diameter: 30.0 };
    let path = passes(&surface, 0.1, AE, 1, (0.8, 16));
    let grid = grid(&surface, [0.8, 0.8], [0.0, 0.0], 0.02);
    let of = |threads| {
        let options = SweepOptions { threads, ..options(0.25) };
        let map = on_plane(&path, &grid, Runout::default(), &options);
        (map.heights.iter().map(|h| h.to_bits()).collect::<Vec<_>>(), map.work)
    };
    let one = of(1);
    assert_eq!(of(2), one);
    assert_eq!(of(3), one);
}

#[test]
fn bull_and_flat_ends_leave_their_bottom() {
    for corner in [0.0, 1.0] {
        let tool = Tool::new(R, corner).unwrap();
        let path = passes(&PLANE, 0.0, AE, 0, (2.0, 1));
        let grid = grid(&PLANE, [0.4, 0.4], [0.0, 0.0], 0.02);
        let cutter = Cutter { tool, ..cutter(Runout::default()) };
        // The passes are those of a ball, whose tip stands where theirs does.
        let map = sweep(&grid, &cutter, &feed_moves(&path, corner), &options(AP), &mut |_| {});
        assert!(map.heights.iter().all(|h| h.abs() < 1e-12), "{corner}");
    }
}

#[test]
fn twice_the_resolution_changes_the_mean_height_by_less_than_a_hundredth() {
    for tilt in [0.0, 15.0_f64] {
        let path = passes(&PLANE, tilt.to_radians(), AE, 2, (0.9, 1));
        // Whole periods from track to track: that the nodes at both ends count in full is then of little weight.
        let of = |cell: f64| {
            let grid = grid(&PLANE, [4.0 * FZ, 2.0 * AE], [0.0, 0.0], cell);
            let map = on_plane(&path, &grid, Runout::default(), &options(AP));
            Levelled::new(&grid, &map.heights).areal()
        };
        let (coarse, fine) = (of(0.01), of(0.005));
        println!("tilt {tilt}: {coarse:?} {fine:?} ratio of Sa {:.5}", coarse.sa / fine.sa);
        assert!((coarse.sa / fine.sa - 1.0).abs() < 0.01);
    }
}

#[test]
fn a_tooth_that_runs_out_farther_than_the_material_is_high_is_seen() {
    // One pass; tooth 0 cuts all that is left on its track, `runout sin(tilt)` below the surface.
    let (tilt, out, start) = (45.0_f64.to_radians(), 0.02, 0.003);
    let path = passes(&PLANE, tilt, AE, 0, (1.0, 1));
    let grid = grid(&PLANE, [4.0 * FZ, 0.01], [0.0, 0.005], 0.01);
    let runout = Runout { offset: 0.0, angle: 0.0, teeth: vec![out, 0.0] };
    let known = -out * sin(tilt);
    let cusp = (2.0 * FZ) * (2.0 * FZ) / (8.0 * R);
    let low = on_plane(&path, &grid, runout.clone(), &SweepOptions { start, ..options(start) });
    let track = &low.heights[..grid.counts()[0]];
    let deepest = track.iter().copied().fold(start, f64::min);
    println!("deepest {deepest:.6} known {known:.6}, cusp {cusp:.6}, swing {:.6}", swing(track));
    assert!((deepest / known - 1.0).abs() < 0.01);
    assert!(track.iter().all(|h| *h < known + 1.1 * cusp));
    // Where there is more material, the same is left of it.
    let high = on_plane(&path, &grid, runout, &options(AP));
    let off = low.heights.iter().zip(&high.heights).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 0.01 * cusp);
}

#[test]
fn tiles_of_any_size_give_the_same_heights() {
    let surface = AnalyticSurface::SphereCap { radius: -40.0, diameter: 30.0 };
    let path = passes(&surface, 0.1, AE, 1, (0.8, 16));
    let of = |cell: f64, resolution: f64| {
        let grid = grid(&surface, [0.8, 0.8], [0.0, 0.0], cell);
        let options = SweepOptions { resolution: Some(resolution), ..options(0.25) };
        on_plane(&path, &grid, Runout::default(), &options).heights
    };
    // Nodes that stand alone in their tiles, and the same ones among others.
    let (coarse, fine) = (of(0.2, 0.02), of(0.02, 0.02));
    for (k, height) in coarse.iter().enumerate() {
        let [i, j] = [k % 5, k / 5].map(|n| 10 * n);
        let off = (height - fine[j * 41 + i]).abs();
        assert!(*height < AP && off < 1e-9, "{k}: {off:e}");
    }
}
