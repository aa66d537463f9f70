//! Closed forms: what simple paths take.

use super::*;
use crate::flatten::Chart;
use crate::geometry::math::{acos, asin, cos, sin};
use crate::geometry::{DVec2, DVec3};
use crate::mesh::{Connectivity, VertexId};
use crate::surface::Surface;
use crate::tool::Tool;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};

const FEED: f64 = 20.0;
const R: f64 = 5.0;

/// A rectangle that rises by `slope` rad along x, its chart the rectangle itself.
struct Plate {
    surface: Surface,
    chart: Chart,
    along: DVec3,
    normal: DVec3,
}

/// A cutter without end.
fn stage(strokes: &Strokes, tool: Tool) -> Stage<'_> {
    Stage { strokes, cutter: endless(tool) }
}

fn endless(tool: Tool) -> Cutter {
    Cutter { tool, length: f64::INFINITY }
}

impl Plate {
    fn new(length: f64, width: f64, slope: f64) -> Self {
        let along = DVec3::new(cos(slope), 0.0, sin(slope));
        let uv = [(0.0, 0.0), (length, 0.0), (length, width), (0.0, width)].map(DVec2::from);
        let faces = [[0, 1, 2], [0, 2, 3]].map(|f| f.map(VertexId)).to_vec();
        let connectivity = Connectivity::new(4, faces).unwrap();
        let surface = Surface::new(connectivity, uv.map(|p| along * p.x + DVec3::Y * p.y).to_vec());
        let chart = Chart::new(&surface, uv.to_vec());
        Self { surface, chart, along, normal: along.cross(DVec3::Y) }
    }

    /// The tip that touches at a place, the axis upright.
    fn tip(&self, tool: &Tool, p: DVec2, allowance: f64) -> DVec3 {
        let contact = self.along * p.x + DVec3::Y * p.y;
        if (self.normal - DVec3::Z).length() < 1e-12 {
            // The middle of the bottom, which touches all over.
            return contact + self.normal * allowance;
        }
        crate::cutter_location::tip(tool, contact, self.normal, DVec3::Z, allowance)
    }
}

fn point(kind: MoveKind, tip: DVec3) -> PathPoint {
    PathPoint {
        kind,
        pass: 0,
        region: 0,
        tip,
        axis: DVec3::Z,
        normal: DVec3::Z,
        flat: Some(DVec2::ZERO),
        feed: FEED,
        mrr: 0.0,
        alpha: 0.0,
        time: 0.0,
    }
}

/// Passes from one flat place to another, with a rapid before each.
fn passes(plate: &Plate, tool: &Tool, allowance: f64, ends: &[(DVec2, DVec2)]) -> Toolpath {
    let mut path = Toolpath::default();
    for &(a, b) in ends {
        path.points.push(point(MoveKind::Rapid, plate.tip(tool, a, allowance)));
        path.points.push(point(MoveKind::Cut, plate.tip(tool, b, allowance)));
    }
    path
}

const LAYER: Layer = Layer { allowance: 0.2, depth: 0.8, falls: false };

/// Rates of all windows of 0.2 R on the last move, mm³/s, without its first and last `margin` mm.
fn last_rates(
    plate: &Plate,
    tool: &Tool,
    side_step: f64,
    path: &Toolpath,
    margin: f64,
) -> Vec<f64> {
    let columns = Columns::new(&plate.surface, &plate.chart, side_step, LAYER.top());
    assert!((columns.area() / plate.surface.area() - 1.0).abs() < 0.002);
    let removed = columns.cut(path, endless(*tool), LAYER, 2);
    let last = removed.of_move(path.points.len() - 1);
    let skip = (margin / last[0].length) as usize;
    let corner = tool.corner_radius();
    let longest = if corner > 0.0 { 0.1 * R.min(4.0 * corner) } else { 0.1 * R };
    assert!((last[0].length - longest).abs() < 0.02);
    let rates = last[skip..last.len() - skip]
        .windows(2)
        .map(|w| FEED * (w[0].volume + w[1].volume) / (w[0].length + w[1].length));
    rates.collect()
}

fn assert_close(rates: &[f64], exact: f64, part: f64) {
    assert!(rates.len() > 20);
    for rate in rates {
        assert!((rate / exact - 1.0).abs() < part, "{rate} is not {exact}: {rates:?}");
    }
}

/// Passes a side step apart at some angle to the plate's sides; the last one is in steady state.
fn steady(angle: f64, side_step: f64) -> Vec<(DVec2, DVec2)> {
    let along = DVec2::new(cos(angle), sin(angle));
    let across = along.perp();
    let middle = DVec2::new(30.0, 20.0);
    let count = (3.0 * R / side_step) as i32;
    (-count..=0)
        .map(|k| middle + across * (side_step * f64::from(k)))
        .map(|m| (m - along * 16.0, m + along * 16.0))
        .collect()
}

#[test]
fn steady_passes_of_a_flat_end_take_the_side_step() {
    let (plate, tool) = (Plate::new(60.0, 40.0, 0.0), Tool::new(R, 0.0).unwrap());
    for (angle, side_step) in [(0.0, 1.5), (0.3, 0.6), (0.6, 1.5), (0.9, 1.0)] {
        let path = passes(&plate, &tool, LAYER.allowance, &steady(angle, side_step));
        let rates = last_rates(&plate, &tool, side_step, &path, 7.0);
        assert_close(&rates, side_step * LAYER.depth * FEED, 0.02);
    }
}

#[test]
fn slots_take_the_section_of_the_cutter() {
    let plate = Plate::new(60.0, 40.0, 0.0);
    let ends = [(DVec2::new(8.0, 15.0), DVec2::new(52.0, 24.0))];
    for corner in [0.0, 0.5, 2.0, R] {
        let tool = Tool::new(R, corner).unwrap();
        let path = passes(&plate, &tool, LAYER.allowance, &ends);
        let rates = last_rates(&plate, &tool, 1.5, &path, 6.0);
        assert_close(&rates, 2.0 * tool.mean_radius(LAYER.depth) * LAYER.depth * FEED, 0.01);
    }
    let h = LAYER.depth;
    let segment = R * R * acos((R - h) / R) - (R - h) * (2.0 * R * h - h * h).sqrt();
    let ball = Tool::new(R, R).unwrap();
    assert!((2.0 * ball.mean_radius(h) * h - segment).abs() < 1e-9);
}

#[test]
fn steady_passes_of_a_ball_leave_their_cusps() {
    let (plate, tool) = (Plate::new(60.0, 40.0, 0.0), Tool::new(R, R).unwrap());
    for (angle, d) in [(0.2, 1.5), (0.7, 0.8)] {
        let path = passes(&plate, &tool, LAYER.allowance, &steady(angle, d));
        let rates = last_rates(&plate, &tool, d, &path, 7.0);
        // Between two circles over their common tangent.
        let half = 0.5 * d;
        let circle = 0.5 * (half * (R * R - half * half).sqrt() + R * R * asin(half / R));
        let cusp_area = 2.0 * (R * half - circle);
        assert_close(&rates, (d * LAYER.depth - cusp_area) * FEED, 0.02);
    }
}

/// An upright flat end on a slope, along the contour lines and uphill: steps of `D sin cos` stay.
#[test]
fn an_upright_flat_end_on_a_slope_takes_the_side_step_less_its_steps() {
    let slope = 0.3;
    let (plate, tool) = (Plate::new(60.0, 40.0, slope), Tool::new(R, 0.0).unwrap());
    let d = 1.0;
    let along_contour = |k: i32| {
        let x = 40.0 - d * f64::from(k);
        (DVec2::new(x, 4.0), DVec2::new(x, 36.0))
    };
    for downhill in [true, false] {
        let mut ends: Vec<_> = (0..=16).map(along_contour).collect();
        if !downhill {
            ends.reverse();
        }
        let path = passes(&plate, &tool, LAYER.allowance, &ends);
        let rates = last_rates(&plate, &tool, d, &path, 7.0);
        // Triangles over the side step, their angles at the surface those of the edge.
        let steps = 0.5 * d * d * sin(slope) * cos(slope);
        assert_close(&rates, (d * LAYER.depth - steps) * FEED, 0.03);
    }
}

/// An upright flat end on a slope, uphill and straight down: its front or its rear touches, and beside that its edge
/// stands `(R - sqrt(R² - y²)) sin` above the surface.
#[test]
fn an_upright_flat_end_takes_a_slot_up_and_down_a_slope() {
    for slope in [0.1, 0.3, 0.6] {
        let (plate, tool) = (Plate::new(60.0, 40.0, slope), Tool::new(R, 0.0).unwrap());
        let (low, high) = (DVec2::new(8.0, 20.0), DVec2::new(52.0, 20.0));
        let height = |y: f64| LAYER.depth - (R - (R * R - y * y).sqrt()) * sin(slope);
        let strip = |k: i32| height(R * (f64::from(k) + 0.5) / 1000.0).max(0.0);
        let section = (-1000..1000).map(strip).sum::<f64>() * R / 1000.0;
        for ends in [(low, high), (high, low)] {
            let path = passes(&plate, &tool, LAYER.allowance, &[ends]);
            let rates = last_rates(&plate, &tool, 1.5, &path, 7.0);
            assert_close(&rates, section * FEED, 0.02);
        }
    }
}

#[test]
fn threads_change_nothing() {
    let (plate, tool) = (Plate::new(60.0, 40.0, 0.2), Tool::new(R, 1.0).unwrap());
    let path = passes(&plate, &tool, LAYER.allowance, &steady(0.4, 2.0));
    let columns = Columns::new(&plate.surface, &plate.chart, 2.0, LAYER.top());
    let one = columns.cut(&path, endless(tool), LAYER, 1);
    assert_eq!(one, columns.cut(&path, endless(tool), LAYER, 3));
    assert!(one.pieces.iter().map(|p| p.volume).sum::<f64>() > 100.0);
}

/// Culling leaves nothing out: every column is as low as the lowest pose near it has it.
#[test]
fn no_tile_is_left_out() {
    let plate = Plate::new(60.0, 40.0, 0.35);
    for corner in [0.0, 2.0, R] {
        let tool = Tool::new(R, corner).unwrap();
        let path = passes(&plate, &tool, LAYER.allowance, &steady(0.4, 2.0));
        let columns = Columns::new(&plate.surface, &plate.chart, 6.0, LAYER.top());
        let removed = columns.cut(&path, endless(tool), LAYER, 1);
        let total: f64 = removed.pieces.iter().map(|p| p.volume).sum();
        let gone = columns.blocks.iter().zip(&removed.heights).flat_map(|(b, heights)| {
            b.columns.iter().zip(heights).map(|(c, h)| c.section.area * (LAYER.top() - h))
        });
        assert!((gone.sum::<f64>() / total - 1.0).abs() < 1e-9);
        let body = body::Body::new(endless(tool), LAYER, columns.spacing);
        for (block, heights) in columns.blocks.iter().zip(&removed.heights) {
            for (column, &left) in block.columns.iter().zip(heights) {
                let lowest = path.points.windows(2).filter(|w| w[1].kind == MoveKind::Cut);
                let lowest = lowest.fold(left, |height, w| {
                    let pose =
                        |t: f64| body::Pose { tip: w[0].tip.lerp(w[1].tip, t), axis: DVec3::Z };
                    (0..64).fold(height, |height, k| {
                        let (a, b) = (f64::from(k) / 64.0, f64::from(k + 1) / 64.0);
                        let stroke = body::Stroke::new(pose(a), pose(b));
                        body.lowered(&stroke, &column.line, height)
                    })
                });
                assert!(left - lowest < 2e-3, "{corner}: {left} above {lowest}");
            }
        }
    }
}

/// A flat end leaned by `lean` leaves crests of `(R - sqrt(R² - s²/4)) sin(lean)` between passes that are `s`
/// apart, and nothing higher.
#[test]
fn what_a_leaned_flat_end_leaves_are_its_crests() {
    let (lean, step) = (0.087, 4.0);
    let (plate, tool) = (Plate::new(60.0, 40.0, lean), Tool::new(R, 0.0).unwrap());
    let rows = (0..=10).map(|k| step * f64::from(k));
    let rows = rows.map(|y| (DVec2::new(70.0, y), DVec2::new(-10.0, y))).collect::<Vec<_>>();
    let path = passes(&plate, &tool, LAYER.allowance, &rows);
    let columns = Columns::new(&plate.surface, &plate.chart, 2.0, LAYER.top());
    let crest = (R - (R * R - 0.25 * step * step).sqrt()) * sin(lean);
    let strokes = Strokes::of(&path, &tool);
    let enough = LAYER.allowance + 0.9 * crest;
    let heights = columns.remains(&[stage(&strokes, tool)], LAYER, enough, 1);
    let highest = heights.iter().flatten().copied().fold(0.0, f64::max) - LAYER.allowance;
    assert!(highest <= crest + 1e-9 && highest > 0.95 * crest, "{highest} of {crest}");
}

/// Strokes that are found by place and held against single tiles leave what all strokes leave, one after the other: the
/// order and the places of passes, loops and turns of the axis do not matter.
#[test]
fn strokes_found_by_place_leave_what_all_strokes_leave() {
    let plate = Plate::new(40.0, 30.0, 0.25);
    let columns = Columns::new(&plate.surface, &plate.chart, 1.5, LAYER.top());
    for corner in [R, 2.0] {
        let tool = Tool::new(R, corner).unwrap();
        // Every seventh row next, so that neighbours are far apart in the path; then a spiral across them.
        let rows = (0..20).map(|k| 1.5 * f64::from(k * 7 % 20));
        let rows = rows.map(|y| (DVec2::new(-6.0, y), DVec2::new(46.0, y + 0.7)));
        let mut path = passes(&plate, &tool, LAYER.allowance + 0.1, &rows.collect::<Vec<_>>());
        for k in 0..120 {
            let (turn, radius) = (0.2 * f64::from(k), 0.08 * f64::from(k));
            let place = DVec2::new(20.0 + radius * cos(turn), 15.0 + radius * sin(turn));
            let kind = if k == 0 { MoveKind::Rapid } else { MoveKind::Cut };
            let mut end = point(kind, plate.tip(&tool, place, LAYER.allowance));
            end.axis = DVec3::new(0.1 * sin(turn), 0.1 * cos(turn), 1.0).normalize();
            path.points.push(end);
        }
        let all = columns.cut(&path, endless(tool), LAYER, 1).heights;
        let strokes = Strokes::of(&path, &tool);
        let found = columns.remains(&[stage(&strokes, tool)], LAYER, f64::NEG_INFINITY, 1);
        let pairs = || all.iter().flatten().zip(found.iter().flatten());
        assert_eq!(pairs().count(), columns.count());
        let off = pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // What either passes over is not deeper than this.
        assert!(off < 5e-4, "{corner}: {off}");
        let lowest = found.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        assert!(lowest < LAYER.allowance + 0.05, "{lowest}");
    }
}

/// What stands farther up from the tip than the cutter is long stays.
#[test]
fn a_cutter_cuts_as_far_up_as_it_is_long() {
    let tool = Tool::new(R, R).unwrap();
    let pose = |x: f64| body::Pose { tip: DVec3::new(x, 0.0, 0.0), axis: DVec3::Z };
    // Past a wall whose layer the side of the cutter enters by half.
    let stroke = body::Stroke::new(pose(-0.1), pose(0.1));
    let out = R + LAYER.allowance + 0.5 * LAYER.depth;
    for (length, height, is_cut) in
        [(f64::INFINITY, 100.0, true), (20.0, 19.0, true), (20.0, 21.0, false)]
    {
        let body = body::Body::new(Cutter { tool, length }, LAYER, 0.1);
        let foot = DVec3::new(0.0, out - LAYER.allowance, height);
        let line = body::Line { foot, normal: -DVec3::Y };
        let left = body.lowered(&stroke, &line, LAYER.top());
        assert_eq!(left < LAYER.top(), is_cut, "{length} mm long, {height} mm up: {left}");
    }
}

/// However the cutter turns, a column falls in a move as far as in many short ones.
#[test]
fn a_turning_cutter_takes_in_a_move_what_it_takes_on_the_way() {
    for corner in [1.0, 2.5, R] {
        let tool = Tool::new(R, corner).unwrap();
        let body =
            body::Body::new(endless(tool), Layer { allowance: 0.0, depth: 0.3, falls: false }, 0.0);
        for turn in [-0.02, 0.0, 0.02] {
            let pose = |t: f64| {
                let lean = 0.09 + turn * t;
                let axis = DVec3::new(sin(lean), 0.3 * turn * t, cos(lean)).normalize();
                let front = DVec3::X.reject_from(axis).normalize() * (R - corner);
                let contact = DVec3::new(0.4 * t, 0.0, corner);
                body::Pose { tip: contact - front - axis * corner, axis }
            };
            let stroke = body::Stroke::new(pose(0.0), pose(1.0));
            for (x, y) in (0..40).flat_map(|i| (0..20).map(move |j| (i, j))) {
                let foot = DVec3::new(0.02 * f64::from(x) - 0.2, 0.1 * f64::from(y), 0.0);
                let line = body::Line { foot, normal: DVec3::Z };
                // Where the move starts is where the one before ended.
                let before = body.lowered(&body::Stroke::new(stroke.from, stroke.from), &line, 0.3);
                let found = body.lowered(&stroke, &line, before);
                let part = |k: i32| stroke.from.toward(&stroke.to, f64::from(k) / 100.0);
                let exact = (0..100).fold(before, |left, k| {
                    body.lowered(&body::Stroke::new(part(k), part(k + 1)), &line, left)
                });
                assert!(
                    (found - exact).abs() < 1e-3,
                    "{corner} {turn} at {foot}: {found} is not {exact}"
                );
            }
        }
    }
}

/// Columns that an earlier path has cut: a path takes from them what it takes after that path, and leaves the same.
#[test]
fn a_path_takes_what_an_earlier_one_left() {
    let plate = Plate::new(40.0, 30.0, 0.25);
    let ball = |r: f64| Tool::new(r, r).unwrap();
    let rows = |step: f64, count: u32, high: f64, tool: Tool| {
        let row = |k: u32| step * f64::from(k);
        let ends = (0..count).map(row).map(|y| (DVec2::new(-6.0, y), DVec2::new(46.0, y)));
        passes(&plate, &tool, LAYER.allowance + high, &ends.collect::<Vec<_>>())
    };
    let (first, second) = (rows(4.0, 8, 0.1, ball(R)), rows(3.0, 11, 0.0, ball(R)));
    let columns = Columns::new(&plate.surface, &plate.chart, 1.5, LAYER.top());
    let both = Toolpath { points: [&first.points[..], &second.points].concat() };
    let whole = columns.cut(&both, endless(ball(R)), LAYER, 1);
    let earlier = Earlier {
        path: first.clone(),
        cutter: endless(ball(R)),
        cusps: 0.5,
        allowance: LAYER.allowance,
        bridged: 0.0,
    };
    let stock = Stock::fresh(LAYER.top()).after(earlier);
    let before = stock.strokes();
    let cut = columns.clone().cut_before(&before, LAYER, 2);
    let after = cut.cut(&second, endless(ball(R)), LAYER, 1);
    let pairs = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        let off = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
        off.fold(0.0, f64::max)
    };
    assert!(pairs(&whole.heights, &after.heights) < 5e-4);
    let volume = |removed: &Removed| removed.pieces.iter().map(|p| p.volume).sum::<f64>();
    let alone = columns.cut(&first, endless(ball(R)), LAYER, 1);
    assert!((volume(&whole) - volume(&alone) - volume(&after)).abs() < 1e-3 * volume(&whole));
    assert!(volume(&after) < 0.5 * volume(&alone));
    // What both leave, whichever is asked for first.
    let strokes = Strokes::of(&second, &ball(R));
    let stages = before.with(&strokes, ball(R), f64::INFINITY);
    let left = columns.remains(&stages, LAYER, f64::NEG_INFINITY, 1);
    assert!(pairs(&left, &whole.heights) < 5e-4);
}
