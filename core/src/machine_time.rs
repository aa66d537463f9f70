//! Machine time: how long a path takes as commanded, and on a machine that must accelerate.
//!
//! Terms. A *junction* is where two moves meet; its speed is limited by the arc that rounds the
//! corner without leaving the tolerance and without using more than half of either move,
//! `v <= sqrt(a rho)`. A backward pass lowers junction speeds so that every move can brake to its end, a
//! forward pass so that it can reach its end; between them moves follow trapezoids. A move on which rotary
//! axes turn takes at least as long as they do, and accelerates no faster than they can.

use crate::cutter_location::contact_offset;
use crate::geometry::DVec3;
use crate::machine::{Machine, Tables};
use crate::tool::Tool;
use crate::toolpath::{MoveKind, PathPoint, PerKind, Toolpath};

/// Time of a path, s, per kind of move.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
pub struct MachineTime {
    /// Every move at its commanded feed, rapids at the fastest feed.
    pub commanded: PerKind,
    /// With the machine's fastest feed and turn, and its acceleration.
    pub limited: PerKind,
}

/// Length that a move's feed refers to, mm.
///
/// The tip's travel while the axis stays, as controllers count it; while the axis turns, the larger
/// of the tip's and the contact's travel, so that the feed is exceeded at neither. A pure turn
/// without contact counts as the travel of the cutter's rim.
pub fn feed_length(from: &PathPoint, to: &PathPoint, tool: &Tool) -> f64 {
    let tip = to.tip.distance(from.tip);
    let turn = to.axis.distance(from.axis);
    if turn < 1e-12 {
        return tip;
    }
    let contact = |p: &PathPoint| {
        (p.normal.distance_squared(p.axis) > 1e-18)
            .then(|| p.tip + contact_offset(tool, p.normal, p.axis))
    };
    match (contact(from), contact(to)) {
        (Some(a), Some(b)) => tip.max(a.distance(b)),
        _ => tip.max(turn * tool.radius()),
    }
}

/// Time of a move at its commanded feed, s; 0 for a move without length, infinite for one without feed.
pub fn commanded_time(from: &PathPoint, to: &PathPoint, tool: &Tool, machine: &Machine) -> f64 {
    let length = feed_length(from, to, tool);
    if length == 0.0 { 0.0 } else { length / commanded_feed(to, machine) }
}

fn commanded_feed(to: &PathPoint, machine: &Machine) -> f64 {
    if to.kind == MoveKind::Rapid { machine.max_feed } else { to.feed }
}

/// Sets every point's `time` from the commanded feeds, starting at 0.
pub fn fill_time(path: &mut Toolpath, tool: &Tool, machine: &Machine) {
    let mut time = 0.0;
    let mut before: Option<PathPoint> = None;
    for point in &mut path.points {
        if let Some(before) = before {
            time += commanded_time(&before, point, tool, machine);
        }
        point.time = time;
        before = Some(*point);
    }
}

/// A move with length.
struct Move {
    kind: MoveKind,
    length: f64,
    feed: f64,
    /// Largest acceleration along it, mm/s².
    acceleration: f64,
    /// Unit direction of the tip; `None` for a turn about it.
    direction: Option<DVec3>,
}

/// Time of a path as commanded and under the machine's limits, corners rounded within `tolerance` mm.
///
/// The path starts and ends at rest.
///
/// # Source
/// Junction speed from the arc inscribed in the corner, forward and backward passes: the look-ahead of
/// open controllers, e.g. Altintas, "Manufacturing Automation" (2012), ch. 5.
pub fn machine_time(
    path: &Toolpath,
    tool: &Tool,
    machine: &Machine,
    tolerance: f64,
) -> MachineTime {
    let mut time = MachineTime::default();
    let mut moves = Vec::with_capacity(path.points.len());
    let mut turns = Turns::new(path, tool, machine, tolerance);
    for i in 1..path.points.len() {
        let (from, to) = (&path.points[i - 1], &path.points[i]);
        let length = feed_length(from, to, tool);
        if length == 0.0 {
            continue;
        }
        let feed = commanded_feed(to, machine);
        let (fastest, acceleration) = turns.limits(from, &path.points[i..], length, length / feed);
        time.commanded[to.kind] += length / feed;
        moves.push(Move {
            kind: to.kind,
            length,
            feed: feed.min(machine.max_feed).min(fastest),
            acceleration: acceleration.min(machine.max_acceleration),
            direction: (to.tip - from.tip).try_normalize(),
        });
    }
    let squared = junction_speeds(&moves, tolerance);
    for (i, m) in moves.iter().enumerate() {
        time.limited[m.kind] += trapezoid(m, squared[i], squared[i + 1]);
    }
    time
}

/// The rotary axes of a machine that has any, along a path.
struct Turns(Option<Tables>);

impl Turns {
    fn new(path: &Toolpath, tool: &Tool, machine: &Machine, tolerance: f64) -> Self {
        let mut tables = Tables::of(machine, tolerance, tool.radius());
        if let (Some(tables), Some(first)) = (&mut tables, path.points.first()) {
            tables.turn(first.axis);
        }
        Self(tables)
    }

    /// The feed, mm/s, and the acceleration, mm/s², that the rotary axes allow for the move to the first of the points that
    /// follow, which has that length and takes that time as commanded.
    fn limits(
        &mut self,
        from: &PathPoint,
        rest: &[PathPoint],
        length: f64,
        commanded: f64,
    ) -> (f64, f64) {
        let Some(tables) = &mut self.0 else { return (f64::INFINITY, f64::INFINITY) };
        let (to, start) = (&rest[0], tables.at);
        let time = if to.kind == MoveKind::Rapid {
            let stretch = rest[1..].iter().take_while(|p| p.kind != MoveKind::Rapid);
            tables.unwind(rest[..1].iter().chain(stretch).map(|p| p.axis));
            tables.turn(to.axis)
        } else {
            let mut legs = Vec::new();
            match tables.go((from.tip, from.axis), (to.tip, to.axis), commanded, &mut legs) {
                Ok(()) => legs.iter().map(|leg| leg.time).sum::<f64>(),
                // No program can be written, but its time can be given.
                Err(_) => tables.turn(to.axis),
            }
        };
        (length / time, length * tables.chain.acceleration(start, tables.at))
    }
}

/// Squared speeds at the `#moves + 1` junctions, mm²/s².
fn junction_speeds(moves: &[Move], tolerance: f64) -> Vec<f64> {
    let mut squared = vec![0.0; moves.len() + 1];
    for i in 1..moves.len() {
        let (before, after) = (&moves[i - 1], &moves[i]);
        let feed = before.feed.min(after.feed);
        squared[i] = corner(before, after, tolerance).min(feed * feed);
    }
    for i in (0..moves.len()).rev() {
        squared[i] = squared[i].min(squared[i + 1] + 2.0 * moves[i].acceleration * moves[i].length);
    }
    for i in 0..moves.len() {
        squared[i + 1] =
            squared[i + 1].min(squared[i] + 2.0 * moves[i].acceleration * moves[i].length);
    }
    squared
}

/// Largest squared speed at which the corner between two moves can be rounded.
fn corner(before: &Move, after: &Move, tolerance: f64) -> f64 {
    let (Some(a), Some(b)) = (before.direction, after.direction) else { return f64::INFINITY };
    // With phi the turn: cos(phi/2)^2 = (1 + cos phi) / 2.
    let half_cosine = (0.5 * (1.0 + a.dot(b))).clamp(0.0, 1.0).sqrt();
    let half_sine = 0.5 * a.distance(b);
    if half_sine < 1e-12 {
        return f64::INFINITY;
    }
    let by_tolerance = tolerance * half_cosine * (1.0 + half_cosine) / (half_sine * half_sine);
    let by_length = 0.5 * before.length.min(after.length) * half_cosine / half_sine;
    before.acceleration.min(after.acceleration) * by_tolerance.min(by_length)
}

/// Time of a move that starts and ends at the given squared speeds.
fn trapezoid(m: &Move, start: f64, end: f64) -> f64 {
    let acceleration = m.acceleration;
    let reachable = 0.5 * (start + end) + acceleration * m.length;
    let top = reachable.min(m.feed * m.feed);
    let (v0, v1, v) = (start.sqrt(), end.sqrt(), top.sqrt());
    let ramps = (2.0 * top - start - end) / (2.0 * acceleration);
    (2.0 * v - v0 - v1) / acceleration + (m.length - ramps).max(0.0) / v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::{cos, sin};
    use crate::machine::{Arrangement, Axes, Chain, RotaryAxis};

    fn machine() -> Machine {
        Machine {
            axes: Axes::ThreeAxis,
            max_feed: 250.0,
            max_acceleration: 2000.0,
            clearance: 10.0,
            travel: crate::machine::Travel::default(),
        }
    }

    fn path(points: impl IntoIterator<Item = (MoveKind, DVec3)>, feed: f64) -> Toolpath {
        let points = points
            .into_iter()
            .map(|(kind, tip)| PathPoint {
                kind,
                pass: 0,
                region: 0,
                tip,
                axis: DVec3::Z,
                normal: DVec3::Z,
                flat: None,
                feed,
                mrr: 0.0,
                alpha: 0.0,
                time: 0.0,
            })
            .collect();
        Toolpath { points }
    }

    fn ball() -> Tool {
        Tool::new(5.0, 5.0).unwrap()
    }

    #[test]
    fn a_straight_line_takes_its_length_and_two_ramps() {
        let line = |n: u32| {
            let at = |i: u32| (MoveKind::Cut, DVec3::X * (100.0 * f64::from(i) / f64::from(n)));
            machine_time(&path((0..=n).map(at), 50.0), &ball(), &machine(), 0.005)
        };
        for n in [1, 7, 1000] {
            let time = line(n);
            assert!((time.commanded.total() - 2.0).abs() < 1e-12);
            assert!((time.limited.total() - (2.0 + 50.0 / 2000.0)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_circle_is_run_at_the_speed_its_curvature_allows() {
        let n = 3600;
        let at = |i: u32| {
            let t = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            (MoveKind::Cut, DVec3::new(cos(t), sin(t), 0.0) * 2.0)
        };
        let time = machine_time(&path((0..=20 * n).map(at), 200.0), &ball(), &machine(), 0.01);
        // sqrt(2000 * 2) = 63.2 mm/s instead of 200.
        let expected = 20.0 * std::f64::consts::TAU * 2.0 / 4000.0f64.sqrt();
        let limited = time.limited.total();
        assert!(limited > expected && limited < 1.01 * expected, "{limited} is not {expected}");
    }

    #[test]
    fn a_sharp_corner_is_nearly_a_stop_and_a_reversal_is_one() {
        let corner = |end: DVec3| {
            let points = [DVec3::ZERO, DVec3::X * 50.0, end].map(|p| (MoveKind::Cut, p));
            machine_time(&path(points, 100.0), &ball(), &machine(), 0.005).limited.total()
        };
        let stop = 2.0 * (0.5 + 0.05);
        assert!((corner(DVec3::ZERO) - stop).abs() < 1e-9);
        let square = corner(DVec3::new(50.0, 50.0, 0.0));
        assert!(square < stop && square > stop - 0.01);
    }

    /// Ten moves of 10 mm around right angles, 50 mm/s, 1000 mm/s², 0.01 mm. A corner is run at the root of
    /// 1000 * 0.01 * c / (1 - c) = 24.142, c = cos 45 degrees: 4.9135 mm/s. The first and the last move have ramps of 0.05 s and
    /// 1.25 mm at rest and of 0.0450865 s and 1.237929 mm at the corner, the others two of those; the rest is run at 50 mm/s.
    #[test]
    fn ten_moves_take_the_time_of_trapezoids_by_hand() {
        let mut at = DVec3::ZERO;
        let mut points = vec![(MoveKind::Cut, at)];
        for i in 0..10 {
            at += if i % 2 == 0 { DVec3::X } else { DVec3::Y } * 10.0;
            points.push((MoveKind::Cut, at));
        }
        let slow = Machine { max_acceleration: 1000.0, ..machine() };
        let time = machine_time(&path(points, 50.0), &ball(), &slow, 0.01).limited.total();
        let ends = 0.05 + 0.0450865 + (10.0 - 1.25 - 1.237929) / 50.0;
        let middle = 2.0 * 0.0450865 + (10.0 - 2.0 * 1.237929) / 50.0;
        assert!((time - (2.0 * ends + 8.0 * middle)).abs() < 1e-5, "{time}");
    }

    #[test]
    fn kinds_are_told_apart_and_rapids_run_at_the_fastest_feed() {
        let points = [
            (MoveKind::Rapid, DVec3::ZERO),
            (MoveKind::Rapid, DVec3::X * 500.0),
            (MoveKind::Link, DVec3::new(500.0, 0.0, -10.0)),
            (MoveKind::Cut, DVec3::new(480.0, 0.0, -10.0)),
        ];
        let mut path = path(points, 10.0);
        let time = machine_time(&path, &ball(), &machine(), 0.005);
        assert_eq!(time.commanded[MoveKind::Rapid], 2.0);
        assert_eq!(time.commanded[MoveKind::Link], 1.0);
        assert!(time.limited[MoveKind::Rapid] > 2.0);
        fill_time(&mut path, &ball(), &machine());
        assert_eq!(path.points.iter().map(|p| p.time).collect::<Vec<_>>(), [0.0, 2.0, 3.0, 5.0]);
    }

    #[test]
    fn tables_take_the_time_of_their_turn() {
        let tilted = |t: f64| DVec3::new(0.6 * sin(t), 0.6 * cos(t), 0.8);
        let time = |axes| {
            let mut p = path((0..=20).map(|i| (MoveKind::Cut, DVec3::X * f64::from(i))), 10.0);
            let turned = |(i, p): (usize, &mut PathPoint)| p.axis = tilted(0.2 * i as f64);
            p.points.iter_mut().enumerate().for_each(turned);
            machine_time(&p, &ball(), &Machine { axes, ..machine() }, 0.005)
        };
        let with = |max_acceleration: f64| {
            let Axes::FiveAxis(chain) = Arrangement::Xyzac.axes(0.0) else { panic!("tables") };
            let axes = chain.axes().map(|a| RotaryAxis { max_speed: 1.0, max_acceleration, ..a });
            time(Axes::FiveAxis(Chain::new(axes, 0.0).unwrap()))
        };
        let (three, five) = (time(Axes::ThreeAxis), with(f64::INFINITY));
        assert_eq!(three.commanded, five.commanded);
        // C turns by 4 rad, 1 rad/s.
        let turned = five.limited.total();
        assert!(three.limited.total() < 3.0 && (4.0..4.1).contains(&turned), "{turned}");
        // With 1 rad/s² it takes a second more: half of one for each of the two ramps.
        let slow = with(1.0).limited.total();
        assert!((5.0..5.1).contains(&slow), "{slow}");
    }

    #[test]
    fn a_turn_about_the_contact_still_takes_time() {
        let tool = Tool::new(5.0, 0.0).unwrap();
        let mut p = path([(MoveKind::Cut, DVec3::ZERO); 2], 10.0);
        p.points[1].axis = DVec3::new(0.6, 0.0, 0.8);
        assert!(commanded_time(&p.points[0], &p.points[1], &tool, &machine()) > 0.1);
    }
}
