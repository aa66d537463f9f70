//! The stock beside the machined surface, for the removal rate: where normals on the boundary lean inward, stock that goes
//! straight up there reaches beyond what stands along the normals.
//!
//! Its samples stand on the edges of the boundary and fan from the normals to the vertical. They have no area and no cusps:
//! only what moves remove of them counts, and the rapids that do.

use super::material::Material;
use super::samples::{Facets, Sample, Tile, widest};
use super::sweep::{Cut, SweptTile, sweep};
use super::walls::{Edge, boundary};
use crate::geometry::offset::{Beside, beside};
use crate::geometry::{DVec3, OrderBy};
use crate::parallel;

/// Samples that are swept together.
const TOGETHER: usize = 1024;

/// What cuts remove of the stock beside `design`, without samples; `up`: unit; `spacing`: between samples, mm.
pub fn swept(
    design: Facets,
    up: DVec3,
    spacing: f64,
    (cuts, material): (&[Cut], Material),
    threads: usize,
) -> Vec<SweptTile> {
    let mut samples = samples(design, up, spacing, material.height);
    let mut tiles = Vec::new();
    group(&mut samples, &mut tiles);
    parallel::map(threads, &tiles, |samples: &Vec<Sample>| {
        let tile = Tile::around(samples.iter().map(|s| s.position));
        let swept = sweep(&tile, samples.clone(), cuts, material);
        SweptTile { samples: Vec::new(), ..swept }
    })
}

fn samples(design: Facets, up: DVec3, spacing: f64, top: f64) -> Vec<Sample> {
    let normals = design.normals();
    let mut edges = boundary(design);
    edges.order_by_key(|e| e.side);
    let of = |edge: &Edge| {
        let side = edge.side;
        let corner = usize::from(side.corner);
        let normals = [corner, (corner + 1) % 3].map(|i| normals[side.facet as usize][i]);
        beside(edge.ends, normals, up, (spacing, top))
    };
    let sample = |c: Beside| Sample { section: c.section, ..Sample::bare(c.foot, c.direction) };
    edges.iter().flat_map(of).map(sample).collect()
}

/// Halves samples at the middle of their widest direction until few are together.
fn group(samples: &mut [Sample], out: &mut Vec<Vec<Sample>>) {
    if samples.len() <= TOGETHER {
        out.extend((!samples.is_empty()).then(|| samples.to_vec()));
        return;
    }
    let axis = widest(samples.iter().map(|s| s.position));
    samples.order_by(|a, b| a.position[axis].total_cmp(&b.position[axis]));
    let (low, high) = samples.split_at_mut(samples.len() / 2);
    group(low, out);
    group(high, out);
}
