//! The cutter moving through the stock: every move measured, then swept, in cutting order.

use super::arc::Engagement;
use super::capsule::Capsule;
use super::swept::{Checkpoint, Stock};
use crate::flat_path::{FlatPoint, Terrain};
use crate::geometry::DVec2;
use crate::job::FeedComponent;
use crate::toolpath::MoveKind;

/// Distance between engagement samples as a fraction of the cutter radius. Larger: peaks between samples are missed;
/// smaller: proportionally slower.
const SAMPLE: f64 = 0.1;
/// Longest capsule as a fraction of the cutter radius; the scale is taken as linear along it.
const LONGEST: f64 = 0.5;
/// Reduced feeds come from the ladder `nominal * RUNG^n`, so that the program is not full of feed
/// words. Smaller: fewer words, more time lost.
const RUNG: f64 = 0.97;
/// An engagement below this counts as rounding.
const IDLE: f64 = 1e-9;
/// Limited moves aim at this fraction of the limit, so that rounding of the program stays below it.
const AIM: f64 = 0.995;

/// Cutting data of the simulation.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Cutting {
    /// Cutter radius `R`, mm.
    pub radius: f64,
    /// Axial depth `H`, mm.
    pub depth: f64,
    /// Nominal feed `V_f`, mm/s.
    pub feed: f64,
    /// Which feed component counts.
    pub vfc: FeedComponent,
    /// Limit on the removal rate, mm³/s; infinite when there is none.
    pub limit: f64,
}

impl Cutting {
    /// Removal rate of an engagement at the nominal feed, mm³/s.
    pub fn rate(&self, engagement: &Engagement) -> f64 {
        self.radius * self.depth * self.feed * engagement.intensity(self.vfc)
    }
}

/// A saved state of a simulation.
#[derive(Debug)]
pub struct Mark {
    points: usize,
    stock: Checkpoint,
    at: DVec2,
}

/// A cutter moving through the stock.
pub struct Simulation<'a> {
    /// Cutting data.
    pub cutting: Cutting,
    /// The surface as seen in the plane.
    pub terrain: &'a dyn Terrain,
    stock: Stock,
    points: Vec<FlatPoint>,
    pass: u32,
    region: u32,
    at: DVec2,
    heading: Option<DVec2>,
}

impl<'a> Simulation<'a> {
    /// A simulation before its first move.
    pub fn new(cutting: Cutting, terrain: &'a dyn Terrain, stock: Stock) -> Self {
        Self {
            cutting,
            terrain,
            stock,
            points: Vec::new(),
            pass: 0,
            region: 0,
            at: DVec2::ZERO,
            heading: None,
        }
    }

    /// Where the cutter is.
    pub fn at(&self) -> DVec2 {
        self.at
    }

    /// Whether any move was made.
    pub fn has_begun(&self) -> bool {
        !self.points.is_empty()
    }

    /// The moves made, in order.
    pub fn points(&self) -> &[FlatPoint] {
        &self.points
    }

    /// The moves made and what is left of the stock.
    pub fn finish(self) -> (Vec<FlatPoint>, Stock) {
        (self.points, self.stock)
    }

    /// Moves from now on belong to a region.
    pub fn begin_region(&mut self, region: u32) {
        self.region = region;
    }

    /// Moves from now on belong to the next pass.
    pub fn next_pass(&mut self) {
        self.pass += 1;
    }

    /// Cutter radius in the plane, flat mm; where the chart ends, the scale of the last known point is used.
    pub fn disc(&self, at: DVec2) -> f64 {
        let scale = self.terrain.scale(at).or_else(|| self.terrain.scale(self.at));
        self.cutting.radius / scale.unwrap_or(1.0)
    }

    /// Marks the present state.
    pub fn mark(&mut self) -> Mark {
        Mark { points: self.points.len(), stock: self.stock.checkpoint(), at: self.at }
    }

    /// Undoes everything since the mark.
    pub fn undo(&mut self, mark: &Mark) {
        self.points.truncate(mark.points);
        self.stock.rollback(&mark.stock);
        self.at = mark.at;
    }

    /// Discards the mark.
    pub fn keep(&mut self) {
        self.stock.commit();
    }

    /// The moves made since the mark.
    pub fn since(&self, mark: &Mark) -> &[FlatPoint] {
        &self.points[mark.points..]
    }

    /// Arrives at `to` from above, through air or where the stock is open.
    pub fn arrive(&mut self, to: DVec2, height: f64, kind: MoveKind) {
        self.at = to;
        self.push(to, height, kind, 0.0, self.cutting.feed, Engagement::default(), 0.0);
    }

    /// Removes the disc at the present place without measuring it: a plunge.
    pub fn plunge(&mut self) {
        let r = self.disc(self.at);
        self.stock.sweep(Capsule::new(self.at, r, self.at, r));
    }

    /// Whether stock is left at a flat place.
    pub fn has_stock(&self, at: DVec2) -> bool {
        self.stock.has_stock(at)
    }

    /// Whether nothing is left of the stock under the cutter at `at`.
    pub fn is_clear(&self, at: DVec2) -> bool {
        let r = self.disc(at);
        let all_round = |feed| self.stock.engagement(at, r, feed).normal_feed == 0.0;
        !self.stock.has_stock(at) && all_round(DVec2::X) && all_round(DVec2::NEG_X)
    }

    /// Engagement at `at` in the unit direction `feed`.
    pub fn engagement(&self, at: DVec2, feed: DVec2) -> Engagement {
        self.stock.engagement(at, self.disc(at), feed)
    }

    /// Moves straight to `to` at the nominal feed.
    pub fn cut(&mut self, to: DVec2, kind: MoveKind) {
        self.advance(to, kind, false);
    }

    /// Moves straight to `to`, slower where the limit requires it.
    pub fn cut_limited(&mut self, to: DVec2, kind: MoveKind) {
        self.advance(to, kind, true);
    }

    /// Makes moves on which the cutter keeps facing its present direction: a leaning axis would swing round with
    /// every turn of a short detour.
    pub fn facing_on(&mut self, moves: impl FnOnce(&mut Self)) {
        if let [.., a, b] = &self.points[..] {
            self.heading = (b.at - a.at).try_normalize();
        }
        moves(self);
        self.heading = None;
    }

    /// From now on the cutter faces a flat direction; with `None` the one in which it moves.
    pub fn face(&mut self, heading: Option<DVec2>) {
        self.heading = heading;
    }

    /// The last move comes from, or goes on, beyond the chart: see [`FlatPoint::overrun`].
    pub fn overrun(&mut self, by: f64) {
        if let Some(last) = self.points.last_mut() {
            last.overrun = by;
        }
    }

    /// Moves at a height through stock whose removal rate at that feed is known, mm³/s.
    pub fn descend(&mut self, to: DVec2, height: f64, mrr: f64, feed: f64) {
        let (from, r0) = (self.at, self.disc(self.at));
        let r1 = self.disc(to);
        self.stock.sweep(Capsule::new(from, r0, to, r1));
        let length = (to - from).length() * 0.5 * self.cutting.radius * (1.0 / r0 + 1.0 / r1);
        self.at = to;
        let engagement = Engagement { alpha: 2.0 * core::f64::consts::PI, normal_feed: 0.0 };
        self.push(to, height, MoveKind::Link, mrr, feed, engagement, length);
    }

    fn advance(&mut self, to: DVec2, kind: MoveKind, limited: bool) {
        let r = self.disc(self.at);
        let (start, whole) = (self.at, to - self.at);
        let length = whole.length();
        if length == 0.0 {
            return;
        }
        let capsules = (length / (LONGEST * r)).ceil().max(1.0) as usize;
        for c in 1..=capsules {
            self.advance_capsule(start + whole * (c as f64 / capsules as f64), kind, limited);
        }
    }

    /// One capsule, measured in pieces before it is swept: what a straight move has swept itself never lies under its
    /// own leading half circle.
    fn advance_capsule(&mut self, to: DVec2, kind: MoveKind, limited: bool) {
        let from = self.at;
        let (r0, r1) = (self.disc(from), self.disc(to));
        let (along, length) = (to - from, (to - from).length());
        let feed = along / length;
        let pieces = (length / (SAMPLE * r0.min(r1))).ceil().max(1.0) as usize;
        let mut idle = true;
        let on_surface = length * 0.5 * self.cutting.radius * (1.0 / r0 + 1.0 / r1);
        for i in 0..pieces {
            let t = (i as f64 + 0.5) / pieces as f64;
            let engagement = self.stock.engagement(from + along * t, r0 + (r1 - r0) * t, feed);
            idle &= engagement.normal_feed < IDLE;
            let rate = self.cutting.rate(&engagement);
            let factor = if limited { feed_factor(rate, self.cutting.limit) } else { 1.0 };
            let end = from + along * ((i + 1) as f64 / pieces as f64);
            self.push(
                end,
                0.0,
                kind,
                rate * factor,
                self.cutting.feed * factor,
                engagement,
                on_surface / pieces as f64,
            );
        }
        // The idle half of a loop takes nothing, and there are many of them.
        if !(idle && kind == MoveKind::Trochoid) {
            self.stock.sweep(Capsule::new(from, r0, to, r1));
        }
        self.at = to;
    }

    #[allow(clippy::too_many_arguments, reason = "the fields of the one point it pushes")]
    fn push(
        &mut self,
        at: DVec2,
        height: f64,
        kind: MoveKind,
        mrr: f64,
        feed: f64,
        engagement: Engagement,
        length: f64,
    ) {
        let alpha = engagement.alpha;
        self.points.push(FlatPoint {
            at,
            height,
            kind,
            pass: self.pass,
            region: self.region,
            feed,
            mrr,
            alpha,
            length,
            heading: self.heading,
            overrun: 0.0,
        });
    }

    /// Gives the moves from index `from` on another kind and feed where they cut nothing.
    pub fn hurry_idle(&mut self, from: usize, feed: f64) {
        for p in &mut self.points[from..] {
            if p.mrr == 0.0 && p.kind == MoveKind::Trochoid {
                p.kind = MoveKind::Return;
                p.feed = feed;
            }
        }
    }
}

/// The largest rung of the feed ladder that keeps `rate` at the limit.
fn feed_factor(rate: f64, limit: f64) -> f64 {
    if rate <= limit {
        return 1.0;
    }
    let mut factor = RUNG;
    while rate * factor > limit * AIM && factor > 1e-6 {
        factor *= RUNG;
    }
    factor
}
