//! Removed volumes → the removal rate of every move, and feeds that keep it to the limit.
//!
//! Terms. A *window* is a stretch of travel of `WINDOW` cutter radii: single columns are noise, the volume of a
//! window is the cut. Steps: (1) volume per millimetre of every piece, as the largest mean over the windows that
//! contain a part of it, and over some longer ones. (2) The feed that keeps this to the limit, from a ladder below
//! the nominal feed. (3) The rate of every piece, as the mean over the window around it. (4) Neighbouring pieces of a
//! move with one feed and nearly one rate are joined.

use super::sweep::{Piece, Removed};
use crate::geometry::DVec3;
use crate::load::{BESIDE_LINKS, LoadLimits, SLOWED_BESIDE};
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use std::ops::Range;

/// Length of a window, cutter radii. Longer: peaks are flattened; shorter: noise of the columns.
const WINDOW: f64 = BESIDE_LINKS;
/// Feeds keep windows of these lengths to the limit, in [`WINDOW`]s: where the cut comes in pulses, a longer window
/// may contain more of them per length. A window of twice this length or more is nearly made up of these.
const LENGTHS: [f64; 3] = [1.0, 4.0 / 3.0, 5.0 / 3.0];
/// Reduced feeds come from the ladder `nominal * RUNG^n`, so that the program is not full of feed
/// words. Smaller: fewer words, more time lost.
const RUNG: f64 = 0.97;
/// Feeds aim at this fraction of the limits: another simulation, with other samples and windows, finds up to a
/// hundredth more.
const AIM: f64 = 0.98;
/// Pieces whose rates differ by less than this fraction of the limit are joined.
const SAME: f64 = 0.05;
/// Pieces of a move shorter than this many cutter radii are joined.
const SHORTEST: f64 = 0.1;

/// Feeds come as close as this to the fastest that keeps the limits.
pub const CLOSEST: f64 = RUNG * AIM;

/// Part of a limit on section or feed per tooth that rounding may take.
const PLAY: f64 = 0.005;

/// The limits and the feeds to start from.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Limit {
    /// Limits on the cut.
    pub load: LoadLimits,
    /// Nominal feed on the surface, mm/s.
    pub feed: f64,
    /// Nominal feed of trochoid returns, mm/s.
    pub return_feed: f64,
    /// Moves slower than this fraction of the feed on the surface, or of a lower one of their own, are not planned.
    pub slowest: f64,
}

impl Limit {
    /// The slowest feed of a move with this nominal feed, mm/s.
    fn least(&self, nominal: f64) -> f64 {
        self.slowest * self.feed.min(nominal)
    }
}

/// A place where the limit would take too slow a feed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TooSlow {
    /// The tip there, mm.
    pub place: DVec3,
    /// Rate at the nominal feed, mm³/s.
    pub rate: f64,
    /// Rate that the limits leave there, mm³/s.
    pub left: f64,
    /// The feed it would take, mm/s.
    pub feed: f64,
}

/// What determines the feeds.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Feeds {
    /// Those of the path; but links and plunges keep to the limit as far as they can.
    LinksLimited(Limit),
    /// The limit.
    Limited(Limit),
}

/// The path with the removal rate of every move, and with feeds.
///
/// Moves in which rate or feed changes are split; new points lie on the straight move.
/// `radius`: of the cutter, mm.
///
/// # Errors
/// [`TooSlow`] at the place that must be slowed most, where that is slower than allowed.
pub fn rated(
    path: &Toolpath,
    removed: &Removed,
    feeds: Feeds,
    radius: f64,
) -> Result<Toolpath, TooSlow> {
    let (Feeds::LinksLimited(limit) | Feeds::Limited(limit)) = feeds;
    let nominal = nominal_feeds(path, removed, feeds);
    let travel = running(removed.pieces.iter().map(|p| p.length));
    let runs = runs(path, removed);
    let per_mm = LENGTHS
        .map(|length| worst_windows(&removed.pieces, &travel, &runs, length * WINDOW * radius))
        .into_iter()
        .reduce(|a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect())
        .unwrap_or_default();
    if matches!(feeds, Feeds::Limited(_)) {
        refuse_too_slow(path, removed, &per_mm, &nominal, limit)?;
    }
    let followed = follow_limit(path, removed, feeds);
    let feed: Vec<f64> = (0..nominal.len())
        .map(|i| if followed[i] { on_ladder(nominal[i], per_mm[i], limit) } else { nominal[i] })
        .collect();
    let rate = window_rates(&removed.pieces, &travel, &feed, &runs, WINDOW * radius);
    let full = limit.load.at_full_feed(limit.feed).min(limit.load.teeth.slot());
    let same = SAME * full * limit.feed;
    let mut out = Toolpath { points: Vec::with_capacity(path.points.len()) };
    out.points.extend(path.points.first());
    for i in 1..path.points.len() {
        let range = removed.first[i]..removed.first[i + 1];
        let joined = join(removed.of_move(i), &feed[range.clone()], &rate[range], same, radius);
        for piece in joined {
            out.points.push(point_on(&path.points[i - 1], &path.points[i], &piece));
        }
    }
    Ok(out)
}

/// The pieces between rapids: a window ends where the cutter leaves the material.
fn runs(path: &Toolpath, removed: &Removed) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = 0;
    for (i, _) in path.points.iter().enumerate().filter(|p| p.1.kind == MoveKind::Rapid) {
        runs.push(start..removed.first[i]);
        start = removed.first[i + 1];
    }
    runs.push(start..removed.pieces.len());
    runs.retain(|run| !run.is_empty());
    runs
}

/// Cumulative sums, one more than there are values.
fn running(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    let sums = values.map(|v| {
        sum += v;
        sum
    });
    core::iter::once(0.0).chain(sums).collect()
}

/// The feed of every piece as it would be without a limit.
fn nominal_feeds(path: &Toolpath, removed: &Removed, feeds: Feeds) -> Vec<f64> {
    let mut out = Vec::with_capacity(removed.pieces.len());
    for (i, p) in path.points.iter().enumerate().skip(1) {
        let feed = match (feeds, p.kind, p.flat) {
            (_, MoveKind::Rapid, _) | (_, _, None) => p.feed,
            (Feeds::Limited(limit), MoveKind::Return, _) => limit.return_feed,
            (Feeds::Limited(limit), ..) => limit.feed,
            _ => p.feed,
        };
        out.extend(core::iter::repeat_n(feed, removed.of_move(i).len()));
    }
    out
}

/// Whether each piece may be slowed to keep to the limit.
fn follow_limit(path: &Toolpath, removed: &Removed, feeds: Feeds) -> Vec<bool> {
    let mut out = Vec::with_capacity(removed.pieces.len());
    for (i, p) in path.points.iter().enumerate().skip(1) {
        let follows = match feeds {
            Feeds::LinksLimited(_) => p.kind == MoveKind::Link,
            Feeds::Limited(_) => p.kind != MoveKind::Rapid,
        };
        out.extend(core::iter::repeat_n(follows, removed.of_move(i).len()));
    }
    out
}

/// The integral of a quantity, given by its cumulative sums at the ends of pieces, up to a distance travelled.
struct Integral<'a> {
    travel: &'a [f64],
    sums: Vec<f64>,
}

impl Integral<'_> {
    /// Up to `at`, which lies in piece `i`.
    fn up_to(&self, at: f64, i: usize) -> f64 {
        let (a, b) = (self.travel[i], self.travel[i + 1]);
        let part = if b > a { ((at - a) / (b - a)).clamp(0.0, 1.0) } else { 1.0 };
        self.sums[i] + part * (self.sums[i + 1] - self.sums[i])
    }
}

/// For every piece the largest mean volume per mm over the windows that contain a part of it. A run shorter than a
/// window counts as one window.
///
/// Volume over travel is linear between the ends of pieces, so the largest window begins or ends at one of them.
fn worst_windows(pieces: &[Piece], travel: &[f64], runs: &[Range<usize>], window: f64) -> Vec<f64> {
    let volume = Integral { travel, sums: running(pieces.iter().map(|p| p.volume)) };
    let mut worst = vec![0.0f64; pieces.len()];
    let mut raise = |from: usize, to: usize, mean: f64| {
        worst[from..=to].iter_mut().for_each(|w| *w = w.max(mean));
    };
    for run in runs {
        let (begin, total) = (travel[run.start], travel[run.end]);
        let window = window.min(total - begin);
        if window <= 0.0 {
            continue;
        }
        let mut j = run.start;
        for i in run.clone() {
            let end = (travel[i] + window).min(total);
            while j + 1 < run.end && travel[j + 1] < end {
                j += 1;
            }
            let taken = volume.up_to(end, j) - volume.sums[i];
            raise(i, j.max(i), taken / window);
        }
        let mut j = run.start;
        for i in run.clone() {
            let start = (travel[i + 1] - window).max(begin);
            while j < i && travel[j + 1] <= start {
                j += 1;
            }
            let taken = volume.sums[i + 1] - volume.up_to(start, j);
            raise(j, i, taken / window);
        }
    }
    worst
}

/// Mean rate over the window around each piece, mm³/s; over the piece itself if that is longer.
fn window_rates(
    pieces: &[Piece],
    travel: &[f64],
    feed: &[f64],
    runs: &[Range<usize>],
    window: f64,
) -> Vec<f64> {
    let time = |p: (&Piece, &f64)| if p.0.length > 0.0 { p.0.length / p.1 } else { 0.0 };
    let volume = Integral { travel, sums: running(pieces.iter().map(|p| p.volume)) };
    let times = Integral { travel, sums: running(pieces.iter().zip(feed).map(time)) };
    let mut rates = vec![0.0; pieces.len()];
    for run in runs {
        let (begin, total) = (travel[run.start], travel[run.end]);
        let (mut low, mut high) = (run.start, run.start);
        for i in run.clone() {
            let middle = 0.5 * (travel[i] + travel[i + 1]);
            let half = 0.5 * window.max(pieces[i].length);
            let (start, end) = ((middle - half).max(begin), (middle + half).min(total));
            while low < i && travel[low + 1] <= start {
                low += 1;
            }
            while high + 1 < run.end && travel[high + 1] < end {
                high += 1;
            }
            let taken = volume.up_to(end, high) - volume.up_to(start, low);
            let time = times.up_to(end, high) - times.up_to(start, low);
            rates[i] = if taken > 0.0 && time > 0.0 { taken / time } else { 0.0 };
        }
    }
    rates
}

/// The largest rung of the ladder at which `per_mm` mm³ per mm keep to the limits.
fn on_ladder(nominal: f64, per_mm: f64, limit: Limit) -> f64 {
    let mut feed = nominal;
    let highest = limit.load.feed(per_mm) * AIM;
    while feed > highest && feed > limit.least(nominal) {
        feed *= RUNG;
    }
    feed
}

fn refuse_too_slow(
    path: &Toolpath,
    removed: &Removed,
    per_mm: &[f64],
    nominal: &[f64],
    limit: Limit,
) -> Result<(), TooSlow> {
    let part = |i: usize| limit.load.feed(per_mm[i]) / limit.least(nominal[i]);
    let Some(worst) = (0..per_mm.len()).min_by(|&a, &b| part(a).total_cmp(&part(b))) else {
        return Ok(());
    };
    if part(worst) >= 1.0 {
        return Ok(());
    }
    let point = removed.first.partition_point(|&f| f <= worst) - 1;
    Err(TooSlow {
        place: path.points[point.min(path.points.len() - 1)].tip,
        rate: per_mm[worst] * limit.feed.min(nominal[worst]),
        left: per_mm[worst] * limit.load.feed(per_mm[worst]),
        feed: limit.load.feed(per_mm[worst]),
    })
}

/// A place where the cutter is engaged over too large an angle, or goes too slowly.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Beyond {
    /// The tip there, mm.
    pub place: DVec3,
    /// Section of the cut, mm².
    pub section: f64,
    /// The feed there, mm/s.
    pub feed: f64,
    /// By how much the limit is broken, as a factor.
    pub excess: f64,
}

/// For each point of a path whose points tell their rates the factor by which the move to it cuts too thickly or too
/// slowly; `None` where it does not, and for what may: links, ramps, and the passes where these end or begin.
pub fn excesses(path: &Toolpath, load: &LoadLimits) -> Vec<Option<f64>> {
    let most = load.teeth.section(load.most_engaged) * (1.0 + PLAY);
    let least = load.least_per_tooth * load.teeth.rate * (1.0 - PLAY);
    let is_engaged = load.most_engaged < core::f64::consts::PI;
    let radius = load.teeth.radius;
    let excess = |p: &PathPoint, away: f64| {
        let cuts = p.mrr > 0.0 && p.feed > 0.0;
        let by_angle = (is_engaged && away > BESIDE_LINKS * radius).then(|| p.mrr / p.feed / most);
        let by_feed = (away > SLOWED_BESIDE * radius).then(|| least / p.feed);
        let excess = by_angle.into_iter().chain(by_feed).fold(0.0, f64::max);
        (cuts && excess > 1.0).then_some(excess)
    };
    path.points.iter().zip(path.away_from_links()).map(|(p, away)| excess(p, away)).collect()
}

/// Where a path whose points tell their rates cuts too thickly or too slowly, at its worst.
pub fn beyond(path: &Toolpath, load: &LoadLimits) -> Option<Beyond> {
    let excesses = path.points.iter().zip(excesses(path, load));
    let broken = excesses.filter_map(|(p, excess)| Some((p, excess?)));
    let worst = broken.reduce(|a, b| if b.1 > a.1 { b } else { a });
    worst.map(|(p, excess)| Beyond { place: p.tip, section: p.mrr / p.feed, feed: p.feed, excess })
}

/// A part of a move with one feed and one rate.
struct Joined {
    end: f64,
    length: f64,
    feed: f64,
    rate: f64,
    /// Range of the rates joined.
    low: f64,
    high: f64,
}

/// Pieces of a move, joined while the feed is the same and the rates differ little.
fn join(pieces: &[Piece], feed: &[f64], rate: &[f64], same: f64, radius: f64) -> Vec<Joined> {
    let mut out: Vec<Joined> = Vec::new();
    for (p, (&feed, &rate)) in pieces.iter().zip(feed.iter().zip(rate)) {
        match out.last_mut() {
            Some(l)
                if l.feed == feed
                    && (l.high.max(rate) - l.low.min(rate) <= same
                        || l.length + p.length < SHORTEST * radius) =>
            {
                let length = l.length + p.length;
                let part = if length > 0.0 { p.length / length } else { 0.0 };
                l.rate += (rate - l.rate) * part;
                (l.low, l.high) = (l.low.min(rate), l.high.max(rate));
                (l.end, l.length) = (p.end, length);
            }
            _ => {
                out.push(Joined { end: p.end, length: p.length, feed, rate, low: rate, high: rate })
            }
        }
    }
    out
}

/// The point where a part of the move from `a` to `b` ends.
fn point_on(a: &PathPoint, b: &PathPoint, piece: &Joined) -> PathPoint {
    let point = if piece.end < 1.0 { a.toward(b, piece.end) } else { *b };
    PathPoint { feed: piece.feed, mrr: piece.rate, ..point }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::Teeth;

    fn pieces(volumes: &[f64], length: f64) -> Vec<Piece> {
        volumes.iter().map(|&volume| Piece { end: 1.0, length, volume }).collect()
    }

    #[test]
    fn every_window_keeps_to_the_limit_at_the_feeds_that_its_pieces_get() {
        let volumes: Vec<f64> =
            (0..400u32).map(|i| f64::from(i * 7919 % 97) * f64::from(i % 31) / 900.0).collect();
        let all = pieces(&volumes, 0.1);
        let travel = running(all.iter().map(|p| p.length));
        let per_mm = worst_windows(&all, &travel, std::slice::from_ref(&(0..all.len())), 0.75);
        let teeth = Teeth { radius: 5.0, depth: 100.0, edge: 100.0, rate: 1.0, speed: 1.0 };
        let load = LoadLimits {
            teeth,
            rate: 100.0,
            power: None,
            least_per_tooth: 0.0,
            most_engaged: core::f64::consts::PI,
        };
        let limit = Limit { load, feed: 40.0, return_feed: 40.0, slowest: 1e-3 };
        let feed: Vec<f64> = per_mm.iter().map(|&q| on_ladder(40.0, q, limit)).collect();
        let rate = window_rates(&all, &travel, &feed, std::slice::from_ref(&(0..all.len())), 0.75);
        let peak = rate.iter().copied().fold(0.0, f64::max);
        assert!(peak <= 100.0 * AIM && peak > 80.0, "{peak}");
        // At the feeds found, any 1 mm of travel, too.
        for w in 0..390 {
            let volume: f64 = volumes[w..w + 10].iter().sum();
            let time: f64 = feed[w..w + 10].iter().map(|f| 0.1 / f).sum();
            assert!(volume / time <= 101.0);
        }
    }

    #[test]
    fn even_pieces_are_one_and_a_step_splits_a_move() {
        let even = pieces(&[1.0; 6], 0.5);
        assert_eq!(join(&even, &[3.0; 6], &[2.0; 6], 0.1, 5.0).len(), 1);
        let stepped = join(&even, &[3.0; 6], &[2.0, 2.0, 2.0, 5.0, 5.0, 5.0], 0.1, 5.0);
        assert_eq!(stepped.iter().map(|j| j.rate).collect::<Vec<_>>(), [2.0, 5.0]);
    }

    /// A window ends at a rapid: what a short run takes is not spread over the way there.
    #[test]
    fn a_short_run_between_rapids_has_the_rate_of_its_own_length() {
        let all = pieces(&[0.0, 1.0, 1.0, 0.0], 0.2);
        let travel = running(all.iter().map(|p| p.length));
        let per_mm = worst_windows(&all, &travel, std::slice::from_ref(&(1..3)), 0.75);
        assert!(per_mm.iter().zip([0.0, 5.0, 5.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-9));
        let rates = window_rates(&all, &travel, &[2.0; 4], std::slice::from_ref(&(1..3)), 0.75);
        assert!(rates.iter().zip([0.0, 10.0, 10.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    /// Radius 5, half engaged at most, 0.5 mm per tooth at least. Beside the link a slow feed does not count within 1.5 mm
    /// and too thick a cut does not within 0.75 mm; farther away both do, and on links nothing does.
    #[test]
    fn what_breaks_a_bound_is_looked_for_on_passes_away_from_links() {
        let teeth = Teeth { radius: 5.0, depth: 1.0, edge: 1.0, rate: 10.0, speed: 1.0 };
        let load = LoadLimits {
            teeth,
            rate: 1e9,
            power: None,
            least_per_tooth: 0.5,
            most_engaged: 0.5 * core::f64::consts::PI,
        };
        let point = |kind, x: f64, section: f64, feed: f64| PathPoint {
            kind,
            pass: 0,
            region: 0,
            tip: DVec3::new(x, 0.0, 0.0),
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed,
            mrr: section * feed,
            alpha: 0.0,
            time: 0.0,
        };
        use MoveKind::{Cut, Link};
        let moves = [
            (Link, 0.0, 10.0, 1.0, false),
            (Cut, 0.7, 10.0, 1.0, false),
            (Cut, 1.0, 10.0, 10.0, true),
            (Cut, 1.4, 1.0, 1.0, false),
            (Cut, 1.6, 1.0, 1.0, true),
            (Cut, 9.0, 10.0, 10.0, true),
            (Cut, 10.0, 4.9, 5.0, false),
            (Link, 11.0, 10.0, 1.0, false),
        ];
        let points = moves.map(|(kind, x, section, feed, _)| point(kind, x, section, feed));
        let path = Toolpath { points: points.to_vec() };
        let found = excesses(&path, &load).iter().map(Option::is_some).collect::<Vec<_>>();
        assert_eq!(found, moves.map(|m| m.4));
        assert_eq!(beyond(&path, &load).map(|b| b.place.x), Some(1.6), "ten times too slow");
    }
}
