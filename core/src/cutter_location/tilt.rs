//! The tool axis along a run of contacts: as the job's rule has it, and tilted away from that where the cutter's side, the
//! shank or the holder would touch something.
//!
//! - *Nominal* axis of a contact: by the rule, turning no faster than allowed.
//! - *Station*: a contact at which axes are tried; between stations the deviation from the nominal axis changes evenly.
//! - *Candidate*: an axis that is tried at a station. Of a ball, which cuts alike with every axis, they lie all around the
//!   surface normal, [`STEP`] apart, in a frame that is carried along the run; of other cutters they have more lead.
//! - *Stretch*: stations in a row whose nominal axis is not clear, with some before and behind to turn back.
//!
//! In steps: (1) the room of the nominal axis at all stations; where there is enough, and between stations more than the
//! tool can move, it stays. (2) On every stretch, the way through the candidates of its stations that is clear and costs
//! the least: the square of the deviation, over the length, and of its change per length (A*, with the cheapest clear
//! candidate of each station for what is ahead; a candidate is tested when its turn comes, so most never are). A station without a clear candidate keeps the nominal
//! axis: what comes too near there is for the simulation to refuse. (3) Between the candidates, deviations that cost less are
//! sought, while they stay clear. (4) Contacts between stations that are not clear then become stations, too, and all is
//! done again.
//!
//! # Source
//! Axis as in spec 08: lead raised locally, rotation about the normal. A*: Hart, Nilsson, Raphael, "A formal basis for the
//! heuristic determination of minimum cost paths", IEEE Trans. Systems Science and Cybernetics 4 (1968). Motion between two places by their distances:
//! Schwarzer, Saha, Latombe, "Exact collision checking of robot paths", Algorithmic Foundations of Robotics V (2004).

use super::above::AboveEnd;
use super::axis::{ToolAxis, tool_axis};
use super::obstacles::Obstacles;
use super::options::PassOptions;
use super::pass::Contact;
use super::tip::tip;
use crate::geometry::math::{acos_clamped, cos, sin};
use crate::geometry::{DVec3, OrderBy, any_perpendicular};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Angle between neighbouring candidates, rad. Smaller: narrower openings are found, in the square of the time.
const STEP: f64 = 7.5 / 180.0 * core::f64::consts::PI;
/// Widest window over which the nominal axis is smoothed, lengths of the run: wide enough for hardly any turn.
const WIDEST: f64 = 16.0;
/// Distance of stations, cutter radii.
const APART: f64 = 0.5;
/// Turn of the nominal axis after which there is another station, rad.
const TURNED: f64 = 0.05;
/// Length over which the axis turns back, cutter radii: what a change of the deviation costs.
const TURNS_OVER: f64 = 2.0;
/// Length of a stretch before and behind what is not clear, times that: there the deviation is a hundredth.
const MARGIN: f64 = 4.5;
/// Room at both stations up to which the contacts between them are looked at, mm.
const TIGHT: f64 = 4.0;
/// How often stations are added.
const MOST_ROUNDS: usize = 8;
/// Halvings of a way between two stations at most.
const HALVINGS: u32 = 3;
/// Rounds of smoothing.
const ROUNDS: usize = 48;
/// How far a deviation moves toward what costs the least, first tried: past it, so that others follow sooner.
const OVER: f64 = 1.5;
/// Cost of a station without a clear axis; more than any deviation.
const TOO_NEAR: f64 = 1e6;
/// How far the axis turns from a station to the next, besides the turn of the nominal axis, steps: past a candidate that
/// is not clear.
const FARTHEST: f64 = 1.5;
/// So many times as far at most where stations are farther apart.
const MOST_STEPS: f64 = 4.0;
/// By how much an axis with which a run begins is off the nominal one, and leans more, where it is tilted, rad: less, or
/// leaning less, it belongs to a run that turns there.
const BEGUN: f64 = 0.05;
/// Deviations that are none, rad.
const STILL: f64 = 1e-4;
/// What rounding may add to a turn, rad.
const ROUNDED: f64 = 1e-9;

/// Unit tool axes of a run's contacts. `start`: the axis with which the run begins, if it continues another; it ends with
/// the same.
pub fn tool_axes(
    contacts: &[Contact],
    start: Option<DVec3>,
    options: &PassOptions,
    obstacles: &Obstacles,
) -> Vec<DVec3> {
    let travel = travel(contacts);
    let nominal = nominal(contacts, &travel, options);
    match obstacles.above() {
        Some(above) if options.largest_tilt > 0.0 && contacts.len() > 1 => {
            let mut run = Run::new(contacts, &travel, &nominal, above, options);
            run.tilted(start)
        }
        _ => nominal,
    }
}

/// Length along the contacts up to each of them, mm.
fn travel(contacts: &[Contact]) -> Vec<f64> {
    let mut travel = vec![0.0; contacts.len()];
    for i in 1..contacts.len() {
        travel[i] = travel[i - 1] + contacts[i].position.distance(contacts[i - 1].position);
    }
    travel
}

/// The axis at every contact, turning no faster than allowed.
///
/// The means of the wanted axes over longer windows turn more slowly; the shortest window, by doubling, that is slow
/// enough is used.
fn nominal(contacts: &[Contact], travel: &[f64], options: &PassOptions) -> Vec<DVec3> {
    let wanted: Vec<DVec3> =
        contacts.iter().map(|c| tool_axis(options.axis, c.normal, c.feed_direction)).collect();
    let total = travel.last().copied().unwrap_or(0.0);
    let mut axes = wanted.clone();
    let mut half = 0.125;
    while turns_faster(&axes, travel, options.axis_rate) && half < WIDEST * total {
        axes = window_means(&wanted, travel, half);
        half *= 2.0;
    }
    axes
}

fn turns_faster(axes: &[DVec3], travel: &[f64], rate: f64) -> bool {
    (1..axes.len())
        .any(|i| axes[i].distance(axes[i - 1]) > rate * (travel[i] - travel[i - 1]) + 1e-12)
}

/// Means over `half` mm of travel to either side, by the trapezoidal rule.
fn window_means(wanted: &[DVec3], travel: &[f64], half: f64) -> Vec<DVec3> {
    let mut integral = vec![DVec3::ZERO; wanted.len()];
    for i in 1..wanted.len() {
        let mean = 0.5 * (wanted[i] + wanted[i - 1]);
        integral[i] = integral[i - 1] + mean * (travel[i] - travel[i - 1]);
    }
    let (total, last) = (travel[wanted.len() - 1], wanted.len() - 1);
    let up_to = |s: f64| -> DVec3 {
        // Before its ends the run goes on with their axes.
        if s < 0.0 {
            return wanted[0] * s;
        }
        if s > total {
            return integral[last] + wanted[last] * (s - total);
        }
        let i = travel.partition_point(|&t| t <= s).clamp(1, wanted.len() - 1);
        let step = travel[i] - travel[i - 1];
        let part = if step > 0.0 { (s - travel[i - 1]) / step } else { 0.0 };
        let end = wanted[i - 1].lerp(wanted[i], part);
        integral[i - 1] + (wanted[i - 1] + end) * (0.5 * part * step)
    };
    (0..wanted.len())
        .map(|i| {
            let sum = up_to(travel[i] + half) - up_to(travel[i] - half);
            sum.try_normalize().unwrap_or(wanted[i])
        })
        .collect()
}

/// A run of contacts and its stations.
struct Run<'a> {
    contacts: &'a [Contact],
    travel: &'a [f64],
    nominal: &'a [DVec3],
    above: &'a AboveEnd,
    options: &'a PassOptions,
    /// The contacts that are stations.
    stations: Vec<usize>,
    /// Least distance of stations, mm.
    apart: f64,
}

/// The first and the last station of a stretch.
type Stretch = (usize, usize);

impl<'a> Run<'a> {
    fn new(
        contacts: &'a [Contact],
        travel: &'a [f64],
        nominal: &'a [DVec3],
        above: &'a AboveEnd,
        options: &'a PassOptions,
    ) -> Self {
        let slowly = FARTHEST * STEP / options.axis_rate;
        let apart = (APART * options.tool.radius()).max(slowly);
        let stations = stations(travel, nominal, apart);
        Self { contacts, travel, nominal, above, options, stations, apart }
    }

    /// The axes of all contacts. `start`: as for [`tool_axes`].
    fn tilted(&mut self, start: Option<DVec3>) -> Vec<DVec3> {
        for _ in 0..MOST_ROUNDS {
            let axes = self.axes(&self.deviations(start));
            let blocked = self.blocked_between(&axes);
            if blocked.is_empty() {
                return axes;
            }
            self.stations.extend(blocked);
            self.stations.order_total();
        }
        self.axes(&self.deviations(start))
    }

    /// The contacts between stations whose axis is not clear though those of the stations are: only where little room is.
    fn blocked_between(&self, axes: &[DVec3]) -> Vec<usize> {
        let rooms: Vec<f64> = self.stations.iter().map(|&i| self.room_at(i, axes[i])).collect();
        let of = |(k, pair): (usize, &[usize])| {
            let room = rooms[k].min(rooms[k + 1]);
            let is_tight = (0.0..TIGHT).contains(&room);
            let between = (pair[0] + 1..pair[1]).filter(move |_| is_tight);
            between.filter(|&i| self.room_at(i, axes[i]) < 0.0)
        };
        self.stations.windows(2).enumerate().flat_map(of).collect()
    }

    /// The deviations from the nominal axis at all stations.
    fn deviations(&self, start: Option<DVec3>) -> Vec<DVec3> {
        let mut deviations = vec![DVec3::ZERO; self.stations.len()];
        let begun = start.filter(|axis| self.is_tilted(*axis));
        let frames = self.frames();
        for (from, to) in self.stretches(begun.is_some()) {
            let candidates: Vec<Vec<DVec3>> = (from..=to)
                .map(|k| {
                    let is_end = k == 0 || k + 1 == self.stations.len();
                    match start.filter(|_| is_end && begun.is_some()) {
                        Some(axis) => vec![axis],
                        None if !is_end && (k == from || k == to) => vec![self.nominal_at(k)],
                        None => self.candidates(k, frames[k]),
                    }
                })
                .collect();
            let way = self.way(from, &candidates);
            for ((k, own), chosen) in (from..=to).zip(&candidates).zip(way) {
                deviations[k] = own[chosen] - self.nominal_at(k);
            }
            self.smooth((from, to), begun.is_some(), &mut deviations);
        }
        deviations
    }

    /// Whether an axis with which the run begins is tilted for something to clear.
    fn is_tilted(&self, axis: DVec3) -> bool {
        let nominal = self.nominal_at(0);
        let normal = self.contacts[0].normal;
        let leans_more = acos_clamped(axis.dot(normal)) > acos_clamped(nominal.dot(normal)) + BEGUN;
        axis.distance(nominal) > BEGUN && (leans_more || self.room(0, nominal) < 0.0)
    }

    /// The axes of all contacts with these deviations at the stations.
    fn axes(&self, deviations: &[DVec3]) -> Vec<DVec3> {
        let mut axes = self.nominal.to_vec();
        for (k, pair) in self.stations.windows(2).enumerate() {
            let (from, to, ends) = (pair[0], pair[1], [deviations[k], deviations[k + 1]]);
            if ends == [DVec3::ZERO; 2] {
                continue;
            }
            let whole = self.travel[to] - self.travel[from];
            for (i, axis) in axes.iter_mut().enumerate().take(to + 1).skip(from) {
                // Where the feed turns two stations are at one place.
                let part = match self.travel[i] - self.travel[from] {
                    _ if i == from => 0.0,
                    done if done < whole => done / whole,
                    _ => 1.0,
                };
                let nominal = self.nominal[i];
                *axis = (nominal + ends[0].lerp(ends[1], part)).normalize_or(nominal);
            }
        }
        axes
    }

    /// Step 1. `is_begun`: whether both ends of the run have axes that are not nominal.
    fn stretches(&self, is_begun: bool) -> Vec<Stretch> {
        let count = self.stations.len();
        let rooms: Vec<f64> = (0..count).map(|k| self.room(k, self.nominal_at(k))).collect();
        let is_blocked = |k: &usize| {
            let k = *k;
            let is_end = k == 0 || k + 1 == count;
            let is_way_blocked = || {
                let next = k + 1;
                next < count
                    && rooms[next] >= 0.0
                    && !self.is_way_clear(
                        k,
                        [self.nominal_at(k), self.nominal_at(next)],
                        [rooms[k], rooms[next]],
                    )
            };
            (is_begun && is_end) || rooms[k] < 0.0 || is_way_blocked()
        };
        let margin = MARGIN * self.turns_over();
        let at = |k: usize| self.travel[self.stations[k]];
        let mut stretches: Vec<Stretch> = Vec::new();
        for k in (0..count).filter(is_blocked) {
            let end = (k + 1).min(count - 1);
            let from = (0..k).rev().find(|&j| at(k) - at(j) >= margin).unwrap_or(0);
            let to = (end..count).find(|&j| at(j) - at(end) >= margin).unwrap_or(count - 1);
            match stretches.last_mut() {
                Some((_, last)) if from <= *last => *last = to,
                _ => stretches.push((from, to)),
            }
        }
        stretches
    }

    /// Step 2: which of the candidates of each station, the first of which is `from`. The first candidate is taken where
    /// none is clear.
    fn way(&self, from: usize, candidates: &[Vec<DVec3>]) -> Vec<usize> {
        let mut states: Vec<Vec<State>> =
            candidates.iter().map(|own| vec![State::default(); own.len()]).collect();
        let ahead = self.ahead(from, candidates, &mut states);
        let mut waiting = BinaryHeap::new();
        for (own, &axis) in candidates.iter().take(1).flatten().enumerate() {
            let cost = self.cost(from, axis);
            let whole = cost + ahead[0];
            waiting.push(Reverse(Move { whole, cost, to: (0, own), before: 0, is_paid: false }));
        }
        let mut end = None;
        while let Some(Reverse(step)) = waiting.pop() {
            let Move { cost, to: (k, own), before, is_paid, .. } = step;
            if states[k][own].before.is_some() {
                continue;
            }
            let axis = candidates[k][own];
            let room = match states[k][own].room {
                Some(room) => room,
                None => self.room(from + k, axis),
            };
            states[k][own].room = Some(room);
            let is_way_clear = || {
                let earlier = k.checked_sub(1).map(|j| (candidates[j][before], states[j][before]));
                let Some((other, State { room: Some(there), .. })) = earlier else { return true };
                there < 0.0 || self.is_way_clear(from + k - 1, [other, axis], [there, room])
            };
            if !is_paid && (room < 0.0 || !is_way_clear()) {
                if own == 0 {
                    let (cost, whole) = (cost + TOO_NEAR, step.whole + TOO_NEAR);
                    waiting.push(Reverse(Move { whole, cost, is_paid: true, ..step }));
                }
                continue;
            }
            states[k][own].before = Some(before);
            if k + 1 == candidates.len() {
                end = Some(own);
                break;
            }
            for (next, &other) in candidates[k + 1].iter().enumerate() {
                let is_open = states[k + 1][next].before.is_none();
                if let Some(change) = self.change(from + k, [axis, other])
                    && is_open
                {
                    let cost = cost + change + self.cost(from + k + 1, other);
                    let (to, whole) = ((k + 1, next), cost + ahead[k + 1]);
                    waiting.push(Reverse(Move { whole, cost, to, before: own, is_paid: false }));
                }
            }
        }
        let mut way = vec![0; candidates.len()];
        let mut own = end;
        for k in (0..candidates.len()).rev() {
            way[k] = own.unwrap_or(0);
            own = states[k][way[k]].before;
        }
        way
    }

    /// What the stations behind each one cost at least: the cheapest candidate of each that is clear, without turns.
    fn ahead(&self, from: usize, candidates: &[Vec<DVec3>], states: &mut [Vec<State>]) -> Vec<f64> {
        let mut ahead = vec![0.0; candidates.len()];
        for k in (1..candidates.len()).rev() {
            let cost = |own: usize| self.cost(from + k, candidates[k][own]);
            let mut order: Vec<usize> = (0..candidates[k].len()).collect();
            order.order_by(|a, b| cost(*a).total_cmp(&cost(*b)));
            let is_clear = |own: &usize| {
                let room = self.room(from + k, candidates[k][*own]);
                states[k][*own].room = Some(room);
                room >= 0.0
            };
            // Where none is clear, the first one is taken.
            let least = order.into_iter().find(is_clear).unwrap_or(0);
            ahead[k - 1] = ahead[k] + cost(least);
        }
        ahead
    }

    /// Step 3: the deviations that cost the least with those beside them, one after the other, or half the way there.
    fn smooth(&self, (from, to): Stretch, is_begun: bool, deviations: &mut [DVec3]) {
        let axis = |k: usize, deviation: DVec3| {
            (self.nominal_at(k) + deviation).normalize_or(self.nominal_at(k))
        };
        let last = self.stations.len() - 1;
        let is_fixed = |k: usize| (k == from || k == to) && (is_begun || (k != 0 && k != last));
        let of = |k: usize, deviations: &[DVec3]| self.room(k, axis(k, deviations[k]));
        let mut rooms: Vec<f64> = (from..=to).map(|k| of(k, deviations)).collect();
        for round in 0..ROUNDS {
            let mut is_still = true;
            for i in from..=to {
                // To and fro.
                let k = if round % 2 == 0 { i } else { from + to - i };
                if is_fixed(k) {
                    continue;
                }
                let beside = [k.checked_sub(1), Some(k + 1).filter(|k| *k <= last)];
                let weigh = |(sum, weights): (DVec3, f64), j: usize| {
                    let weight = self.turns_over().powi(2) / self.length(j.min(k));
                    (sum + weight * deviations[j], weights + weight)
                };
                let (sum, weights) =
                    beside.iter().flatten().fold((DVec3::ZERO, 0.0), |s, j| weigh(s, *j));
                let lowest = sum / (weights + self.share(k));
                for part in [OVER, 1.0, 0.5] {
                    let wanted = axis(k, deviations[k].lerp(lowest, part));
                    let moved = wanted - self.nominal_at(k);
                    if (moved - deviations[k]).length() < STILL {
                        break;
                    }
                    let room = self.room(k, wanted);
                    let is_clear = room >= 0.0
                        && self.is_allowed(k, wanted)
                        && beside.iter().flatten().all(|&j| {
                            let other = (axis(j, deviations[j]), rooms[j.clamp(from, to) - from]);
                            let [a, b] = if j < k {
                                [other, (wanted, room)]
                            } else {
                                [(wanted, room), other]
                            };
                            (from..=to).contains(&j)
                                && self.is_way_clear(j.min(k), [a.0, b.0], [a.1, b.1])
                        });
                    if is_clear {
                        (deviations[k], rooms[k - from]) = (moved, room);
                        is_still = false;
                        break;
                    }
                }
            }
            if is_still {
                break;
            }
        }
    }

    /// Whether an axis leans no more than is allowed, or than the nominal one.
    fn is_allowed(&self, station: usize, axis: DVec3) -> bool {
        let normal = self.contacts[self.stations[station]].normal;
        let least = cos(self.options.largest_tilt).min(self.nominal_at(station).dot(normal));
        axis.dot(normal) >= least - ROUNDED
    }

    /// Length of the run from a station to the next, mm; not 0.
    fn length(&self, station: usize) -> f64 {
        let [from, to] = [station, station + 1].map(|k| self.travel[self.stations[k]]);
        (to - from).max(0.1 * self.apart)
    }

    fn nominal_at(&self, station: usize) -> DVec3 {
        self.nominal[self.stations[station]]
    }

    fn turns_over(&self) -> f64 {
        TURNS_OVER * self.options.tool.radius()
    }

    /// Length of the run that a station stands for, mm.
    fn share(&self, station: usize) -> f64 {
        let at = |k: usize| self.travel[self.stations[k]];
        let last = self.stations.len() - 1;
        0.5 * (at((station + 1).min(last)) - at(station.saturating_sub(1)))
    }

    fn cost(&self, station: usize, axis: DVec3) -> f64 {
        axis.distance_squared(self.nominal_at(station)) * self.share(station)
    }

    /// The cost of turning from an axis at a station to another at the next one; `None` if that is too far.
    fn change(&self, station: usize, axes: [DVec3; 2]) -> Option<f64> {
        let nominal = [self.nominal_at(station), self.nominal_at(station + 1)];
        let change = ((axes[1] - nominal[1]) - (axes[0] - nominal[0])).length();
        let length = self.length(station);
        let steps = (length / self.apart).clamp(1.0, MOST_STEPS);
        let as_nominal = nominal[0].distance(nominal[1]);
        let fastest = (self.options.axis_rate * length).max(as_nominal) + ROUNDED;
        let is_near = change <= FARTHEST * STEP * steps && axes[0].distance(axes[1]) <= fastest;
        is_near.then(|| change * change * self.turns_over().powi(2) / length)
    }

    /// Axes that are tried at a station, the nominal one first.
    fn candidates(&self, station: usize, [across, along]: [DVec3; 2]) -> Vec<DVec3> {
        let nominal = self.nominal_at(station);
        let contact = &self.contacts[self.stations[station]];
        let (normal, largest) = (contact.normal, self.options.largest_tilt);
        let mut candidates = vec![nominal];
        if self.options.tool.bottom_radius() > 0.0 {
            let lead = match self.options.axis {
                ToolAxis::Lead(lead) => lead,
                ToolAxis::Fixed(_) => return candidates,
            };
            let leads = (1..).map(|i| lead + f64::from(i) * STEP).take_while(|l| *l <= largest);
            candidates.extend(
                leads.map(|l| tool_axis(ToolAxis::Lead(l), normal, contact.feed_direction)),
            );
            return candidates;
        }
        let most = (largest / STEP) as i32;
        for (i, j) in (-most..=most).flat_map(|i| (-most..=most).map(move |j| (i, j))) {
            let (x, y) = (f64::from(i) * STEP, f64::from(j) * STEP);
            let angle = (x * x + y * y).sqrt();
            if angle <= largest {
                let way = if angle > 0.0 { (across * x + along * y) / angle } else { DVec3::ZERO };
                candidates.push((normal * cos(angle) + way * sin(angle)).normalize_or(normal));
            }
        }
        candidates
    }

    /// Two directions across the normal of each station, carried along the run.
    fn frames(&self) -> Vec<[DVec3; 2]> {
        let mut across = DVec3::ZERO;
        let frame = |&i: &usize| {
            let normal = self.contacts[i].normal;
            let carried = across.reject_from_normalized(normal);
            across = carried.try_normalize().unwrap_or(any_perpendicular(normal));
            [across, normal.cross(across)]
        };
        self.stations.iter().map(frame).collect()
    }

    /// The room of an axis at a station, mm; negative, too, where the cutter's side touches.
    fn room(&self, station: usize, axis: DVec3) -> f64 {
        self.room_at(self.stations[station], axis)
    }

    /// The same at a contact.
    fn room_at(&self, contact: usize, axis: DVec3) -> f64 {
        let contact = &self.contacts[contact];
        let tip = self.tip(contact, axis);
        let room = self.above.room(tip, axis);
        let is_clear = room >= 0.0 && self.above.is_slim_clear(tip, axis, contact.facet_error);
        if is_clear { room } else { room.min(-ROUNDED) }
    }

    fn tip(&self, contact: &Contact, axis: DVec3) -> DVec3 {
        let PassOptions { tool, allowance, .. } = self.options;
        tip(tool, contact.position, contact.normal, axis, *allowance)
    }

    /// Whether wide sections stay clear on the way from a station to the next, with these axes and rooms there.
    fn is_way_clear(&self, station: usize, axes: [DVec3; 2], rooms: [f64; 2]) -> bool {
        let contacts = [station, station + 1].map(|k| &self.contacts[self.stations[k]]);
        let tips = [self.tip(contacts[0], axes[0]), self.tip(contacts[1], axes[1])];
        self.is_motion_clear(tips, axes, rooms, HALVINGS)
    }

    fn is_motion_clear(
        &self,
        tips: [DVec3; 2],
        axes: [DVec3; 2],
        rooms: [f64; 2],
        halvings: u32,
    ) -> bool {
        let farthest = tips[0].distance(tips[1]) + self.above.height() * axes[0].distance(axes[1]);
        if farthest <= rooms[0] + rooms[1] || halvings == 0 {
            return true;
        }
        let tip = 0.5 * (tips[0] + tips[1]);
        let axis = (axes[0] + axes[1]).normalize_or(axes[1]);
        let room = self.above.room(tip, axis);
        room >= 0.0
            && self.is_motion_clear([tips[0], tip], [axes[0], axis], [rooms[0], room], halvings - 1)
            && self.is_motion_clear([tip, tips[1]], [axis, axes[1]], [room, rooms[1]], halvings - 1)
    }
}

/// What is known of a candidate.
#[derive(Copy, Clone, Debug, Default)]
struct State {
    /// The candidate of the station before from which it is reached the most cheaply, once that is known.
    before: Option<usize>,
    room: Option<f64>,
}

/// A way to a candidate.
#[derive(Copy, Clone, Debug)]
struct Move {
    /// Of the way up to there, and at least of what follows.
    whole: f64,
    /// Of the way up to there.
    cost: f64,
    /// Station, of the stretch, and candidate.
    to: (usize, usize),
    /// Candidate of the station before.
    before: usize,
    /// Whether the cost holds that it is not clear.
    is_paid: bool,
}

impl Move {
    fn key(&self) -> (usize, usize, usize) {
        (self.to.0, self.to.1, self.before)
    }
}

impl Ord for Move {
    fn cmp(&self, other: &Self) -> Ordering {
        self.whole.total_cmp(&other.whole).then(self.key().cmp(&other.key()))
    }
}

impl PartialOrd for Move {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Move {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Move {}

/// Contacts at least so far apart along the run, mm, or at which the nominal axis has turned, with both ends.
fn stations(travel: &[f64], nominal: &[DVec3], apart: f64) -> Vec<usize> {
    let mut stations = vec![0];
    let last = travel.len() - 1;
    for (i, at) in travel.iter().enumerate().take(last).skip(1) {
        let before = stations.last().copied().unwrap_or(0);
        let has_turned = nominal[i].distance(nominal[before]) > TURNED;
        if at - travel[before] >= apart || has_turned {
            stations.push(i);
        }
    }
    stations.push(last);
    stations
}

#[cfg(test)]
mod tests {
    use super::super::above::KeptClear;
    use super::super::check_mesh::CheckMesh;
    use super::super::clearance::{Hindrance, clearance};
    use super::*;
    use crate::tool::{Assembly, AssemblyPart, Section, Tool};
    use crate::toolpath::MoveKind;

    const RADIUS: f64 = 4.0;
    const ASKED: f64 = 0.5;

    fn assembly(corner: f64) -> Assembly {
        let section = |part, heights, radii| Section { part, heights, radii };
        Assembly {
            tool: Tool::new(RADIUS, corner).unwrap(),
            cutter_length: 16.0,
            sections: vec![
                section(AssemblyPart::Shank, [16.0, 24.0], [RADIUS; 2]),
                section(AssemblyPart::Holder, [24.0, 44.0], [15.0, 20.0]),
            ],
        }
    }

    /// A wall across x from `x` on, over the whole length of the passes.
    fn wall(x: f64, from: f64, to: f64) -> Hindrance {
        let corners = [(from, -5.0), (to, -5.0), (to, 60.0), (from, 60.0)];
        let positions = corners.map(|(y, z)| DVec3::new(x, y, z));
        Hindrance::new(&positions, &[[0, 1, 2], [0, 2, 3]])
    }

    /// Beside what is kept clear of.
    fn obstacles(corner: f64, hindrance: Hindrance) -> Obstacles {
        let kept = vec![KeptClear { hindrance, wide: ASKED, slim: ASKED }];
        Obstacles::of_part(CheckMesh::nothing()).with_above(AboveEnd::new(&assembly(corner), kept))
    }

    fn options(corner: f64, lead: f64) -> PassOptions {
        PassOptions {
            tool: Tool::new(RADIUS, corner).unwrap(),
            axis: ToolAxis::Lead(lead),
            axis_rate: f64::INFINITY,
            largest_tilt: 0.8,
            allowance: 0.0,
            tolerance: 0.005,
            reach: 40.0,
        }
    }

    /// A pass along Y on the plane z = 0, at x = 0, of a length in mm.
    fn pass(count: u32, length: f64) -> Vec<Contact> {
        let contact = |i: u32| Contact {
            position: DVec3::new(0.0, (f64::from(i) / f64::from(count) - 0.5) * length, 0.0),
            normal: DVec3::Z,
            feed_direction: DVec3::Y,
            key: i as usize,
            feed: 20.0,
            kind: MoveKind::Cut,
            facet_error: 0.0,
        };
        (0..=count).map(contact).collect()
    }

    /// The least distance of the whole tool, at contacts and in the middles between them.
    fn least(contacts: &[Contact], axes: &[DVec3], o: &PassOptions, hindrance: &Hindrance) -> f64 {
        let assembly = assembly(o.tool.corner_radius());
        let at = |c: &Contact, a: DVec3| tip(&o.tool, c.position, c.normal, a, 0.0);
        let of = |tip, axis| clearance(hindrance, &assembly, tip, axis, 10.0).distance;
        (1..contacts.len()).fold(f64::INFINITY, |least, i| {
            let [from, to] = [i - 1, i].map(|k| at(&contacts[k], axes[k]));
            let middle = (axes[i - 1] + axes[i]).normalize();
            least.min(of(to, axes[i])).min(of(0.5 * (from + to), middle))
        })
    }

    #[test]
    fn a_ball_leans_away_from_a_wall_along_the_pass() {
        let (contacts, o) = (pass(240, 60.0), options(RADIUS, 0.0));
        let near = wall(6.0, -100.0, 100.0);
        let axes = tool_axes(&contacts, None, &o, &obstacles(RADIUS, near.clone()));
        assert!(least(&contacts, &axes, &o, &near) >= ASKED);
        // The holder's lower edge clears where (24 - 4) sin a - 15 cos a = 0.5 - 6 of what turns about the ball's middle.
        let tilts = axes.iter().map(|a| acos_clamped(a.z).to_degrees());
        let (low, high) = tilts.fold((90.0f64, 0.0f64), |(l, h), t| (l.min(t), h.max(t)));
        assert!(low > 18.0 && high < 30.0, "{low} {high}");
        assert!(axes.iter().all(|a| a.x < 0.0));
    }

    #[test]
    fn it_leans_only_where_it_must() {
        let (contacts, o) = (pass(240, 120.0), options(RADIUS, 0.1));
        let near = wall(6.0, -2.0, 2.0);
        let axes = tool_axes(&contacts, None, &o, &obstacles(RADIUS, near.clone()));
        assert!(least(&contacts, &axes, &o, &near) >= ASKED);
        let nominal = tool_axis(o.axis, DVec3::Z, DVec3::Y);
        let moved: Vec<f64> = axes.iter().map(|a| a.distance(nominal)).collect();
        assert!(moved[0] < 0.02 && moved[240] < 0.02, "{} {}", moved[0], moved[240]);
        assert!(moved[120] > 0.2);
        // No jump on the way.
        assert!(axes.windows(2).all(|w| w[0].distance(w[1]) < 0.08));
    }

    /// Where the feed turns, two contacts are at one place, and each leans by itself.
    #[test]
    fn a_ball_leans_away_from_a_wall_at_a_corner_of_the_pass() {
        let o = options(RADIUS, 0.2);
        let along = pass(120, 30.0);
        let back = along.iter().rev().map(|c| {
            let position = DVec3::new(c.position.y - 15.0, 15.0, 0.0);
            Contact { position, feed_direction: -DVec3::X, ..*c }
        });
        let contacts: Vec<Contact> = along.iter().copied().chain(back).collect();
        assert_eq!(contacts[120].position, contacts[121].position);
        let near = wall(6.0, -100.0, 100.0);
        let axes = tool_axes(&contacts, None, &o, &obstacles(RADIUS, near.clone()));
        let at = |i: usize| tip(&o.tool, contacts[i].position, contacts[i].normal, axes[i], 0.0);
        for (i, &axis) in axes.iter().enumerate() {
            let distance = clearance(&near, &assembly(RADIUS), at(i), axis, 10.0).distance;
            assert!(distance >= ASKED, "{i}: {distance}");
        }
    }

    #[test]
    fn a_flat_end_gets_more_lead_before_a_wall_behind_it() {
        let (contacts, o) = (pass(240, 60.0), options(0.0, 0.1));
        let corners = [(-50.0, -5.0), (50.0, -5.0), (50.0, 60.0), (-50.0, 60.0)];
        let positions = corners.map(|(x, z)| DVec3::new(x, -45.0, z));
        let behind = Hindrance::new(&positions, &[[0, 1, 2], [0, 2, 3]]);
        let axes = tool_axes(&contacts, None, &o, &obstacles(0.0, behind.clone()));
        assert!(least(&contacts, &axes, &o, &behind) >= ASKED);
        assert!(axes.iter().all(|a| a.x.abs() < 1e-12));
        assert!(axes[0].y > axes[240].y);
    }

    #[test]
    fn a_branch_begins_and_ends_with_the_axis_of_its_pass() {
        let (contacts, o) = (pass(60, 60.0), options(RADIUS, 0.0));
        let start = DVec3::new(-0.3, 0.1, 1.0).normalize();
        let away = obstacles(RADIUS, wall(500.0, -1.0, 1.0));
        let axes = tool_axes(&contacts, Some(start), &o, &away);
        assert!(axes[0].distance(start) < 1e-9 && axes[60].distance(start) < 1e-9);
        assert!(axes[30].distance(DVec3::Z) < start.distance(DVec3::Z));
        assert_eq!(tool_axes(&contacts, None, &o, &away), vec![DVec3::Z; 61]);
    }

    /// Between two walls too near for the holder no axis is clear: the job's own one stays.
    #[test]
    fn where_nothing_is_clear_the_axis_stays() {
        let (contacts, o) = (pass(60, 60.0), options(RADIUS, 0.0));
        let positions: Vec<DVec3> = [-6.0, 6.0]
            .iter()
            .flat_map(|&x| {
                [(-99.0, -5.0), (99.0, -5.0), (99.0, 60.0), (-99.0, 60.0)]
                    .map(|(y, z)| DVec3::new(x, y, z))
            })
            .collect();
        let between = Hindrance::new(&positions, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
        let axes = tool_axes(&contacts, None, &o, &obstacles(RADIUS, between));
        assert_eq!(axes, vec![DVec3::Z; 61]);
    }
}
