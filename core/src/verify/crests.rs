//! How high the cusps between neighbouring passes are, one by one, from sections across the passes.
//!
//! - *Place*: a point on a cutting move; places stand for equal lengths of it.
//! - *Section*: where the plane across the move meets the surface at the place's contact.
//! - *Crest*: the highest residual on a section between the footprint of this pass and that of the next
//!   one, on either side.
//!
//! Steps: (1) places evenly along the cutting moves; (2) the contact of each: of the samples that this
//! move left, the one nearest to the cutter there; (3) residuals on the section, at first a few a pass
//! distance, then closer around the highest. The next pass is known by its move, which is far along the
//! path, not by any plan. A place near the boundary, or without a next pass, has no crest there.

use super::Outcome;
use super::body::Body;
use super::motion::{Motion, Step};
use super::samples::{Facets, Sample};
use super::section::{Chain, Surface};
use super::sweep::{Material, Swept, swept};
use crate::geometry::DVec3;
use crate::parallel;
use crate::toolpath::{MoveKind, Toolpath};

/// Places on a path. More: finer shares, more time.
const PLACES: usize = 300;
/// Mean distances of passes that a section reaches to either side.
const REACH: f64 = 1.75;
/// Samples a mean distance of passes at first.
const COARSE: f64 = 7.0;
/// Parts into which the ways beside the highest sample are cut, and how often: a crest is then found to
/// 1/1512 of a pass, where a cusp of straight flanks has lost less than half a percent.
const FINER: usize = 6;
const ROUNDS: usize = 3;
/// A pass is left behind where the residual fell below this part of its crest.
const FALLEN: f64 = 0.6;
/// Moves farther along the path than this are another pass, cutter radii.
const ANOTHER: f64 = 1.0;
/// A contact is no farther from the cutter than this part of the stock's height.
const TOUCH: f64 = 0.25;
/// Samples of one move that are looked at for a contact.
const MOST_LOOKED_AT: usize = 4096;
/// Cusps from this part of the limit to the limit use it well.
const FULL: f64 = 0.9;

/// The heights of the cusps, mm, and where they could not be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Crests {
    /// Heights in ascending order; each stands for as much of the path.
    pub heights: Vec<f64>,
    /// Sides of the places at which the cutter touches; those without a height have no next pass, or lie at the
    /// boundary.
    pub sides: usize,
    /// The highest, where.
    pub highest_at: Option<DVec3>,
}

impl Crests {
    /// The height that this share of the crests stays below, mm.
    pub fn percentile(&self, share: f64) -> Option<f64> {
        let last = self.heights.len().checked_sub(1)?;
        Some(self.heights[(share * last as f64).round() as usize])
    }

    /// Share of the crests between 0.9 of a limit and the limit, and above it.
    pub fn shares(&self, limit: f64) -> [f64; 2] {
        let count =
            |least: f64| (self.heights.len() - self.heights.partition_point(|&h| h < least)) as f64;
        // A cusp of exactly the limit is within it.
        let above = count(limit * (1.0 + 1e-3));
        let all = self.heights.len().max(1) as f64;
        [(count(FULL * limit) - above) / all, above / all]
    }

    /// Share of the sides that have a crest.
    pub fn told(&self) -> f64 {
        self.heights.len() as f64 / self.sides.max(1) as f64
    }
}

/// What crests are looked for on.
pub struct Survey<'a> {
    /// The path.
    pub path: &'a Toolpath,
    /// Its moves.
    pub motion: &'a Motion,
    /// The cutter.
    pub body: &'a Body,
    /// What is cut.
    pub material: Material,
    /// Allowance left on it, mm.
    pub stock: f64,
}

/// A place on a cutting move.
struct Place {
    /// Index of the move.
    of: usize,
    /// Part of it.
    part: f64,
}

/// A place where the cutter touches the surface.
struct Contact {
    /// Index of the move.
    of: usize,
    /// Part of it.
    part: f64,
    /// Where, mm.
    contact: DVec3,
    /// Direction of the move.
    way: DVec3,
}

impl Survey<'_> {
    /// The crests beside the passes. `samples`: what was found on the surface.
    pub fn crests(&self, design: Facets, samples: &[Outcome], threads: usize) -> Crests {
        let surface = Surface::new(design);
        let left = left_by(samples, self.motion.moves().len());
        let ways = self.ways();
        let (places, length) = self.places();
        let mut contacts = parallel::map(threads, &places, |p: &Place| self.contact(p, &left));
        contacts.retain(Option::is_some);
        // What the moves on the surface left, over their length.
        let cut = length * contacts.len() as f64 / places.len().max(1) as f64;
        let distance = (self.cut_area(samples) / cut).min(2.0 * self.body.radius());
        let found = parallel::map(threads, &contacts, |contact: &Option<Contact>| {
            let contact = contact.as_ref()?;
            self.beside(contact, &surface, &ways, distance)
        });
        let mut crests: Vec<(f64, DVec3)> =
            found.into_iter().flatten().flatten().flatten().collect();
        crests.sort_by(|a, b| a.0.total_cmp(&b.0));
        Crests {
            sides: 2 * contacts.len(),
            highest_at: crests.last().map(|c| c.1),
            heights: crests.into_iter().map(|c| c.0 - self.stock).collect(),
        }
    }

    /// The area that moves along passes left as it is, mm².
    fn cut_area(&self, samples: &[Outcome]) -> f64 {
        let is_cut = |s: &&Outcome| {
            let end = s.by.and_then(|by| self.path.points.get(by as usize + 1));
            s.machined && end.is_some_and(|p| p.kind == MoveKind::Cut)
        };
        samples.iter().filter(is_cut).map(|s| f64::from(s.area)).sum()
    }

    /// Where the cutter touches at a place, if it does.
    fn contact(&self, place: &Place, left: &[Vec<DVec3>]) -> Option<Contact> {
        let m = &self.motion.moves()[place.of];
        let at = m.at(place.part);
        let candidates = left.get(place.of)?;
        let stride = candidates.len() / MOST_LOOKED_AT + 1;
        let far = |p: &DVec3| self.body.nearest(&at, *p).distance;
        let looked_at = candidates.iter().step_by(stride).copied();
        let contact = looked_at.min_by(|a, b| far(a).total_cmp(&far(b)))?;
        let way = (m.to.tip - m.from.tip).try_normalize()?;
        let (of, part) = (place.of, place.part);
        (far(&contact) < TOUCH * self.material.height).then_some(Contact { of, part, contact, way })
    }

    /// Places evenly along the cutting moves, and the length of these.
    fn places(&self) -> (Vec<Place>, f64) {
        let length = |i: usize| self.path.points[i].tip.distance(self.path.points[i + 1].tip);
        let cuts: Vec<usize> = (0..self.motion.moves().len())
            .filter(|&i| self.path.points[i + 1].kind == MoveKind::Cut)
            .collect();
        let total: f64 = cuts.iter().map(|&i| length(i)).sum();
        let apart = total / PLACES as f64;
        let (mut places, mut before) = (Vec::new(), 0.0);
        for i in cuts {
            let end = before + length(i);
            while places.len() < PLACES && (places.len() as f64 + 0.5) * apart < end {
                let part = ((places.len() as f64 + 0.5) * apart - before) / length(i);
                places.push(Place { of: i, part });
            }
            before = end;
        }
        (places, total)
    }

    /// The way along the path to the start of every move, mm.
    fn ways(&self) -> Vec<f64> {
        let mut way = 0.0;
        let steps = self.path.points.windows(2).map(|w| w[0].tip.distance(w[1].tip));
        core::iter::once(0.0)
            .chain(steps.map(|s| {
                way += s;
                way
            }))
            .collect()
    }

    /// The crests on the two sides of a contact.
    fn beside(
        &self,
        place: &Contact,
        surface: &Surface,
        ways: &[f64],
        distance: f64,
    ) -> Option<[Option<(f64, DVec3)>; 2]> {
        let chains = surface.across(place.contact, place.way, REACH * distance)?;
        let mut steps = Vec::new();
        let reach = REACH * distance + self.material.height;
        self.motion.near(self.body, place.contact, reach, &mut |step| steps.push(*step));
        let here = ways[place.of] + place.part * (ways[place.of + 1] - ways[place.of]);
        let section = Section { survey: self, steps: &steps, ways, here, distance };
        Some(chains.map(|chain| section.crest(&chain)))
    }
}

/// The places that every move left.
fn left_by(samples: &[Outcome], moves: usize) -> Vec<Vec<DVec3>> {
    let mut left = vec![Vec::new(); moves];
    for s in samples.iter().filter(|s| s.machined && !s.too_tight) {
        if let Some(of) = s.by.and_then(|by| left.get_mut(by as usize)) {
            of.push(s.place());
        }
    }
    left
}

/// What is asked along one section.
struct Section<'a> {
    survey: &'a Survey<'a>,
    /// The steps that reach it.
    steps: &'a [Step],
    /// Ways along the path to its moves.
    ways: &'a [f64],
    /// That of the place.
    here: f64,
    /// Mean distance of passes.
    distance: f64,
}

impl Section<'_> {
    /// The highest residual between this pass and the next along a chain, and where.
    fn crest(&self, chain: &Chain) -> Option<(f64, DVec3)> {
        let mut apart = self.distance / COARSE;
        let count = (chain.length() / apart) as usize;
        let ways: Vec<f64> = (0..=count).map(|i| apart * i as f64).collect();
        let residuals = self.residuals(chain, &ways, self.steps);
        let end = self.next_pass(&residuals)?;
        let mut top = highest(&residuals[..=end]);
        if chain.length() - ways[top] < 0.5 * self.distance {
            return None;
        }
        let mut best = (residuals[top].height, ways[top]);
        let place = chain.at(best.1);
        let steps = self.reaching(place.position + place.normal * best.0, 2.0 * apart);
        for _ in 0..ROUNDS {
            let finer = apart / FINER as f64;
            let around = |k: usize| best.1 + finer * (k as f64 - FINER as f64);
            let ways: Vec<f64> = (1..2 * FINER).map(around).filter(|&w| w >= 0.0).collect();
            let residuals = self.residuals(chain, &ways, &steps);
            top = highest(&residuals);
            best = (residuals[top].height, ways[top]);
            apart = finer;
        }
        Some((best.0, chain.at(best.1).position))
    }

    /// The sample in the footprint of the next pass at which its crest is behind.
    fn next_pass(&self, residuals: &[Swept]) -> Option<usize> {
        let another = ANOTHER * self.survey.body.radius();
        let is_another = |by: u32| {
            let (start, end) = (self.ways[by as usize], self.ways[by as usize + 1]);
            (start - self.here).max(self.here - end) > another
        };
        let mut highest: f64 = 0.0;
        residuals.iter().position(|s| {
            let height = s.height - self.survey.stock;
            highest = highest.max(height);
            s.by.is_some_and(is_another) && height <= FALLEN * highest
        })
    }

    /// The steps that come within a distance of a point, or nearer than that to it.
    fn reaching(&self, point: DVec3, distance: f64) -> Vec<Step> {
        let body = self.survey.body;
        let reaches = |step: &&Step| {
            let turned = 2.0 * step.half_turn * point.distance(step.to.tip);
            let way = 2.0 * step.half_way.length() + turned;
            body.nearest(&step.to, point).distance < distance + way
        };
        self.steps.iter().filter(reaches).copied().collect()
    }

    fn residuals(&self, chain: &Chain, ways: &[f64], steps: &[Step]) -> Vec<Swept> {
        let sample = |&way: &f64| {
            let place = chain.at(way);
            Sample {
                position: place.position,
                centroid: place.position,
                normal: place.normal,
                area: 0.0,
                machined: true,
            }
        };
        let samples = ways.iter().map(sample).collect();
        swept(samples, steps, self.survey.body, self.survey.material)
    }
}

fn highest(residuals: &[Swept]) -> usize {
    (0..residuals.len())
        .fold(0, |best, i| if residuals[i].height > residuals[best].height { i } else { best })
}
