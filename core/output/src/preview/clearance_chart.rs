//! How far the tool stays clear of what it must not touch, along time.

use super::colour::{self, Rgb};
use super::mrr_chart::time_step;
use super::svg::{Anchor, Stroke, Svg, clock, round_step};
use evencut_core::geometry::DVec2;

const SIZE: DVec2 = DVec2::new(960.0, 380.0);
/// Upper left corner of the panel, px.
const CORNER: DVec2 = DVec2::new(84.0, 74.0);
const PANEL: DVec2 = DVec2::new(780.0, 240.0);
/// One column a px: what a screen can show.
const COLUMNS: usize = 780;
/// The range of distances, and the least of them.
const RANGE: Rgb = Rgb([0x9c, 0xc4, 0xd8]);
const LEAST: Rgb = Rgb([0x1f, 0x5f, 0x86]);
/// Least height of the panel, wanted distances.
const SHOWN: f64 = 4.0;
/// Room above the largest distance that was measured, as a part of it.
const ROOM: f64 = 1.1;

/// Distances along a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearances {
    /// Times of the path's points, s, not decreasing.
    pub time: Vec<f64>,
    /// The smallest distance on the move that ends at each of them, mm; negative where the tool cuts in.
    pub distance: Vec<f64>,
    /// The distance that is wanted, mm.
    pub wanted: f64,
    /// Distances above this one, mm, were not told apart.
    pub beyond: f64,
}

impl Clearances {
    /// Start, end and distance of each move.
    fn moves(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        self.time.windows(2).zip(self.distance.iter().skip(1)).map(|(t, d)| (t[0], t[1], *d))
    }

    fn duration(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE)
    }

    /// Distance at the top of the panel and at its foot, mm.
    fn range(&self) -> (f64, f64) {
        let measured = self.moves().map(|m| m.2).filter(|d| *d < self.beyond).fold(0.0, f64::max);
        let wide = (ROOM * measured).max(SHOWN * self.wanted);
        let top = wide.min(self.beyond).max(f64::MIN_POSITIVE);
        let least = self.moves().map(|m| m.2).fold(0.0, f64::min);
        // Of a deep cut the depth is not shown to scale.
        (top, least.max(-top))
    }
}

/// The smallest distance between the tool and what it must not touch along the time of a path, with the wanted one as a
/// line.
///
/// Each column shows the range of the distances in it; where the least is below what is wanted, that is set off.
pub fn clearance_chart(found: &Clearances) -> String {
    let mut svg = Svg::new(
        SIZE.x,
        SIZE.y,
        "Clearance along time",
        "Smallest distance of cutter, shank and holder from what they must not touch, with the wanted clearance.",
    );
    svg.text(DVec2::new(30.0, 30.0), Anchor::Start, 16.0, "Clearance along time");
    key(&mut svg);
    let axes = Axes::of(found);
    axes.grid(&mut svg);
    axes.bands(&mut svg, found);
    axes.wanted_line(&mut svg, found.wanted);
    let nearest = found.moves().min_by(|a, b| a.2.total_cmp(&b.2)).filter(|m| m.2 < found.beyond);
    let heading = match nearest {
        Some((from, to, least)) => {
            axes.mark(&mut svg, 0.5 * (from + to), least);
            format!("smallest {least:.3} mm at {}, wanted {:.3} mm", clock(to), found.wanted)
        }
        None => format!("never nearer than {} mm, wanted {:.3} mm", found.beyond, found.wanted),
    };
    svg.text(CORNER - DVec2::new(0.0, 9.0), Anchor::Start, 13.0, &heading);
    let label = DVec2::new(CORNER.x + PANEL.x / 2.0, SIZE.y - 18.0);
    svg.text(
        label,
        Anchor::Middle,
        12.0,
        "time, min:s; distances above the panel are larger than shown",
    );
    svg.finish()
}

fn key(svg: &mut Svg) {
    let at = DVec2::new(SIZE.x - 420.0, 20.0);
    for (fill, label, shift) in
        [(RANGE, "range", 0.0), (colour::OVER_LIMIT, "below the wanted one", 150.0)]
    {
        let low = at + DVec2::new(shift, 0.0);
        svg.rectangle(low, DVec2::new(14.0, 11.0), fill);
        svg.text(low + DVec2::new(20.0, 10.0), Anchor::Start, 12.0, label);
    }
    let from = at + DVec2::new(75.0, 6.0);
    svg.line(from, from + DVec2::new(16.0, 0.0), Stroke::solid(LEAST, 1.5));
    svg.text(from + DVec2::new(22.0, 4.0), Anchor::Start, 12.0, "least");
}

/// The scales of the panel: s, mm.
struct Axes {
    duration: f64,
    top: f64,
    foot: f64,
}

impl Axes {
    fn of(found: &Clearances) -> Self {
        let (top, foot) = found.range();
        Self { duration: found.duration(), top, foot }
    }

    /// The place of a time and a distance, which is kept in the panel.
    fn place(&self, time: f64, distance: f64) -> DVec2 {
        let height = (distance.clamp(self.foot, self.top) - self.foot) / (self.top - self.foot);
        CORNER + PANEL * DVec2::new(time / self.duration, 1.0 - height)
    }

    fn grid(&self, svg: &mut Svg) {
        let step = round_step(self.top - self.foot, 5.0);
        let (first, last) = ((self.foot / step).ceil() as i64, (self.top / step).floor() as i64);
        for i in first..=last {
            let value = step * i as f64;
            let at = self.place(0.0, value);
            svg.line(at, at + DVec2::new(PANEL.x, 0.0), Stroke::solid(colour::FAINT, 1.0));
            let decimals = if step < 0.1 { 2 } else { 1 };
            svg.text(at + DVec2::new(-8.0, 4.0), Anchor::End, 12.0, &format!("{value:.decimals$}"));
        }
        let step = time_step(self.duration);
        for i in 0..=(self.duration / step).floor() as usize {
            let time = step * i as f64;
            let at = self.place(time, self.foot);
            svg.line(at, at + DVec2::new(0.0, 5.0), Stroke::solid(colour::INK, 1.0));
            svg.text(at + DVec2::new(0.0, 19.0), Anchor::Middle, 12.0, &clock(time));
        }
        let foot = self.place(0.0, self.foot);
        svg.line(foot, foot + DVec2::new(PANEL.x, 0.0), Stroke::solid(colour::INK, 1.0));
        svg.text(CORNER + DVec2::new(-8.0, -9.0), Anchor::End, 12.0, "mm");
    }

    fn bands(&self, svg: &mut Svg, found: &Clearances) {
        let width = self.duration / COLUMNS as f64;
        let mut columns = vec![(f64::INFINITY, f64::NEG_INFINITY); COLUMNS];
        for (from, to, distance) in found.moves() {
            let [first, last] = [from, to].map(|t| ((t / width) as usize).min(COLUMNS - 1));
            for (low, high) in &mut columns[first..=last] {
                (*low, *high) = (low.min(distance), high.max(distance));
            }
        }
        let filled: Vec<(f64, f64, f64)> = columns
            .iter()
            .enumerate()
            .filter(|(_, (low, high))| low <= high)
            .map(|(i, &(low, high))| (width * i as f64, low, high))
            .collect();
        let step = |value: &dyn Fn(f64, f64) -> f64| -> Vec<DVec2> {
            let corners = |&(t, low, high): &(f64, f64, f64)| {
                [t, t + width].map(|t| self.place(t, value(low, high)))
            };
            filled.iter().flat_map(corners).collect()
        };
        let band = |upper: Vec<DVec2>, lower: Vec<DVec2>| -> Vec<DVec2> {
            upper.into_iter().chain(lower.into_iter().rev()).collect()
        };
        svg.region(&[band(step(&|_, high| high), step(&|low, _| low))], RANGE, None);
        if filled.iter().any(|(_, low, _)| *low < found.wanted) {
            let lower = step(&|low, _| low.min(found.wanted));
            svg.region(&[band(step(&|_, _| found.wanted), lower)], colour::OVER_LIMIT, None);
        }
        svg.polyline(&step(&|low, _| low), Stroke::solid(LEAST, 1.0));
    }

    fn wanted_line(&self, svg: &mut Svg, wanted: f64) {
        let from = self.place(0.0, wanted);
        let to = from + DVec2::new(PANEL.x, 0.0);
        svg.line(from, to, Stroke::dashed(colour::INK, 1.3));
        svg.text(to + DVec2::new(6.0, -2.0), Anchor::Start, 12.0, "wanted");
        svg.text(to + DVec2::new(6.0, 12.0), Anchor::Start, 12.0, &format!("{wanted:.3}"));
    }

    /// A small triangle under the smallest distance.
    fn mark(&self, svg: &mut Svg, time: f64, distance: f64) {
        let tip = self.place(time, distance) + DVec2::new(0.0, 1.5);
        let wing = DVec2::new(4.0, 7.0);
        svg.region(&[vec![tip, tip + wing, tip + DVec2::new(-wing.x, wing.y)]], colour::INK, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(distance: Vec<f64>) -> Clearances {
        let time = (0..distance.len()).map(|i| i as f64).collect();
        Clearances { time, distance, wanted: 0.1, beyond: 1.0 }
    }

    #[test]
    fn what_is_too_near_is_set_off() {
        let over = colour::OVER_LIMIT.hex();
        let count = |distance| clearance_chart(&found(distance)).matches(&over).count();
        assert_eq!(count(vec![1.0, 0.3, 0.1, 0.5]), 1);
        assert_eq!(count(vec![1.0, 0.3, 0.099, 0.5]), 2);
        assert_eq!(count(vec![1.0, -3.0, 0.5]), 2);
    }

    #[test]
    fn the_smallest_is_named() {
        let text = clearance_chart(&found(vec![1.0, 0.3, 0.096, 0.5]));
        assert!(text.contains("smallest 0.096 mm at 0:02.0, wanted 0.100 mm"), "{text}");
        assert!(clearance_chart(&found(vec![1.0; 3])).contains("never nearer than 1 mm"));
    }

    #[test]
    fn no_distances_are_drawn() {
        let text = clearance_chart(&Clearances::default());
        assert!(text.ends_with("</svg>\n") && !text.contains("NaN") && !text.contains("inf"));
    }
}
