//! The removal rate along time.

use evencut_core::toolpath::Toolpath;

/// The removal rate along time: `mrr[i]` holds from `time[i - 1]` to `time[i]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// Times, s, not decreasing.
    pub time: Vec<f64>,
    /// Removal rates, mm³/s, as many.
    pub mrr: Vec<f64>,
}

impl Profile {
    /// The profile of a path with the feeds as commanded.
    pub fn of(path: &Toolpath) -> Self {
        Self {
            time: path.points.iter().map(|p| p.time).collect(),
            mrr: path.points.iter().map(|p| p.mrr).collect(),
        }
    }

    /// Start, end and rate of each piece.
    pub fn pieces(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        self.time.windows(2).zip(self.mrr.iter().skip(1)).map(|(t, &m)| (t[0], t[1], m))
    }

    /// Time of the last sample, s; 0 without samples.
    pub fn duration(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// Largest rate, mm³/s; 0 without samples.
    pub fn peak(&self) -> f64 {
        self.pieces().map(|(.., m)| m).fold(0.0, f64::max)
    }

    /// Mean over the time in which the rate is above zero, mm³/s; 0 if it never is.
    pub fn mean_while_cutting(&self) -> f64 {
        let (time, volume) = self.cutting_sum(|m| m);
        if time > 0.0 { volume / time } else { 0.0 }
    }

    /// Standard deviation over mean in the time in which the rate is above zero; 0 if it never is.
    pub fn variation_while_cutting(&self) -> f64 {
        let mean = self.mean_while_cutting();
        let (time, squares) = self.cutting_sum(|m| (m - mean) * (m - mean));
        if time > 0.0 { (squares / time).sqrt() / mean } else { 0.0 }
    }

    /// Time of cutting, and the integral of a function of the rate over it.
    fn cutting_sum(&self, of: impl Fn(f64) -> f64) -> (f64, f64) {
        self.pieces()
            .filter(|&(.., m)| m > 0.0)
            .fold((0.0, 0.0), |(time, sum), (a, b, m)| (time + (b - a), sum + (b - a) * of(m)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_cut_does_not_vary() {
        let profile = Profile { time: vec![0.0, 1.0, 5.0, 6.0], mrr: vec![0.0, 3.0, 3.0, 0.0] };
        assert_eq!(profile.mean_while_cutting(), 3.0);
        assert_eq!(profile.variation_while_cutting(), 0.0);
        assert_eq!((profile.peak(), profile.duration()), (3.0, 6.0));
    }

    #[test]
    fn nothing_is_zero() {
        let nothing = Profile::default();
        let figures = [nothing.duration(), nothing.peak(), nothing.variation_while_cutting()];
        assert_eq!(figures, [0.0; 3]);
    }
}
