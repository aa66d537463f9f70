//! The measured removal rate, over windows of travel, compared with the predicted one.

use super::motion::Motion;
use crate::geometry::DVec3;
use crate::toolpath::Toolpath;

/// Length of a window as a fraction of the cutter radius.
const WINDOW: f64 = 0.2;

/// The mean removal rates over a stretch of the path.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Window {
    /// Time at its start and end, s.
    pub time: [f64; 2],
    /// Tool tip in its middle, mm.
    pub place: DVec3,
    /// Index of the move in its middle; that move ends at the next point of the path.
    pub of: u32,
    /// Distance travelled, mm.
    pub travel: f64,
    /// Measured rate, mm³/s.
    pub measured: f64,
    /// Rate that the path states, mm³/s.
    pub predicted: f64,
}

/// Measured and predicted rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rate {
    /// The window of the highest measured rate, among windows that start at every step.
    pub peak: Option<Window>,
    /// Windows one after the other.
    pub windows: Vec<Window>,
    /// Volume that was removed, mm³.
    pub volume: f64,
    /// Root mean square of the difference, over the time in which either rate is above zero, mm³/s.
    pub rms_difference: f64,
    /// The window of the largest difference.
    pub largest_difference: Option<Window>,
}

/// A step in time.
#[derive(Copy, Clone)]
struct Slice {
    of: u32,
    /// Fraction of the move at its end.
    end: f64,
    start: f64,
    duration: f64,
    travel: f64,
    volume: f64,
    predicted: f64,
}

/// The rate from the volume that each step removed, in order of steps. `every` is called with the windows that start at
/// every step.
pub fn measure(
    path: &Toolpath,
    motion: &Motion,
    removed: &[(u64, f64)],
    radius: f64,
    every: &mut dyn FnMut(Window),
) -> Rate {
    // Steps are half as long but for rounding.
    let window = WINDOW * radius * (1.0 - 1e-9);
    let mut rate = Rate { volume: removed.iter().map(|r| r.1).sum(), ..Rate::default() };
    for run in runs(path, motion, removed) {
        each_window(&run, window, motion, &mut |w| {
            if rate.peak.is_none_or(|p| w.measured > p.measured) {
                rate.peak = Some(w);
            }
            every(w);
        });
        rate.windows.extend(consecutive(&run, window, motion));
    }
    let (mut squares, mut time) = (0.0, 0.0);
    for w in rate.windows.iter().filter(|w| w.measured.max(w.predicted) > 0.0) {
        let (difference, duration) = (w.measured - w.predicted, w.time[1] - w.time[0]);
        squares += difference * difference * duration;
        time += duration;
        let larger = |l: Window| difference.abs() > (l.measured - l.predicted).abs();
        if rate.largest_difference.is_none_or(larger) {
            rate.largest_difference = Some(*w);
        }
    }
    rate.rms_difference = if time > 0.0 { (squares / time).sqrt() } else { 0.0 };
    rate
}

/// Steps between rapids.
fn runs(path: &Toolpath, motion: &Motion, removed: &[(u64, f64)]) -> Vec<Vec<Slice>> {
    let mut runs = vec![Vec::new()];
    let mut removed = removed.iter().copied().peekable();
    for (i, m) in motion.moves().iter().enumerate() {
        if m.rapid {
            if runs.last().is_some_and(|r| !r.is_empty()) {
                runs.push(Vec::new());
            }
            while removed.next_if(|r| r.0 < m.first_step + u64::from(m.steps)).is_some() {}
            continue;
        }
        let (from, to) = (&path.points[i], &path.points[i + 1]);
        let duration = (to.time - from.time).max(0.0) / f64::from(m.steps.max(1));
        let length = to.tip.distance(from.tip) / f64::from(m.steps.max(1));
        for k in 0..m.steps {
            let index = m.first_step + u64::from(k);
            let volume = removed.next_if(|r| r.0 == index).map_or(0.0, |r| r.1);
            let Some(run) = runs.last_mut() else { continue };
            run.push(Slice {
                of: i as u32,
                end: f64::from(k + 1) / f64::from(m.steps),
                start: from.time + duration * f64::from(k),
                duration,
                travel: if to.feed > 0.0 && duration > 0.0 { to.feed * duration } else { length },
                volume,
                predicted: to.mrr * duration,
            });
        }
    }
    runs
}

/// Calls `each` with the windows that start at each slice; a run shorter than a window is one.
fn each_window(run: &[Slice], window: f64, motion: &Motion, each: &mut dyn FnMut(Window)) {
    let (mut end, mut sum) = (0, Sum::default());
    for start in 0..run.len() {
        while end < run.len() && sum.travel < window {
            sum.add(&run[end], 1.0);
            end += 1;
        }
        if sum.travel < window && start > 0 {
            break;
        }
        // Of the last slice only what the window needs.
        let last = &run[end - 1];
        let beyond =
            if last.travel > 0.0 { (sum.travel - window).max(0.0) / last.travel } else { 0.0 };
        let mut part = sum;
        part.add(last, -beyond);
        if part.time > 0.0 {
            each(part.window(run, start, end, motion));
        }
        sum.add(&run[start], -1.0);
    }
}

fn consecutive(run: &[Slice], window: f64, motion: &Motion) -> Vec<Window> {
    let mut out = Vec::new();
    let (mut start, mut sum) = (0, Sum::default());
    for (i, slice) in run.iter().enumerate() {
        sum.add(slice, 1.0);
        if (sum.travel >= window || i + 1 == run.len()) && sum.time > 0.0 {
            out.push(sum.window(run, start, i + 1, motion));
            (start, sum) = (i + 1, Sum::default());
        }
    }
    out
}

#[derive(Copy, Clone, Default)]
struct Sum {
    travel: f64,
    time: f64,
    volume: f64,
    predicted: f64,
}

impl Sum {
    fn add(&mut self, slice: &Slice, part: f64) {
        self.travel += slice.travel * part;
        self.time += slice.duration * part;
        self.volume += slice.volume * part;
        self.predicted += slice.predicted * part;
    }

    fn window(&self, run: &[Slice], start: usize, end: usize, motion: &Motion) -> Window {
        let middle = &run[(start + end) / 2];
        let from = run[start].start;
        Window {
            time: [from, from + self.time],
            place: motion.moves()[middle.of as usize].at(middle.end).tip,
            of: middle.of,
            travel: self.travel,
            measured: self.volume.max(0.0) / self.time,
            predicted: self.predicted / self.time,
        }
    }
}
