//! The removal rate along time, before and after.

use super::colour::{self, Rgb};
use super::path_layers::rate;
use super::svg::{Anchor, Stroke, Svg, clock, round_step};
use crate::report::Profile;
use evencut_core::geometry::DVec2;
use evencut_core::units::{per_minute, per_second};

const SIZE: DVec2 = DVec2::new(960.0, 560.0);
/// Upper left corners of the two panels, px.
const PANELS: [DVec2; 2] = [DVec2::new(84.0, 74.0), DVec2::new(84.0, 316.0)];
const PANEL: DVec2 = DVec2::new(780.0, 180.0);
/// One column a px: what a screen can show.
const COLUMNS: usize = 780;
/// Below the range.
const LOAD: Rgb = Rgb([0xdb, 0xea, 0xf2]);
const BELOW_LIMIT: Rgb = Rgb([0x9c, 0xc4, 0xd8]);
const MEAN: Rgb = Rgb([0x1f, 0x5f, 0x86]);
/// Size of the peak's label, px.
const LABEL: f64 = 11.0;
/// What rounding may add to a rate that is at the limit.
const AT_LIMIT: f64 = 1.0 + 1e-6;

/// Removal rate along time of the plain passes (`before`) and of the delivered path (`after`), one
/// above the other on the same scales, with the limit, mm³/s, as a line.
///
/// Each column shows the range of the rate, what lies below the range lighter, and the mean; what
/// exceeds the limit is set off.
pub fn mrr_chart(before: &Profile, after: &Profile, limit: f64) -> String {
    let mut svg = Svg::new(
        SIZE.x,
        SIZE.y,
        "Removal rate along time",
        "Removal rate of the plain passes and of the delivered path, with the limit.",
    );
    svg.text(DVec2::new(30.0, 30.0), Anchor::Start, 16.0, "Removal rate along time");
    key(&mut svg);
    let axes = Axes::of(before, after, limit);
    for (corner, profile, name) in
        [(PANELS[0], before, "Plain passes"), (PANELS[1], after, "Delivered path")]
    {
        panel(&mut svg, &axes, corner, profile, limit, name);
    }
    let label = DVec2::new(PANELS[1].x + PANEL.x / 2.0, SIZE.y - 18.0);
    svg.text(label, Anchor::Middle, 12.0, "time at the feeds as programmed, min:s");
    svg.finish()
}

/// Where [`mrr_chart`] shows times and rates.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ChartPlacement {
    /// Upper left corners of the panels of the plain passes and of the delivered path, px.
    pub panels: [[f64; 2]; 2],
    /// Width and height of a panel, px.
    pub size: [f64; 2],
    /// Time at a panel's right side, s.
    pub duration: f64,
    /// Removal rate at its top, mm³/min.
    pub top: f64,
}

/// Where [`mrr_chart`] shows times and rates of the same profiles.
pub(super) fn placement(before: &Profile, after: &Profile, limit: f64) -> ChartPlacement {
    let axes = Axes::of(before, after, limit);
    ChartPlacement {
        panels: PANELS.map(|p| p.to_array()),
        size: PANEL.to_array(),
        duration: axes.duration,
        top: per_minute(axes.top),
    }
}

/// The scales that both panels share: s, mm³/s.
struct Axes {
    duration: f64,
    top: f64,
}

impl Axes {
    fn of(before: &Profile, after: &Profile, limit: f64) -> Self {
        let peak = before.peak().max(after.peak()).max(limit);
        Self {
            duration: before.duration().max(after.duration()).max(f64::MIN_POSITIVE),
            top: 1.12 * peak.max(f64::MIN_POSITIVE),
        }
    }

    fn place(&self, corner: DVec2, time: f64, mrr: f64) -> DVec2 {
        corner + PANEL * DVec2::new(time / self.duration, 1.0 - mrr / self.top)
    }
}

fn key(svg: &mut Svg) {
    let at = DVec2::new(SIZE.x - 420.0, 20.0);
    let box_size = DVec2::new(14.0, 11.0);
    let entries = [(BELOW_LIMIT, "range", 0.0), (colour::OVER_LIMIT, "above the limit", 150.0)];
    for (fill, label, shift) in entries {
        let low = at + DVec2::new(shift, 0.0);
        svg.rectangle(low, box_size, fill);
        svg.text(low + DVec2::new(20.0, 10.0), Anchor::Start, 12.0, label);
    }
    let from = at + DVec2::new(75.0, 6.0);
    svg.line(from, from + DVec2::new(16.0, 0.0), Stroke::solid(MEAN, 1.5));
    svg.text(from + DVec2::new(22.0, 4.0), Anchor::Start, 12.0, "mean");
}

fn panel(svg: &mut Svg, axes: &Axes, corner: DVec2, profile: &Profile, limit: f64, name: &str) {
    grid(svg, axes, corner);
    let columns = Column::reduce(profile, axes.duration);
    bands(svg, axes, corner, &columns, limit);
    limit_line(svg, axes, corner, limit);
    let heading = format!(
        "{name}: peak {} mm³/min ({:.2} of the limit), mean while cutting {} mm³/min, {}",
        rate(per_minute(profile.peak())),
        if limit > 0.0 { profile.peak() / limit } else { 0.0 },
        rate(per_minute(profile.mean_while_cutting())),
        clock(profile.duration()),
    );
    svg.text(corner - DVec2::new(0.0, 9.0), Anchor::Start, 13.0, &heading);
    peak_mark(svg, axes, corner, profile, limit);
}

/// Axes with round ticks.
fn grid(svg: &mut Svg, axes: &Axes, corner: DVec2) {
    let top = per_minute(axes.top);
    let step = round_step(top, 5.0);
    for i in 0..=(top / step).floor() as usize {
        let value = step * i as f64;
        let at = axes.place(corner, 0.0, per_second(value));
        svg.line(at, at + DVec2::new(PANEL.x, 0.0), Stroke::solid(colour::FAINT, 1.0));
        svg.text(at + DVec2::new(-8.0, 4.0), Anchor::End, 12.0, &rate(value));
    }
    let step = time_step(axes.duration);
    for i in 0..=(axes.duration / step).floor() as usize {
        let time = step * i as f64;
        let at = axes.place(corner, time, 0.0);
        svg.line(at, at + DVec2::new(0.0, 5.0), Stroke::solid(colour::INK, 1.0));
        svg.text(at + DVec2::new(0.0, 19.0), Anchor::Middle, 12.0, &clock(time));
    }
    let foot = corner + DVec2::new(0.0, PANEL.y);
    svg.line(foot, foot + DVec2::new(PANEL.x, 0.0), Stroke::solid(colour::INK, 1.0));
    let unit = corner + DVec2::new(-8.0, -9.0);
    svg.text(unit, Anchor::End, 12.0, "mm³/min");
}

/// A step of time that reads well, at most eight to the axis.
pub(super) fn time_step(duration: f64) -> f64 {
    let seconds = [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0];
    if duration < 8.0 {
        return round_step(duration, 8.0);
    }
    let hour = 3600.0;
    let round = seconds.into_iter().find(|s| duration / s <= 8.0);
    round.unwrap_or_else(|| hour * round_step(duration / hour, 8.0).max(1.0))
}

/// Range and mean of the rate in one column.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Column {
    low: f64,
    high: f64,
    /// Integral of the rate over the part of the column that is covered, and its duration.
    volume: f64,
    covered: f64,
}

impl Column {
    const EMPTY: Self = Self { low: f64::INFINITY, high: 0.0, volume: 0.0, covered: 0.0 };

    /// The columns over `duration`, those after the profile's end empty.
    fn reduce(profile: &Profile, duration: f64) -> Vec<Self> {
        let width = duration / COLUMNS as f64;
        let mut columns = vec![Self::EMPTY; COLUMNS];
        for (from, to, mrr) in profile.pieces() {
            let first = ((from / width) as usize).min(COLUMNS - 1);
            let last = ((to / width) as usize).min(COLUMNS - 1);
            for (i, column) in columns.iter_mut().enumerate().take(last + 1).skip(first) {
                let left = width * i as f64;
                column.take(mrr, (to.min(left + width) - from.max(left)).max(0.0));
            }
        }
        columns
    }

    fn take(&mut self, mrr: f64, duration: f64) {
        self.low = self.low.min(mrr);
        self.high = self.high.max(mrr);
        self.volume += mrr * duration;
        self.covered += duration;
    }
}

fn bands(svg: &mut Svg, axes: &Axes, corner: DVec2, columns: &[Column], limit: f64) {
    let width = axes.duration / COLUMNS as f64;
    let filled: Vec<(f64, Column)> = columns
        .iter()
        .enumerate()
        .filter(|(_, c)| c.covered > 0.0)
        .map(|(i, &c)| (width * i as f64, c))
        .collect();
    let step = |value: &dyn Fn(&Column) -> f64| -> Vec<DVec2> {
        filled
            .iter()
            .flat_map(|(t, c)| [*t, t + width].map(|t| axes.place(corner, t, value(c))))
            .collect()
    };
    let band = |upper: Vec<DVec2>, lower: Vec<DVec2>| -> Vec<DVec2> {
        upper.into_iter().chain(lower.into_iter().rev()).collect()
    };
    let load = band(step(&|c| c.low.min(limit)), step(&|_| 0.0));
    svg.region(&[load], LOAD, None);
    let range = band(step(&|c| c.high.min(limit)), step(&|c| c.low.min(limit)));
    svg.region(&[range], BELOW_LIMIT, None);
    if filled.iter().any(|(_, c)| c.high > limit * AT_LIMIT) {
        let excess = band(step(&|c| c.high.max(limit)), step(&|_| limit));
        svg.region(&[excess], colour::OVER_LIMIT, None);
    }
    let mean: Vec<DVec2> = filled
        .iter()
        .map(|(t, c)| axes.place(corner, t + 0.5 * width, c.volume / c.covered))
        .collect();
    svg.polyline(&mean, Stroke::solid(MEAN, 1.0));
}

fn limit_line(svg: &mut Svg, axes: &Axes, corner: DVec2, limit: f64) {
    let from = axes.place(corner, 0.0, limit);
    let to = from + DVec2::new(PANEL.x, 0.0);
    svg.line(from, to, Stroke::dashed(colour::INK, 1.3));
    svg.text(to + DVec2::new(6.0, -2.0), Anchor::Start, 12.0, "limit");
    svg.text(to + DVec2::new(6.0, 12.0), Anchor::Start, 12.0, &rate(per_minute(limit)));
}

/// A small triangle over the highest rate with its value, which the line of the limit does not cross.
fn peak_mark(svg: &mut Svg, axes: &Axes, corner: DVec2, profile: &Profile, limit: f64) {
    let peak = profile.peak();
    let Some((from, to, _)) = profile.pieces().find(|&(.., mrr)| mrr == peak && mrr > 0.0) else {
        return;
    };
    let at = axes.place(corner, 0.5 * (from + to), peak);
    let tip = at - DVec2::new(0.0, 1.5);
    let wing = DVec2::new(4.0, -7.0);
    svg.region(&[vec![tip, tip + wing, tip + DVec2::new(-wing.x, wing.y)]], colour::INK, None);
    let near_end = at.x > corner.x + PANEL.x - 80.0;
    let (anchor, shift) = if near_end { (Anchor::End, -8.0) } else { (Anchor::Start, 8.0) };
    let label = format!("peak {}", rate(per_minute(peak)));
    let line = axes.place(corner, 0.0, limit).y;
    let above = tip.y - 1.0;
    let is_crossed = (above - LABEL..above + 3.0).contains(&line);
    let foot = DVec2::new(tip.x + shift, if is_crossed { line - 4.0 } else { above });
    svg.text(foot, anchor, LABEL, &label);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_keep_peak_and_volume() {
        let n = 10_000;
        let profile = Profile {
            time: (0..n).map(|i| 0.01 * f64::from(i)).collect(),
            mrr: (0..n).map(|i| if i == 5_000 { 9.0 } else { f64::from(i % 7) }).collect(),
        };
        let columns = Column::reduce(&profile, profile.duration());
        let high = columns.iter().map(|c| c.high).fold(0.0, f64::max);
        assert_eq!(high, 9.0);
        let volume: f64 = columns.iter().map(|c| c.volume).sum();
        let direct: f64 = profile.pieces().map(|(a, b, m)| (b - a) * m).sum();
        assert!((volume - direct).abs() < 1e-6 * direct);
    }

    #[test]
    fn times_read_as_clocks() {
        assert_eq!(
            [clock(0.0), clock(61.4), clock(3600.0), clock(2.5)],
            ["0:00", "1:01", "60:00", "0:02.5"]
        );
    }

    #[test]
    fn ticks_are_few_and_round() {
        for duration in [0.3, 7.0, 8.0, 59.0, 600.0, 5_000.0, 100_000.0] {
            let count = duration / time_step(duration);
            assert!((1.0..=8.0).contains(&count), "{duration}: {count}");
        }
    }

    #[test]
    fn empty_profiles_are_drawn() {
        let text = mrr_chart(&Profile::default(), &Profile::default(), 0.0);
        assert!(text.ends_with("</svg>\n") && !text.contains("NaN") && !text.contains("inf"));
    }
}
