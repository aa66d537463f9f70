//! Passes on cylinders, on which the ball's centre and its chords are known.

use super::super::axes::AxisOptions;
use super::super::axes::Stand;
use super::super::shapes::{Cylinder, options};
use super::super::strips::{Measured, Strip, ways};
use super::*;
use crate::cutter_location::Hindrance;
use crate::footprint::Footprint;
use crate::geometry::math::{atan2, cos};
use crate::nurbs::NurbsCurve;
use crate::tool::{Assembly, Tool};

const HUB: Cylinder = Cylinder { radius: 50.0, length: 80.0 };
const RADIUS: f64 = 3.0;
const ALLOWANCE: f64 = 0.2;
const TOLERANCE: f64 = 0.01;
const EXTENSION: f64 = 6.0;
const FORWARD: Order = Order { forward: true, back: false };

/// Axes with nothing in their way.
fn axes(wheel: &Wheel, channel: &Channel) -> AxisField {
    let stand = |i: usize| {
        let (s, t) = ((i / 3) as f64 / 8.0, (i % 3) as f64 / 2.0);
        let [along, _] = ways(wheel, channel, s, t);
        Stand {
            contact: channel.place(wheel, s, t),
            normal: wheel.normal(channel.at(s, t)),
            along: along.normalize(),
        }
    };
    let stands: Vec<Stand> = (0..27).map(stand).collect();
    let cutter = Assembly::of_cutter(Tool::new(RADIUS, RADIUS).unwrap(), 12.0);
    let wanted = AxisOptions { clearance: 0.1, allowance: 0.0, steepest: 1.3, threads: 1 };
    AxisField::new(&stands, 9, 3, &Hindrance::default(), &cutter, &wanted).unwrap()
}

/// A channel with all that a route needs.
struct Case {
    wheel: Wheel,
    channel: Channel,
    axes: AxisField,
}

impl Case {
    fn new(wheel: Wheel, channel: Channel) -> Self {
        let axes = axes(&wheel, &channel);
        Self { wheel, channel, axes }
    }

    /// On the hub: a channel that winds around by `turn` mm per mm along, from one height to another.
    fn helix(hub: Cylinder, turn: f64, (from, to): (f64, f64), width: f64) -> Self {
        let wheel = hub.wheel(12);
        let side = |s: f64| DVec2::new(10.0 + turn * (to - from) * s, from + (to - from) * s);
        let channel = hub.channel(&wheel, side, |s| side(s) + DVec2::X * width);
        Self::new(wheel, channel)
    }

    fn route(&self, tolerance: f64) -> Route<'_> {
        let (allowance, extension) = (ALLOWANCE, EXTENSION);
        let Self { wheel, channel, axes } = self;
        let clear = &|_: &[Station]| true;
        Route { wheel, channel, axes, radius: RADIUS, allowance, tolerance, extension, clear }
    }

    fn lines(&self, cusp: f64) -> Vec<Line> {
        let footprint = Footprint::new(Tool::new(RADIUS, RADIUS).unwrap(), 0.0);
        Measured::new(&self.wheel, &self.channel, &Strip { footprint, cusp }).equal_parts()
    }
}

/// Distance from the axis z.
fn from_axis(p: DVec3) -> f64 {
    DVec3::new(p.x, p.y, 0.0).length()
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    atan2(a.cross(b).length(), a.dot(b))
}

/// A chord of `2 sqrt(2 rho eps - eps²)` has the sagitta `eps`.
#[test]
fn steps_are_chords_of_the_error() {
    let case = Case::helix(HUB, 0.0, (10.0, 60.0), 30.0);
    let route = case.route(TOLERANCE);
    // Around the cylinder.
    let curve = |x: f64| (0.5, x);
    for error in [0.001, 0.01, 0.1] {
        for x in [0.1, 0.4, 0.7] {
            let place = |x: f64| case.channel.place(&case.wheel, 0.5, x);
            let speed = place(x + 1e-5).distance(place(x - 1e-5)) / 2e-5;
            let chord = route.step(&curve, x, error) * speed;
            let sagitta = HUB.radius - (HUB.radius.powi(2) - 0.25 * chord * chord).sqrt();
            assert!((sagitta / error - 1.0).abs() < 1e-3, "{sagitta} of {error}");
        }
    }
}

#[test]
fn centres_are_at_the_radius_and_the_allowance_along_the_normal() {
    let case = Case::helix(HUB, 0.8, (10.0, 60.0), 8.0);
    let route = case.route(TOLERANCE);
    for (s, t) in [(0.0, 0.0), (0.3, 0.5), (1.0, 1.0)] {
        let station = route.station((s, t), MoveKind::Cut, 0);
        let contact = case.channel.place(&case.wheel, s, t);
        let outward = DVec3::new(contact.x, contact.y, 0.0) / HUB.radius;
        assert!(station.centre.distance(contact + outward * (RADIUS + ALLOWANCE)) < 1e-9);
        let tip = station.centre - station.axis * RADIUS;
        assert!(route.tip(&station).distance(tip) < 1e-12);
        assert!((station.axis.length() - 1.0).abs() < 1e-9);
    }
}

/// Between points tip and axis change evenly, and the ball's centre stays beside the cylinder.
#[test]
fn between_points_the_centre_keeps_the_tolerance() {
    let case = Case::helix(HUB, 1.0, (10.0, 60.0), 8.0);
    let exact = HUB.radius + RADIUS + ALLOWANCE;
    let mut counts = Vec::new();
    for tolerance in [0.05, 0.01, 0.002] {
        let route = case.route(tolerance);
        let all = route.along(&|x| (x, 0.3), MoveKind::Cut, 4);
        for w in all.windows(2) {
            for k in 0..=8 {
                let t = f64::from(k) / 8.0;
                let axis = w[0].axis.lerp(w[1].axis, t).normalize();
                let centre = route.tip(&w[0]).lerp(route.tip(&w[1]), t) + axis * RADIUS;
                let off = (from_axis(centre) - exact).abs();
                assert!(off <= tolerance, "{off} of {tolerance}");
            }
        }
        assert!(all.iter().all(|s| s.pass == 4 && s.kind == MoveKind::Cut));
        let ends = [all[0], all[all.len() - 1]].map(|s| s.at.unwrap());
        assert_eq!(ends, [case.channel.at(0.0, 0.3), case.channel.at(1.0, 0.3)]);
        counts.push(all.len());
    }
    // Points are as the root of one over the tolerance.
    assert!(counts[2] < 8 * counts[0], "{counts:?}");
}

/// Passes go on in their own direction, and turn until they run along the axis.
#[test]
fn extensions_begin_along_the_tangent_and_end_along_the_axis() {
    let case = Case::helix(HUB, 1.0, (20.0, 60.0), 8.0);
    let mut angles = Vec::new();
    for tolerance in [TOLERANCE, TOLERANCE / 16.0] {
        let route = case.route(tolerance);
        let path = route.path(&case.lines(0.05), 0, FORWARD).stations;
        let cut = path.iter().rposition(|s| s.kind == MoveKind::Cut).unwrap();
        let way = |i: usize| path[i + 1].centre - path[i].centre;
        let turn = angle(way(cut - 1), way(cut));
        // A chord is off the tangent by half the arc that it spans.
        assert!(turn < (2.0 * tolerance / HUB.radius).sqrt(), "{turn}");
        angles.push(turn);
        let first = path.iter().position(|s| s.kind == MoveKind::Cut).unwrap();
        assert!(angle(way(first - 1), way(first)) < (2.0 * tolerance / HUB.radius).sqrt());
        let (begins, ends) = (way(0), way(path.len() - 2));
        let five_degrees = cos(0.0873);
        assert!(begins.normalize().z > five_degrees && ends.normalize().z.abs() > five_degrees);
        // First control point one piece along the tangent, the second another, the third one along the axis.
        let exit = path[cut];
        let [along, around] = [DVec3::Z, DVec3::Z.cross(exit.centre).normalize()];
        // The centre winds about a larger cylinder than the contact.
        let centres = (HUB.radius + RADIUS + ALLOWANCE) / HUB.radius;
        let sign = way(cut).z.signum();
        let tangent = (along + around * centres).normalize() * sign;
        let piece = 0.5 * EXTENSION;
        let end = exit.centre + tangent * (2.0 * piece) + along * (sign * piece);
        let found = path[path.len() - 1].centre;
        // The map is interpolated between rows, 0.4 mm apart.
        assert!(found.distance(end) < 0.01, "{found} is not {end}");
    }
    assert!(angles[1] < 0.5 * angles[0], "{angles:?}");
}

/// A pass that crosses its channel goes on as it runs, not as the channel does.
#[test]
fn a_slanted_pass_goes_on_along_its_own_tangent() {
    let case = Case::helix(HUB, 0.0, (20.0, 60.0), 30.0);
    let tolerance = TOLERANCE / 16.0;
    let route = case.route(tolerance);
    let rows = super::super::channel::ROWS;
    let t = (0..rows).map(|r| 0.2 + 0.5 * r as f64 / (rows - 1) as f64).collect();
    let path = route.path(&[Line::new(t, 0, (0.0, 1.0))], 0, FORWARD).stations;
    let way = |i: usize| path[i + 1].centre - path[i].centre;
    let first = path.iter().position(|s| s.kind == MoveKind::Cut).unwrap();
    let last = path.iter().rposition(|s| s.kind == MoveKind::Cut).unwrap();
    for cut in [first, last] {
        let turn = angle(way(cut - 1), way(cut));
        assert!(turn < 2.0 * (2.0 * tolerance / HUB.radius).sqrt(), "{turn}");
    }
}

/// On a flat ring a channel leaves radially, and so does the cutter.
#[test]
fn where_a_channel_leaves_radially_extensions_end_along_the_meridian() {
    let line = NurbsCurve::line(DVec3::X * 10.0, DVec3::X * 50.0).unwrap();
    let ring = line.revolved(DVec3::ZERO, DVec3::Z).unwrap();
    let wheel = Wheel::new(&ring, &options(12), DVec3::new(30.0, 0.0, 10.0)).unwrap();
    let side = |from: f64| {
        let at = |r: usize| {
            let s = r as f64 / (super::super::channel::ROWS - 1) as f64;
            DVec2::new(from + 0.3 * s, 0.2 + 0.8 * s)
        };
        (0..super::super::channel::ROWS).map(at).collect::<Vec<DVec2>>()
    };
    let channel = Channel::new(&wheel, &side(0.3), &side(0.45), &[]).unwrap();
    let case = Case::new(wheel, channel);
    let route = case.route(TOLERANCE);
    let lines = case.lines(0.05);
    let path = route.path(&lines[..1], 0, FORWARD).stations;
    let cut = path.iter().rposition(|s| s.kind == MoveKind::Cut).unwrap();
    let exit = path[cut].centre;
    assert!((from_axis(exit) - 50.0).abs() < 1e-9, "at the rim");
    let radial = DVec3::new(exit.x, exit.y, 0.0).normalize();
    let last = path[path.len() - 1].centre - path[path.len() - 2].centre;
    assert!(angle(last, radial) < 0.0873, "{last}");
    // Level: nothing along the axis.
    assert!(path.iter().all(|s| (s.centre.z - RADIUS - ALLOWANCE).abs() < 1e-9));
}

/// Also where the hub goes on beyond the channel, and passes are far apart.
#[test]
fn links_at_one_end_stay_off_the_hub() {
    for (hub, cusp) in [(HUB, 0.01), (Cylinder { radius: 15.0, length: 80.0 }, 0.2)] {
        let case = Case::helix(hub, 0.0, (20.0, 60.0), 8.0);
        let route = case.route(TOLERANCE);
        let lines = case.lines(cusp);
        let path = route.path(&lines, 0, FORWARD).stations;
        let least = hub.radius + RADIUS + ALLOWANCE - TOLERANCE;
        for w in path.windows(2) {
            for k in 0..=8 {
                let t = f64::from(k) / 8.0;
                let axis = w[0].axis.lerp(w[1].axis, t).normalize();
                let centre = route.tip(&w[0]).lerp(route.tip(&w[1]), t) + axis * RADIUS;
                let off = from_axis(centre) - least;
                assert!(off >= 0.0, "{centre}: {off}, radius {}", hub.radius);
            }
        }
        let passes: Vec<u32> = path.iter().filter(|s| s.at.is_some()).map(|s| s.pass).collect();
        let mut each = passes.clone();
        each.dedup();
        assert_eq!(each, (0..lines.len() as u32).collect::<Vec<u32>>(), "each once, in order");
    }
}
