//! A block with a crowned top: a closed part of which a job selects the top.

use crate::triangulate::{Domain, PlaneMesh, triangulate};
use evencut_core::geometry::{DVec2, DVec3};
use evencut_core::mesh::TriangleSoup;

const HALF_SIZE: DVec2 = DVec2::new(45.0, 30.0);
/// Height of the crown above the bottom, mm.
const HEIGHT: f64 = 30.0;
/// Radii of curvature of the crown at its top along X and Y, mm.
const RADII: DVec2 = DVec2::new(160.0, 75.0);
const SPACING: f64 = 1.7;
/// Rows of triangles from bottom to top.
const ROWS: usize = 14;

/// An elliptic paraboloid on four upright walls and a flat bottom.
///
/// # Source
/// Hilbert and Cohn-Vossen, "Geometry and the Imagination" (1952), section 3: the elliptic
/// paraboloid.
pub fn block() -> Result<TriangleSoup, String> {
    let plane = triangulate(&Domain::rectangle(-HALF_SIZE, HALF_SIZE, SPACING), SPACING)?;
    let mut part = TriangleSoup::default();
    part.positions.extend(plane.points.iter().map(|&p| p.extend(top(p))));
    part.faces.extend(&plane.faces);
    let bottom = part.positions.len() as u32;
    part.positions.extend(plane.points.iter().map(|&p| p.extend(0.0)));
    part.faces.extend(plane.faces.iter().map(|&[a, b, c]| [bottom + a, bottom + c, bottom + b]));
    add_walls(&mut part, &plane, bottom);
    Ok(part)
}

fn top(p: DVec2) -> f64 {
    HEIGHT - p.x * p.x / (2.0 * RADII.x) - p.y * p.y / (2.0 * RADII.y)
}

/// Rows of triangles between the border of the bottom and that of the top.
fn add_walls(part: &mut TriangleSoup, plane: &PlaneMesh, bottom: u32) {
    let around = plane.boundary as u32;
    let between = part.positions.len() as u32;
    for row in 1..ROWS {
        let share = row as f64 / ROWS as f64;
        let heights = plane.points[..plane.boundary].iter();
        part.positions.extend(heights.map(|&p| DVec3::new(p.x, p.y, share * top(p))));
    }
    let vertex = |row: usize, i: u32| match row {
        0 => bottom + i % around,
        ROWS => i % around,
        _ => between + (row as u32 - 1) * around + i % around,
    };
    for row in 0..ROWS {
        for i in 0..around {
            let (a, b) = (vertex(row, i), vertex(row, i + 1));
            let (d, c) = (vertex(row + 1, i), vertex(row + 1, i + 1));
            part.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
}
