//! The cheapest branch that closes a cluster of gaps.

use super::branch::{Anchor, AnchoredBranch, closed};
use super::cluster::Cluster;
use super::gaps::Place;
use super::passes::Passes;
use super::tree::Tree;
use crate::flat_path::Terrain;
use crate::geometry::DVec2;
use crate::geometry::polyline::simplify_open;
use crate::job::RingOrder;
use crate::level_set::strip_metric::FlatMetric;
use core::slice::from_ref;

/// Places of a cluster are brought this near to a pass. Smaller: branches get longer; larger: the surface between the
/// middles of the places is left too far away.
const AIM: f64 = 0.495;
/// A ring this much farther from a place than the nearest one still counts as beside it, passes.
const BESIDE: f64 = 0.5;
/// The outward and return legs of a long branch lie this fraction of the gap to either side of its middle line: then
/// ring, leg, leg and ring are evenly spaced.
const SPREAD: f64 = 1.0 / 3.0;
/// A long branch may deviate this much from the middle of its cluster, passes.
const STRAIGHTENED: f64 = 0.05;
/// A long branch ends at most this far before its cluster does, passes.
const LONGEST_TRIM: f64 = 0.6;
/// Halvings of a length that is sought.
const HALVINGS: usize = 10;
/// Distance of the points at which a branch is checked to stay inside, passes.
const PROBE: f64 = 0.1;
/// Passes that a branch may run outside of ring 0, to allow for the inaccuracy of the field between vertices.
const ROOM_SLACK: f64 = 0.02;

/// What the choice of a branch depends on.
pub struct Chooser<'a> {
    /// The passes so far.
    pub passes: &'a Passes,
    /// Where a branch may run.
    pub terrain: &'a dyn Terrain,
    /// Order of the rings: branches leave from the ring that is cut later, into cleared stock.
    pub order: RingOrder,
    /// Whether the cutter machines beside the ends of branches, but not beyond them.
    pub lags: bool,
}

impl Chooser<'_> {
    /// The branch for a cluster; `None` where none stays inside.
    pub fn branch(&self, cluster: &Cluster) -> Option<AnchoredBranch> {
        let deepest = cluster.deepest();
        let beside = deepest.gap + BESIDE;
        let is_core = self.passes.nearest(deepest, beside, |level| level > deepest.level).is_none();
        let found = self.straight(cluster).or_else(|| self.along(cluster));
        found.map(|(anchor, points)| AnchoredBranch { anchor, points, is_core })
    }

    /// The nearest point of a pass from which a branch may leave for that place.
    fn anchor(&self, place: &Place) -> Option<Anchor> {
        let later = |level: f64| (level > place.level) == (self.order == RingOrder::OutsideIn);
        self.passes
            .nearest(place, place.gap + BESIDE, later)
            .or_else(|| self.passes.nearest(place, f64::INFINITY, |_| true))
    }

    /// Straight from the nearest point through the widest gap, as short as possible while closing the cluster.
    fn straight(&self, cluster: &Cluster) -> Option<(Anchor, Vec<DVec2>)> {
        let deepest = cluster.deepest();
        let anchor = self.anchor(deepest)?;
        let way = deepest.at - anchor.at;
        let closes = |t: f64| {
            let near = |p: &Place| p.metric.nearest_on(p.at, anchor.at, anchor.at + way * t).0;
            cluster.places().all(|p| near(p) <= AIM)
        };
        let along = |p: &Place| (p.at - anchor.at).dot(way) / way.length_squared();
        let longest = cluster.places().map(along).fold(0.0, f64::max);
        if !closes(longest) {
            return None;
        }
        let t = least(longest, closes);
        let tip = anchor.at + way * t;
        self.is_inside(&[anchor.at, tip], deepest).then(|| (anchor, vec![tip]))
    }

    /// Along the middle of the cluster: round it where it is closed, else to both ends and back.
    fn along(&self, cluster: &Cluster) -> Option<(Anchor, Vec<DVec2>)> {
        let line = cluster.middle_line();
        let round = second_way(cluster, &line).and_then(|back| self.round(cluster, &line, &back));
        round.or_else(|| self.out_and_back(cluster, &line))
    }

    fn out_and_back(&self, cluster: &Cluster, line: &[u32]) -> Option<(Anchor, Vec<DVec2>)> {
        let (anchor, split) = self.nearest_of(cluster, line)?;
        let points = cluster.points(line);
        let arms = [points[..=split].iter().rev().copied().collect(), points[split..].to_vec()];
        let straight = straightened(arms.clone(), cluster);
        // Along a boundary that bends a straight way may lead outside.
        let out = self.there_and_back(&anchor, straight, cluster);
        let out = out.or_else(|| self.there_and_back(&anchor, arms, cluster))?;
        Some((anchor, out))
    }

    /// Along both arms of a cluster's middle line, trimmed, and back.
    fn there_and_back(
        &self,
        anchor: &Anchor,
        mut arms: [Vec<DVec2>; 2],
        cluster: &Cluster,
    ) -> Option<Vec<DVec2>> {
        if !self.lags {
            trim(&mut arms, 0, cluster);
            trim(&mut arms, 1, cluster);
        }
        let gaps = Gaps::of(cluster);
        let spread = |at: DVec2, across: DVec2| SPREAD * gaps.across(at, across);
        let narrow: Vec<DVec2> = arms.iter().flat_map(|arm| hairpin(arm, |_, _| 0.0)).collect();
        let wide: Vec<DVec2> = arms.iter().flat_map(|arm| hairpin(arm, spread)).collect();
        let is_inside = |line: &[DVec2]| self.is_inside(&closed(anchor, line), cluster.deepest());
        let left = |line: &Vec<DVec2>| count_uncovered(from_ref(line), cluster);
        let mut out = if left(&wide) <= left(&narrow) && is_inside(&wide) { wide } else { narrow };
        out.dedup();
        is_inside(&out).then_some(out)
    }

    /// Once round a cluster that is closed in itself.
    fn round(&self, cluster: &Cluster, out: &[u32], back: &[u32]) -> Option<(Anchor, Vec<DVec2>)> {
        let mut line: Vec<u32> = out.iter().chain(&back[1..]).copied().collect();
        line.pop();
        let (anchor, from) = self.nearest_of(cluster, &line)?;
        line.rotate_left(from);
        line.push(line[0]);
        let raw = cluster.points(&line);
        let deepest = cluster.deepest();
        // A closed line in two halves: both have ends that stay.
        let (first, second) = (&raw[..=raw.len() / 2], &raw[raw.len() / 2..]);
        let tolerance = STRAIGHTENED / deepest.metric.mean();
        let mut points = simplify_open(first, tolerance);
        points.extend(simplify_open(second, tolerance).into_iter().skip(1));
        self.is_inside(&closed(&anchor, &points), deepest).then_some((anchor, points))
    }

    /// The member of a line that is nearest to where a branch may leave, and that anchor.
    fn nearest_of(&self, cluster: &Cluster, line: &[u32]) -> Option<(Anchor, usize)> {
        let anchors = line.iter().enumerate().filter_map(|(i, &m)| {
            let anchor = self.anchor(cluster.member(m))?;
            Some((anchor, i))
        });
        anchors.min_by(|a, b| a.0.distance.total_cmp(&b.0.distance).then(a.1.cmp(&b.1)))
    }

    /// Whether a polyline stays in the chart and inside of ring 0.
    fn is_inside(&self, line: &[DVec2], near: &Place) -> bool {
        line.windows(2).all(|w| {
            let way = w[1] - w[0];
            let steps = (near.metric.length(way) / PROBE).ceil().clamp(1.0, 1e4) as usize;
            self.terrain.joins(w[0], w[1])
                && (1..=steps).all(|i| {
                    let room = self.terrain.room(w[0] + way * (i as f64 / steps as f64));
                    room.is_some_and(|room| room >= -ROOM_SLACK)
                })
        })
    }
}

/// Out along an arm and back on separate legs: at each point offset by `spread` to either side, flat mm, along the
/// unit direction across.
fn hairpin(arm: &[DVec2], spread: impl Fn(DVec2, DVec2) -> f64) -> Vec<DVec2> {
    if arm.len() < 2 {
        return arm.to_vec();
    }
    let aside = |i: usize| {
        let (before, after) = (arm[i.saturating_sub(1)], arm[(i + 1).min(arm.len() - 1)]);
        let across = (after - before).perp().normalize_or_zero();
        across * spread(arm[i], across)
    };
    let sides: Vec<DVec2> = (0..arm.len()).map(aside).collect();
    let out = (0..arm.len()).map(|i| arm[i] + sides[i]);
    let back = (0..arm.len()).rev().map(|i| arm[i] - sides[i]);
    out.chain(back).collect()
}

/// The gaps of a cluster's places, found by nearness in the plane.
struct Gaps<'a> {
    places: Vec<&'a Place>,
    tree: Tree,
}

impl<'a> Gaps<'a> {
    fn of(cluster: &'a Cluster) -> Self {
        let places: Vec<&Place> = cluster.places().collect();
        let points: Vec<[DVec2; 2]> = places.iter().map(|p| [p.at, p.at]).collect();
        Self { places, tree: Tree::new(&points) }
    }

    /// Gap of the place nearest to `at`, as a flat length in the unit direction `across`.
    fn across(&self, at: DVec2, across: DVec2) -> f64 {
        let plain = FlatMetric { xx: 1.0, xy: 0.0, yy: 1.0 };
        let nearest = self.tree.nearest(&plain, at, f64::INFINITY, |_| true);
        let place = nearest.map(|hit| self.places[hit.id as usize]);
        place.map_or(0.0, |p| p.gap / p.metric.length(across).max(f64::MIN_POSITIVE))
    }
}

/// The least length, up to `longest`, at which `holds` is true, given that it is true at `longest` and beyond.
fn least(longest: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, longest);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// For every place whether it is farther from all lines than the target.
fn uncovered<'a>(
    lines: &[Vec<DVec2>],
    places: impl Iterator<Item = &'a Place>,
) -> impl Iterator<Item = bool> {
    let tree = Tree::of_polylines(lines);
    places.map(move |p| tree.nearest(&p.metric, p.at, AIM, |_| true).is_none())
}

fn count_uncovered(lines: &[Vec<DVec2>], cluster: &Cluster) -> usize {
    uncovered(lines, cluster.places()).filter(|is_left| *is_left).count()
}

/// A second route between the ends of a cluster's middle line, where the cluster is closed in itself.
fn second_way(cluster: &Cluster, line: &[u32]) -> Option<Vec<u32>> {
    let points = cluster.points(line);
    let left: Vec<bool> = uncovered(from_ref(&points), cluster.places()).collect();
    if !left.contains(&true) {
        return None;
    }
    let ends = [points[0], points[points.len() - 1]];
    let is_at_end = |p: &Place| ends.iter().any(|e| p.metric.length(p.at - *e) <= LONGEST_TRIM);
    let allowed: Vec<bool> =
        cluster.places().zip(&left).map(|(p, is_left)| *is_left || is_at_end(p)).collect();
    cluster.way_round(line, &allowed)
}

/// Arms with fewer points, unless that leaves more places farther away than the target.
fn straightened(arms: [Vec<DVec2>; 2], cluster: &Cluster) -> [Vec<DVec2>; 2] {
    let tolerance = STRAIGHTENED / cluster.deepest().metric.mean();
    let fewer = arms.clone().map(|arm| simplify_open(&arm, tolerance));
    let is_enough = count_uncovered(&fewer, cluster) <= count_uncovered(&arms, cluster);
    if is_enough { fewer } else { arms }
}

/// Shortens an arm at its end as long as nothing is left farther away than the target.
fn trim(arms: &mut [Vec<DVec2>; 2], which: usize, cluster: &Cluster) {
    let end = arms[which][arms[which].len() - 1];
    let per_pass = 1.0 / cluster.deepest().metric.mean();
    let whole: f64 = arms[which].windows(2).map(|w| (w[1] - w[0]).length()).sum();
    let most = (LONGEST_TRIM * per_pass).min(whole);
    let near_end = |p: &&Place| p.metric.length(p.at - end) <= LONGEST_TRIM + 1.0;
    // What lies beside the rest anyway is not asked again.
    let rest = [arms[1 - which].clone(), shortened(&arms[which], most)];
    let near: Vec<&Place> = cluster.places().filter(near_end).collect();
    let beyond_rest = uncovered(&rest, near.iter().copied());
    let at_stake = near.iter().copied().zip(beyond_rest).filter(|(_, is_left)| *is_left);
    let from = rest[1].len().saturating_sub(2);
    let covers = |line: &[DVec2], p: &Place| {
        let near = |w: &[DVec2]| p.metric.nearest_on(p.at, w[0], w[1]).0 < AIM;
        line[from..].windows(2).any(near)
    };
    let at_stake: Vec<&Place> =
        at_stake.map(|(p, _)| p).filter(|p| covers(&arms[which], p)).collect();
    let kept = least(most, |kept| {
        let line = shortened(&arms[which], most - kept);
        at_stake.iter().all(|p| covers(&line, p))
    });
    arms[which] = shortened(&arms[which], most - kept);
}

/// A polyline without the last `cut` mm of it.
fn shortened(line: &[DVec2], mut cut: f64) -> Vec<DVec2> {
    let mut out = line.to_vec();
    while out.len() > 1 {
        let (last, before) = (out[out.len() - 1], out[out.len() - 2]);
        let length = (last - before).length();
        if length > cut {
            let n = out.len();
            out[n - 1] = last.lerp(before, cut / length);
            break;
        }
        cut -= length;
        out.pop();
    }
    out
}
