//! Surfaces for the tests of this stage.

use crate::geometry::DVec3;
use crate::geometry::math::{cos, sin};
use crate::mesh::{Connectivity, VertexId};
use crate::surface::Surface;

/// A reproducible number in `-0.5..0.5` for every pair.
pub fn jitter(i: usize, salt: u64) -> f64 {
    let mut x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ salt.wrapping_mul(0xD134_2543);
    x ^= x >> 31;
    x = x.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 29;
    (x >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// `n` by `n` quads over the unit square with alternating diagonals, mapped by `place`.
pub fn grid(n: usize, place: impl Fn(f64, f64) -> DVec3) -> Surface {
    grid_of(n, n, |i, j| place(i as f64 / n as f64, j as f64 / n as f64))
}

/// `columns` by `rows` quads with alternating diagonals; corner `(i, j)` lies at `place(i, j)`.
pub fn grid_of(columns: usize, rows: usize, place: impl Fn(usize, usize) -> DVec3) -> Surface {
    let mut positions = Vec::new();
    for j in 0..=rows {
        positions.extend((0..=columns).map(|i| place(i, j)));
    }
    let mut faces = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let a = (j * (columns + 1) + i) as u32;
            let (b, c, d) = (a + 1, a + columns as u32 + 2, a + columns as u32 + 1);
            let pair =
                if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            faces.extend(pair.map(|f| f.map(VertexId)));
        }
    }
    Surface::new(Connectivity::new(positions.len(), faces).unwrap(), positions)
}

/// The unit square, jittered inside, sheared along `x` by `shear` per unit of `y`.
pub fn sheared_plane(n: usize, shear: f64) -> Surface {
    let step = 1.0 / n as f64;
    grid_of(n, n, |i, j| {
        let inside = i > 0 && i < n && j > 0 && j < n;
        let k = i * (n + 1) + j;
        let shift = if inside { [jitter(k, 1), jitter(k, 2)] } else { [0.0; 2] };
        let (x, y) = ((i as f64 + 0.6 * shift[0]) * step, (j as f64 + 0.6 * shift[1]) * step);
        DVec3::new(x + shear * y, y, 0.0)
    })
}

/// A disk of hexagonal rings (ring `k` has `6 k` vertices), mapped by `place(radius, angle)` from
/// the unit disk.
pub fn disk(rings: u32, place: impl Fn(f64, f64) -> DVec3) -> Surface {
    let start = |ring: u32| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    let vertex =
        |ring: u32, i: u32| VertexId(start(ring) + if ring == 0 { 0 } else { i % (6 * ring) });
    let mut positions = vec![place(0.0, 0.0)];
    let mut faces = Vec::new();
    for ring in 1..=rings {
        for i in 0..6 * ring {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(6 * ring);
            positions.push(place(f64::from(ring) / f64::from(rings), angle));
            let (sector, k) = (i / ring, i % ring);
            let inner = sector * (ring - 1) + k;
            faces.push([vertex(ring, i), vertex(ring, i + 1), vertex(ring - 1, inner)]);
            if k + 1 < ring {
                faces.push([
                    vertex(ring - 1, inner),
                    vertex(ring, i + 1),
                    vertex(ring - 1, inner + 1),
                ]);
            }
        }
    }
    Surface::new(Connectivity::new(positions.len(), faces).unwrap(), positions)
}

/// A patch of the cone that narrows by `slope` of its length; a cylinder for `slope` 0.
///
/// Vertices lie on rulings, jittered along them, so that the mesh is developable exactly.
pub fn rolled_sheet(n: usize, slope: f64) -> Surface {
    grid_of(n, n, |i, j| {
        let inside = i > 0 && i < n && j > 0 && j < n;
        let shift = if inside { 0.7 * jitter(i * (n + 1) + j, 3) } else { 0.0 };
        let along = (j as f64 + shift) / n as f64;
        let (radius, angle) = (10.0 * (1.0 - slope * along), 2.5 * i as f64 / n as f64);
        DVec3::new(radius * cos(angle), radius * sin(angle), 25.0 * along)
    })
}

/// A flat ring of `n` quads: vertices `0..n` outside, `n..2 n` inside.
pub fn ring(n: u32) -> Surface {
    let at = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k % n) / f64::from(n);
        let radius = if k < n { 2.0 } else { 1.0 };
        radius * DVec3::new(cos(angle), sin(angle), 0.0)
    };
    let quad = |i: u32| {
        let j = (i + 1) % n;
        [[i, j, n + j], [i, n + j, n + i]].map(|f| f.map(VertexId))
    };
    let faces = (0..n).flat_map(quad).collect();
    let positions: Vec<DVec3> = (0..2 * n).map(at).collect();
    Surface::new(Connectivity::new(positions.len(), faces).unwrap(), positions)
}
