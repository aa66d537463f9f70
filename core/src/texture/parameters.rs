//! Parameters of a height map.
//!
//! Terms. Heights are measured from the nominal form, so that the form is removed already; what is left of a slope goes
//! with the *mean plane*, by least squares. *Areal* parameters are those of ISO 25178-2 of all that is left, without
//! filters. *Profile* parameters are those of single lines of nodes, each from its own mean, averaged over all lines of
//! a direction: Ra over the whole line (ISO 21920-2; of equal sections, the same as the mean that ISO 4287 takes), Rz
//! the mean over five sections of the line, which stand for the five sampling lengths of ISO 4287, of the highest over
//! the lowest. There is no filter, and a section that is shorter than a cusp does not hold its whole height: Rz across
//! the feed wants a window of five side steps at least. Rt is taken over the whole line.
//!
//! Sq, and Rq with every line from its own mean, are defined as in the Python package SurfaceTopography 1.27.

use super::grid::Grid;

/// Sections of a line, each of which is to hold a cusp.
pub const SECTIONS: usize = 5;
/// Fewest nodes of a section; shorter lines have one.
const FEWEST: usize = 3;

/// Areal parameters; lengths in mm.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Areal {
    /// Mean of the heights without sign.
    pub sa: f64,
    /// Root of their mean square.
    pub sq: f64,
    /// Highest over lowest.
    pub sz: f64,
    /// Skewness; 0 of a plane.
    pub ssk: f64,
    /// Kurtosis; 0 of a plane.
    pub sku: f64,
}

/// Profile parameters of the lines of one direction, mm.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Profile {
    /// Mean of the heights without sign.
    pub ra: f64,
    /// Root of their mean square, over all lines together.
    pub rq: f64,
    /// Mean over the sections of highest over lowest.
    pub rz: f64,
    /// Highest over lowest of a whole line.
    pub rt: f64,
}

/// A height map without its mean plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Levelled {
    counts: [usize; 2],
    heights: Vec<f64>,
}

impl Levelled {
    /// Takes the mean plane off heights over a grid, in the grid's order.
    pub fn new(grid: &Grid, heights: &[f64]) -> Self {
        Self::of(grid.counts(), heights)
    }

    /// Takes the mean plane off heights over even nodes, `u` fastest; NaN where there is none, beyond the surface or not
    /// cut, which is left out of everything.
    pub fn of(counts: [usize; 2], heights: &[f64]) -> Self {
        let at = |k: usize| [(k % counts[0]) as f64, (k / counts[0]) as f64];
        let on = || heights.iter().enumerate().filter(|(_, h)| !h.is_nan());
        let count = on().count().max(1) as f64;
        let middle = [0, 1].map(|axis| on().map(|(k, _)| at(k)[axis]).sum::<f64>() / count);
        let mean = on().map(|(_, h)| h).sum::<f64>() / count;
        let centred = |k: usize| [0, 1].map(|axis| at(k)[axis] - middle[axis]);
        let (mut first, mut second, mut mixed) = ([0.0; 2], [0.0; 2], 0.0);
        for (k, h) in on() {
            let x = centred(k);
            for axis in [0, 1] {
                first[axis] += x[axis] * h;
                second[axis] += x[axis] * x[axis];
            }
            mixed += x[0] * x[1];
        }
        let slope = slopes(first, second, mixed);
        let level = |(k, h): (usize, &f64)| {
            let [x, y] = centred(k);
            h - mean - slope[0] * x - slope[1] * y
        };
        Self { counts, heights: heights.iter().enumerate().map(level).collect() }
    }

    /// Heights over the mean plane, mm, `u` fastest.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Areal parameters.
    pub fn areal(&self) -> Areal {
        let on = || self.heights.iter().copied().filter(|h| !h.is_nan());
        let count = on().count().max(1) as f64;
        let mean = |f: fn(f64) -> f64| on().map(f).sum::<f64>() / count;
        let square = mean(|h| h * h);
        let sq = square.sqrt();
        let part = |moment: f64, of: f64| if of > 0.0 { moment / of } else { 0.0 };
        Areal {
            sa: mean(f64::abs),
            sq,
            sz: swing(on()),
            ssk: part(mean(|h| h * h * h), square * sq),
            sku: part(mean(|h| h * h * h * h), square * square),
        }
    }

    /// Parameters of the lines along the feed.
    pub fn along(&self) -> Profile {
        let [nu, nv] = self.counts;
        self.profile(nv, nu, |line, i| line * nu + i)
    }

    /// Parameters of the lines across the feed.
    pub fn across(&self) -> Profile {
        let [nu, nv] = self.counts;
        self.profile(nu, nv, |line, i| i * nu + line)
    }

    /// Means over lines of nodes, by the number of nodes that each has on the surface.
    fn profile(&self, lines: usize, nodes: usize, at: impl Fn(usize, usize) -> usize) -> Profile {
        let (mut ra, mut squares, mut rz, mut rt, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut line = Vec::with_capacity(nodes);
        for l in 0..lines {
            line.clear();
            line.extend((0..nodes).map(|i| self.heights[at(l, i)]).filter(|h| !h.is_nan()));
            if line.is_empty() {
                continue;
            }
            let held = line.len() as f64;
            let mean = line.iter().sum::<f64>() / held;
            line.iter_mut().for_each(|h| *h -= mean);
            ra += line.iter().map(|h| h.abs()).sum::<f64>();
            squares += line.iter().map(|h| h * h).sum::<f64>();
            rz += sections(&line) * held;
            rt += swing(line.iter().copied()) * held;
            count += held;
        }
        let count = count.max(1.0);
        Profile { ra: ra / count, rq: (squares / count).sqrt(), rz: rz / count, rt: rt / count }
    }
}

/// Slopes of the mean plane by least squares, from the sums of place times height and of products of places.
fn slopes(first: [f64; 2], second: [f64; 2], mixed: f64) -> [f64; 2] {
    let determinant = second[0] * second[1] - mixed * mixed;
    // Nodes on a line have no slope across it.
    if determinant <= 1e-12 * second[0] * second[1] {
        return [0, 1].map(|a| if second[a] > 0.0 { first[a] / second[a] } else { 0.0 });
    }
    [
        (first[0] * second[1] - first[1] * mixed) / determinant,
        (first[1] * second[0] - first[0] * mixed) / determinant,
    ]
}

/// Mean over the sections of a line of highest over lowest.
fn sections(line: &[f64]) -> f64 {
    let count = if line.len() < SECTIONS * FEWEST { 1 } else { SECTIONS };
    let part = |k: usize| &line[k * line.len() / count..(k + 1) * line.len() / count];
    (0..count).map(|k| swing(part(k).iter().copied())).sum::<f64>() / count as f64
}

/// Highest over lowest; 0 of nothing.
fn swing(heights: impl Iterator<Item = f64>) -> f64 {
    let ends = heights.fold(None, |ends: Option<(f64, f64)>, h| {
        Some(ends.map_or((h, h), |(low, high)| (low.min(h), high.max(h))))
    });
    ends.map_or(0.0, |(low, high)| high - low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math::cos;
    use std::f64::consts::TAU;

    const COUNTS: [usize; 2] = [1000, 30];

    /// A wave along `u` with ten periods, even about the middle, on a slope.
    fn wave() -> Levelled {
        let heights: Vec<f64> = (0..COUNTS[0] * COUNTS[1])
            .map(|k| {
                let (i, j) = ((k % COUNTS[0]) as f64, (k / COUNTS[0]) as f64);
                0.003 * cos(TAU * (i + 0.5) / 100.0) + 0.5 + 1e-3 * i - 2e-3 * j
            })
            .collect();
        Levelled::of(COUNTS, &heights)
    }

    #[test]
    fn a_wave_has_the_parameters_of_a_sine() {
        let wave = wave();
        let areal = wave.areal();
        assert!((areal.sa / (0.003 * 4.0 / TAU) - 1.0).abs() < 0.01, "{areal:?}");
        assert!((areal.sq / (0.003 / 2.0_f64.sqrt()) - 1.0).abs() < 0.01);
        assert!((areal.sz / 0.006 - 1.0).abs() < 0.01);
        assert!(areal.ssk.abs() < 0.02 && (areal.sku - 1.5).abs() < 0.02);
        let along = wave.along();
        assert!((along.ra - areal.sa).abs() < 1e-12 && (along.rq - areal.sq).abs() < 1e-12);
        assert!((along.rz / 0.006 - 1.0).abs() < 0.01 && along.rt >= along.rz);
        assert!(wave.across().rt < 1e-12);
    }

    #[test]
    fn nodes_beyond_the_surface_count_for_nothing() {
        let (nu, nv) = (40, 30);
        let slope = |k: usize| 0.1 + 0.01 * (k % nu) as f64 - 0.02 * (k / nu) as f64;
        let is_on = |k: usize| (k % nu) + (k / nu) < 35;
        let bump = |k: usize| if k.is_multiple_of(2) { 1e-3 } else { -1e-3 };
        let of = |gap: &dyn Fn(usize) -> bool| {
            let height = |k: usize| if gap(k) { slope(k) + bump(k) } else { f64::NAN };
            Levelled::of([nu, nv], &(0..nu * nv).map(height).collect::<Vec<f64>>())
        };
        let (whole, part) = (of(&|_| true), of(&is_on));
        assert!((part.areal().sa / whole.areal().sa - 1.0).abs() < 0.01);
        assert!((part.areal().sz / whole.areal().sz - 1.0).abs() < 0.05);
        assert!((part.along().ra / whole.along().ra - 1.0).abs() < 0.05);
        assert_eq!(
            part.heights().iter().filter(|h| h.is_nan()).count(),
            (0..nu * nv).filter(|k| !is_on(*k)).count()
        );
    }

    #[test]
    fn a_plane_has_no_texture() {
        let heights: Vec<f64> = (0..600).map(|k| 0.1 + f64::from(k % 30) * 0.01).collect();
        let plane = Levelled::of([30, 20], &heights);
        let areal = plane.areal();
        assert!(areal.sz < 1e-14 && areal.sa < 1e-14);
        assert_eq!(Levelled::of([3, 3], &[0.0; 9]).areal().sku, 0.0);
    }
}
