//! Variants of one job side by side, as bars.

use super::colour::{self, Rgb};
use super::svg::{Anchor, Stroke, Svg};
use evencut_core::geometry::DVec2;

const MARGIN: f64 = 30.0;
/// Lower edge of the headings of the columns.
const HEADER: f64 = 84.0;
const ROW: f64 = 30.0;
const BAR: f64 = 16.0;
/// Width of the column of names.
const NAMES: f64 = 170.0;
/// Width of a column of bars, and of the longest bar in it.
const COLUMN: (f64, f64) = (230.0, 130.0);
/// Width of the last columns.
const FIGURES: f64 = 90.0;
/// Bars of lengths, of times, of residuals within the limit.
const FILL: Rgb = Rgb([0x77, 0xaa, 0xdd]);
const TIME: Rgb = Rgb([0x99, 0xdd, 0xff]);
const WITHIN: Rgb = Rgb([0xee, 0xdd, 0x88]);

/// A variant in figures; what is not known is left out.
#[derive(Clone, Debug)]
pub struct Bars {
    /// Its name.
    pub name: &'static str,
    /// Length of the passes, mm, and that as a multiple of the shortest that can be.
    pub length: Option<(f64, f64)>,
    /// Time on the machine, s.
    pub machine_time: Option<f64>,
    /// Highest residual and its limit, mm.
    pub residual: Option<(f64, Option<f64>)>,
    /// Time of planning, s.
    pub computing: f64,
    /// Number of regions.
    pub regions: u64,
    /// Whether all limits are kept.
    pub is_kept: Option<bool>,
}

/// A table of bars, a row a variant.
pub fn comparison(title: &str, rows: &[Bars]) -> String {
    let width = 2.0 * MARGIN + NAMES + 3.0 * COLUMN.0 + 2.0 * FIGURES;
    let height = HEADER + ROW * rows.len() as f64 + MARGIN;
    let description = "Length, time and residual of several plans of one job.";
    let mut svg = Svg::new(width, height, title, description);
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, title);
    let left = |k: usize| MARGIN + NAMES + COLUMN.0 * k as f64;
    for (k, heading) in ["length, m (x shortest)", "on the machine, min:s", "largest residual, µm"]
        .iter()
        .enumerate()
    {
        svg.text(DVec2::new(left(k), HEADER - 16.0), Anchor::Start, 12.0, heading);
    }
    let figure = |k: f64| width - MARGIN - FIGURES * (1.0 - k);
    for (k, heading) in [(0.0, "regions"), (1.0, "planning, s")] {
        svg.text(DVec2::new(figure(k), HEADER - 16.0), Anchor::End, 12.0, heading);
    }
    let most = |of: fn(&Bars) -> Option<f64>| rows.iter().filter_map(of).fold(0.0, f64::max);
    let longest = most(|r| r.length.map(|l| l.0));
    let slowest = most(|r| r.machine_time);
    let highest = most(|r| r.residual.map(|(h, limit)| h.max(limit.unwrap_or(0.0))));
    for (i, row) in rows.iter().enumerate() {
        let y = HEADER + ROW * i as f64;
        let rule = DVec2::new(MARGIN, y);
        svg.line(rule, DVec2::new(width - MARGIN, y), Stroke::solid(colour::FAINT, 1.0));
        let base = y + 0.5 * ROW + 4.0;
        svg.text(DVec2::new(MARGIN, base), Anchor::Start, 12.0, row.name);
        let mut bar = |k: usize, share: f64, fill: Rgb, label: &str| {
            let corner = DVec2::new(left(k), y + 0.5 * (ROW - BAR));
            svg.rectangle(corner, DVec2::new(COLUMN.1 * share, BAR), fill);
            let at = DVec2::new(left(k) + COLUMN.1 * share + 8.0, base);
            svg.text(at, Anchor::Start, 12.0, label);
        };
        if let Some((length, over)) = row.length {
            bar(0, length / longest, FILL, &format!("{:.2} ({over:.2})", length / 1000.0));
        }
        if let Some(seconds) = row.machine_time {
            let whole = seconds.round() as u64;
            let label = format!("{}:{:02}", whole / 60, whole % 60);
            bar(1, seconds / slowest, TIME, &label);
        }
        if let Some((height, limit)) = row.residual {
            let fill = if row.is_kept == Some(false) { colour::WARNING } else { WITHIN };
            bar(2, height / highest, fill, &format!("{:.1}", 1e3 * height));
            if let Some(limit) = limit {
                let x = left(2) + COLUMN.1 * limit / highest;
                let ink = Stroke::solid(colour::INK, 1.5);
                svg.line(DVec2::new(x, y + 4.0), DVec2::new(x, y + ROW - 4.0), ink);
            }
        }
        svg.text(DVec2::new(figure(0.0), base), Anchor::End, 12.0, &row.regions.to_string());
        let seconds = format!("{:.2}", row.computing);
        svg.text(DVec2::new(figure(1.0), base), Anchor::End, 12.0, &seconds);
    }
    svg.finish()
}
