//! Loops in a pocket whose walls meet at 30 degrees, and in a straight slot.

use super::*;
use crate::engagement::{Cutting, Stock};
use crate::flat_path::{FlatPoint, Terrain};
use crate::job::FeedComponent;
use crate::outline::Outline;

const RADIUS: f64 = 5.0;
const STEP: f64 = 1.5;
const LIMIT: f64 = 1.5 * STEP;

/// A pocket: the corners of its walls, clockwise.
struct Pocket(Vec<DVec2>);

impl Pocket {
    /// An isosceles triangle whose apex, at the origin, has 30 degrees.
    fn wedge() -> Self {
        let half = 15f64.to_radians();
        let (x, y) = (90.0 * math::cos(half), 90.0 * math::sin(half));
        Self([(0.0, 0.0), (x, y), (x, -y)].map(|(x, y)| DVec2::new(x, y)).to_vec())
    }

    fn slot() -> Self {
        let corners = [(0.0, 0.0), (0.0, 60.0), (90.0, 60.0), (90.0, 0.0)];
        Self(corners.map(|(x, y)| DVec2::new(x, y)).to_vec())
    }

    fn sides(&self, inset: f64) -> Vec<[DVec2; 2]> {
        let corners = self.ring(inset);
        (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]).collect()
    }

    /// The pocket made smaller by `inset` all round.
    fn ring(&self, inset: f64) -> Vec<DVec2> {
        let n = self.0.len();
        let inward = |i: usize| -(self.0[(i + 1) % n] - self.0[i]).normalize().perp();
        (0..n)
            .map(|i| {
                let (a, b) = (inward((i + n - 1) % n), inward(i));
                self.0[i] + (a + b) * (inset / (1.0 + a.dot(b)))
            })
            .collect()
    }

    fn wall(&self, at: DVec2) -> f64 {
        let inside = |[a, b]: [DVec2; 2]| -(b - a).normalize().perp_dot(at - a);
        self.sides(0.0).into_iter().map(inside).fold(f64::INFINITY, f64::min)
    }

    fn simulation(&self) -> Simulation<'_> {
        let mut outline = self.0.clone();
        outline.reverse();
        let stock = Stock::new(&Outline::from_loops(vec![outline]));
        let vfc = FeedComponent::Mean;
        let cutting = Cutting { radius: RADIUS, depth: 1.0, feed: 1.0, vfc, limit: LIMIT };
        Simulation::new(cutting, self, stock)
    }

    fn corridor(&self) -> Corridor {
        let rings = [self.sides(RADIUS), self.sides(RADIUS + STEP)].map(Vec::into_iter);
        let [own, next] = rings;
        Corridor::new(own, next, STEP)
    }

    /// Cuts ring 0 from one place on it to another by loops.
    fn cut(&self, points: &[DVec2], is_run_again: bool, share: f64) -> (Vec<FlatPoint>, usize) {
        let corridor = self.corridor();
        let mut simulation = self.simulation();
        let shares = vec![share; points.len()];
        let span = Span {
            points,
            branches: &[],
            corridor: &corridor,
            toward: 1.0,
            shares: &shares,
            is_run_again,
            begins_at_boundary: false,
        };
        let (back, center, _) = entry(&simulation, &span, &LOOPS);
        enter(&mut simulation, back, center, &LOOPS);
        let entered = simulation.points().len();
        let loops = clear_span(&mut simulation, &span, &LOOPS);
        (simulation.points()[entered..].to_vec(), loops)
    }
}

impl Terrain for Pocket {
    fn scale(&self, at: DVec2) -> Option<f64> {
        (self.wall(at) >= 0.0).then_some(1.0)
    }
    fn room(&self, at: DVec2) -> Option<f64> {
        self.scale(at).map(|_| (self.wall(at) - RADIUS) / STEP)
    }
    fn joins(&self, from: DVec2, to: DVec2) -> bool {
        self.scale(from).is_some() && self.scale(to).is_some()
    }
}

const LOOPS: Loops = Loops {
    radius: 0.5 * STEP,
    least: 0.1,
    smallest: 0.1,
    max_bite: STEP,
    return_feed: 3.0,
    tolerance: 0.005,
    hand: 1.0,
};

fn distance(at: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let part = ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    at.distance(a.lerp(b, part))
}

/// Ring 0 of the wedge beside its apex: in along one wall, out along the other.
fn beside_apex(wedge: &Pocket) -> Vec<DVec2> {
    let ring = wedge.ring(RADIUS);
    let near = |i: usize| ring[0].lerp(ring[i], 25.0 / ring[0].distance(ring[i]));
    vec![near(2), ring[0], near(1)]
}

#[test]
fn radii_in_a_wedge_are_those_of_the_inscribed_circles() {
    let wedge = Pocket::wedge();
    let (simulation, corridor) = (wedge.simulation(), wedge.corridor());
    let points = beside_apex(&wedge);
    let span = Span {
        points: &points,
        branches: &[],
        corridor: &corridor,
        toward: 1.0,
        shares: &[1.0; 3],
        is_run_again: true,
        begins_at_boundary: false,
    };
    let guide = Guide::new(&simulation, &span, &LOOPS);
    let rings: Vec<_> =
        [wedge.sides(RADIUS), wedge.sides(RADIUS + STEP)].into_iter().flatten().collect();
    let (mut widest, mut narrowest) = (0.0f64, f64::INFINITY);
    for along in 0..=1000 {
        let place = guide.station(guide.length * f64::from(along) / 1000.0);
        let inscribed =
            rings.iter().map(|&side| distance(place.center, side)).fold(f64::INFINITY, f64::min);
        if place.radius > LOOPS.smallest {
            let off = (place.radius - inscribed).abs();
            assert!(off <= 0.05 * inscribed, "{} {inscribed} at {}", place.radius, place.center);
        }
        widest = widest.max(place.radius);
        narrowest = narrowest.min(place.radius);
    }
    // Between two rings half a step; up to where ring 1 turns round, more; at the apex nothing.
    let last = SHY * STEP / (1.0 + math::sin(15f64.to_radians()));
    assert!((guide.station(0.0).radius - SHY * 0.5 * STEP).abs() < 0.02 * STEP);
    assert!((widest - last).abs() < 0.05 * last && narrowest < LOOPS.smallest, "{widest} {last}");
}

#[test]
fn a_wedge_is_cut_once_and_returns_are_short() {
    let wedge = Pocket::wedge();
    let points = beside_apex(&wedge);
    let (path, loops) = wedge.cut(&points, true, 1.0);
    assert!(loops > 20, "{loops}");
    let length = |kind: MoveKind, from: usize| -> f64 {
        path[from..].iter().filter(|p| p.kind == kind).map(|p| p.length).sum()
    };
    let (cut, back) = (length(MoveKind::Trochoid, 0), length(MoveKind::Return, 0));
    assert!(back < cut, "{back} {cut}");
    assert!(path.iter().all(|p| p.mrr <= LIMIT), "the limit");
    assert!(path.iter().all(|p| p.kind != MoveKind::Return || p.mrr == 0.0));
    assert!(path.iter().all(|p| wedge.wall(p.at) > RADIUS - 0.03 * STEP));
    // The narrow end is not cut again on the way out.
    let apex = points[1];
    let end = path.iter().rposition(|p| p.at.distance(apex) < 0.5).unwrap();
    let near = path[end..].iter().take_while(|p| p.at.distance(apex) < 2.0 * STEP);
    assert!(near.filter(|p| p.kind == MoveKind::Trochoid && p.mrr > 0.1 * LIMIT).count() < 3);
}

#[test]
fn loops_that_the_ring_follows_end_before_their_cut_is_thin() {
    let slot = Pocket::slot();
    let ring = slot.ring(RADIUS);
    let points = [DVec2::new(ring[1].x + 10.0, ring[1].y), DVec2::new(ring[1].x + 40.0, ring[1].y)];
    let length = |is_run_again: bool| -> (f64, f64, usize) {
        let (path, loops) = slot.cut(&points, is_run_again, 1.0);
        let of = |kind| path.iter().filter(|p| p.kind == kind).map(|p| p.length).sum::<f64>();
        assert!(path.iter().all(|p| p.mrr <= LIMIT), "the limit");
        (of(MoveKind::Trochoid), of(MoveKind::Return), loops)
    };
    let (whole, thick) = (length(false), length(true));
    assert!(thick.0 < 0.9 * whole.0, "{thick:?} {whole:?}");
    // Half of a full circle cuts, and the chord is shorter than the other half.
    let circles = core::f64::consts::PI * STEP * thick.2 as f64;
    assert!(thick.0 + thick.1 < 0.85 * circles, "{thick:?} {circles}");
}

#[test]
fn where_the_disc_removes_more_than_the_cutter_bites_are_larger() {
    let slot = Pocket::slot();
    let ring = slot.ring(RADIUS);
    let points = [DVec2::new(ring[1].x + 10.0, ring[1].y), DVec2::new(ring[1].x + 40.0, ring[1].y)];
    let (path, loops) = slot.cut(&points, true, 1.0);
    let (larger, fewer) = slot.cut(&points, true, 0.7);
    let peak = |path: &[FlatPoint]| path.iter().map(|p| p.mrr).fold(0.0, f64::max);
    assert!(peak(&path) <= LIMIT && 0.7 * peak(&larger) <= LIMIT && peak(&larger) > LIMIT);
    assert!((fewer as f64) < 0.85 * loops as f64, "{fewer} {loops}");
}
