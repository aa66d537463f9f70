//! The edges of the blades on the hub → the channel between two of them, in parts where a splitter blade divides it.
//!
//! - *Part*: what has two sides from end to end. Before a splitter, and behind it where it ends within the channel, both
//!   its parts are bounded by a dividing line that runs on from its nose and its tail.

use super::beside::beside;
use super::channel::{Channel, ROWS, closed_line, part};
use super::error::HubError;
use super::sides::{Flanks, narrowest, spaced};
use super::spline::ParameterCurve;
use super::strips::Line;
use super::wheel::Wheel;
use crate::cutter_location::Hindrance;
use crate::geometry::{DVec2, DVec3};
use crate::nurbs::TrimLoop;

/// Fewest rows of a piece of a side.
const FEWEST: usize = 5;
/// Halvings in the search for the largest cutter that fits.
const HALVINGS: usize = 12;
/// Part by which that cutter is smaller than what was found.
const SPARE: f64 = 0.02;

/// How far a hub may differ from pitch to pitch, mm.
pub const ALIKE: f64 = 0.01;

/// The edges of blades on the hub, and how far passes stay away from them.
pub struct Edges<'a> {
    pub wheel: &'a Wheel,
    /// The edge of the blade, and the blade.
    pub blade: (&'a ParameterCurve, &'a Hindrance),
    /// Those of the splitter.
    pub splitter: Option<(&'a ParameterCurve, &'a Hindrance)>,
    /// Radius of the cutter and its distance from fillets, mm.
    pub radius: f64,
    pub clearance: f64,
    pub tolerance: f64,
}

/// The channel between two blades.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Its parts, from side to side.
    pub parts: Vec<Part>,
    /// Whether a splitter ends within it and leaves a hole.
    is_hole: bool,
    /// Its narrowest place and the width there, mm.
    pub narrowest: (DVec3, f64),
    /// Pitches by which the splitter stands from where it is given.
    pub splitter_pitches: i32,
}

/// A part of a channel.
#[derive(Clone, Debug)]
pub struct Part {
    pub channel: Channel,
    /// First and last row at which one of its sides is a flank of the splitter: the left one, but of the first part.
    flank: Option<(usize, usize)>,
}

impl Part {
    /// Its passes, of a part that is not the first one without what runs on the dividing line, which the part before has
    /// already.
    pub fn own(&self, lines: Vec<Line>, is_first: bool) -> Vec<Line> {
        let Some((nose, tail)) = self.flank.filter(|_| !is_first) else { return lines };
        let (from, to) = (part(nose, ROWS), part(tail, ROWS));
        let own = |mut line: Line| {
            if line.level == 0 {
                line.from = line.from.max(from);
                line.to = line.to.min(to);
            }
            line
        };
        lines.into_iter().map(own).filter(|line| line.from < line.to).collect()
    }
}

/// A side of a part, made of pieces.
struct Pieces {
    nodes: Vec<DVec2>,
    /// First row of the flank of the splitter, and its last one.
    corners: (usize, usize),
}

impl Edges<'_> {
    /// The channel behind the blade.
    ///
    /// # Errors
    /// [`HubError`]: a channel too narrow for the cutter, with the largest one that fits, or without a map.
    pub fn layout(&self) -> Result<Layout, HubError> {
        let found = self.at(self.radius + self.clearance)?;
        if found.narrowest.1 > 0.0 {
            return found.layout(self.wheel);
        }
        let (place, _) = found.narrowest;
        let (mut fits, mut too_large) = (0.0, self.radius);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (fits + too_large);
            match self.at(middle + self.clearance) {
                Ok(found) if found.narrowest.1 > 0.0 => fits = middle,
                _ => too_large = middle,
            }
        }
        if fits == 0.0 {
            return Err(self.overlap(place));
        }
        let largest = 2.0 * fits * (1.0 - SPARE);
        Err(HubError::TooNarrow {
            place,
            diameter: 2.0 * self.radius,
            clearance: self.clearance,
            largest,
        })
    }

    /// Why not even the smallest cutter fits at a place.
    fn overlap(&self, place: DVec3) -> HubError {
        let without = Edges { splitter: None, ..*self };
        let least = self.radius / f64::from(1 << HALVINGS) + self.clearance;
        let is_free = |found: Result<Found, HubError>| found.is_ok_and(|f| f.narrowest.1 > 0.0);
        match self.splitter.is_some() && is_free(without.at(least)) {
            true => HubError::SplitterAside { place },
            false => HubError::Overlap { place, blades: self.wheel.blades },
        }
    }

    /// The sides of the channel at a distance from the edges, mm.
    fn at(&self, distance: f64) -> Result<Found, HubError> {
        let (wheel, tolerance) = (self.wheel, self.tolerance);
        let clearance = self.clearance;
        let away = |(edge, blade): (&ParameterCurve, &Hindrance)| {
            beside(wheel, edge, blade, (distance - clearance, clearance), tolerance)
        };
        let blade = Flanks::new(wheel, &away(self.blade)?, true)?;
        let next = blade.carried(wheel, 1, tolerance.max(ALIKE))?;
        let (left, right) = (blade.behind, next.before);
        let mut least = narrowest(wheel, &left, &right);
        let mut splitter = None;
        if let Some(edge) = self.splitter {
            let curve = away(edge)?;
            let flanks = Flanks::new(wheel, &curve, false)?;
            let pitches = pitches_to(wheel, &left, &flanks);
            let flanks = flanks.carried(wheel, pitches, tolerance.max(ALIKE))?;
            for (a, b) in [(&left, &flanks.before), (&flanks.behind, &right)] {
                let found = narrowest(wheel, a, b);
                if found.1 < least.1 {
                    least = found;
                }
            }
            let at_rim = |flank: &[DVec2]| flank.last().is_some_and(|p| wheel.is_at_rim(*p));
            let ends_within = !(at_rim(&flanks.before) || at_rim(&flanks.behind));
            splitter = Some((flanks, ends_within, pitches));
        }
        Ok(Found { left, right, splitter, narrowest: least })
    }
}

/// Pitches by which a splitter is turned to stand behind the left side.
fn pitches_to(wheel: &Wheel, left: &[DVec2], splitter: &Flanks) -> i32 {
    let (around, along) = (wheel.around, 1 - wheel.around);
    let Some(&nose) = splitter.behind.first() else { return 0 };
    let nearest = left
        .iter()
        .min_by(|a, b| (a[along] - nose[along]).abs().total_cmp(&(b[along] - nose[along]).abs()));
    let pitch = wheel.period() / f64::from(wheel.blades);
    nearest.map_or(0, |at| ((at[around] - nose[around]) / pitch).ceil() as i32)
}

/// The sides of a channel.
struct Found {
    left: Vec<DVec2>,
    right: Vec<DVec2>,
    /// Flanks of the splitter, whether it ends within the channel, and by how many pitches it was turned.
    splitter: Option<(Flanks, bool, i32)>,
    narrowest: (DVec3, f64),
}

impl Found {
    fn layout(self, wheel: &Wheel) -> Result<Layout, HubError> {
        let Self { left, right, splitter, narrowest } = self;
        let sides = [&left, &right].map(|side| spaced(wheel, side, ROWS));
        let whole = Channel::new(wheel, &sides[0], &sides[1], &[])?;
        let Some((flanks, is_closed, splitter_pitches)) = splitter else {
            let parts = vec![Part { channel: whole, flank: None }];
            return Ok(Layout { parts, is_hole: false, narrowest, splitter_pitches: 0 });
        };
        let flanks = parted(&whole, &flanks, is_closed);
        let [before, behind] = flanks.map(|flank| Pieces::new(wheel, &whole, &flank, is_closed));
        let corners = |pieces: &Pieces, right: bool| {
            let (nose, tail) = pieces.corners;
            let all = [Some(nose), (tail + 1 < ROWS).then_some(tail)];
            all.into_iter().flatten().map(|row| (row, right)).collect::<Vec<_>>()
        };
        let first = Channel::new(wheel, &sides[0], &before.nodes, &corners(&before, true))?;
        let second = Channel::new(wheel, &behind.nodes, &sides[1], &corners(&behind, false))?;
        let parts = vec![
            Part { channel: first, flank: Some(before.corners) },
            Part { channel: second, flank: Some(behind.corners) },
        ];
        Ok(Layout { parts, is_hole: is_closed, narrowest, splitter_pitches })
    }
}

impl Pieces {
    /// A dividing line up to the nose, a flank of the splitter, and a dividing line on from its tail.
    fn new(wheel: &Wheel, whole: &Channel, flank: &[DVec2], is_closed: bool) -> Self {
        let (nose, tail) = (flank[0], flank[flank.len() - 1]);
        let line = |from: (f64, f64), to: (f64, f64), n: usize| {
            (0..n).map(move |i| {
                let x = i as f64 / (n - 1) as f64;
                (from.0 + (to.0 - from.0) * x, from.1 + (to.1 - from.1) * x)
            })
        };
        let (s, t) = whole.inverse(nose);
        let (s_tail, t_tail) = if is_closed { whole.inverse(tail) } else { (1.0, t) };
        let rows = |part: f64| ((part * (ROWS - 1) as f64).round() as usize).max(FEWEST);
        let first = rows(s);
        let last = if is_closed { rows(1.0 - s_tail) } else { 0 };
        let middle = (ROWS - 1).saturating_sub(first + last).max(FEWEST);
        let mut nodes: Vec<DVec2> =
            line((0.0, t), (s, t), first + 1).map(|(s, t)| whole.at(s, t)).collect();
        nodes.pop();
        nodes.extend(spaced(wheel, flank, middle + 1));
        if last > 0 {
            nodes.pop();
            nodes.extend(
                line((s_tail, t_tail), (1.0, t_tail), last + 1).map(|(s, t)| whole.at(s, t)),
            );
        }
        nodes.truncate(ROWS);
        Self { nodes, corners: (first, first + middle) }
    }
}

/// The flanks of a splitter, parted where lines along the channel part at its nose, and meet behind its tail.
fn parted(whole: &Channel, flanks: &Flanks, is_closed: bool) -> [Vec<DVec2>; 2] {
    let around: Vec<DVec2> =
        flanks.before.iter().rev().chain(flanks.behind.iter().skip(1)).copied().collect();
    let along: Vec<f64> = around.iter().map(|p| whole.inverse(*p).0).collect();
    let extreme = |sign: f64| {
        (0..along.len())
            .min_by(|&a, &b| (sign * along[a]).total_cmp(&(sign * along[b])))
            .unwrap_or(0)
    };
    let nose = extreme(1.0);
    if !is_closed {
        return [around[..=nose].iter().rev().copied().collect(), around[nose..].to_vec()];
    }
    let (n, tail) = (around.len(), extreme(-1.0));
    let run = |step: usize| {
        let mut at = nose;
        let mut points = vec![around[at]];
        while at != tail && points.len() <= n {
            at = (at + step) % n;
            points.push(around[at]);
        }
        points
    };
    [run(n - 1), run(1)]
}

impl Layout {
    /// Outline of the channel and its holes, as loops for a mesh.
    pub fn loops(&self) -> Vec<TrimLoop> {
        let reversed = |points: Vec<DVec2>| points.into_iter().rev().collect::<Vec<DVec2>>();
        let [first, .., last] = &self.parts[..] else {
            return self.parts.iter().map(|part| part.channel.outline()).collect();
        };
        let flank = |part: &Part, right: bool| {
            let (nose, tail) = part.flank.unwrap_or((0, ROWS - 1));
            part.channel.side(right)[nose..=tail].to_vec()
        };
        let (before, behind) = (flank(first, true), flank(last, false));
        let between = match self.is_hole {
            true => Vec::new(),
            false => [reversed(before.clone()), behind.clone()].concat(),
        };
        let outer = [
            first.channel.side(false),
            first.channel.across(ROWS - 1),
            between,
            last.channel.across(ROWS - 1),
            reversed(last.channel.side(true)),
            reversed(last.channel.across(0)),
            reversed(first.channel.across(0)),
        ];
        let mut loops = vec![closed_line(outer.concat(), true)];
        if self.is_hole {
            loops.push(closed_line([before, reversed(behind)].concat(), false));
        }
        loops
    }
}

#[cfg(test)]
mod tests;
