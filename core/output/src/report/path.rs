//! What is reported of a path: length, time and removal rate.

use super::profile::Profile;
use evencut_core::load::{BESIDE_LINKS, LoadLimits, Material, SLOWED_BESIDE};
use evencut_core::toolpath::{MoveKind, PathPoint, Planar, Toolpath};
use evencut_core::units::per_minute;
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

/// Predicted load of a path. What concerns engagement and feed per tooth is of passes and loops, but for 0.15 and 0.3 cutter
/// radii of them beside links, which are slowed for what these remove.
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

/// How far the disc in the plane (MRR3) is from the rate found in the material, over passes and loops.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PlaneFigures {
    /// Root mean square of their difference over time, mm³/min.
    pub rms_difference_mm3_per_min: f64,
    /// The same as a fraction of the limit.
    pub rms_difference_over_limit: f64,
    /// Largest difference, the plane's less the material's, mm³/min.
    pub largest_difference_mm3_per_min: f64,
    /// Tool tip at the end of that move, mm.
    pub largest_difference_at_mm: [f64; 3],
}

impl PlaneFigures {
    /// `planar`: the prediction for each point of the path; `limit` of the rate, mm³/s. `None` where nothing is predicted.
    pub fn of(path: &Toolpath, planar: &[Option<Planar>], limit: f64) -> Option<Self> {
        let (mut squares, mut time) = (0.0, 0.0);
        let mut largest: Option<(f64, &PathPoint)> = None;
        for (pair, planar) in path.points.windows(2).zip(planar.iter().skip(1)) {
            let (p, duration) = (&pair[1], pair[1].time - pair[0].time);
            let is_pass = matches!(p.kind, MoveKind::Cut | MoveKind::Trochoid);
            let Some(planar) = planar.filter(|planar| is_pass && planar.mrr3().max(p.mrr) > 0.0)
            else {
                continue;
            };
            let difference = planar.mrr3() - p.mrr;
            squares += difference * difference * duration;
            time += duration;
            if largest.is_none_or(|(l, _)| difference.abs() > f64::abs(l)) {
                largest = Some((difference, p));
            }
        }
        let (difference, p) = largest.filter(|_| time > 0.0)?;
        let rms = (squares / time).sqrt();
        Some(Self {
            rms_difference_mm3_per_min: per_minute(rms),
            rms_difference_over_limit: rms / limit,
            largest_difference_mm3_per_min: per_minute(difference),
            largest_difference_at_mm: p.tip.to_array(),
        })
    }
}

impl RateFigures {
    /// Figures of a path whose points tell their rate.
    pub fn of(path: &Toolpath, load: &LoadLimits, material: Option<Material>) -> Self {
        let profile = Profile::of(path);
        let (mut peak, mut near, mut cutting) = (0.0_f64, 0.0, 0.0);
        let (mut section, mut slowest, mut power) = (0.0_f64, f64::INFINITY, 0.0_f64);
        let away = path.away_from_links();
        let radius = load.teeth.radius;
        for (pair, away) in path.points.windows(2).zip(away.into_iter().skip(1)) {
            let (p, time) = (&pair[1], pair[1].time - pair[0].time);
            if p.mrr <= 0.0 || p.feed <= 0.0 {
                continue;
            }
            let cut = p.mrr / p.feed;
            let share = load.share(cut, p.feed);
            peak = peak.max(share);
            cutting += time;
            near += if (NEAR..=1.0 + ROUNDING).contains(&share) { time } else { 0.0 };
            if away > BESIDE_LINKS * radius {
                section = section.max(cut);
            }
            if away > SLOWED_BESIDE * radius {
                slowest = slowest.min(p.feed);
            }
            power = material.map_or(0.0, |m| power.max(m.power(&load.teeth, cut, p.feed)));
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
    use evencut_core::geometry::DVec3;
    use evencut_core::load::Teeth;

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

    #[test]
    fn the_plane_is_compared_over_passes_and_loops() {
        use MoveKind::{Cut, Link, Trochoid};
        let points = vec![
            point(Cut, 0.0, 0.0, 0.0),
            point(Cut, 1.0, 10.0, 3.0),
            point(Trochoid, 2.0, 8.0, 4.0),
            point(Link, 3.0, 99.0, 9.0),
            point(Cut, 4.0, 0.0, 10.0),
        ];
        let planar =
            [0.0, 11.0, 5.0, 0.0, 0.0].map(|mrr2| Some(Planar { mrr2, tau: 1.0, alpha: 0.0 }));
        let figures = PlaneFigures::of(&Toolpath { points }, &planar, 10.0).unwrap();
        // 1 above for 3 s, 3 below for 1 s.
        let rms = f64::sqrt((3.0 + 9.0) / 4.0);
        assert!((figures.rms_difference_over_limit - 0.1 * rms).abs() < 1e-12);
        assert!((figures.largest_difference_mm3_per_min + 180.0).abs() < 1e-9);
        assert_eq!(figures.largest_difference_at_mm[0], 2.0);
        assert_eq!(PlaneFigures::of(&Toolpath::default(), &[], 10.0), None);
    }
}
