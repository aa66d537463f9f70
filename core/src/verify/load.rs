//! How hard the cutter was worked: engagement, feed per tooth, power.
//!
//! A window that removes a volume `V` over a distance `l` in a time `t` has a section `A = V / l`. A disc of the cutter's
//! mean radius `R` over the depth `H` takes as much when it is engaged over `phi`, `1 - cos(phi) = A / (R H)`; its chips
//! are `h = f_z A / (R H phi)` thick on average, less where the edge is longer than `H`. Power is `k_c V / t` with
//! `k_c = k_c1.1 h^-m_c`.
//!
//! Source: Kienzle (VDI-Z 94, 1952). The formulas are those of planning, but nothing else is shared with it.

use super::rate::Window;
use crate::geometry::math;
use crate::tool::Tool;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use core::f64::consts::TAU;

/// Sections below this share of a slot's are scraps, which teeth rub off whatever the feed.
const SCRAP: f64 = 0.01;

/// Windows so close to a link, in their own lengths, are not judged by their feed per tooth: a pass that begins
/// where a plunge ends is slowed for what the plunge removes.
const BESIDE: f64 = 1.5;

/// Teeth and material, and the limits on what they are asked.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Number of teeth.
    pub flutes: u32,
    /// Spindle speed, rev/s.
    pub spindle: f64,
    /// `k_c1.1`, N/mm², and `m_c` of the material, where it is known.
    pub material: Option<(f64, f64)>,
    /// Largest angle of engagement, rad.
    pub most_engaged: Option<f64>,
    /// Smallest feed per tooth, mm.
    pub least_per_tooth: Option<f64>,
    /// Largest power, W.
    pub most_power: Option<f64>,
    /// Largest mean cutting force, N.
    pub most_force: Option<f64>,
    /// Whether the path says which of its moves are links and ramps, so that engagement and feed per tooth can be judged.
    pub knows_links: bool,
}

impl LoadOptions {
    /// The same for a program, which does not say which of its moves are links and ramps: these may be engaged farther
    /// and go slower.
    pub fn of_program(self) -> Self {
        Self { most_engaged: None, least_per_tooth: None, knows_links: false, ..self }
    }
}

/// A value and the window in which it is the worst.
pub type Worst = Option<(f64, Window)>;

/// What was asked of the cutter at worst.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Load {
    /// Largest angle of engagement on passes and loops, rad.
    pub engaged: Worst,
    /// Smallest feed per tooth where these cut, mm.
    pub per_tooth: Worst,
    /// Largest power, W; `None` where the material is not known.
    pub power: Worst,
    /// Largest mean cutting force, N.
    pub force: Worst,
}

/// Measures windows.
pub struct Gauge<'a> {
    path: &'a Toolpath,
    options: LoadOptions,
    radius: f64,
    /// Section of a quarter turn, `R H`, mm².
    quarter: f64,
    /// Depth over the length of the edge in it.
    thinned: f64,
    pub load: Load,
}

impl<'a> Gauge<'a> {
    /// `depth`: of the layer of stock, mm.
    pub fn new(path: &'a Toolpath, tool: &Tool, depth: f64, options: LoadOptions) -> Self {
        let radius = tool.mean_radius(depth);
        let thinned = (depth / tool.edge_length(depth)).min(1.0);
        Self { path, options, radius, quarter: radius * depth, thinned, load: Load::default() }
    }

    /// Takes note of a window.
    pub fn measure(&mut self, window: Window) {
        let time = window.time[1] - window.time[0];
        if window.travel <= 0.0 || time <= 0.0 || window.measured <= 0.0 {
            return;
        }
        let section = window.measured * time / window.travel;
        let part = (section / self.quarter).min(2.0);
        let engaged = math::acos_clamped(1.0 - part);
        let per_tooth =
            window.travel / time / (f64::from(self.options.flutes) * self.options.spindle);
        if self.options.knows_links && part > 2.0 * SCRAP {
            if self.is_on_pass(window, 0.0) {
                worst(&mut self.load.engaged, engaged, window, |new, old| new > old);
            }
            if self.is_on_pass(window, BESIDE) {
                worst(&mut self.load.per_tooth, per_tooth, window, |new, old| new < old);
            }
        }
        if let Some((kc11, mc)) = self.options.material {
            let chip = per_tooth * part / engaged * self.thinned;
            let power = 1e-3 * kc11 * math::powf(chip, -mc) * window.measured;
            let force = 1e3 * power / (TAU * self.radius * self.options.spindle);
            worst(&mut self.load.power, power, window, |new, old| new > old);
            worst(&mut self.load.force, force, window, |new, old| new > old);
        }
    }
}

impl Gauge<'_> {
    /// Whether a window, and what is `beside` it, in its own lengths, lies on passes and loops.
    fn is_on_pass(&self, window: Window, beside: f64) -> bool {
        let points = &self.path.points;
        let [start, end] = window.time;
        let beside = beside * (end - start);
        let (start, end) = (start - beside, end + beside);
        // Moves that end after its start, up to the one in which it ends.
        let first = points.partition_point(|p| p.time <= start).max(1);
        let last = points.partition_point(|p| p.time < end).min(points.len().saturating_sub(1));
        let is_pass = |p: &PathPoint| matches!(p.kind, MoveKind::Cut | MoveKind::Trochoid);
        let moves = points.get(first..=last.max(first)).unwrap_or_default();
        // What returns of a loop remove is a scrap.
        let is_part = |p: &PathPoint| is_pass(p) || p.kind == MoveKind::Return;
        moves.iter().all(is_part) && moves.iter().any(is_pass)
    }
}

fn worst(held: &mut Worst, value: f64, window: Window, is_worse: fn(f64, f64) -> bool) {
    if value.is_finite() && held.is_none_or(|(old, _)| is_worse(value, old)) {
        *held = Some((value, window));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec3;
    use core::f64::consts::PI;

    /// A straight slot, 10 mm wide and 2 mm deep, at 20 mm/s with 4 teeth at 100 rev/s: 633 N, 1.988 kW.
    #[test]
    fn a_straight_slot_is_as_by_hand() {
        let point = |x: f64| PathPoint {
            kind: MoveKind::Cut,
            pass: 0,
            region: 0,
            tip: DVec3::X * x,
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed: 20.0,
            mrr: 0.0,
            alpha: 0.0,
            time: x / 20.0,
        };
        let path = Toolpath { points: vec![point(0.0), point(10.0)] };
        let options = LoadOptions {
            flutes: 4,
            spindle: 100.0,
            material: Some((2100.0, 0.25)),
            most_engaged: None,
            least_per_tooth: None,
            most_power: None,
            most_force: None,
            knows_links: true,
        };
        let mut gauge = Gauge::new(&path, &Tool::new(5.0, 0.0).unwrap(), 2.0, options);
        gauge.measure(Window {
            time: [0.1, 0.15],
            place: DVec3::ZERO,
            of: 0,
            travel: 1.0,
            measured: 400.0,
            predicted: 0.0,
        });
        let value = |worst: Worst| worst.map_or(0.0, |(value, _)| value);
        let load = gauge.load;
        assert!((value(load.engaged) - PI).abs() < 1e-6);
        assert!((value(load.per_tooth) - 0.05).abs() < 1e-12);
        assert!((value(load.power) - 1988.0).abs() < 1.0, "{:?}", load.power);
        assert!((value(load.force) - 633.0).abs() < 1.0, "{:?}", load.force);
    }

    /// A plunge of 1 mm, 0.5 mm of a pass that is slowed for it, and the pass at its full feed: there only engagement is
    /// judged right beside the plunge, and nothing in windows that have a part of it.
    #[test]
    fn beside_a_plunge_engagement_is_judged_but_not_the_feed() {
        let point = |kind, x: f64, z: f64, feed: f64, time: f64| PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: DVec3::new(x, 0.0, z),
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed,
            mrr: 0.0,
            alpha: 0.0,
            time,
        };
        let path = Toolpath {
            points: vec![
                point(MoveKind::Link, 0.0, 1.0, 2.0, 0.0),
                point(MoveKind::Link, 0.0, 0.0, 2.0, 0.5),
                point(MoveKind::Cut, 0.5, 0.0, 2.0, 0.75),
                point(MoveKind::Cut, 20.5, 0.0, 20.0, 1.75),
            ],
        };
        let options = LoadOptions {
            flutes: 4,
            spindle: 100.0,
            material: None,
            most_engaged: None,
            least_per_tooth: None,
            most_power: None,
            most_force: None,
            knows_links: true,
        };
        let tool = Tool::new(5.0, 0.0).unwrap();
        let of = |time: [f64; 2], travel: f64| {
            let measured = 20.0 * travel / (time[1] - time[0]);
            let mut gauge = Gauge::new(&path, &tool, 2.0, options);
            let place = DVec3::ZERO;
            gauge.measure(Window { time, place, of: 1, travel, measured, predicted: 0.0 });
            (gauge.load.engaged.is_some(), gauge.load.per_tooth.is_some())
        };
        assert_eq!(of([0.45, 0.55], 0.2), (false, false));
        assert_eq!(of([0.51, 0.6], 0.18), (true, false));
        assert_eq!(of([1.0, 1.05], 1.0), (true, true));
    }
}
