//! The material before the first operation, where the job says where it ends: no thicker over the surface than is cut at
//! once.
//!
//! How thick it is over a place is how far it reaches from there along the normal, straight up, or toward its nearest face,
//! whichever is the least: on the steep wall of a pocket the normal runs through all that is in the pocket, and beside a
//! corner along the material on the next wall. Steps: (1) whether each triangle's middle, and the place on its normal that
//! is as high over it as material may be, lie within the material: by the faces that a line from there straight up crosses
//! ([`Solid`]); (2) the same in the other directions; (3) the thickest place by bisection, for the message.

use super::error::PlanError;
use crate::cutter_location::{Hindrance, nearest_place};
use crate::geometry::DVec3;
use crate::geometry::boxes::{Boxes, around};
use crate::level_set::PassMesh;
use crate::parallel;
use crate::surface::Part;

/// Thickness up to which it is looked for, in thicknesses that are allowed.
const THICKEST: f64 = 1e6;
/// Halvings of the thickness.
const HALVINGS: usize = 40;
/// Triangles that are looked at one after another.
const CHUNK: usize = 4096;

/// Refuses material that is thicker than `allowed` mm and the tolerance, mm, somewhere over the meshes.
///
/// # Errors
/// [`PlanError::StockTooThick`].
pub fn refuse_thick<'a>(
    stock: &Part,
    meshes: impl Iterator<Item = &'a PassMesh>,
    (allowed, tolerance): (f64, f64),
    threads: usize,
) -> Result<(), PlanError> {
    let solid = Solid::new(stock);
    let mut worst: Option<(DVec3, f64)> = None;
    for mesh in meshes {
        let chunks: Vec<_> = mesh.connectivity().faces().chunks(CHUNK).collect();
        let found = parallel::map(threads, &chunks, |faces| {
            let corners = faces.iter().map(|face| face.map(|v| mesh.positions()[v.index()]));
            solid.thickest(corners, allowed + tolerance)
        });
        for (place, thickness) in found.into_iter().flatten() {
            if worst.is_none_or(|(_, most)| thickness > most) {
                worst = Some((place, thickness));
            }
        }
    }
    match worst {
        None => Ok(()),
        Some((place, thickness)) => Err(PlanError::StockTooThick { place, thickness, allowed }),
    }
}

/// What faces enclose.
struct Solid {
    /// The triangles as seen from above, with their heights.
    seen: Boxes,
    triangles: Vec<[DVec3; 3]>,
    /// The same in space.
    faces: Hindrance,
}

impl Solid {
    fn new(part: &Part) -> Self {
        let corners = |face: &[u32; 3]| face.map(|v| part.positions[v as usize]);
        let triangles: Vec<[DVec3; 3]> = part.faces.iter().map(corners).collect();
        let seen = |(triangle, number): (&[DVec3; 3], u32)| around(number, &triangle.map(flat));
        Self {
            seen: Boxes::new(triangles.iter().zip(0..).map(seen).collect()),
            triangles,
            faces: Hindrance::new(&part.positions, &part.faces),
        }
    }

    /// Where over triangles it is the thickest, and how thick, mm; `None` where it is nowhere thicker than `most` mm.
    fn thickest(
        &self,
        triangles: impl Iterator<Item = [DVec3; 3]>,
        most: f64,
    ) -> Option<(DVec3, f64)> {
        let mut worst = None;
        for [a, b, c] in triangles {
            let (place, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero());
            let least = worst.map_or(most, |(_, thickness)| thickness);
            if normal != DVec3::ZERO
                && let Some(thickness) = self.thickness(place, normal, least)
            {
                worst = Some((place, thickness));
            }
        }
        worst
    }

    /// How thick it is over a place, mm; `None` where it is no thicker than `least` mm.
    fn thickness(&self, place: DVec3, normal: DVec3, least: f64) -> Option<f64> {
        let is_in = |along: DVec3, way: f64| self.contains(place + way * along);
        if !is_in(normal, least) || !is_in(DVec3::Z, least) || !self.contains(place) {
            return None;
        }
        let nearest = nearest_place(&self.faces, place).unwrap_or(place);
        // What is nearest may be the other side of the part.
        let to_nearest = (nearest - place).try_normalize().filter(|way| way.dot(normal) > 0.0);
        let to_nearest = to_nearest.unwrap_or(normal);
        let reach = |along: DVec3| {
            let (mut low, mut high) = (least, 2.0 * least);
            while is_in(along, high) && high < THICKEST * least {
                (low, high) = (high, 2.0 * high);
            }
            for _ in 0..HALVINGS {
                let middle = low.midpoint(high);
                if is_in(along, middle) { low = middle } else { high = middle }
            }
            low
        };
        let ways = [normal, DVec3::Z, to_nearest];
        let is_thick = is_in(to_nearest, least);
        is_thick.then(|| ways.into_iter().map(reach).fold(f64::INFINITY, f64::min))
    }

    /// Whether a place is enclosed: a line from there straight up leaves through more faces than it enters by.
    fn contains(&self, p: DVec3) -> bool {
        let crossed = self.seen.holding(flat(p)).map(|triangle| self.triangles[triangle as usize]);
        crossed.map(|triangle| above(p, triangle)).sum::<i32>() > 0
    }
}

/// A place as seen from above.
fn flat(p: DVec3) -> DVec3 {
    p.with_z(0.0)
}

/// 1 if a line from `p` straight up leaves through the triangle, -1 if it enters there, 0 if it passes by. Of the sides
/// that two triangles share one has the line, so that no crossing is lost or counted twice.
fn above(p: DVec3, corners: [DVec3; 3]) -> i32 {
    let flat = corners.map(|c| c.truncate() - p.truncate());
    let side = |i: usize| {
        // The same for both triangles at the side.
        let (a, b) = (flat[i], flat[(i + 1) % 3]);
        let is_ordered = (a.x, a.y) < (b.x, b.y);
        let turn = if is_ordered { a.perp_dot(b) } else { b.perp_dot(a) };
        (turn >= 0.0) == is_ordered
    };
    let sides = [0, 1, 2].map(side);
    if sides[0] != sides[1] || sides[1] != sides[2] {
        return 0;
    }
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let height = normal.dot(p - a);
    match sides[0] {
        true if height < 0.0 => 1,
        false if height > 0.0 => -1,
        _ => 0,
    }
}
