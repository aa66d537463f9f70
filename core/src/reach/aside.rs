//! What of a part is not machined in one setup.

use super::facet::area_normal;
use super::options::ReachOptions;
use super::terrain::Terrain;
use crate::geometry::DVec3;
use crate::geometry::math::cos;
use crate::parallel;
use crate::surface::Part;

/// Distance of the places at which a face is looked at, cutter radii, and most of them along a side.
const APART: f64 = 0.5;
const MOST_ALONG: f64 = 24.0;

/// Areas of what was selected and is not machined, mm².
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Aside {
    /// All that was selected.
    pub selected: f64,
    /// Faces away from the axis.
    pub away: f64,
    /// Steeper than the job machines.
    pub steep: f64,
    /// In the shadow of something above it.
    pub shadowed: f64,
    /// In pieces that are too small for passes.
    pub small: f64,
    /// Surface on which the cutter bridges the part, which is lower there.
    pub bridged: f64,
    /// How much lower the part is there at most, mm.
    pub deepest_bridged: f64,
}

/// The middles of the triangles into which one is divided, `along` on each side.
fn places([a, b, c]: [DVec3; 3], along: u32) -> Vec<DVec3> {
    let third = 1.0 / 3.0;
    let n = f64::from(along);
    let at = |i: u32, j: u32, shift: f64| {
        let (u, v) = ((f64::from(i) + shift) / n, (f64::from(j) + shift) / n);
        a + (b - a) * u + (c - a) * v
    };
    let upright = (0..along).flat_map(|i| (0..along - i).map(move |j| (i, j, third)));
    let turned = (1..along).flat_map(|i| (0..along - i).map(move |j| (i - 1, j, 2.0 * third)));
    upright.chain(turned).map(|(i, j, shift)| at(i, j, shift)).collect()
}

/// What is seen of a face from above.
struct Seen {
    area: f64,
    /// Cosine of its slope.
    z: f64,
    /// Fraction of it that is in sight.
    in_sight: f64,
}

impl Seen {
    fn of(corners: [DVec3; 3], terrain: &Terrain, options: &ReachOptions) -> Self {
        let normal = area_normal(corners);
        let (area, z) = (0.5 * normal.length(), normal.normalize_or_zero().z);
        if z < cos(options.steepest) {
            return Self { area, z, in_sight: 0.0 };
        }
        let along = (area.sqrt() / (APART * options.tool.radius())).ceil().clamp(2.0, MOST_ALONG);
        let places = places(corners, along as u32);
        let seen = places.iter().filter(|p| terrain.is_in_sight(**p)).count();
        Self { area, z, in_sight: seen as f64 / places.len() as f64 }
    }
}

/// Figures of what faces away, is too steep or in shadow, and the faces of it.
pub(super) fn set_aside(
    terrain: &Terrain,
    machined: &Part,
    options: &ReachOptions,
) -> (Aside, Part) {
    let seen = parallel::map(options.threads, &machined.faces, |face| {
        Seen::of(face.map(|v| machined.positions[v as usize]), terrain, options)
    });
    let steepest = cos(options.steepest);
    let mut aside = Aside::default();
    for Seen { area, z, in_sight, .. } in &seen {
        aside.selected += area;
        match *z {
            z if z <= 0.0 => aside.away += area,
            z if z < steepest => aside.steep += area,
            _ => aside.shadowed += (1.0 - in_sight) * area,
        }
    }
    let is_left = |seen: &Seen| seen.in_sight < 1.0;
    let left = machined.faces.iter().zip(&seen).filter(|(_, seen)| is_left(seen));
    let faces = left.map(|(face, _)| *face).collect();
    (aside, Part { positions: machined.positions.clone(), faces })
}
