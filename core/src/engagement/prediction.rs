//! What the disc in the plane predicts for a path that was delivered: `MRR2`, `tau` and `MRR3`.
//!
//! 1. The disc moves along the flat images of the contacts, in cutting order, and takes what it has not taken before.
//! 2. Of each pass and loop the mean over the move: `MRR2 = (R / s) alpha (V_fc / s) H` in the plane, `tau = s²`,
//!    `MRR3 = tau MRR2`. Links, plunges and ramps take stock, but the plane does not know how deep they are in it.
//!
//! Source: "Trajectory planning for constant-force milling of freeform surfaces based on conformal mapping",
//! a Chinese patent application: the material removal rate on the surface from that in the plane.

use super::simulation::Simulation;
use crate::toolpath::{MoveKind, Planar, Toolpath};

/// The prediction for each move, named by its end, with the engagement where the rate is largest; `None` for links and
/// rapids, and beside the chart. `simulation` has not begun.
pub fn predicted(path: &Toolpath, mut simulation: Simulation) -> Vec<Option<Planar>> {
    let mut out = vec![None; path.points.len()];
    for (i, p) in path.points.iter().enumerate() {
        let Some(at) = p.flat else { continue };
        let is_on = i > 0 && path.points[i - 1].flat.is_some();
        if !is_on {
            simulation.arrive(at, 0.0, p.kind);
            simulation.plunge();
            continue;
        }
        let made = simulation.points().len();
        simulation.cut(at, p.kind);
        if !matches!(p.kind, MoveKind::Cut | MoveKind::Trochoid | MoveKind::Return) {
            continue;
        }
        let Some(scale) = simulation.terrain.scale(at) else { continue };
        let pieces = &simulation.points()[made..];
        let length: f64 = pieces.iter().map(|piece| piece.length).sum();
        if length <= 0.0 {
            continue;
        }
        let rate = pieces.iter().map(|piece| piece.mrr * piece.length).sum::<f64>() / length;
        let largest = pieces.iter().max_by(|a, b| a.mrr.total_cmp(&b.mrr));
        let tau = scale * scale;
        out[i] = Some(Planar {
            mrr2: rate * p.feed / simulation.cutting.feed / tau,
            tau,
            alpha: largest.map_or(0.0, |piece| piece.alpha),
        });
    }
    out
}
