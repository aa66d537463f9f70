//! A split mesh for tests.

use super::*;
use crate::flatten::bff;
use crate::surface::AnalyticSurface;
use std::sync::LazyLock;

/// A bump of 30 mm on a square of 40 mm, and its chart.
pub static BUMP: LazyLock<(Surface, Chart)> = LazyLock::new(|| {
    let soup = AnalyticSurface::Bump { size: 40.0, height: 14.0, width: 7.0 }.mesh(1.0);
    let faces = soup.faces.iter().map(|f| f.map(VertexId)).collect();
    let connectivity = crate::mesh::Connectivity::new(soup.positions.len(), faces).unwrap();
    let surface = Surface::new(connectivity, soup.positions);
    let chart = bff(&surface).unwrap();
    (surface, chart)
});

/// The middle of the chart, about which it is symmetric.
pub fn middle() -> DVec2 {
    let uv = BUMP.1.uv();
    uv.iter().sum::<DVec2>() / uv.len() as f64
}

impl SplitMesh {
    /// What must hold of a split mesh of that surface.
    pub fn validate(&self, surface: &Surface) {
        for h in 0..3 * self.faces.len() as u32 {
            if let Some(o) = self.opposite(h) {
                assert_eq!(self.opposite(o), Some(h));
                let (a, b) = self.ends(h);
                assert_eq!(self.ends(o), (b, a));
            }
        }
        for v in 0..self.uv.len() as u32 {
            let fan = self.around(v);
            assert!(!fan.is_empty() && fan.iter().all(|&h| self.ends(h).0 == v));
        }
        for (mean, p) in self.means.iter().zip(&self.positions) {
            let of = |m: &(u32, f64)| surface.positions()[m.0 as usize] * m.1;
            let expected: DVec3 = mean.iter().map(of).sum();
            assert!(expected.distance(*p) < 1e-9);
        }
        let area: f64 = (0..self.faces.len()).map(|f| self.area(f)).sum();
        assert!((area / surface.area() - 1.0).abs() < 1e-12);
        let turned = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| self.uv[v as usize]);
            cross2(a, b, c) <= 0.0
        };
        assert!(!self.faces.iter().any(turned));
    }
}
