//! What is reported of a path: length, time and removal rate.

use super::profile::Profile;
use crate::toolpath::{MoveKind, Toolpath};
use crate::units::per_minute;
use serde::Serialize;

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

/// Predicted removal rate of a path.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RateFigures {
    /// Largest removal rate, mm³/min.
    pub peak_mm3_per_min: f64,
    /// Mean removal rate while cutting, mm³/min.
    pub mean_mm3_per_min: f64,
    /// Coefficient of variation of the removal rate while cutting.
    pub variation: f64,
    /// Largest removal rate as a multiple of the limit.
    pub peak_over_limit: f64,
}

impl RateFigures {
    /// Figures of a path whose points tell their rate; `limit`: mm³/s.
    pub fn of(path: &Toolpath, limit: f64) -> Self {
        let profile = Profile::of(path);
        let peak = profile.peak();
        Self {
            peak_mm3_per_min: per_minute(peak),
            mean_mm3_per_min: per_minute(profile.mean_while_cutting()),
            variation: profile.variation_while_cutting(),
            peak_over_limit: peak / limit,
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
        let rate = RateFigures::of(&path, 8.0);
        let f = PathFigures::of(&path, 5.0, ByKind::default(), Some(rate));
        assert_eq!((f.length_mm.cut, f.length_mm.link, f.length_mm.total), (12.0, 3.0, 15.0));
        assert_eq!((f.time_s.cut, f.time_s.link, f.time_s.total), (4.0, 2.0, 6.0));
        assert_eq!((rate.peak_mm3_per_min, rate.peak_over_limit), (240.0, 0.5));
        // Three seconds at 2 and one at 4: mean 2.5, variance 0.75.
        assert_eq!(rate.mean_mm3_per_min, 150.0);
        assert!((rate.variation - 0.75f64.sqrt() / 2.5).abs() < 1e-12);
    }
}
