//! Branches: they keep every place within half a pass of the nearest pass.
//!
//! Rings one pass apart leave no place farther away than half a pass, except where fronts meet: at a ridge of the
//! field the rings have corners, and the places between two corners of inner angle `a` are up to `1 / (1 + sin(a/2))`
//! passes away, 0.59 at a right angle and 0.79 at 30 degrees; between the last rings it is up to a whole pass. The
//! cusp height grows with the square of this distance.
//!
//! - *Gap*: distance of a place from the nearest pass, in passes of the strip metric there.
//! - *Cluster*: connected places whose gap is above the limit.
//! - *Branch*: a detour of a ring, out to a cluster and back. It leaves from the ring that is cut later, so that it
//!   runs into cleared stock.
//!
//! 1. Places near ridges are measured against all rings.
//! 2. Every cluster gets the shortest straight branch from the nearest ring that closes it, or, where none does, one
//!    along its middle line: to both ends and back, or once round a closed cluster.
//! 3. The gaps are measured again, until none is left or the rounds are used up.
//!
//! A cluster is left open where the cusp over it is not above what may be left ([`ClosingOptions::accepted`]): on a coarse mesh
//! every edge would else get branches of a few hundredths of a millimetre, each with two turns back.

mod branch;
mod chooser;
mod cluster;
mod gaps;
mod options;
mod passes;
mod tree;

use super::field::PassField;
use super::passes::Pass;
use super::refine::PassMesh;
use crate::flat_path::Terrain;
use crate::geometry::DVec2;
use crate::mesh::FaceId;
use branch::{AnchoredBranch, closed};
use chooser::Chooser;
use cluster::Clusters;
pub use gaps::Place as Gap;
use gaps::{Place, gaps};
pub use options::ClosingOptions;
use passes::Passes;
use tree::Tree;

/// With more places than this, gaps are reported and not closed: such passes do not fit the surface.
const MOST_PLACES: usize = 4_000_000;
/// Rounds of closing and measuring. More rounds close the gaps that branches themselves leave.
const ROUNDS: usize = 6;

/// What was closed and what is left open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosingReport {
    /// Number of branches.
    pub branches: usize,
    /// How many of them close a core, which has no ring inside it.
    pub cores: usize,
    /// Length of the branches on the surface, out and back, mm.
    pub length: f64,
    /// Largest distance of a place from the nearest pass, passes.
    pub widest_gap: f64,
    /// Where that is, flat mm.
    pub widest_at: DVec2,
    /// Area on the surface that is farther from the nearest pass than is accepted, mm².
    pub left: f64,
}

impl ClosingReport {
    /// The sum over several regions.
    pub fn joined(reports: impl IntoIterator<Item = Self>) -> Self {
        let add = |sum: Self, next: Self| {
            let widest = if next.widest_gap > sum.widest_gap { next.clone() } else { sum.clone() };
            Self {
                branches: sum.branches + next.branches,
                cores: sum.cores + next.cores,
                length: sum.length + next.length,
                left: sum.left + next.left,
                ..widest
            }
        };
        reports.into_iter().fold(Self::default(), add)
    }
}

/// The places farther than half a pass from all of the given flat segments, where the field shows that neighbouring
/// passes may not be near.
pub fn uncovered(
    mesh: &PassMesh,
    field: &PassField,
    lines: &[[DVec2; 2]],
    options: &ClosingOptions,
) -> Vec<Gap> {
    gaps(mesh, field, &Tree::new(lines), options).places
}

/// Adds to the rings the branches that close the gaps between them.
pub fn close(
    rings: &mut [Pass],
    mesh: &PassMesh,
    field: &PassField,
    terrain: &dyn Terrain,
    options: &ClosingOptions,
) -> ClosingReport {
    let mut passes = Passes::new(rings, options, mean_pass(mesh));
    let found = gaps(mesh, field, passes.without_branches(), options);
    let mut places = found.places;
    if places.len() > MOST_PLACES {
        return report(&passes, &places, found.widest_kept, terrain, options);
    }
    for _ in 0..ROUNDS {
        let chooser = Chooser {
            passes: &passes,
            terrain,
            order: options.order,
            lags: options.footprint.lags(),
        };
        let clusters = Clusters::of(&places);
        let wide = clusters.iter().filter(|b| b.deepest().gap > options.accepted());
        let branches: Vec<AnchoredBranch> = wide.filter_map(|b| chooser.branch(&b)).collect();
        if branches.is_empty() {
            break;
        }
        lower(&mut places, passes.add(branches));
    }
    passes.attach(rings);
    report(&passes, &places, found.widest_kept, terrain, options)
}

/// Mean size of a pass, flat mm.
fn mean_pass(mesh: &PassMesh) -> f64 {
    let (mut flat, mut passes) = (0.0, 0.0);
    for (f, face) in mesh.connectivity().faces().iter().enumerate() {
        let [a, b, c] = face.map(|v| mesh.uv()[v.index()]);
        let area = (b - a).perp_dot(c - a).abs();
        if let Some(metric) = mesh.flat_metric(FaceId(f as u32)) {
            flat += area;
            passes += area * metric.mean() * metric.mean();
        }
    }
    if passes > 0.0 { (flat / passes).sqrt() } else { 1.0 }
}

/// Lowers the gaps by new branches and drops the places that are within the limit.
fn lower(places: &mut Vec<Place>, branches: &Tree) {
    for place in places.iter_mut() {
        if let Some(hit) = branches.nearest(&place.metric, place.at, place.gap, |_| true) {
            place.gap = hit.distance;
        }
    }
    places.retain(|p| p.gap > gaps::LIMIT);
}

fn report(
    passes: &Passes,
    places: &[Place],
    widest_kept: (f64, DVec2),
    terrain: &dyn Terrain,
    options: &ClosingOptions,
) -> ClosingReport {
    let scale = |p: DVec2| terrain.scale(p).unwrap_or(1.0);
    let on_surface = |d: &AnchoredBranch| {
        let line = closed(&d.anchor, &d.points);
        line.windows(2).map(|w| (w[1] - w[0]).length() * scale(0.5 * (w[0] + w[1]))).sum::<f64>()
    };
    let widest =
        places.iter().fold(widest_kept, |w, p| if p.gap > w.0 { (p.gap, p.at) } else { w });
    let left = places.iter().filter(|p| p.gap > options.accepted());
    let area = |p: &Place| p.area * scale(p.at) * scale(p.at);
    ClosingReport {
        branches: passes.branches().len(),
        cores: passes.branches().iter().filter(|d| d.is_core).count(),
        length: passes.branches().iter().map(on_surface).fold(0.0, |sum, l| sum + l),
        widest_gap: widest.0,
        widest_at: widest.1,
        left: left.map(area).fold(0.0, |sum, a| sum + a),
    }
}

#[cfg(test)]
mod tests;
