//! Rest: places that a delivered path leaves too high, and the branches of its passes over them.
//!
//! Level curves model the strip of a cutter with a flat bottom to second order, and only up to half a side step
//! beside them. Where passes turn sharply, meet the boundary at a small angle, or end beside passes in another
//! direction, the remaining height is measured on the path itself.
//!
//! - *Height* of a sample of the surface: the lowest position of the cutter along its normal (`heights`).
//! - *Branch*: a detour from the nearest place of a pass to the rear end of a high place, along it with the cutter
//!   facing as on the pass, and back (`branch`). Where the cutter cannot go there on the surface, a *rest pass*: down
//!   from above, along it and up again.
//!
//! 1. The cutter moves straight from each point of the path to the next; the height of a sample is the lowest
//!    position of the cutter over it.
//! 2. A place that the cutter cannot touch is reached from the nearest place beside it where the cutter comes low
//!    enough; a place that cannot be reached at all is inaccessible.
//! 3. The highest sample gets a branch along the samples around it that are too high. What the branch leaves of all
//!    samples near it is measured; what is still too high is next. A branch that lowers nothing enough is left out.
//! 4. The branches are inserted into the path, which is not changed elsewhere: no sample gets higher.
//! 5. The surroundings of what is nearly too high are searched for higher places, and 2 to 4 are repeated.

use crate::cutter_location::{Standing, is_in_wall, lowest_off_walls, raise_at, standing_clear};
use crate::geometry::{DVec2, DVec3};
use crate::link::{DeliverError, Delivered};
use crate::parallel;
use crate::removal::{FeedIndex, Place};
use crate::toolpath::{PathPoint, Toolpath};
use std::collections::BTreeSet;

mod branch;
mod context;
mod heights;
mod high;
mod samples;

use branch::{Branch, Moves, inserted};
pub use context::{Rest, RestOptions};
use high::High;
pub use samples::Places;
use samples::Sample;

/// A branch where the cutter does not fit is worth making if it lowers a height to this fraction.
const WORTH: f64 = 0.5;
/// Number of branches over a place after which it is given up: an obstacle holds the cutter up.
const TRIES: u8 = 3;
/// Greatest number of rounds of searching and lowering.
const ROUNDS: usize = 6;
/// Greatest number of times that the samples beside passes are placed anew, since branches have others beside them.
const LOOKS: usize = 3;
/// Width of the cells in which places beside branches are looked up, side steps.
const NEAR_BRANCH: f64 = 3.0;
/// Greatest number of branches of a round, and of those that are tried. More: the problem is not single places.
const MOST_BRANCHES: usize = 2000;
const MOST_TRIED: usize = 3 * MOST_BRANCHES;

/// From where a sample that is too high can be lowered.
enum Lowered {
    /// The cutter has to touch at this distance beside it, flat.
    From(DVec2),
    /// It does not fit.
    Nowhere,
    /// It would penetrate a wall, and does not come low enough beside it.
    InWall,
}

impl Rest<'_> {
    /// The path with branches over what it leaves too high anywhere but within a wall.
    ///
    /// # Errors
    /// [`DeliverError`] when a rest pass cannot be delivered.
    pub fn cut(&mut self, path: Delivered) -> Result<Delivered, DeliverError> {
        self.beside_walls = false;
        let mut path = path;
        let mut near_branches: Option<BTreeSet<[i64; 2]>> = None;
        for _ in 0..LOOKS {
            // Away from branches nothing changed.
            self.samples = self.all_samples(&path, near_branches.as_ref());
            self.on_ridges = self.ball().is_some() && !self.samples.is_empty();
            self.branched.clear();
            path = self.rounds(path)?;
            // Where samples are the same for any path, another look shows nothing new.
            if self.ball().is_none() || self.branched.is_empty() {
                break;
            }
            near_branches = Some(Self::with_neighbours(&self.branched));
        }
        Ok(path)
    }

    /// The path with branches over what is too high at these flat places, beside walls too.
    ///
    /// # Errors
    /// As [`cut`](Self::cut).
    pub fn cut_at(&mut self, left: &[DVec2], path: Delivered) -> Result<Delivered, DeliverError> {
        let samples = left.iter().filter_map(|at| self.places.at(*at));
        (self.samples, self.on_ridges) = (samples.collect(), false);
        self.beside_walls = true;
        self.rounds(path)
    }

    /// The places that were found too high where the cutter cannot come low enough, from whichever side.
    pub fn into_inaccessible(self) -> Vec<Place> {
        self.inaccessible
    }

    fn rounds(&mut self, mut path: Delivered) -> Result<Delivered, DeliverError> {
        for _ in 0..ROUNDS {
            let (heights, high) = self.high(&path.toolpath);
            let branches = self.branches(&path, heights, high);
            if branches.is_empty() {
                break;
            }
            branches.iter().for_each(|branch| self.mark(branch));
            path = inserted(path, branches, &self.deliverer)?;
        }
        Ok(path)
    }

    /// The heights of all samples, and which of them are too high and can be lowered.
    fn high(&mut self, path: &Toolpath) -> (Vec<f64>, Vec<usize>) {
        let strokes = self.strokes(path);
        let mut heights = self.refined(&strokes);
        let mut high = self.worth_lowering(&heights, path);
        if high.is_empty() || self.on_ridges {
            self.climb(&mut heights, &strokes);
            high = self.worth_lowering(&heights, path);
        }
        (heights, high)
    }

    /// Branches over what is too high, the highest sample first. Afterwards the samples are those that are or were
    /// nearly too high.
    fn branches(
        &mut self,
        path: &Delivered,
        mut heights: Vec<f64>,
        high: Vec<usize>,
    ) -> Vec<Branch> {
        let RestOptions { limit, .. } = self.options;
        let lowerable: BTreeSet<usize> = high.iter().copied().collect();
        let moves = Moves::of(path);
        let mut high =
            High::of(high, &self.samples, &heights, self.reach(0.0), self.options.side_step);
        let mut branches: Vec<Branch> = Vec::new();
        for _ in 0..MOST_TRIED {
            let Some(worst) = high.worst().filter(|_| branches.len() < MOST_BRANCHES) else {
                break;
            };
            let before = heights[worst];
            let Some((branch, aimed)) = self.branch(worst, &high, &moves) else { break };
            let mut near = Vec::new();
            let lowered = branch.is_some_and(|branch| {
                let is_of_use;
                (is_of_use, near) = self.lower(&mut heights, &high, &branch);
                branches.extend(is_of_use.then_some(branch));
                is_of_use
            });
            for &i in aimed.iter().filter(|i| heights[**i] > limit) {
                self.samples[i].branches += 1;
            }
            // What came lower, but not low enough, is for the next round, which looks for a way from beside.
            let is_lowered = lowered && heights[worst] < before;
            for i in near.into_iter().chain(aimed) {
                let is_high = heights[i] > limit && self.samples[i].branches < TRIES;
                if !is_high || i == worst && is_lowered {
                    high.remove(i);
                }
            }
        }
        let is_left =
            |i: &usize| heights[*i] > self.climbed_from(&self.samples[*i]) || lowerable.contains(i);
        let is_excused = |i: &usize| heights[*i] > limit && !lowerable.contains(i);
        let left = (0..heights.len()).filter(|i| is_left(i) && !is_excused(i));
        // Where branches lowered some, the highest place between them may be another.
        let sample = |i: usize| Sample {
            is_climbed: self.samples[i].is_climbed && !lowerable.contains(&i),
            ..self.samples[i]
        };
        self.samples = left.map(sample).collect();
        self.on_ridges = false;
        for branch in &branches {
            let beside = self.samples_beside(branch.path());
            self.samples.extend(beside);
        }
        branches
    }

    /// Lowers the heights of what is too high by those that a branch leaves; whether one comes low enough, or much
    /// lower where the cutter does not fit, and all that are near the branch.
    fn lower(&self, heights: &mut [f64], high: &High, branch: &Branch) -> (bool, Vec<usize>) {
        let all = branch.path().toolpath.points.iter().map(|p| self.centre(p));
        let (from, to) =
            all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        // The highest comes first.
        let most = DVec3::splat(self.reach(high.most()));
        let mut near = high.within(from - most, to + most);
        near.retain(|&i| self.is_near(i, heights[i], branch));
        let samples: Vec<Sample> = near.iter().map(|&i| self.samples[i]).collect();
        let strokes = self.strokes(&branch.path().toolpath);
        let left = self.heights(&samples, &strokes, self.options.limit);
        let mut is_of_use = false;
        for (&i, left) in near.iter().zip(left) {
            is_of_use |= self.is_worth(heights[i], left);
            heights[i] = heights[i].min(left);
        }
        (is_of_use, near)
    }

    /// Whether it is worth lowering a height to another, mm.
    fn is_worth(&self, height: f64, left: f64) -> bool {
        let RestOptions { limit, allowed, .. } = self.options;
        left <= limit.max(WORTH * height) || height > allowed && left <= allowed
    }

    /// How far from the centre of the cutter's end it may lower a sample of a height, mm. What the side of a cutter
    /// lowers is left out: it is measured in the next round.
    fn reach(&self, height: f64) -> f64 {
        let pass = &self.deliverer.options.pass;
        pass.tool.radius() + pass.allowance + height
    }

    /// The centre of the cutter's end, mm: of its ball, or of the disc around which its corner is.
    fn centre(&self, point: &PathPoint) -> DVec3 {
        point.tip + point.axis * self.deliverer.options.pass.tool.corner_radius()
    }

    /// A cell of the chart, a little wider than a branch lowers the surface beside it.
    fn cell_of(&self, flat: DVec2) -> [i64; 2] {
        (flat / self.branch_cell()).to_array().map(|x| x.floor() as i64)
    }

    fn branch_cell(&self) -> f64 {
        NEAR_BRANCH * self.options.side_step
    }

    /// Remembers the cells that a branch goes through.
    fn mark(&mut self, branch: &Branch) {
        let places: Vec<DVec2> =
            branch.path().places.iter().flatten().map(|place| place.flat).collect();
        for pair in places.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            // Every cell on the way, or one beside it.
            let count = (from.distance(to) / self.branch_cell()).ceil().clamp(1.0, 1e4) as u32;
            for i in 0..=count {
                let at = from.lerp(to, f64::from(i) / f64::from(count));
                self.branched.insert(self.cell_of(at));
            }
        }
    }

    /// Some cells and those around them.
    fn with_neighbours(own: &BTreeSet<[i64; 2]>) -> BTreeSet<[i64; 2]> {
        let steps = || -1..=1;
        let around =
            |&[i, j]: &[i64; 2]| steps().flat_map(move |a| steps().map(move |b| [i + a, j + b]));
        own.iter().flat_map(around).collect()
    }

    /// Whether a branch may lower a sample of a height.
    fn is_near(&self, sample: usize, height: f64, branch: &Branch) -> bool {
        let Sample { at, .. } = self.samples[sample];
        let points = &branch.path().toolpath.points;
        let reach = self.reach(height);
        let is_beside = |w: &[PathPoint]| {
            let (from, to) = (self.centre(&w[0]), self.centre(&w[1]));
            let way = to - from;
            let along = (at - from).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
            (from + way * along.clamp(0.0, 1.0)).distance(at) <= reach
        };
        points.windows(2).any(is_beside)
    }

    /// The samples that are too high and can be lowered: where the cutter, if it is to touch there, comes low enough,
    /// or much lower than it did, or can lower them from a place beside. The highest sample of a cell represents the
    /// whole cell.
    fn worth_lowering(&mut self, heights: &[f64], path: &Toolpath) -> Vec<usize> {
        let is_worth =
            |i: &usize| heights[*i] > self.options.limit && self.samples[*i].branches < TRIES;
        let cells = self.by_cell((0..heights.len()).filter(is_worth), heights);
        let feeds = FeedIndex::new(path, self.deliverer.options.pass.axis);
        let lowered = parallel::map(self.deliverer.options.threads, &cells, |cell| {
            let sample = &self.samples[cell[0]];
            self.lowered(sample, heights[cell[0]], feeds.nearest(sample.flat))
        });
        let mut out = Vec::new();
        // Between the samples of a cell nothing else was tested.
        let least = self.cell();
        for (cell, lowered) in cells.into_iter().zip(lowered) {
            match lowered {
                Lowered::From(beside) => {
                    cell.iter().for_each(|&i| self.samples[i].beside = beside);
                    out.extend(cell);
                }
                Lowered::Nowhere => self.inaccessible.extend(cell.iter().map(|&i| {
                    let Sample { at: centre, spacing, .. } = self.samples[i];
                    Place { centre, radius: spacing.max(least) }
                })),
                Lowered::InWall => {}
            }
        }
        out
    }

    /// From where the cutter lowers a sample.
    fn lowered(&self, sample: &Sample, height: f64, feed: DVec3) -> Lowered {
        let (limit, obstacles) = (self.options.limit, self.deliverer.obstacles);
        let pass = &self.deliverer.options.pass;
        let &Sample { at, normal, flat, .. } = sample;
        let low = |height: f64| at + normal * (pass.allowance + height);
        if is_in_wall(at, normal, feed, pass, obstacles) {
            let beside = || lowest_off_walls(at, normal, feed, pass, obstacles);
            let is_lowered =
                self.beside_walls && beside().is_some_and(|at| at.contains(low(limit)));
            return if is_lowered { Lowered::From(DVec2::ZERO) } else { Lowered::InWall };
        }
        if self.is_worth(height, raise_at(at, normal, feed, pass, obstacles)) {
            return Lowered::From(DVec2::ZERO);
        }
        let places: Vec<(Sample, Standing)> = self
            .places
            .around(sample)
            .filter_map(|s| Some((s, standing_clear(s.at, s.normal, feed, pass, obstacles)?)))
            .collect();
        let allowed = self.options.allowed;
        let heights = [limit, allowed].into_iter().filter(|h| *h < height);
        let place = heights
            .into_iter()
            .find_map(|height| places.iter().find(|(_, standing)| standing.contains(low(height))));
        place.map_or(Lowered::Nowhere, |(place, _)| Lowered::From(place.flat - flat))
    }
}

#[cfg(test)]
mod tests;
