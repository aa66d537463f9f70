//! Open passes over a plate in the plane.

use super::*;
use crate::engagement::{Cutting, Stock};
use crate::flat_path::Terrain;
use crate::footprint::Footprint;
use crate::job::{FeedComponent, ForceControl, Links, RingOrder, Traverse};
use crate::level_set::Pass;
use crate::link::{Group, LayOptions, Precedence, cut_passes, lay};
use crate::outline::Outline;
use crate::tool::Tool;

const SIDE: f64 = 30.0;
const RADIUS: f64 = 3.0;
const STEP: f64 = 1.2;
const DEPTH: f64 = 2.0;
const FEED: f64 = 25.0;
/// Of the removal rate: one and a half times that of a straight pass.
const LIMIT: f64 = 1.5 * STEP * DEPTH * FEED;

/// A flat square plate with open sides.
struct Plate;

impl Terrain for Plate {
    fn scale(&self, at: DVec2) -> Option<f64> {
        (at.min_element() >= 0.0 && at.max_element() <= SIDE).then_some(1.0)
    }
    fn room(&self, at: DVec2) -> Option<f64> {
        self.scale(at).map(|_| f64::INFINITY)
    }
    fn joins(&self, from: DVec2, to: DVec2) -> bool {
        self.scale(from).is_some() && self.scale(to).is_some()
    }
}

/// Straight passes across the plate, in the order given; the second one with a branch.
fn passes(at: impl Iterator<Item = f64>) -> Vec<Pass> {
    let pass = |(k, x): (usize, f64)| Pass {
        level: k as f64,
        points: (0..=20).map(|i| DVec2::new(x, SIDE * f64::from(i) / 20.0)).collect(),
        is_closed: false,
        overrun: [0.0, 0.5],
        half: [0.0; 2],
        beside: [0.0; 2],
        branches: Vec::new(),
    };
    let mut passes: Vec<Pass> = at.enumerate().map(pass).collect();
    let points = vec![passes[1].points[10] + DVec2::X * 0.5];
    passes[1].branches.push(Branch { at: 10, points });
    passes
}

/// The path as it is laid, and as it is cut, with what stock it leaves and the number of loops.
fn cut(
    passes: &[Pass],
    traverse: Traverse,
    limit: f64,
) -> (Vec<FlatPoint>, Vec<FlatPoint>, f64, usize) {
    let precedence = Precedence::new(&[], RingOrder::OutsideIn);
    let groups = [Group { passes, precedence: &precedence }];
    let laid = lay(
        &groups,
        &Plate,
        &LayOptions {
            order: RingOrder::OutsideIn,
            traverse,
            links: Links::Surface,
            stock_on_right: true,
            radius: RADIUS,
            height: DEPTH,
            feed: FEED,
            footprint: Footprint::new(Tool::new(RADIUS, RADIUS).unwrap(), 0.0),
        },
    );
    let corners = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)];
    let outline = corners.map(|(x, y)| DVec2::new(x, y)).to_vec();
    let vfc = FeedComponent::Mean;
    let cutting = Cutting { radius: RADIUS, depth: DEPTH, feed: FEED, vfc, limit };
    let options = CutOptions {
        order: RingOrder::OutsideIn,
        links: Links::Surface,
        control: ForceControl::Trochoid,
        loops: Loops {
            radius: 0.5 * STEP,
            least: 0.1,
            smallest: 0.1,
            max_bite: STEP,
            return_feed: 50.0,
            tolerance: 0.005,
            hand: 1.0,
        },
    };
    let stock = Stock::new(&Outline::from_loops(vec![outline]));
    let mut simulation = Simulation::new(cutting, &Plate, stock);
    let measured = Measured { plain: &|_| Some(f64::INFINITY), beyond: &|_| 1.0 };
    let loops = cut_passes(&mut simulation, (&groups, &laid), &options, measured, |_| {});
    let (points, stock) = simulation.finish();
    let mut left = 0.0;
    stock.remaining(0.1, |_, area| left += area);
    (laid, points, left, loops)
}

fn across() -> impl Iterator<Item = f64> {
    (0..=25).map(|k| STEP * f64::from(k))
}

#[test]
fn passes_that_keep_the_limit_are_cut_as_they_were_laid() {
    for traverse in [Traverse::Zigzag, Traverse::OneWay] {
        let (laid, points, left, loops) = cut(&passes(across()), traverse, f64::INFINITY);
        assert!(loops == 0 && left == 0.0, "{loops} loops, {left} mm² left");
        let mut cut = points.iter();
        for p in &laid {
            // Moves are cut in pieces.
            let is_it = |q: &&FlatPoint| {
                let same = (q.kind, q.pass, q.height) == (p.kind, p.pass, p.height);
                same && q.at.distance(p.at) < 1e-9
            };
            let found = cut.find(is_it).unwrap_or_else(|| panic!("{p:?} is missing"));
            assert_eq!((found.overrun, found.heading), (p.overrun, p.heading));
        }
    }
}

/// From one side on the first passes cut little; in the middle of the plate the first one is a slot.
#[test]
fn loops_keep_the_limit_and_leave_nothing() {
    let from_middle = (12..=25).chain((0..12).rev()).map(|k| STEP * f64::from(k));
    let starts: [(Vec<Pass>, f64); 2] =
        [(passes(across()), 0.3 * LIMIT), (passes(from_middle), LIMIT)];
    for (passes, limit) in starts {
        for traverse in [Traverse::Zigzag, Traverse::OneWay] {
            let (_, points, left, loops) = cut(&passes, traverse, limit);
            assert!(loops > 20, "{loops} loops");
            assert_eq!(left, 0.0);
            let peak = points.iter().map(|p| p.mrr).fold(0.0, f64::max);
            assert!(peak <= limit, "{peak} of {limit}");
            // Loops do the work: hardly anything but the helix down is slowed.
            let cutting = points.iter().filter(|p| p.kind != MoveKind::Link);
            let slowed: f64 =
                cutting.clone().filter(|p| p.feed < 0.9 * FEED).map(|p| p.length).sum();
            let total: f64 = cutting.map(|p| p.length).sum();
            assert!(slowed < 0.1 * total, "{slowed} of {total} mm");
            // They begin where the pass before has cleared, and grow from there: one that began in the stock would be a
            // slot, over half of the cutter.
            let loops = points.iter().filter(|p| p.kind == MoveKind::Trochoid);
            let widest = loops.map(|p| p.mrr / p.feed / DEPTH).fold(0.0, f64::max);
            assert!(widest < RADIUS, "{widest} mm");
        }
    }
}
