//! Passes over material that the path left although the cutter can reach it.
//!
//! A flat or bull end that stands at an angle to the surface touches with its edge, and its body lies beside the
//! contact: it may stay outside of the innermost ring of a dome and leave the summit uncut. What the material columns
//! show as left is grouped into *clusters*; each gets straight passes along its longest direction, one per side step
//! of its width, that begin and end beyond it.

use crate::flat_path::{FlatPoint, Terrain};
use crate::geometry::DVec2;
use crate::toolpath::MoveKind;
use std::collections::BTreeMap;

/// Greatest number of clusters that get passes, largest first: each costs a retract. On a mesh whose facets are
/// coarser than the requested cusps there would be no end of them; what stays is reported.
const MOST_CLUSTERS: usize = 60;
/// Fraction of a side step between passes over a cluster.
const STEP: f64 = 0.7;
/// Attempts to pull the end of a pass back to where the cutter may be.
const TRIES: usize = 24;

/// What the passes depend on.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RestPassOptions {
    /// Side step on the surface, mm.
    pub side_step: f64,
    /// How far passes go beyond a cluster, mm: half a side step, and the width of the cutter's flat bottom,
    /// which may stand beside the contact.
    pub beyond: f64,
    /// Height from which the cutter comes down, mm.
    pub height: f64,
    /// Feed on the surface, mm/s.
    pub feed: f64,
    /// Index of the first pass.
    pub first_pass: u32,
    /// Index of the region to which they are assigned.
    pub region: u32,
}

/// A straight flat pass.
struct Pass {
    from: DVec2,
    to: DVec2,
}

/// Flat moves over the places that are left; empty where the cutter may not go.
pub fn rest_passes(
    left: &[DVec2],
    terrain: &dyn Terrain,
    options: &RestPassOptions,
) -> Vec<FlatPoint> {
    let mut points = Vec::new();
    let mut pass = options.first_pass;
    for cluster in clusters(left, terrain, options.side_step) {
        for Pass { from, to } in passes(&cluster, terrain, options) {
            let point = |at, height, kind| FlatPoint {
                at,
                height,
                kind,
                pass,
                region: options.region,
                feed: options.feed,
                mrr: 0.0,
                alpha: 0.0,
                length: 0.0,
                heading: None,
                overrun: 0.0,
            };
            points.push(point(from, options.height, MoveKind::Rapid));
            points.push(point(from, 0.0, MoveKind::Link));
            points.push(point(to, 0.0, MoveKind::Cut));
            pass += 1;
        }
    }
    points
}

/// Places that lie together, the largest cluster first.
fn clusters(left: &[DVec2], terrain: &dyn Terrain, side_step: f64) -> Vec<Vec<DVec2>> {
    let Some(scale) = left.iter().find_map(|&p| terrain.scale(p)) else { return Vec::new() };
    let cell = side_step / scale;
    let mut cells: BTreeMap<[i64; 2], Vec<DVec2>> = BTreeMap::new();
    for &p in left {
        let key = (p / cell).floor();
        cells.entry([key.x as i64, key.y as i64]).or_default().push(p);
    }
    let mut clusters = Vec::new();
    while let Some((first, points)) = cells.pop_first() {
        let (mut cluster, mut open) = (points, vec![first]);
        while let Some([x, y]) = open.pop() {
            for key in (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j])) {
                if let Some(points) = cells.remove(&key) {
                    cluster.extend(points);
                    open.push(key);
                }
            }
        }
        clusters.push(cluster);
    }
    // Stable: equal clusters stay in the order of their cells.
    clusters.sort_by_key(|cluster| core::cmp::Reverse(cluster.len()));
    clusters.truncate(MOST_CLUSTERS);
    clusters
}

/// Straight passes that cover a cluster.
fn passes(cluster: &[DVec2], terrain: &dyn Terrain, options: &RestPassOptions) -> Vec<Pass> {
    let middle = cluster.iter().sum::<DVec2>() / cluster.len() as f64;
    let Some(scale) = terrain.scale(middle) else { return Vec::new() };
    let along = longest_direction(cluster, middle);
    let across = along.perp();
    let extent = |d: DVec2| {
        let places = cluster.iter().map(|p| (*p - middle).dot(d));
        places.fold((0.0f64, 0.0f64), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (first, last) = extent(along);
    let (low, high) = extent(across);
    let step = STEP * options.side_step / scale;
    let count = ((high - low) / step).ceil().max(1.0);
    let beyond = options.beyond / scale;
    let line = |i: usize| {
        let offset = low + (high - low) * (i as f64 + 0.5) / count;
        let on = |x: f64| middle + across * offset + along * x;
        let (from, to) =
            (reach(terrain, on(0.5 * (first + last)), on(first - beyond))?, on(last + beyond));
        let to = reach(terrain, on(0.5 * (first + last)), to)?;
        let joined = terrain.joins(from, to) && from != to;
        joined.then_some(if i.is_multiple_of(2) {
            Pass { from, to }
        } else {
            Pass { from: to, to: from }
        })
    };
    (0..count as usize).filter_map(line).collect()
}

/// `to`, or the farthest place toward it from `from` at which the cutter may be.
fn reach(terrain: &dyn Terrain, from: DVec2, to: DVec2) -> Option<DVec2> {
    let allowed = |p: DVec2| terrain.room(p).is_some_and(|room| room >= 0.0);
    let part = |i: usize| from.lerp(to, 1.0 - i as f64 / TRIES as f64);
    (0..=TRIES).map(part).find(|&p| allowed(p))
}

/// Unit direction of the largest spread.
fn longest_direction(cluster: &[DVec2], middle: DVec2) -> DVec2 {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in cluster {
        let d = *p - middle;
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
    }
    let half = 0.5 * (xx - yy);
    let largest = 0.5 * (xx + yy) + (half * half + xy * xy).sqrt();
    // The longer of two forms of the eigenvector.
    let (a, b) = (DVec2::new(largest - yy, xy), DVec2::new(xy, largest - xx));
    let longer = if a.length_squared() >= b.length_squared() { a } else { b };
    longer.try_normalize().unwrap_or(DVec2::X)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit scale everywhere within 50 mm of the origin.
    struct Plane;

    impl Terrain for Plane {
        fn scale(&self, _: DVec2) -> Option<f64> {
            Some(1.0)
        }
        fn room(&self, at: DVec2) -> Option<f64> {
            Some(50.0 - at.length())
        }
        fn joins(&self, _: DVec2, _: DVec2) -> bool {
            true
        }
    }

    const OPTIONS: RestPassOptions = RestPassOptions {
        side_step: 1.0,
        beyond: 5.0,
        height: 0.5,
        feed: 20.0,
        first_pass: 7,
        region: 0,
    };

    #[test]
    fn a_cluster_is_passed_along_its_length() {
        let left: Vec<DVec2> =
            (0..100).map(|i| DVec2::new(0.1 * f64::from(i), 0.05 * f64::from(i % 5))).collect();
        let points = rest_passes(&left, &Plane, &OPTIONS);
        assert_eq!(points.len(), 3);
        assert_eq!(
            points.iter().map(|p| p.kind).collect::<Vec<_>>(),
            [MoveKind::Rapid, MoveKind::Link, MoveKind::Cut]
        );
        let (from, to) = (points[1].at, points[2].at);
        assert!((from.distance(to) - 19.9).abs() < 0.2, "{from} {to}");
        assert!(points.iter().all(|p| p.pass == 7));
    }

    #[test]
    fn clusters_apart_get_passes_of_their_own_and_stay_in_the_region() {
        let spot = |at: DVec2| (0..9).map(move |i| at + DVec2::splat(0.02 * f64::from(i)));
        let left: Vec<DVec2> = spot(DVec2::ZERO).chain(spot(DVec2::new(47.0, 0.0))).collect();
        let points = rest_passes(&left, &Plane, &OPTIONS);
        assert_eq!(points.len(), 6);
        assert!(points.iter().all(|p| p.at.length() <= 50.0));
        assert!(rest_passes(&[], &Plane, &OPTIONS).is_empty());
    }
}
