//! Whole pockets in the plane, from rings to the delivered flat path.

use super::*;
use crate::engagement::{Cutting, Stock};
use crate::flat_path::Terrain;
use crate::job::{FeedComponent, ForceControl, Links};
use crate::level_set::Branch;
use crate::link::Precedence;
use crate::outline::Outline;

/// A flat square plate with walls; rings are squares.
struct Plate {
    side: f64,
    radius: f64,
    step: f64,
}

impl Terrain for Plate {
    fn scale(&self, at: DVec2) -> Option<f64> {
        let inside = at.min_element() >= 0.0 && at.max_element() <= self.side;
        inside.then_some(1.0)
    }

    fn room(&self, at: DVec2) -> Option<f64> {
        let wall = at.min_element().min(self.side - at.max_element());
        (wall >= 0.0).then_some((wall - self.radius) / self.step)
    }

    fn joins(&self, from: DVec2, to: DVec2) -> bool {
        self.scale(from).is_some() && self.scale(to).is_some()
    }
}

impl Plate {
    fn corners(&self, inset: f64) -> Vec<DVec2> {
        let (a, b) = (inset, self.side - inset);
        // Clockwise: the inside is on the right.
        [(a, a), (a, b), (b, b), (b, a)].map(|(x, y)| DVec2::new(x, y)).to_vec()
    }

    fn rings(&self) -> Vec<Pass> {
        let count = ((0.5 * self.side - self.radius) / self.step).ceil() as usize;
        (0..count)
            .map(|k| Pass {
                level: if k == 0 { 1e-3 } else { k as f64 },
                points: dense(&self.corners(self.radius + self.step * k as f64)),
                is_closed: true,
                overrun: [0.0; 2],
                half: [0.0; 2],
                beside: [0.0; 2],
                branches: Vec::new(),
            })
            .collect()
    }

    fn run(&self, control: ForceControl, limit: f64, hand: f64) -> (Vec<FlatPoint>, Stock, usize) {
        self.run_measured(
            control,
            limit,
            hand,
            Measured { plain: &|_| Some(f64::INFINITY), beyond: &|_| 1.0 },
        )
    }

    fn run_measured(
        &self,
        control: ForceControl,
        limit: f64,
        hand: f64,
        measured: Measured,
    ) -> (Vec<FlatPoint>, Stock, usize) {
        self.run_rings(self.rings(), control, limit, hand, measured)
    }

    fn run_rings(
        &self,
        rings: Vec<Pass>,
        control: ForceControl,
        limit: f64,
        hand: f64,
        measured: Measured,
    ) -> (Vec<FlatPoint>, Stock, usize) {
        let mut outline = self.corners(0.0);
        outline.reverse();
        let stock = Stock::new(&Outline::from_loops(vec![outline]));
        let cutting = Cutting {
            radius: self.radius,
            depth: 0.5,
            feed: 20.0,
            vfc: FeedComponent::Mean,
            limit,
        };
        let loops = Loops {
            radius: 0.5 * self.step,
            least: 0.1,
            smallest: 0.1,
            max_bite: 2.0,
            return_feed: 50.0,
            tolerance: 0.005,
            hand,
        };
        let options =
            CutOptions { order: RingOrder::OutsideIn, links: Links::Surface, control, loops };
        let precedence = Precedence::new(&rings, options.order);
        let mut simulation = Simulation::new(cutting, self, stock);
        let loops = {
            let group = Group { passes: &rings, precedence: &precedence };
            cut_passes(&mut simulation, (&[group], &[]), &options, measured, |_| {})
        };
        let (points, stock) = simulation.finish();
        (points, stock, loops)
    }
}

fn dense(corners: &[DVec2]) -> Vec<DVec2> {
    let n = corners.len();
    (0..n)
        .flat_map(|i| (0..20).map(move |k| (i, k)))
        .map(|(i, k)| corners[i].lerp(corners[(i + 1) % n], k as f64 / 20.0))
        .collect()
}

fn peak(points: &[FlatPoint]) -> f64 {
    points.iter().map(|p| p.mrr).fold(0.0, f64::max)
}

fn left_inside(stock: &Stock, plate: &Plate) -> f64 {
    let mut area = 0.0;
    stock.remaining(0.1, |p, a| {
        let corner = (p - p
            .clamp(DVec2::splat(plate.radius), DVec2::splat(plate.side - plate.radius)))
        .length();
        if corner < plate.radius - 0.05 {
            area += a;
        }
    });
    area
}

const PLATE: Plate = Plate { side: 60.0, radius: 5.0, step: 1.5 };

#[test]
fn plain_rings_cut_a_slot_first() {
    let (points, stock, _) = PLATE.run(ForceControl::Feed, f64::INFINITY, 1.0);
    let slot = 2.0 * 5.0 * 0.5 * 20.0;
    assert!((peak(&points) - slot).abs() < 1e-6 * slot);
    assert_eq!(left_inside(&stock, &PLATE), 0.0);
}

#[test]
fn feed_control_keeps_the_limit_and_the_geometry() {
    let limit = 1.5 * 1.5 * 0.5 * 20.0;
    let (points, stock, _) = PLATE.run(ForceControl::Feed, limit, 1.0);
    assert!(peak(&points) <= limit && peak(&points) > 0.9 * limit);
    assert_eq!(left_inside(&stock, &PLATE), 0.0);
}

#[test]
fn trochoids_are_only_where_plain_passes_exceed_the_limit() {
    let limit = 1.5 * 1.5 * 0.5 * 20.0;
    let run = |truth: &dyn Fn(DVec2) -> Option<f64>| {
        PLATE.run_measured(
            ForceControl::Trochoid,
            limit,
            1.0,
            Measured { plain: truth, beyond: &|_| 1.0 },
        )
    };
    let loops = |points: &[FlatPoint]| {
        points.iter().filter(|p| p.kind == MoveKind::Trochoid).map(|p| p.at.x).collect::<Vec<_>>()
    };
    let (points, stock, count) = run(&|_| None);
    assert!(count == 0 && loops(&points).is_empty());
    assert!(peak(&points) <= limit && left_inside(&stock, &PLATE) == 0.0);
    let middle = 0.5 * PLATE.side;
    let (points, stock, count) = run(&|at: DVec2| (at.x > middle).then_some(f64::INFINITY));
    assert!(count > 0 && loops(&points).iter().all(|x| *x > middle - 2.0 * PLATE.radius));
    assert!(peak(&points) <= limit && left_inside(&stock, &PLATE) == 0.0);
}

#[test]
fn trochoids_keep_the_limit_and_leave_nothing() {
    for hand in [1.0, -1.0] {
        let limit = 1.5 * 1.5 * 0.5 * 20.0;
        let (points, stock, loops) = PLATE.run(ForceControl::Trochoid, limit, hand);
        assert!(peak(&points) <= limit, "{} {limit}", peak(&points));
        assert!(loops > 100, "{loops} loops");
        assert_eq!(left_inside(&stock, &PLATE), 0.0);
        // Loops do the work: hardly anything is slowed.
        let slowed: f64 = points.iter().filter(|p| p.feed < 15.0).map(|p| p.length).sum();
        let total: f64 = points.iter().map(|p| p.length).sum();
        assert!(slowed < 0.02 * total, "{slowed} of {total}");
    }
}

#[test]
fn a_ring_of_corners_alone_is_entered_on_its_longest_side() {
    let corners = [(0.0, 0.0), (0.0, 4.0), (9.0, 4.0), (9.0, 0.0)];
    let points = corners.map(|(x, y)| DVec2::new(x, y)).to_vec();
    let branch = |at: usize| Branch { at, points: vec![DVec2::new(1.0, 1.0)] };
    let branches = vec![branch(1), branch(2)];
    let ring = Pass { points, branches, ..PLATE.rings()[0].clone() };
    let split = with_middle_of_longest_side(&ring);
    assert_eq!(split.points.len(), 5);
    assert_eq!(split.points[2], DVec2::new(4.5, 4.0));
    for (before, after) in ring.branches.iter().zip(&split.branches) {
        assert_eq!(ring.points[before.at], split.points[after.at]);
    }
    let rings = || vec![Pass { points: PLATE.corners(PLATE.radius), ..PLATE.rings()[0].clone() }];
    let limit = 1.5 * 1.5 * 0.5 * 20.0;
    let measured = Measured { plain: &|_| Some(f64::INFINITY), beyond: &|_| 1.0 };
    let (points, ..) = PLATE.run_rings(rings(), ForceControl::Trochoid, limit, 1.0, measured);
    let middle = 0.5 * PLATE.side;
    let off = (points[0].at - middle).abs();
    assert!(off.min_element() < PLATE.radius, "entered at {}", points[0].at);
}

#[test]
fn loops_cut_less_where_they_broke_the_limit() {
    let limit = 1.5 * 1.5 * 0.5 * 20.0;
    let middle = 0.5 * PLATE.side;
    let run = |by: f64| {
        let beyond = move |at: DVec2| if at.x > middle { by } else { 1.0 };
        let truth = |_| Some(f64::INFINITY);
        PLATE.run_measured(
            ForceControl::Trochoid,
            limit,
            1.0,
            Measured { plain: &truth, beyond: &beyond },
        )
    };
    // Of loops well away from where the factor changes, and from corners, where loops may be slowed instead.
    let peak = |points: &[FlatPoint], is_right: bool| {
        let loops = points.iter().filter(|p| p.kind == MoveKind::Trochoid);
        let off = |p: &FlatPoint| [(p.at.x - middle).abs(), (p.at.y - middle).abs()];
        let away =
            |p: &&FlatPoint| (p.at.x > middle) == is_right && off(p)[0] > 12.0 && off(p)[1] < 20.0;
        loops.filter(away).map(|p| p.mrr).fold(0.0, f64::max)
    };
    let (points, stock, most) = run(1.25);
    assert_eq!(left_inside(&stock, &PLATE), 0.0);
    assert!(peak(&points, true) <= limit / 1.25 && peak(&points, true) > 0.9 * limit / 1.25);
    assert!(peak(&points, false) <= limit && peak(&points, false) > 0.9 * limit);
    assert!(most > run(1.0).2);
}
