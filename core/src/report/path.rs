//! What is reported of a path: length, time and removal rate.

use super::profile::Profile;
use crate::load::{LoadLimits, Material};
use crate::toolpath::{MoveKind, Toolpath};
use crate::units::per_minute;
use serde::Serialize;

/// From this part of a limit on, the cut is near it.
const NEAR: f64 = 0.8;
/// Part of a limit that rounding may exceed it by.
const ROUNDING: f64 = 1e-9;

/// A value for each kind of move and their sum.
#[derive(Copy, Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ByKind {
    /// Along passes.
    pub cut: f64,
    /// Cutting parts of trochoids.
    pub trochoid: f64,
    /// Parts of trochoids that cut nothing.
    #[serde(rename = "return")]
    pub return_: f64,
    /// Links at feed.
    pub link: f64,
    /// Rapids.
    pub rapid: f64,
    /// All moves.
    pub total: f64,
}

impl ByKind {
    /// Adds to a kind and to the sum.
    pub fn add(&mut self, kind: MoveKind, value: f64) {
        let slot = match kind {
            MoveKind::Cut => &mut self.cut,
            MoveKind::Trochoid => &mut self.trochoid,
            MoveKind::Return => &mut self.return_,
            MoveKind::Link => &mut self.link,
            MoveKind::Rapid => &mut self.rapid,
        };
        *slot += value;
        self.total += value;
    }

    /// The values with names to read, the sum last.
    pub fn rows(&self) -> [(&'static str, f64); 6] {
        [
            ("cut", self.cut),
            ("trochoid", self.trochoid),
            ("trochoid return", self.return_),
            ("link", self.link),
            ("rapid", self.rapid),
            ("total", self.total),
        ]
    }
}

/// Length, time and removal rate of a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PathFigures {
    /// Nominal feed, mm/min.
    pub feed_mm_per_min: f64,
    /// Length of the tool tip's path by kind of move, mm.
    pub length_mm: ByKind,
    /// Time with the feeds as commanded by kind of move, s.
    pub time_s: ByKind,
    /// Time under the machine's limits by kind of move, s.
    pub machine_time_s: ByKind,
    /// Predicted removal rate; these keys are missing where it is not controlled.
    #[serde(flatten)]
    pub rate: Option<RateFigures>,
}

/// Predicted load of a path. What concerns engagement, feed per tooth, power and force is of passes and loops.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RateFigures {
    /// Largest removal rate, mm³/min.
    pub peak_mm3_per_min: f64,
    /// Mean removal rate while cutting, mm³/min.
    pub mean_mm3_per_min: f64,
    /// Coefficient of variation of the removal rate while cutting.
    pub variation: f64,
    /// Largest of removal rate, power and force as a multiple of its limit.
    pub peak_over_limit: f64,
    /// Share of the cutting time in which the largest of them is from 0.8 of its limit to the limit.
    pub near_limit: f64,
    /// Largest angle of engagement, degrees, of a disc that takes the same volume.
    pub engagement_deg: f64,
    /// Smallest feed per tooth, mm.
    pub feed_per_tooth_mm: f64,
    /// Largest power, W; null where the material is not known.
    pub power_w: Option<f64>,
    /// Largest mean cutting force, N; null where the material is not known.
    pub force_n: Option<f64>,
}

impl RateFigures {
    /// Figures of a path whose points tell their rate.
    pub fn of(path: &Toolpath, load: &LoadLimits, material: Option<Material>) -> Self {
        let profile = Profile::of(path);
        let (mut peak, mut near, mut cutting) = (0.0_f64, 0.0, 0.0);
        let (mut section, mut slowest, mut power) = (0.0_f64, f64::INFINITY, 0.0_f64);
        for pair in path.points.windows(2) {
            let (p, time) = (&pair[1], pair[1].time - pair[0].time);
            if p.mrr <= 0.0 || p.feed <= 0.0 {
                continue;
            }
            let cut = p.mrr / p.feed;
            let share = load.share(cut, p.feed);
            peak = peak.max(share);
            cutting += time;
            near += if (NEAR..=1.0 + ROUNDING).contains(&share) { time } else { 0.0 };
            if matches!(p.kind, MoveKind::Cut | MoveKind::Trochoid) {
                section = section.max(cut);
                slowest = slowest.min(p.feed);
                power = material.map_or(0.0, |m| power.max(m.power(&load.teeth, cut, p.feed)));
            }
        }
        Self {
            peak_mm3_per_min: per_minute(profile.peak()),
            mean_mm3_per_min: per_minute(profile.mean_while_cutting()),
            variation: profile.variation_while_cutting(),
            peak_over_limit: peak,
            near_limit: if cutting > 0.0 { near / cutting } else { 0.0 },
            engagement_deg: load.teeth.engaged(section).to_degrees(),
            feed_per_tooth_mm: if slowest.is_finite() {
                load.teeth.per_tooth(slowest)
            } else {
                0.0
            },
            power_w: material.map(|_| 1e-3 * power),
            force_n: material.map(|_| power / load.teeth.speed),
        }
    }
}

impl PathFigures {
    /// Figures of a path; `feed`: nominal, mm/s, `machine_time`: s by kind.
    pub fn of(path: &Toolpath, feed: f64, machine_time: ByKind, rate: Option<RateFigures>) -> Self {
        let (mut length, mut time) = (ByKind::default(), ByKind::default());
        for pair in path.points.windows(2) {
            length.add(pair[1].kind, pair[0].tip.distance(pair[1].tip));
            time.add(pair[1].kind, pair[1].time - pair[0].time);
        }
        Self {
            feed_mm_per_min: per_minute(feed),
            length_mm: length,
            time_s: time,
            machine_time_s: machine_time,
            rate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::DVec3;
    use crate::load::Teeth;
    use crate::toolpath::PathPoint;

    fn point(kind: MoveKind, x: f64, mrr: f64, time: f64) -> PathPoint {
        PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: DVec3::new(x, 0.0, 0.0),
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed: 1.0,
            mrr,
            alpha: 0.0,
            time,
        }
    }

    #[test]
    fn figures_of_a_small_path() {
        let path = Toolpath {
            points: vec![
                point(MoveKind::Rapid, 0.0, 0.0, 0.0),
                point(MoveKind::Cut, 10.0, 2.0, 3.0),
                point(MoveKind::Cut, 12.0, 4.0, 4.0),
                point(MoveKind::Link, 15.0, 0.0, 6.0),
            ],
        };
        let teeth = Teeth { radius: 2.0, depth: 2.0, edge: 2.0, rate: 10.0, speed: 1.0 };
        let (rate, most_engaged) = (8.0, core::f64::consts::PI);
        let load = LoadLimits { teeth, rate, power: None, least_per_tooth: 0.0, most_engaged };
        let rate = RateFigures::of(&path, &load, None);
        let f = PathFigures::of(&path, 5.0, ByKind::default(), Some(rate));
        assert_eq!((f.length_mm.cut, f.length_mm.link, f.length_mm.total), (12.0, 3.0, 15.0));
        assert_eq!((f.time_s.cut, f.time_s.link, f.time_s.total), (4.0, 2.0, 6.0));
        assert_eq!((rate.peak_mm3_per_min, rate.peak_over_limit), (240.0, 0.5));
        // 4 mm² are a quarter turn.
        assert!((rate.engagement_deg - 90.0).abs() < 1e-9 && rate.feed_per_tooth_mm == 0.1);
        assert_eq!((rate.near_limit, rate.power_w), (0.0, None));
        // Three seconds at 2 and one at 4: mean 2.5, variance 0.75.
        assert_eq!(rate.mean_mm3_per_min, 150.0);
        assert!((rate.variation - 0.75f64.sqrt() / 2.5).abs() < 1e-12);
    }
}
