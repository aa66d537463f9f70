//! Surfaces for the tests of this stage.

use crate::geometry::DVec3;
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
