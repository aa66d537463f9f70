//! Regions from map distortion: the surface is split until every piece maps evenly.
//!
//! - *Stretch* `sigma_ave`: mean stretch of a face by its flat map, mm per flat mm.
//! - *Measure* `e`: a function of the stretch that shows where the map's scale is larger and where smaller than
//!   average.
//! - *Uniformity* `U = P5(sigma_ave) / P95(sigma_ave)`: how evenly a piece maps.
//!
//! 1. A piece gets a new flat map; if `U` is high enough, or the piece too small, it is kept.
//! 2. Candidate cuts are drawn: where the smoothed measure crosses the job's threshold, and where it crosses its
//!    quartiles; and straight across the flat piece, without which a horn would become a stack of ever thinner rings.
//!    Groups that are too small are merged into a neighbour.
//! 3. The candidate after which the pieces map most evenly is carried out: its isoline is inserted as a curve. If the
//!    area-weighted mean of `U` does not rise, the split is undone.
//! 4. The same is done with every part, down to the given depth. Every split makes pieces of at least the least area,
//!    so the loop ends.
//!
//! The source clusters by the sign of `e` alone; the other cuts are ours and used only where the pieces map more
//! evenly.
//!
//! # Source
//! "Method for generating region-wise contour-parallel tool paths on a curved surface", a Chinese patent application of
//! 2022.

mod flattened;
mod measure;
mod sketch;

pub use flattened::Flattened;
pub use measure::{Evenness, Stretch, percentile};

use super::split_mesh::SplitMesh;
use crate::flatten::FlattenError;
use crate::job::DistortionOptions;
use crate::parallel;
use sketch::{Cut, sketches};

/// By how much a split must raise the uniformity to be kept. Smaller: useless pieces.
const GAIN: f64 = 0.003;
/// Penalty for every piece beyond two, in uniformity.
const PIECE: f64 = 0.004;

/// Splits all faces of a split mesh into pieces that map evenly; returns the pieces.
///
/// `least`: least area of a piece, mm².
///
/// # Errors
/// [`FlattenError`] when the whole surface cannot be flattened.
pub fn divide(
    split_mesh: &mut SplitMesh,
    options: &DistortionOptions,
    least: f64,
    threads: usize,
) -> Result<Vec<Flattened>, FlattenError> {
    let all: Vec<u32> = (0..split_mesh.faces().len() as u32).collect();
    let groups = split_mesh.groups(&all, |_| 0, 0.0);
    (0..).zip(&groups).for_each(|(label, faces)| split_mesh.set_label(faces, label));
    let mut open = Vec::new();
    for faces in &groups {
        open.extend(Flattened::of(split_mesh, faces)?);
    }
    let mut done = Vec::new();
    for _ in 0..options.depth {
        let (even, uneven): (Vec<_>, Vec<_>) =
            open.into_iter().partition(|p| p.uniformity() >= options.uniformity);
        done.extend(even);
        let chosen = parallel::map(threads, &uneven, |p| chosen(split_mesh, p, options, least));
        open = Vec::new();
        for (piece, cut) in uneven.into_iter().zip(chosen) {
            match cut.and_then(|cut| carried_out(split_mesh, &piece, &cut, least)) {
                Some(parts) => open.extend(parts),
                None => done.push(piece),
            }
        }
    }
    done.extend(open);
    // What was split later may have put vertices on borders of what was done before.
    let lists: Vec<Vec<u32>> = done.iter().map(|p| split_mesh.labelled(p.piece.faces[0])).collect();
    let fresh = parallel::map(threads, &lists, |faces| Flattened::of(split_mesh, faces));
    Ok(fresh.into_iter().flatten().flatten().collect())
}

/// The best of the cuts of a piece; `None` if none makes the pieces map more evenly.
fn chosen(
    split_mesh: &SplitMesh,
    piece: &Flattened,
    options: &DistortionOptions,
    least: f64,
) -> Option<Cut> {
    let faces = split_mesh.labelled(piece.piece.faces[0]);
    let short_of = options.uniformity - piece.uniformity();
    let mut best = (piece.uniformity() + GAIN.min(0.5 * short_of), None);
    for cut in sketches(piece, options, least) {
        let value = on_split_mesh(split_mesh, piece, &cut);
        let Some(parts) = parts(split_mesh, &faces, &value, least) else { continue };
        let score = score(&parts, options.uniformity);
        if score > best.0 {
            best = (score, Some(cut));
        }
        // Nothing scores better.
        if parts.len() == 2 && parts.iter().all(|p| p.uniformity() >= options.uniformity) {
            break;
        }
    }
    best.1
}

/// Quality of a split: the mean uniformity, capped at the required one, less a small penalty for every piece beyond
/// two.
fn score(parts: &[Flattened], enough: f64) -> f64 {
    mean_uniformity(parts, enough) - PIECE * parts.len().saturating_sub(2) as f64
}

/// Area-weighted mean of the uniformities, each capped at `most`.
fn mean_uniformity(parts: &[Flattened], most: f64) -> f64 {
    let areas = parts.iter().map(|p| p.surface.area());
    let sum: f64 = parts.iter().zip(areas.clone()).map(|(p, a)| a * p.uniformity().min(most)).sum();
    sum / areas.sum::<f64>()
}

/// The values of a cut at all vertices of the split mesh; NaN outside of the piece.
fn on_split_mesh(split_mesh: &SplitMesh, piece: &Flattened, cut: &Cut) -> Vec<f64> {
    let known = piece.piece.vertices.iter().max().map_or(0, |&v| v as usize + 1);
    let mut value = vec![f64::NAN; known];
    for (&v, &x) in piece.piece.vertices.iter().zip(&cut.0) {
        value[v as usize] = x;
    }
    split_mesh.extend(&mut value);
    value
}

/// The groups of faces on both sides of a cut, with flat maps; `None` if there is only one.
fn parts(
    split_mesh: &SplitMesh,
    faces: &[u32],
    value: &[f64],
    least: f64,
) -> Option<Vec<Flattened>> {
    let side = |f: u32| {
        let sum: f64 = split_mesh.faces()[f as usize].iter().map(|&v| value[v as usize]).sum();
        u32::from(sum > 0.0)
    };
    let groups = split_mesh.groups(faces, side, least);
    if groups.len() < 2 {
        return None;
    }
    groups.iter().map(|faces| Flattened::of(split_mesh, faces).ok().flatten()).collect()
}

/// Carries out a cut; `None`, with the pieces as they were, if the map does not become more even.
fn carried_out(
    split_mesh: &mut SplitMesh,
    piece: &Flattened,
    cut: &Cut,
    least: f64,
) -> Option<Vec<Flattened>> {
    let first = piece.piece.faces[0];
    let value = on_split_mesh(split_mesh, piece, cut);
    let value = split_mesh.cut_isoline(split_mesh.labels()[first as usize], value);
    let parts = parts(split_mesh, &split_mesh.labelled(first), &value, least)?;
    if mean_uniformity(&parts, 1.0) <= piece.uniformity() {
        return None;
    }
    for part in &parts[1..] {
        let label = split_mesh.pieces() as u32;
        split_mesh.set_label(&part.piece.faces, label);
    }
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::super::split_mesh::samples::BUMP;
    use super::*;
    use crate::job::DistortionMeasure;

    fn divided(options: &DistortionOptions, threads: usize) -> (SplitMesh, Vec<Flattened>) {
        let (surface, chart) = &*BUMP;
        let mut split_mesh = SplitMesh::new(surface, chart);
        let pieces = divide(&mut split_mesh, options, 20.0, threads).unwrap();
        split_mesh.validate(surface);
        (split_mesh, pieces)
    }

    #[test]
    fn every_piece_of_a_bump_maps_evenly() {
        let (surface, chart) = &*BUMP;
        let before = Stretch::of(surface, chart).evenness().uniformity;
        let options = DistortionOptions::default();
        let (split_mesh, pieces) = divided(&options, 2);
        assert!(before < 0.7 && pieces.len() > 1, "{before}, {} pieces", pieces.len());
        assert!(pieces.iter().all(|p| p.uniformity() >= options.uniformity));
        assert!(pieces.iter().all(|p| p.piece.area(&split_mesh) >= 20.0));
        let area: f64 = pieces.iter().map(|p| p.piece.area(&split_mesh)).sum();
        assert!((area / surface.area() - 1.0).abs() < 1e-9);
        let disk = |p: &Flattened| {
            let c = &p.piece.connectivity;
            c.euler_characteristic() == 2 - c.boundary_loops().len() as i64
        };
        assert!(pieces.iter().all(disk));
    }

    #[test]
    fn threads_change_nothing() {
        let labels = |threads| divided(&DistortionOptions::default(), threads).0.labels().to_vec();
        assert_eq!(labels(1), labels(3));
    }

    #[test]
    fn without_depth_there_is_one_piece() {
        let options = DistortionOptions { depth: 0, ..DistortionOptions::default() };
        assert_eq!(divided(&options, 1).1.len(), 1);
    }

    #[test]
    fn every_measure_divides() {
        for measure in
            [DistortionMeasure::Stretch, DistortionMeasure::Area, DistortionMeasure::Angle]
        {
            let options = DistortionOptions { measure, uniformity: 0.8, ..Default::default() };
            assert!(divided(&options, 2).1.len() > 1, "{measure:?}");
        }
    }
}
