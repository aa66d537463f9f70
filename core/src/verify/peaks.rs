//! The highest places between samples, and the deepest.
//!
//! Where a sample stands so high that what may stand beside it could break the limit, the surface around it is
//! searched: on a lattice of half the distance of samples, then on lattices four times as fine around the highest place
//! found. Each lattice covers what is nearer to that place than to its neighbours on the one before.
//!
//! One sample of every block is searched around, the highest first, and so many at most that the search takes a
//! fraction of the sweep. The places found stand for no area.

use super::body::Body;
use super::figures::sampling_bound;
use super::motion::{Motion, Step};
use super::samples::{BLOCK, Patch, Sample, Tile};
use super::sweep::{Material, Swept, SweptTile, swept};
use super::{Excused, Outcome, VerifyOptions};
use crate::geometry::DVec3;
use crate::parallel;

/// Lattices, one around another: the last has places a 128th of the samples' distance apart.
const ROUNDS: usize = 4;
/// Half a lattice's width, its places' distances.
const HALF: i32 = 2;
/// How many times finer than the one before each lattice is.
const FINER: f64 = 4.0;
/// Samples one of which is searched around at most, and how many may be in any case.
const ONE_OF: usize = 128;
const AT_LEAST: usize = 512;
/// The same for gouges, of which there are few, as a part.
const FOR_GOUGES: usize = 4;
/// Gouges less deep than this are none, mm.
const NO_GOUGE: f64 = 1e-6;
/// Steps farther from a lattice's middle than this are left out, its places' distances: it is as far to its corners and
/// as much again down a slope of 45 degrees.
const NEAR: f64 = 6.0;

/// What is sought.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Sought {
    /// The largest residual where it is judged.
    Scallop,
    /// The deepest gouge anywhere.
    Gouge,
}

/// What is searched.
pub struct Search<'a> {
    /// Tiles of the part.
    pub tiles: &'a [Tile],
    /// The moves.
    pub motion: &'a Motion,
    /// The cutter.
    pub body: &'a Body,
    /// What is cut.
    pub material: Material,
    /// Distance of the samples, mm.
    pub spacing: f64,
    /// The edges on which walls stand.
    pub walled: &'a [[DVec3; 2]],
    /// What is asked.
    pub options: &'a VerifyOptions,
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Places higher than the sample that was searched around.
    pub peaks: Vec<Outcome>,
    /// Nothing is higher than this or the highest place, mm.
    pub highest: f64,
}

/// A sample that is searched around.
struct Start {
    tile: usize,
    of: Swept,
    score: f64,
}

impl Sought {
    /// How high it is, if that counts.
    fn score(self, s: &Outcome) -> Option<f64> {
        match self {
            Self::Scallop => s.is_judged().then_some(f64::from(s.residual)),
            Self::Gouge => Some(-f64::from(s.residual)),
        }
    }
}

impl Search<'_> {
    /// Searches around the samples that were swept. `outcomes`: the same, by tile.
    pub fn search(&self, sought: Sought, swept: &[SweptTile], outcomes: &[Vec<Outcome>]) -> Found {
        let scores = outcomes.iter().flatten().filter_map(|s| sought.score(s));
        let least = scores.fold(self.most(sought), f64::max);
        let mut found = Found { peaks: Vec::new(), highest: f64::NEG_INFINITY };
        let mut starts = Vec::new();
        let mut count = 0;
        for (tile, (swept, outcomes)) in swept.iter().zip(outcomes).enumerate() {
            count += outcomes.len();
            for (swept, outcomes) in swept.samples.chunks(BLOCK).zip(outcomes.chunks(BLOCK)) {
                let scored = swept.iter().zip(outcomes);
                let scored = scored.filter_map(|(s, o)| Some((sought.score(o)?, s)));
                let Some((score, of)) = scored.reduce(|a, b| if b.0 > a.0 { b } else { a }) else {
                    continue;
                };
                let most = score + self.bound(sought, score, self.spacing);
                let is_gouge = sought == Sought::Gouge && score > NO_GOUGE;
                if most > least && of.by.is_some() && (is_gouge || sought == Sought::Scallop) {
                    starts.push(Start { tile, of: *of, score });
                } else {
                    found.highest = found.highest.max(most);
                }
            }
        }
        starts.sort_by(|a, b| b.score.total_cmp(&a.score));
        let part = if sought == Sought::Gouge { FOR_GOUGES } else { 1 };
        let most = (count / ONE_OF).max(AT_LEAST) / part;
        for start in starts.drain(most.min(starts.len())..) {
            let most = start.score + self.bound(sought, start.score, self.spacing);
            found.highest = found.highest.max(most);
        }
        starts.sort_by_key(|s| s.tile);
        let groups: Vec<&[Start]> = starts.chunk_by(|a, b| a.tile == b.tile).collect();
        let climbed = parallel::map(self.options.threads, &groups, |group: &&[Start]| {
            self.around_tile(sought, group, least)
        });
        for (peak, most) in climbed.into_iter().flatten() {
            found.highest = found.highest.max(most);
            found.peaks.extend(peak);
        }
        found
    }

    /// What may not be exceeded.
    fn most(&self, sought: Sought) -> f64 {
        let tolerance = self.options.tolerance;
        match sought {
            Sought::Scallop => {
                self.options.scallop.map_or(f64::INFINITY, |limit| limit + tolerance)
            }
            Sought::Gouge => tolerance,
        }
    }

    /// How much higher it may be beside a place, with places `spacing` mm apart.
    fn bound(&self, sought: Sought, score: f64, spacing: f64) -> f64 {
        let slope = sampling_bound(score, spacing, self.options);
        let corner = self.options.tool.corner_radius();
        match sought {
            // The bottom of a gouge is as round as the cutter.
            Sought::Gouge if corner > 0.0 => slope.min(spacing * spacing / (8.0 * corner)),
            _ => slope,
        }
    }

    /// The peaks beside some samples of a tile, each with what nothing beside it exceeds.
    fn around_tile(
        &self,
        sought: Sought,
        starts: &[Start],
        least: f64,
    ) -> Vec<(Option<Outcome>, f64)> {
        let tile = &self.tiles[starts[0].tile];
        let reach = 2.0 * self.spacing;
        let near = |t: &&Tile| t.centre.distance(tile.centre) <= t.radius + tile.radius + reach;
        let tiles: Vec<&Tile> = self.tiles.iter().filter(near).collect();
        let excused = Excused::near(self.options, self.walled, tile.centre, tile.radius + reach);
        starts.iter().map(|start| self.climb(sought, start, &tiles, &excused, least)).collect()
    }

    fn climb(
        &self,
        sought: Sought,
        start: &Start,
        tiles: &[&Tile],
        excused: &Excused,
        least: f64,
    ) -> (Option<Outcome>, f64) {
        let Self { body, material, .. } = *self;
        let origin = start.of.sample;
        let wide = 2.0 * self.spacing;
        let patches: Vec<&Patch> = tiles
            .iter()
            .filter(|t| t.centre.distance(origin.position) <= t.radius + wide)
            .flat_map(|t| &t.patches)
            .filter(|p| p.machined == origin.machined && p.is_near(origin.position, wide))
            .collect();
        let mut all = Vec::new();
        let reach = wide + material.height.max(material.deepest);
        self.motion.near(body, origin.position, reach, &mut |step| all.push(*step));
        let mut steps = all.clone();
        let (mut best, mut score) = (start.of, start.score);
        let mut apart = 0.5 * FINER * self.spacing;
        for _ in 0..ROUNDS {
            apart /= FINER;
            let top = best.sample.position + best.sample.normal * best.height;
            steps.retain(|step: &Step| step.may_come_near(body, top, NEAR * apart));
            let around = lattice(&best.sample, apart, &patches);
            for s in swept(around, &steps, body, material) {
                let outcome = excused.outcome(&s, self.options);
                if s.by.is_some()
                    && let Some(found) = sought.score(&outcome)
                    && found > score
                {
                    (best, score) = (s, found);
                }
            }
            if score + self.bound(sought, score, apart) <= least {
                break;
            }
        }
        // With every step, in case a steep slope hid one.
        let mut peak = None;
        for s in swept(vec![best.sample], &all, body, material) {
            let outcome = excused.outcome(&s, self.options);
            let found = sought.score(&outcome).unwrap_or(start.score);
            score = found.max(start.score);
            peak = (found > start.score).then_some(outcome);
        }
        (peak, score + self.bound(sought, score, apart))
    }
}

/// Places on a lattice around a sample, on the patches.
fn lattice(middle: &Sample, apart: f64, patches: &[&Patch]) -> Vec<Sample> {
    let (u, v) = middle.normal.any_orthonormal_pair();
    let mut out = Vec::with_capacity(((2 * HALF + 1) * (2 * HALF + 1)) as usize);
    for j in -HALF..=HALF {
        for i in -HALF..=HALF {
            let point = middle.position + (u * f64::from(i) + v * f64::from(j)) * apart;
            let on = patches.iter().filter(|p| p.is_near(point, 2.0 * apart)).map(|p| {
                let sample = p.nearest(point);
                (sample.position.distance_squared(point), sample)
            });
            // The other side of a thin sheet is another place.
            let on = on.filter(|s| s.1.normal.dot(middle.normal) > 0.0);
            let nearest = on.reduce(|a, b| if b.0 < a.0 { b } else { a });
            out.extend(nearest.filter(|_| (i, j) != (0, 0)).map(|s| s.1));
        }
    }
    out
}
