//! The passes of a channel → the path of the cutter, from the approach to the retract.
//!
//! Steps: (1) points along every pass by the chord error: `l = 2 sqrt(2 rho eps - eps²)` for the radius of curvature
//! `rho` (S-HUB, step 5), halved until the ball's centre between two points is within the tolerance, too; (2) centre,
//! tip and axis at each: `centre = contact + (r + allowance) n`, `tip = centre - r a` (step 7); (3) extensions at the ends
//! of the channel: straight on along the tangent, then a quadratic Bezier curve that turns along the hub's axis, or along
//! its meridian where the channel leaves radially (step 6), and shorter where something else is in the way; (4) links:
//! between extensions at the same end, else over the hub.

use super::axes::AxisField;
use super::channel::Channel;
use super::strips::Line;
use super::wheel::Wheel;
use crate::geometry::{DVec2, DVec3};
use crate::surface::ShapeOperator;
use crate::toolpath::MoveKind;

/// Share of the tolerance that chords use.
const CHORDS: f64 = 0.3;
/// Longest and shortest step along a pass, as parts of the channel.
const LONGEST_STEP: f64 = 1.0 / 16.0;
const SHORTEST_STEP: f64 = 1.0 / 65_536.0;
/// Pieces of an extension: of its straight beginning, and of its Bezier curve.
const STRAIGHT_PIECES: usize = 4;
const BEZIER_PIECES: usize = 12;
/// A centre whose foot lies farther aside than this is beyond the rim of the hub, mm.
const ASIDE: f64 = 1e-3;
/// Least part of the axis in the direction in which a channel leaves for its extensions to turn along the axis.
const AXIAL: f64 = 0.5;
/// Parts of an extension that are tried, where the whole is not clear.
const SHARES: [f64; 6] = [1.0, 0.75, 0.5, 0.25, 0.125, 0.0];
/// Longest step of a link through the air, cutter radii.
const LINK_STEP: f64 = 1.0;
/// Steps of such a link from which on it is not divided further.
const MOST_LINK_STEPS: usize = 256;

/// The cutter at a place.
#[derive(Copy, Clone, Debug)]
pub struct Station {
    pub kind: MoveKind,
    /// Index of the pass.
    pub pass: u32,
    /// Parameters of the hub at the contact; `None` away from the hub.
    pub at: Option<DVec2>,
    /// Centre of the ball, mm.
    pub centre: DVec3,
    /// Unit tool axis.
    pub axis: DVec3,
    /// Unit normal at the contact; the axis where there is none.
    pub normal: DVec3,
}

/// A channel with all that its path depends on.
pub struct Route<'a> {
    pub wheel: &'a Wheel,
    pub channel: &'a Channel,
    pub axes: &'a AxisField,
    pub radius: f64,
    pub allowance: f64,
    pub tolerance: f64,
    pub extension: f64,
    /// Whether the cutter may go that way, from station to station.
    pub clear: &'a dyn Fn(&[Station]) -> bool,
}

/// The path over the passes of a part of a channel.
#[derive(Clone, Debug, Default)]
pub struct Leg {
    pub stations: Vec<Station>,
    pub shortened: Shortened,
}

/// Extensions that something is in the way of.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Shortened {
    /// How many.
    pub count: usize,
    /// What is left of the shortest, mm, and where its pass ends.
    pub least: (f64, DVec3),
}

impl Shortened {
    /// Those of two pieces of a path.
    pub fn with(self, other: Self) -> Self {
        let count = self.count + other.count;
        let is_first = other.count == 0 || self.count > 0 && self.least.0 <= other.least.0;
        Self { count, least: if is_first { self.least } else { other.least } }
    }
}

/// How a part of a channel is gone over.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// Whether the first pass is cut from its low end.
    pub forward: bool,
    /// Whether the cutter goes back over the last pass.
    pub back: bool,
}

/// Where a pass begins or ends: at an end of the channel, or within it.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Port {
    s: f64,
    t: f64,
    /// Growth of `t` with `s` along the pass.
    slope: f64,
}

impl Port {
    fn end(self) -> Option<bool> {
        if self.s <= 0.0 {
            Some(false)
        } else if self.s >= 1.0 {
            Some(true)
        } else {
            None
        }
    }
}

impl Route<'_> {
    /// The path over the passes, one after the other from side to side; it begins and ends above the first and the last
    /// place. `first`: number of the first pass.
    pub fn path(&self, lines: &[Line], first: u32, order: Order) -> Leg {
        let mut leg = Leg::default();
        let mut last: Option<Port> = None;
        let mut left: Vec<&Line> = lines.iter().collect();
        let mut pass = first;
        while !left.is_empty() {
            let (index, forward) = self.next(&left, last).unwrap_or((0, order.forward));
            let line = left.remove(index);
            let (from, to) = if forward { (line.from, line.to) } else { (line.to, line.from) };
            let port = |s: f64| Port { s, t: line.at(s), slope: line.slope(s) };
            let curve = |x: f64| {
                let s = from + (to - from) * x;
                (s, line.at(s))
            };
            let cut = self.along(&curve, MoveKind::Cut, pass);
            self.enter(&mut leg, last, port(from), &cut, pass);
            leg.stations.extend(&cut);
            last = Some(port(to));
            if order.back && left.is_empty() {
                let back = cut.iter().rev().skip(1);
                leg.stations.extend(back.map(|s| Station { kind: MoveKind::Link, ..*s }));
                last = Some(port(from));
            }
            pass += 1;
        }
        if let Some(port) = last {
            self.leave(&mut leg, port);
        }
        leg
    }

    /// Index of the pass that follows, the one that begins nearest to where the last one ended, and whether it is cut from its
    /// low end.
    fn next(&self, left: &[&Line], last: Option<Port>) -> Option<(usize, bool)> {
        let last = last?;
        let here = self.channel.place(self.wheel, last.s, last.t);
        let away = |(i, forward): (usize, bool)| {
            let line = left[i];
            let s = if forward { line.from } else { line.to };
            self.channel.place(self.wheel, s, line.at(s)).distance(here)
        };
        let choices = (0..left.len()).flat_map(|i| [(i, true), (i, false)]);
        choices.min_by(|a, b| away(*a).total_cmp(&away(*b)))
    }

    /// The cutter on the hub at (s, t).
    fn station(&self, (s, t): (f64, f64), kind: MoveKind, pass: u32) -> Station {
        let at = self.channel.at(s, t);
        let normal = self.wheel.normal(at);
        let centre = self.wheel.hub.point(at) + normal * (self.radius + self.allowance);
        let (rows, columns) = self.axes.size();
        let axis = self.axes.axis(s * (rows - 1) as f64, t * (columns - 1) as f64);
        Station { kind, pass, at: Some(at), centre, axis, normal }
    }

    /// Stations along a curve of the channel, `x` from 0 to 1, with both ends.
    fn along(&self, curve: &dyn Fn(f64) -> (f64, f64), kind: MoveKind, pass: u32) -> Vec<Station> {
        let error = CHORDS * self.tolerance;
        let station = |x: f64| self.station(curve(x), kind, pass);
        let mut all = vec![station(0.0)];
        let mut x = 0.0;
        while x < 1.0 {
            let here = all[all.len() - 1];
            let mut step = self.step(curve, x, error).clamp(SHORTEST_STEP, LONGEST_STEP);
            if x + 1.5 * step >= 1.0 {
                step = if x + step >= 1.0 { 1.0 - x } else { 0.5 * (1.0 - x) };
            }
            let mut next = station(x + step);
            while step > SHORTEST_STEP
                && self.chord_error(&here, &next, &station(x + 0.5 * step)) > error
            {
                step *= 0.5;
                next = station(x + step);
            }
            x = if x + step > 1.0 - SHORTEST_STEP { 1.0 } else { x + step };
            all.push(if x == 1.0 { station(1.0) } else { next });
        }
        all
    }

    /// The step that the chord error allows at `x`, as a part of the curve.
    fn step(&self, curve: &dyn Fn(f64) -> (f64, f64), x: f64, error: f64) -> f64 {
        const STEP: f64 = 1e-4;
        let (x0, x1) = ((x - STEP).max(0.0), (x + STEP).min(1.0));
        let place = |x: f64| {
            let (s, t) = curve(x);
            self.channel.place(self.wheel, s, t)
        };
        let way = (place(x1) - place(x0)) / (x1 - x0);
        let (s, t) = curve(x);
        let jet = self.wheel.jet(self.channel.at(s, t));
        let shape = ShapeOperator::from_derivatives(jet.first, jet.second);
        let bend = shape.normal_curvature(way).abs();
        let rho = if bend > 1e-9 { 1.0 / bend } else { 1e9 };
        let length = 2.0 * (2.0 * rho * error - error * error).max(0.0).sqrt();
        length / way.length().max(f64::MIN_POSITIVE)
    }

    /// How far the ball's centre is off its place in the middle between two stations, mm.
    fn chord_error(&self, a: &Station, b: &Station, middle: &Station) -> f64 {
        let tip = 0.5 * (self.tip(a) + self.tip(b));
        let axis = (a.axis + b.axis).normalize_or(a.axis);
        (tip + axis * self.radius).distance(middle.centre)
    }

    /// The tip of the cutter, mm.
    pub fn tip(&self, station: &Station) -> DVec3 {
        station.centre - station.axis * self.radius
    }

    /// From where the path ends to the first station of a pass: through the air at the same end of the channel, else over
    /// the hub.
    fn enter(&self, leg: &mut Leg, last: Option<Port>, to: Port, cut: &[Station], pass: u32) {
        let Some(last) = last else {
            let way = |share: f64| {
                let mut way = self.extension(to, cut, share);
                way.reverse();
                way
            };
            let is_clear = |way: &[Station]| (self.clear)(&[way, first_of(cut)].concat());
            let (way, share) = longest(way, is_clear);
            self.note(leg, to, share, cut);
            leg.stations.extend(way);
            return;
        };
        let near: Vec<Station> = leg.stations.iter().rev().take(2).copied().collect();
        if last.end().is_some() && last.end() == to.end() {
            let is_clear =
                |way: &[Station]| (self.clear)(&[first_of(&near), way, first_of(cut)].concat());
            let way = |share: f64| self.through_air((last, &near), (to, cut), share);
            let (way, share) = longest(way, is_clear);
            if share > 0.0 {
                self.note(leg, last, share, &near);
                self.note(leg, to, share, cut);
                leg.stations.extend(way);
                return;
            }
        }
        let curve = |x: f64| (last.s + (to.s - last.s) * x, last.t + (to.t - last.t) * x);
        let link = self.along(&curve, MoveKind::Link, pass);
        let way = self.clear_overrun(leg, last, &near);
        if !way.is_empty() {
            leg.stations.extend(way);
            leg.stations.extend(link.first());
        }
        // Both ends are stations of passes.
        leg.stations.extend(link.iter().skip(1).take(link.len().saturating_sub(2)));
        let way = self.clear_overrun(leg, to, cut);
        if !way.is_empty() {
            leg.stations.extend(link.last());
            leg.stations.extend(way);
        }
    }

    /// Out along the extension of a pass, over to that of another one, and in.
    fn through_air(
        &self,
        (last, near): (Port, &[Station]),
        (to, cut): (Port, &[Station]),
        share: f64,
    ) -> Vec<Station> {
        let mut way = self.extension(last, near, share);
        let mut inward = self.extension(to, cut, share);
        inward.reverse();
        if let (Some(&from), Some(&to)) = (way.last(), inward.first()) {
            way.extend(self.between(from, to));
        }
        way.extend(inward);
        way
    }

    /// Stations through the air between two others.
    pub fn between(&self, from: Station, to: Station) -> Vec<Station> {
        let foot = self.wheel.nearest(from.centre.lerp(to.centre, 0.5));
        let centres = self.over_hub(from.centre, to.centre, foot);
        let steps = centres.len() + 1;
        let station = |(i, centre): (usize, DVec3)| {
            let t = (i + 1) as f64 / steps as f64;
            let axis = from.axis.lerp(to.axis, t).normalize_or(to.axis);
            Station { kind: MoveKind::Link, at: None, centre, axis, normal: axis, ..to }
        };
        centres.into_iter().enumerate().map(station).collect()
    }

    /// Out along the beginning of the extension and back, where the path goes on over the hub: the end of the channel is
    /// oblique, and a pass that stops there leaves its corner.
    fn clear_overrun(&self, leg: &mut Leg, port: Port, cut: &[Station]) -> Vec<Station> {
        let out = |share: f64| {
            let all = self.extension(port, cut, share).into_iter();
            all.take(STRAIGHT_PIECES).collect::<Vec<Station>>()
        };
        let (out, share) =
            longest(out, |out: &[Station]| (self.clear)(&[first_of(cut), out].concat()));
        self.note(leg, port, share, cut);
        out.iter().chain(out.iter().rev().skip(1)).copied().collect()
    }

    /// Notes an extension that is shorter than it should be.
    fn note(&self, leg: &mut Leg, port: Port, share: f64, cut: &[Station]) {
        if let (Some(_), Some(first), true) = (port.end(), cut.first(), share < 1.0) {
            let place = first.centre - first.normal * (self.radius + self.allowance);
            let one = Shortened { count: 1, least: (share * self.extension, place) };
            leg.shortened = leg.shortened.with(one);
        }
    }

    /// Centres between two ends of extensions: straight on, but where a hub that goes on beyond the channel is in the way.
    /// `foot`: parameters of the hub near them.
    fn over_hub(&self, from: DVec3, to: DVec3, foot: DVec2) -> Vec<DVec3> {
        let clear = |centre: DVec3| self.off_hub(centre, self.wheel.hub.project(centre, foot).0);
        let error = CHORDS * self.tolerance;
        let mut steps = (from.distance(to) / (LINK_STEP * self.radius)).ceil().max(1.0) as usize;
        loop {
            let at = |i: usize| clear(from.lerp(to, i as f64 / steps as f64));
            let all: Vec<DVec3> = (0..=steps).map(at).collect();
            let dips = |w: &[DVec3]| {
                let middle = 0.5 * (w[0] + w[1]);
                clear(middle).distance(middle) > error
            };
            if steps >= MOST_LINK_STEPS || !all.windows(2).any(dips) {
                return all[1..steps].to_vec();
            }
            steps *= 2;
        }
    }

    /// Adds the extension at the end of the path.
    fn leave(&self, leg: &mut Leg, port: Port) {
        let near: Vec<Station> = leg.stations.iter().rev().take(2).copied().collect();
        let way = |share: f64| self.extension(port, &near, share);
        let is_clear = |way: &[Station]| (self.clear)(&[first_of(&near), way].concat());
        let (way, share) = longest(way, is_clear);
        self.note(leg, port, share, &near);
        leg.stations.extend(way);
    }

    /// Stations beyond an end of the channel, from the pass outward; `cut`: the pass, from that end on; `share`: of the
    /// extension's length. None for a pass that ends within the channel.
    fn extension(&self, port: Port, cut: &[Station], share: f64) -> Vec<Station> {
        let (Some(end), Some(first)) = (port.end(), cut.first()) else { return Vec::new() };
        if share <= 0.0 {
            return Vec::new();
        }
        let out = self.tangent(port) * if end { 1.0 } else { -1.0 };
        let turned = self.turned_out(first.centre, out);
        let piece = 0.5 * share * self.extension;
        let control = [
            first.centre + out * piece,
            first.centre + out * (2.0 * piece),
            first.centre + out * (2.0 * piece) + turned * piece,
        ];
        let straight = (1..STRAIGHT_PIECES)
            .map(|i| first.centre.lerp(control[0], i as f64 / STRAIGHT_PIECES as f64));
        let bent = (0..=BEZIER_PIECES).map(|i| {
            let x = i as f64 / BEZIER_PIECES as f64;
            let y = 1.0 - x;
            control[0] * (y * y) + control[1] * (2.0 * x * y) + control[2] * (x * x)
        });
        let mut foot = first.at.unwrap_or_default();
        let mut beyond = |centre: DVec3| {
            (foot, _) = self.wheel.hub.project(centre, foot);
            let centre = self.off_hub(centre, foot);
            Station { kind: MoveKind::Link, at: None, centre, normal: first.axis, ..*first }
        };
        straight.chain(bent).map(&mut beyond).collect()
    }

    /// Direction in which the ball's centre runs at an end of a pass, toward larger `s`.
    fn tangent(&self, port: Port) -> DVec3 {
        const STEP: f64 = 1e-4;
        let centre = |s: f64| {
            let t = (port.t + port.slope * (s - port.s)).clamp(0.0, 1.0);
            self.station((s, t), MoveKind::Cut, 0).centre
        };
        let (a, b) = ((port.s - STEP).max(0.0), (port.s + STEP).min(1.0));
        (centre(b) - centre(a)).normalize_or_zero()
    }

    /// The direction in which an extension turns: along the axis, or the meridian.
    fn turned_out(&self, place: DVec3, out: DVec3) -> DVec3 {
        let around = self.wheel.around_at(place);
        let meridian = (out - around * out.dot(around)).normalize_or(out);
        let axis = self.wheel.axis();
        let part = meridian.dot(axis);
        if part.abs() >= AXIAL { axis * part.signum() } else { meridian }
    }

    /// A centre moved off the hub, where the hub goes on and is nearer than the ball allows.
    fn off_hub(&self, centre: DVec3, foot: DVec2) -> DVec3 {
        let (place, normal) = (self.wheel.hub.point(foot), self.wheel.normal(foot));
        let least = self.radius + self.allowance;
        let way = centre - place;
        let height = way.dot(normal);
        if (way - normal * height).length() > ASIDE {
            // The nearest place is on the rim.
            return if way.length() < least {
                place + way.normalize_or(normal) * least
            } else {
                centre
            };
        }
        if height < least { place + normal * least } else { centre }
    }
}

/// The first station, as a way.
fn first_of(stations: &[Station]) -> &[Station] {
    stations.get(..1).unwrap_or_default()
}

/// The way by the largest share that is clear, and that share.
fn longest(
    way: impl Fn(f64) -> Vec<Station>,
    is_clear: impl Fn(&[Station]) -> bool,
) -> (Vec<Station>, f64) {
    let clear = SHARES.into_iter().map(|share| (way(share), share));
    let mut clear = clear.filter(|(way, share)| *share == 0.0 || is_clear(way));
    clear.next().unwrap_or_default()
}

#[cfg(test)]
mod tests;
