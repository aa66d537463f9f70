//! The highest and the deepest places between samples.
//!
//! Where a sample is so high that the surface beside it could break the limit, the surface around it is searched: on
//! a lattice of half the sample distance, then on lattices four times as fine around the highest place found. Each
//! lattice covers what is nearer to that place than to its neighbours on the previous one.
//!
//! One sample of every block is searched around, the highest first, and only so many that the search takes a fraction
//! of the time of the sweep. The places found have no area.

use super::body::Body;
use super::excused::Excused;
use super::figures::sampling_bound;
use super::material::{Material, Swept};
use super::motion::Step;
use super::options::VerifyOptions;
use super::outcome::Outcome;
use super::samples::{BLOCK, Patch, Sample, Tile};
use super::sweep::{Cut, SweptTile, swept_in_order};
use super::walls::{Facet, part_behind};
use crate::geometry::offset::CREASE;
use crate::geometry::{DVec3, OrderBy};
use crate::parallel;

/// By this factor the places of the last lattice are closer together than samples.
const FINEST: f64 = 128.0;
/// Half the width of a lattice, in distances of its places.
const HALF: i32 = 2;
/// How many times finer each lattice is than the previous one.
const FINER: f64 = 4.0;
/// One in this many samples is searched around at most; and the number that is always allowed.
const ONE_OF: usize = 512;
const AT_LEAST: usize = 384;
/// The same fraction for gouges, which are rare.
const FOR_GOUGES: usize = 4;
/// Gouges less deep than this are ignored, mm.
const NO_GOUGE: f64 = 1e-6;
/// Steps farther from the middle of a lattice than this are skipped, in distances of its places: its corners are that
/// far away, and as much again down a slope of 45 degrees.
const NEAR: f64 = 6.0;
/// Number of highest peaks along whose ridges others are searched; half the width of the lattice on which these
/// searches begin, in distances of its places, which are a quarter of the sample distance; and how many of its places
/// are searched around.
const RIDGES: usize = 12;
const ALONG: i32 = 4;
const ON_RIDGE: usize = 12;

/// The kind of peak that is searched.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Sought {
    /// The largest residual where it is held to the limit.
    Scallop,
    /// The deepest gouge anywhere.
    Gouge,
}

/// The data to search.
pub struct Search<'a> {
    /// Tiles of the part.
    pub tiles: &'a [Tile],
    /// The cuts in their order.
    pub cuts: &'a [Cut<'a>],
    /// What is cut.
    pub material: Material,
    /// Distance of the samples, mm.
    pub spacing: f64,
    /// How far from sharp edges gouges are searched, mm.
    pub inset: f64,
    /// The edges on which walls stand.
    pub walled: &'a [[DVec3; 2]],
    /// The limits.
    pub options: &'a VerifyOptions,
}

/// The results.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Places higher than the sample that was searched around.
    pub peaks: Vec<Outcome>,
    /// No height exceeds this or the highest place, mm.
    pub highest: f64,
}

/// A sample that is searched around.
struct Start {
    tile: usize,
    of: Swept,
    score: f64,
    /// The place found there, if it is higher than any sample nearby.
    peak: Option<Outcome>,
}

impl Sought {
    /// Its height, if that counts.
    fn score(self, s: &Outcome) -> Option<f64> {
        match self {
            Self::Scallop => s.is_judged().then_some(f64::from(s.residual)),
            Self::Gouge => s.is_of_part().then_some(-f64::from(s.residual)),
        }
    }
}

impl Search<'_> {
    /// Searches around the samples that were swept. `outcomes`: their results, by tile.
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
                // The next sample is up to half a diagonal away.
                let beside = self.bound(sought, score, core::f64::consts::SQRT_2 * self.spacing);
                if score + beside > least && of.is_cut() && (is_gouge || sought == Sought::Scallop)
                {
                    starts.push(Start { tile, of: *of, score, peak: None });
                } else {
                    found.highest = found.highest.max(most);
                }
            }
        }
        starts.order_by(|a, b| b.score.total_cmp(&a.score));
        let part = if sought == Sought::Gouge { FOR_GOUGES } else { 1 };
        let most = (count / ONE_OF).max(AT_LEAST) / part;
        for start in starts.drain(most.min(starts.len())..) {
            let most = start.score + self.bound(sought, start.score, self.spacing);
            found.highest = found.highest.max(most);
        }
        starts.order_by_key(|s| s.tile);
        let groups: Vec<&[Start]> = starts.chunk_by(|a, b| a.tile == b.tile).collect();
        let climbed = parallel::map(self.options.threads, &groups, |group: &&[Start]| {
            self.around_tile(sought, group, least, false)
        });
        let mut tops = Vec::new();
        for (peak, most) in climbed.into_iter().flatten() {
            found.highest = found.highest.max(most);
            tops.push(peak);
        }
        // The highest on a ridge may be a step aside of where its ridge was met best.
        tops.order_by(|a, b| b.score.total_cmp(&a.score));
        let least = tops.first().map_or(least, |t| t.score);
        let ridges: Vec<&[Start]> = tops.chunks(1).take(RIDGES).collect();
        let along = parallel::map(self.options.threads, &ridges, |group: &&[Start]| {
            self.around_tile(sought, group, least, true)
        });
        tops.extend(along.into_iter().flatten().map(|(peak, _)| peak));
        found.peaks.extend(tops.iter().filter_map(|t| t.peak));
        found
    }

    /// The height that must not be exceeded.
    fn most(&self, sought: Sought) -> f64 {
        let tolerance = self.options.tolerance;
        match sought {
            Sought::Scallop => {
                self.options.scallop.map_or(f64::INFINITY, |limit| limit + tolerance)
            }
            Sought::Gouge => tolerance,
        }
    }

    /// How much higher the surface may be beside a place, with places `spacing` mm apart.
    fn bound(&self, sought: Sought, score: f64, spacing: f64) -> f64 {
        let slope = sampling_bound(score, spacing, self.options);
        let corner = self.options.tool.corner_radius();
        match sought {
            // The bottom of a gouge is as round as the cutter.
            Sought::Gouge if corner > 0.0 => slope.min(spacing * spacing / (8.0 * corner)),
            _ => slope,
        }
    }

    /// The peaks beside some samples of a tile, each with an upper bound of its surroundings; or those along their
    /// ridges.
    fn around_tile(
        &self,
        sought: Sought,
        starts: &[Start],
        least: f64,
        is_ridge: bool,
    ) -> Vec<(Start, f64)> {
        let tile = &self.tiles[starts[0].tile];
        let reach = 2.0 * self.spacing;
        let near = |t: &&Tile| t.centre.distance(tile.centre) <= t.radius + tile.radius + reach;
        let tiles: Vec<&Tile> = self.tiles.iter().filter(near).collect();
        let excused = Excused::near(self.options, self.walled, tile.centre, tile.radius + reach);
        let mut out = Vec::new();
        for start in starts {
            let around = self.around(start, &tiles);
            if !is_ridge {
                out.push(self.climb(sought, start, &around, &excused, least, 0.5 * self.spacing));
                continue;
            }
            let places =
                self.lattice(sought, &start.of.sample, (ALONG, 0.25 * self.spacing), &around);
            let swept = swept_in_order(places, &around.cuts, self.material);
            let started = |of: Swept| {
                let outcome = excused.outcome(&of, self.options);
                let score = sought.score(&outcome).filter(|_| of.is_cut())?;
                Some(Start { tile: start.tile, of, score, peak: Some(outcome) })
            };
            let mut places: Vec<Start> = swept.into_iter().filter_map(started).collect();
            places.order_by(|a, b| b.score.total_cmp(&a.score));
            let climb = |p| self.climb(sought, p, &around, &excused, least, 0.125 * self.spacing);
            out.extend(places.iter().take(ON_RIDGE).map(climb));
        }
        out
    }

    /// Places on a lattice around a sample: half its width, and how far apart they are.
    fn lattice(
        &self,
        sought: Sought,
        middle: &Sample,
        (half, apart): (i32, f64),
        around: &Around,
    ) -> Vec<Sample> {
        let mut places = lattice(middle, half, apart, &around.patches);
        if sought == Sought::Gouge {
            places.retain(|s| !self.is_at_edge(s, &around.others));
            places.iter_mut().filter(|s| !s.machined).for_each(|s| self.end(s, &around.facets));
        }
        places
    }

    /// Ends the material behind a place of the rest of the part where another face is nearer.
    fn end(&self, place: &mut Sample, facets: &[Facet]) {
        let Sample { position, normal, .. } = *place;
        let Material { deepest, tolerance, .. } = self.material;
        let behind = part_behind(position, normal, facets, deepest, tolerance);
        place.wall = (behind < deepest).then_some(behind);
    }

    /// Whether a place lies at a sharp edge: there a cutter that touches the edge cuts deep along a facet's normal.
    fn is_at_edge(&self, place: &Sample, patches: &[&Patch]) -> bool {
        let Sample { position, normal, .. } = *place;
        patches.iter().filter(|p| p.is_near(position, self.inset)).any(|p| {
            let other = p.nearest(position);
            other.position.distance(position) < self.inset && other.normal.dot(normal) < CREASE
        })
    }

    /// The surroundings of a sample.
    fn around<'t>(&'t self, start: &Start, tiles: &[&'t Tile]) -> Around<'t> {
        let origin = start.of.sample;
        // The ridge's places are searched around, too.
        let wide = 3.0 * self.spacing;
        let patches = tiles
            .iter()
            .filter(|t| t.centre.distance(origin.position) <= t.radius + wide)
            .flat_map(|t| &t.patches)
            .filter(|p| p.is_near(origin.position, wide))
            .collect::<Vec<_>>();
        let others = patches.clone();
        let facets = match origin.machined {
            true => Vec::new(),
            false => others.iter().filter_map(|p| Facet::of(p.corners)).collect(),
        };
        let patches = patches.into_iter().filter(|p| p.machined == origin.machined).collect();
        let reach = wide + self.material.height.max(self.material.deepest);
        let near = |cut: &Cut<'t>| {
            let mut steps = Vec::new();
            cut.motion.near(cut.body, origin.position, reach, &mut |step| steps.push(*step));
            (steps, cut.body)
        };
        Around { patches, others, facets, cuts: self.cuts.iter().map(near).collect() }
    }

    /// Climbs from a start, on lattices of which the first has places `widest` mm apart.
    fn climb(
        &self,
        sought: Sought,
        start: &Start,
        around: &Around,
        excused: &Excused,
        least: f64,
        widest: f64,
    ) -> (Start, f64) {
        let mut cuts = around.cuts.clone();
        let (mut best, mut score) = (start.of, start.score);
        let finest = self.spacing / FINEST;
        let mut apart = FINER * widest;
        while apart > 1.5 * finest {
            apart /= FINER;
            let top = best.sample.position + best.sample.normal * best.height;
            for (steps, body) in &mut cuts {
                steps.retain(|step| step.may_come_near(body, top, NEAR * apart));
            }
            let places = self.lattice(sought, &best.sample, (HALF, apart), around);
            for s in swept_in_order(places, &cuts, self.material) {
                let outcome = excused.outcome(&s, self.options);
                if s.is_cut()
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
        let mut peak = start.peak;
        for s in swept_in_order(vec![best.sample], &around.cuts, self.material) {
            let outcome = excused.outcome(&s, self.options);
            let found = sought.score(&outcome).unwrap_or(start.score);
            score = found.max(start.score);
            if found > start.score {
                (peak, best) = (Some(outcome), s);
            }
        }
        let most = score + self.bound(sought, score, apart);
        (Start { tile: start.tile, of: best, score, peak }, most)
    }
}

/// The surroundings of a start.
struct Around<'a> {
    patches: Vec<&'a Patch>,
    /// Those of what is machined and of the rest of the part.
    others: Vec<&'a Patch>,
    /// The same as facets, about a place of the rest.
    facets: Vec<Facet>,
    /// Of every cut the steps that reach it.
    cuts: Vec<(Vec<Step>, &'a Body)>,
}

/// Places on a lattice around a sample, on the patches.
fn lattice(middle: &Sample, half: i32, apart: f64, patches: &[&Patch]) -> Vec<Sample> {
    let (u, v) = middle.normal.any_orthonormal_pair();
    let mut out = Vec::with_capacity(((2 * half + 1) * (2 * half + 1)) as usize);
    for j in -half..=half {
        for i in -half..=half {
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
