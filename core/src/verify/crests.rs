//! The heights of the individual cusps between neighbouring passes, from sections across the passes.
//!
//! - *Place*: a point on a cutting move; all places represent equal lengths of it.
//! - *Section*: where the plane perpendicular to the move meets the surface at the place's contact.
//! - *Crest*: the highest residual on a section between the footprints of this pass and of the next one, on either
//!   side.
//!
//! Steps: (1) places evenly along the cutting moves; (2) the contact of each: of the samples that this move left, the
//! one nearest to the cutter there; (3) residuals on the section, at first a few per pass distance, then closer
//! around the highest. The next pass is recognised by its index in the table, or, in programs and on spirals, by its
//! move, which is far away along the path; loops of a trochoid are not separate passes. Where there is no next pass,
//! or where the boundary or the end of a pass is nearer than the passes are to each other, the crest is left out.

use super::body::Body;
use super::material::{Material, Swept};
use super::motion::{Motion, Step};
use super::outcome::Outcome;
use super::samples::{Facets, Sample};
use super::section::{Chain, Surface};
use super::sweep::swept;
use crate::geometry::{DVec3, OrderBy};
use crate::parallel;
use crate::toolpath::{MoveKind, Toolpath};

/// Number of places on a path, which gives shares to a percentage point. Fewer on a path with a stated removal rate:
/// it is meant for an even cut, and trochoids leave cusps of their own.
const PLACES: usize = 1200;
const PLACES_OF_EVEN_CUT: usize = 300;
/// Reach of a section to either side, mean pass distances.
const REACH: f64 = 1.75;
/// Initial samples per mean pass distance.
const COARSE: f64 = 7.0;
/// Number of parts into which the intervals beside the highest sample are divided, and number of divisions: a crest
/// is then found to 1/1512 of a pass, where a cusp with straight flanks has lost less than half a percent.
const FINER: usize = 6;
const ROUNDS: usize = 3;
/// A pass has been left where the residual falls below this fraction of its crest.
const FALLEN: f64 = 0.6;
/// Moves farther away along the path than this belong to another pass, cutter radii.
const ANOTHER: f64 = 1.0;
/// A contact is no farther from the cutter than this fraction of the stock's height.
const TOUCH: f64 = 0.25;
/// Samples of one move that are examined for a contact.
const MOST_LOOKED_AT: usize = 4096;
/// Cusps from this fraction of the limit to the limit make good use of it.
const FULL: f64 = 0.9;

/// The heights of the cusps, mm, and how many could not be measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Crests {
    /// Heights in ascending order; each represents an equal part of the path.
    pub heights: Vec<f64>,
    /// Number of sides of the places at which the cutter touches; those without a height have no next pass, or lie
    /// near the boundary or the end of a pass.
    pub sides: usize,
    /// The place of the highest cusp.
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
    pub fn measured_share(&self) -> f64 {
        self.heights.len() as f64 / self.sides.max(1) as f64
    }
}

/// Where crests are searched.
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
    pub allowance: f64,
}

/// A place on a cutting move.
struct Place {
    /// Index of the move.
    of: usize,
    /// Part of it.
    part: f64,
}

/// Where the moves lie on their passes.
struct Course {
    /// Distance along cuts to the start of every move, and to the end of the last, mm.
    cut: Vec<f64>,
    /// The same along cuts and trochoids.
    all: Vec<f64>,
    /// Where, in that distance, the pass of a move begins and ends.
    ends: Vec<[f64; 2]>,
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
    /// The crests beside the passes. `samples`: the simulated samples of the surface.
    pub fn crests(&self, design: Facets, samples: &[Outcome], threads: usize) -> Crests {
        let surface = Surface::new(design);
        let left = left_by(samples, self.motion.moves().len());
        let course = Course::new(self.path);
        let (places, length) = self.places();
        let mut contacts = parallel::map(threads, &places, |p: &Place| self.contact(p, &left));
        contacts.retain(Option::is_some);
        // What the moves on the surface left, over their length.
        let cut = length * contacts.len() as f64 / places.len().max(1) as f64;
        let distance = (self.cut_area(samples) / cut).min(2.0 * self.body.radius());
        let found = parallel::map(threads, &contacts, |contact: &Option<Contact>| {
            let contact = contact.as_ref()?;
            self.beside(contact, &surface, &course, distance)
        });
        let mut crests: Vec<(f64, DVec3)> =
            found.into_iter().flatten().flatten().flatten().collect();
        crests.order_by(|a, b| a.0.total_cmp(&b.0));
        Crests {
            sides: 2 * contacts.len(),
            highest_at: crests.last().map(|c| c.1),
            heights: crests.into_iter().map(|c| c.0 - self.allowance).collect(),
        }
    }

    /// The area whose final height moves along passes determined, mm².
    fn cut_area(&self, samples: &[Outcome]) -> f64 {
        let is_cut = |s: &&Outcome| {
            let end = s.by.and_then(|by| self.path.points.get(by as usize + 1));
            s.machined && end.is_some_and(|p| p.kind == MoveKind::Cut)
        };
        samples.iter().filter(is_cut).map(|s| f64::from(s.area)).sum()
    }

    /// Contact of the cutter at a place, if it touches there.
    fn contact(&self, place: &Place, left: &[Vec<DVec3>]) -> Option<Contact> {
        let m = &self.motion.moves()[place.of];
        let at = m.at(place.part);
        let candidates = left.get(place.of)?;
        let stride = candidates.len() / MOST_LOOKED_AT + 1;
        let far = |p: &DVec3| self.body.nearest(&at, *p).distance;
        let looked_at = candidates.iter().step_by(stride).map(|p| (far(p), *p));
        let (distance, contact) = looked_at.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let way = (m.to.tip - m.from.tip).try_normalize()?;
        let (of, part) = (place.of, place.part);
        (distance < TOUCH * self.material.height).then_some(Contact { of, part, contact, way })
    }

    /// Places evenly along the cutting moves, and the length of these moves.
    fn places(&self) -> (Vec<Place>, f64) {
        let length = |i: usize| self.path.points[i].tip.distance(self.path.points[i + 1].tip);
        let cuts: Vec<usize> = (0..self.motion.moves().len())
            .filter(|&i| self.path.points[i + 1].kind == MoveKind::Cut)
            .collect();
        let total: f64 = cuts.iter().map(|&i| length(i)).sum();
        let tells_rate = self.path.points.iter().any(|p| p.mrr > 0.0);
        let count = if tells_rate { PLACES_OF_EVEN_CUT } else { PLACES };
        let apart = total / count as f64;
        let (mut places, mut before) = (Vec::new(), 0.0);
        for i in cuts {
            let end = before + length(i);
            while places.len() < count && (places.len() as f64 + 0.5) * apart < end {
                let part = ((places.len() as f64 + 0.5) * apart - before) / length(i);
                places.push(Place { of: i, part });
            }
            before = end;
        }
        (places, total)
    }

    /// The crests on the two sides of a contact.
    fn beside(
        &self,
        place: &Contact,
        surface: &Surface,
        course: &Course,
        distance: f64,
    ) -> Option<[Option<(f64, DVec3)>; 2]> {
        if course.is_near_end(place.of, place.part, distance) {
            return None;
        }
        let chains = surface.across(place.contact, place.way, REACH * distance)?;
        let mut steps = Vec::new();
        let reach = REACH * distance + self.material.height;
        self.motion.near(self.body, place.contact, reach, &mut |step| steps.push(*step));
        let section = Section { survey: self, place, surface, steps: &steps, course, distance };
        Some(chains.map(|chain| section.crest(&chain)))
    }
}

/// The samples left by each move.
fn left_by(samples: &[Outcome], moves: usize) -> Vec<Vec<DVec3>> {
    let mut left = vec![Vec::new(); moves];
    for s in samples.iter().filter(|s| s.machined && !s.inaccessible) {
        if let Some(of) = s.by.and_then(|by| left.get_mut(by as usize)) {
            of.push(s.place());
        }
    }
    left
}

/// Whether a move cuts along a pass or in loops on it.
fn is_on_pass(kind: MoveKind) -> bool {
    matches!(kind, MoveKind::Cut | MoveKind::Trochoid | MoveKind::Return)
}

impl Course {
    fn new(path: &Toolpath) -> Self {
        let way = |counts: &dyn Fn(MoveKind) -> bool| {
            let mut way = 0.0;
            let steps = path.points.windows(2).map(|w| {
                way += if counts(w[1].kind) { w[0].tip.distance(w[1].tip) } else { 0.0 };
                way
            });
            core::iter::once(0.0).chain(steps).collect::<Vec<f64>>()
        };
        let (cut, all) = (way(&|kind| kind == MoveKind::Cut), way(&is_on_pass));
        let mut ends = vec![[0.0; 2]; path.points.len().saturating_sub(1)];
        // Stretches on which neither the pass changes nor a link or rapid lies between.
        let key = |i: usize| (is_on_pass(path.points[i + 1].kind), path.points[i + 1].pass);
        let mut first = 0;
        for i in 0..ends.len() {
            if i + 1 == ends.len() || key(i + 1) != key(i) {
                ends[first..=i].fill([all[first], all[i + 1]]);
                first = i + 1;
            }
        }
        Self { cut, all, ends }
    }

    /// Whether a part of a move lies less than `distance` mm from the end of its pass.
    fn is_near_end(&self, of: usize, part: f64, distance: f64) -> bool {
        let at = self.all[of] + part * (self.all[of + 1] - self.all[of]);
        let [first, last] = self.ends[of];
        at - first < distance || last - at < distance
    }
}

/// The data of one section.
struct Section<'a> {
    survey: &'a Survey<'a>,
    place: &'a Contact,
    surface: &'a Surface<'a>,
    /// The steps that reach it.
    steps: &'a [Step],
    course: &'a Course,
    /// Mean distance of passes.
    distance: f64,
}

impl Section<'_> {
    /// The highest residual between this pass and the next along a chain, and its place.
    fn crest(&self, chain: &Chain) -> Option<(f64, DVec3)> {
        let mut apart = self.distance / COARSE;
        let count = (chain.length() / apart) as usize;
        let ways: Vec<f64> = (0..=count).map(|i| apart * i as f64).collect();
        let residuals = self.residuals(chain, &ways, self.steps);
        let end = self.next_pass(&residuals)?;
        let mut top = highest(&residuals[..=end]);
        if self.is_left_out(&residuals[end], chain, ways[top]) {
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

    /// The sample in the footprint of the next pass that marks the end of the crest.
    fn next_pass(&self, residuals: &[Swept]) -> Option<usize> {
        let mut highest: f64 = 0.0;
        residuals.iter().position(|s| {
            let height = s.height - self.survey.allowance;
            highest = highest.max(height);
            s.by.is_some_and(|by| self.is_another(by as usize)) && height <= FALLEN * highest
        })
    }

    /// Whether a move is on another pass, or on another turn of a spiral.
    fn is_another(&self, by: usize) -> bool {
        let points = &self.survey.path.points;
        let (own, other) = (&points[self.place.of + 1], &points[by + 1]);
        if own.pass != other.pass {
            return is_on_pass(other.kind);
        }
        let cut = &self.course.cut;
        let here =
            cut[self.place.of] + self.place.part * (cut[self.place.of + 1] - cut[self.place.of]);
        let far = (cut[by] - here).max(here - cut[by + 1]);
        other.kind == MoveKind::Cut && far > ANOTHER * self.survey.body.radius()
    }

    /// Whether a crest `way` mm along a chain is near the boundary, or the next pass, of which a sample is given,
    /// ends near it.
    fn is_left_out(&self, next: &Swept, chain: &Chain, way: f64) -> bool {
        let (distance, crest) = (self.distance, chain.at(way));
        let ends = |by: u32| {
            let m = &self.survey.motion.moves()[by as usize];
            let along = m.to.tip - m.from.tip;
            let part = (crest.position - m.from.tip).dot(along) / along.length_squared();
            self.course.is_near_end(
                by as usize,
                if part > 0.0 { part.min(1.0) } else { 0.0 },
                distance,
            )
        };
        if chain.is_near_boundary(way, distance) || next.by.is_none_or(ends) {
            return true;
        }
        let across = crest.normal.cross(self.place.way).normalize_or(self.place.way);
        let along = self.surface.across(crest.position, across, distance);
        along.is_none_or(|chains| chains.iter().any(|c| c.is_near_boundary(0.0, distance)))
    }

    /// The steps that come within a distance of a point, or nearer than that to it.
    fn reaching(&self, point: DVec3, distance: f64) -> Vec<Step> {
        let body = self.survey.body;
        let reaches = |step: &&Step| step.may_come_near(body, point, distance);
        self.steps.iter().filter(reaches).copied().collect()
    }

    fn residuals(&self, chain: &Chain, ways: &[f64], steps: &[Step]) -> Vec<Swept> {
        let sample = |&way: &f64| {
            let place = chain.at(way);
            Sample::bare(place.position, place.normal)
        };
        let samples = ways.iter().map(sample).collect();
        swept(samples, steps, self.survey.body, self.survey.material)
    }
}

fn highest(residuals: &[Swept]) -> usize {
    (0..residuals.len())
        .fold(0, |best, i| if residuals[i].height > residuals[best].height { i } else { best })
}
