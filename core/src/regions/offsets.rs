//! Offsets of the open passes of neighbouring regions.
//!
//! All passes of a region can be shifted by a fraction of a pass. Along an inner border the outermost passes of both
//! sides machine everything between them if their distances from it add up to no more than a pass; otherwise the
//! remainder has to be machined by extra moves, out and back. The shifts are chosen, one region after the other, so
//! that the total length of passes and extra moves is shortest; the outermost pass of a region stays within half a
//! pass of the end of its field.

use super::region_mesh::RegionMesh;
use crate::level_set::PassField;
use crate::mesh::FaceId;
use std::collections::BTreeMap;

/// Shifts that are tried, evenly over a pass.
const SHIFTS: usize = 25;
/// Rounds through all regions. After them nothing changes any more.
const ROUNDS: usize = 4;
/// Outermost passes of two regions at most this far apart, passes, leave nothing between them: gaps are measured from
/// 0.504 passes on.
const CLOSED: f64 = 1.008;
/// Factor for what is left beside a pass: it is machined out and back.
const OUT_AND_BACK: f64 = 2.0;
/// Steps in which the length of a level curve is tabulated, passes.
const BIN: f64 = 1.0 / SHIFTS as f64;

/// A stretch of an inner border with the values of its two regions.
struct Stretch {
    /// mm.
    length: f64,
    sides: [Side; 2],
}

/// A stretch of border seen from one region.
#[derive(Copy, Clone)]
struct Side {
    region: usize,
    /// The field there, passes.
    value: f64,
    /// Whether it grows toward the border.
    grows: bool,
}

impl Side {
    /// Distance of the outermost pass from the border, passes.
    fn distance(&self, shifts: &[f64]) -> f64 {
        let value = self.value - shifts[self.region];
        if self.grows { value - value.floor() } else { value.ceil() - value }
    }
}

/// The shift of the field of every region, passes, after which its passes lie at whole levels.
pub(super) fn shifts(region_meshes: &[RegionMesh], fields: &[&PassField]) -> Vec<f64> {
    let stretches = stretches(region_meshes, fields);
    let lengths: Vec<Lengths> = region_meshes
        .iter()
        .zip(fields)
        .map(|(region_mesh, field)| Lengths::of(region_mesh, field))
        .collect();
    let mut shifts = vec![0.0; region_meshes.len()];
    for _ in 0..ROUNDS {
        for region in 0..region_meshes.len() {
            let beside = |s: &&Stretch| s.sides.iter().any(|side| side.region == region);
            let beside: Vec<&Stretch> = stretches.iter().filter(beside).collect();
            let mut best = (f64::INFINITY, shifts[region]);
            for k in 0..SHIFTS {
                shifts[region] = BIN * k as f64;
                let is_open = |s: &&&Stretch| {
                    s.sides.iter().map(|side| side.distance(&shifts)).sum::<f64>() > CLOSED
                };
                let open: f64 = beside.iter().filter(is_open).map(|s| s.length).sum();
                let cost = lengths[region].at(k) + OUT_AND_BACK * open;
                if cost < best.0 {
                    best = (cost, shifts[region]);
                }
            }
            shifts[region] = best.1;
        }
    }
    shifts
}

/// The stretches of all inner borders.
fn stretches(region_meshes: &[RegionMesh], fields: &[&PassField]) -> Vec<Stretch> {
    let mut waiting: BTreeMap<[u64; 4], Side> = BTreeMap::new();
    let mut stretches = Vec::new();
    for (region, (region_mesh, field)) in region_meshes.iter().zip(fields).enumerate() {
        for (h, [from, to]) in region_mesh.border_sides() {
            let bits = |v: crate::mesh::VertexId| {
                let p = region_mesh.fine.uv()[v.index()];
                [p.x.to_bits(), p.y.to_bits()]
            };
            let value = |v: crate::mesh::VertexId| field.values()[v.index()];
            let middle = 0.5 * (value(from) + value(to));
            let inner = value(region_mesh.fine.connectivity().ends(h.next()).1);
            let side = Side { region, value: middle, grows: inner < middle };
            let ([a, b], [c, d]) = (bits(from), bits(to));
            match waiting.remove(&[c, d, a, b]) {
                Some(other) => {
                    let length = region_mesh.fine.positions()[from.index()]
                        .distance(region_mesh.fine.positions()[to.index()]);
                    stretches.push(Stretch { length, sides: [other, side] });
                }
                None => {
                    waiting.insert([a, b, c, d], side);
                }
            }
        }
    }
    stretches
}

/// Length of the passes of a region as a function of its shift.
struct Lengths {
    /// By shift, mm.
    of_shift: Vec<f64>,
}

impl Lengths {
    fn of(region_mesh: &RegionMesh, field: &PassField) -> Self {
        let (low, high) = field.range();
        // Lengths of level curves, mm, by bins of their level.
        let bins = ((high - low) / BIN).clamp(1.0, 1e6) as usize + 1;
        let mut curves = vec![0.0; bins];
        for (f, face) in region_mesh.fine.connectivity().faces().iter().enumerate() {
            let values = face.map(|v| field.values()[v.index()]);
            let (l, h) = values.iter().fold((high, low), |(l, h), &v| (l.min(v), h.max(v)));
            let length = region_mesh.integral(FaceId(f as u32), values) / BIN;
            let [from, to] = [l, h].map(|v| (((v - low) / BIN) as usize).min(bins - 1));
            for bin in &mut curves[from..=to.max(from)] {
                *bin += length / (to.max(from) - from + 1) as f64;
            }
        }
        let curve = |level: f64| curves.get(((level - low) / BIN) as usize).copied().unwrap_or(0.0);
        let of_shift = |k: usize| {
            let first = (low - BIN * k as f64).ceil() + BIN * k as f64;
            let levels = (0..).map(|i| first + f64::from(i)).take_while(|level| *level < high);
            let last = levels.clone().last().unwrap_or(first);
            // Unshifted they are near enough to both ends of the field.
            match k == 0 || (first - low).max(high - last) <= 0.5 {
                true => levels.map(curve).sum::<f64>(),
                false => f64::INFINITY,
            }
        };
        Self { of_shift: (0..SHIFTS).map(of_shift).collect() }
    }

    fn at(&self, shift: usize) -> f64 {
        self.of_shift[shift]
    }
}
