//! One pass of cutter contacts → the fewest cutter locations that keep to the tolerance.
//!
//! Steps: (1) an axis and a tip for every contact, the tip lifted clear of the part. (2) Between neighbours,
//! midpoints are tested and lifted where the straight piece would gouge. (3) Points are dropped while the path stays
//! within half the tolerance of the dense one; points where the feed changes are kept. (4) The remaining pieces are
//! tested again against the part, and split where they gouge.
//!
//! The tolerance is divided: a quarter for penetration that is accepted at contacts (walls beside the cutter), a
//! quarter for penetration between them, half for the dropped points.

use super::error::LocateError;
use super::obstacles::Obstacles;
use super::options::PassOptions;
use super::probe::{Placed, Probe};
use super::ruling::corner;
use super::tip::{contact_offset, tip};
use crate::geometry::DVec3;
use crate::tool::Tool;
use crate::toolpath::MoveKind;

/// A point of a pass on the surface; consecutive contacts are joined by straight pieces.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Contact {
    /// Position on the surface, mm.
    pub position: DVec3,
    /// Unit surface normal toward the tool.
    pub normal: DVec3,
    /// Direction of travel, of any length.
    pub feed_direction: DVec3,
    /// The caller's own index.
    pub key: usize,
    /// Feed on the piece that ends here, mm/s; a change of it survives the reduction.
    pub feed: f64,
    /// Purpose of the piece that ends here; a change of it survives the reduction.
    pub kind: MoveKind,
    /// How far facets and smooth surface may be apart here, mm; see [`facet_error`].
    pub facet_error: f64,
}

/// A point of the located path.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Located {
    /// Tool tip, mm.
    pub tip: DVec3,
    /// Unit tool axis.
    pub axis: DVec3,
    /// Contact it was located from, mm.
    pub contact: DVec3,
    /// Unit surface normal there.
    pub normal: DVec3,
    /// Feed of the move that ends here, mm/s.
    pub feed: f64,
    /// How far the tip was lifted from touching the contact, mm; infinite where there is no path between the points
    /// before and behind.
    pub raise: f64,
    /// Whether it is the location of that very contact, not of a place between contacts or beside a wall.
    pub is_of_contact: bool,
    /// Keys of the first and the last contact whose pieces the move that ends here covers.
    pub keys: (usize, usize),
}

/// A span of the pass where the cutter does not fit: it was lifted beyond the tolerance and the facets'
/// own error.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LiftedSpan {
    /// First contact, mm.
    pub from: DVec3,
    /// Last contact, mm.
    pub to: DVec3,
    /// Length along the contacts, mm.
    pub length: f64,
    /// Largest raise, mm.
    pub raise: f64,
    /// Contact where it occurs, mm.
    pub place: DVec3,
}

/// A located pass.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct LocatedPass {
    /// The path, in order.
    pub points: Vec<Located>,
    /// Where the cutter does not fit.
    pub lifted: Vec<LiftedSpan>,
}

/// An upper bound of the raise, mm, caused by facets and interpolated normals alone, for a cutter of radius `radius`
/// on a facet with these corners and unit vertex normals.
///
/// The arc over an edge whose normals differ by `beta` rises `length * beta / 8` above it, and a
/// cutter tilted by `beta` against the facet cuts `radius * beta^2 / 2` into it.
pub fn facet_error(corners: [DVec3; 3], normals: [DVec3; 3], radius: f64) -> f64 {
    let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    (0..3).fold(0.0, |worst: f64, i| {
        let j = (i + 1) % 3;
        let along_edge = (normals[j] - normals[i]).length();
        let tilt = (normals[i] - face).length();
        let sagitta = (corners[j] - corners[i]).length() * along_edge / 8.0;
        worst.max(sagitta + 0.5 * radius * tilt * tilt)
    })
}

/// Locates the cutter along a pass. `axes`: the unit tool axis at each contact ([`tool_axes`](super::tool_axes)).
///
/// Every straight piece of the result
/// stays within `tolerance` of the lifted path and penetrates the part (grown by the allowance) no deeper than that;
/// in five axes the depth of the cut follows from tip and axis and is held to the same tolerance. Where the wanted
/// position would require a jump, the cutter is lifted along its axis beside the obstacle.
///
/// # Errors
/// [`LocateError::BelowHorizon`] where the surface faces away from a fixed axis,
/// [`LocateError::NotFinite`] for an invalid contact.
pub fn locate_pass(
    contacts: &[Contact],
    axes: &[DVec3],
    options: &PassOptions,
    obstacles: &Obstacles,
) -> Result<LocatedPass, LocateError> {
    require_finite(contacts)?;
    require_reachable(contacts, axes)?;
    let probe = Probe::new(options, obstacles);
    let dense = dense_path(contacts, axes, options, &probe);
    let kept = reduce(&dense, contacts, options, &probe);
    let points = kept
        .iter()
        .enumerate()
        .map(|(i, &k)| located(contacts, &dense, if i == 0 { None } else { Some(kept[i - 1]) }, k))
        .collect();
    Ok(LocatedPass { points, lifted: lifted_spans(contacts, &dense, options.tolerance) })
}

/// A point of the dense path.
#[derive(Copy, Clone)]
struct Dense {
    tip: DVec3,
    axis: DVec3,
    contact: DVec3,
    normal: DVec3,
    raise: f64,
    /// The contact at which the piece that holds this point ends.
    piece: usize,
    /// Whether this point is that contact.
    at_contact: bool,
    /// Whether it was tested to penetrate by at most a quarter of the tolerance.
    tested: bool,
    /// Whether it was lifted out of everything that it would penetrate.
    is_free: bool,
    /// Direction out of the wall off which the cutter was moved, unit.
    away: Option<DVec3>,
}

impl Probe<'_> {
    /// The longest step, mm, of which only the midpoint is tested.
    ///
    /// When a cutter turns about its contact, its rounding, of radius `r`, passes places that it was not near before.
    /// Between places `s/2` apart it penetrates by up to `s²/(32 r)`, here three quarters of the tolerance.
    fn longest_step(&self, a: &Dense, b: &Dense) -> f64 {
        let mut longest = 0.5 * self.tool.radius();
        // Off a wall that turns, or off its end: between places `s/2` apart it penetrates by up to `s²/(32 R)`.
        let is_turning = match (a.away, b.away) {
            (None, None) => false,
            (Some(a), Some(b)) => a.dot(b) < STRAIGHT,
            _ => true,
        };
        if is_turning {
            longest = longest.min((8.0 * self.tool.radius() * self.tolerance).sqrt());
        }
        let is_swing = a.tip.distance(b.tip) > SWING * a.contact.distance(b.contact);
        if !is_swing {
            return longest;
        }
        let corner = self.tool.corner_radius();
        let rounding = if corner > 0.0 { corner } else { self.tool.radius() };
        longest.min((24.0 * rounding * self.tolerance).sqrt())
    }

    /// Whether two places of one contact are apart: beside a wall, the cutter was moved off it to one side and to the
    /// other. Over an edge it swings from one to the other.
    fn is_jump(&self, a: &Dense, b: &Dense) -> bool {
        let is_off_wall = a.away.is_some() || b.away.is_some();
        is_off_wall && same_axis(a.axis, b.axis) && a.contact.distance(b.contact) < self.tolerance
    }

    /// Whether the move between two places leads from the cut up onto what stands beside the surface: the cut is to
    /// reach its foot.
    fn is_ramp(&self, a: &Dense, b: &Dense) -> bool {
        !self.obstacles.rulings().is_empty() && (a.raise - b.raise).abs() > self.tool.radius()
    }

    /// Whether the cutter in the middle between two places certainly penetrates by less than a quarter of the
    /// tolerance, because it penetrates nothing at either place.
    ///
    /// A cutter of corner radius `r` is a ball of that radius swept over a convex set. What is clear at both ends of
    /// a step `s` is at least `r` from each of the two copies of every ball, and so `sqrt(r² - s²/4)` from the one in
    /// the middle (parallelogram law).
    fn is_between(&self, a: &Dense, b: &Dense) -> bool {
        let r = self.tool.corner_radius();
        let square = 0.25 * a.tip.distance_squared(b.tip);
        let is_same = a.is_free && b.is_free && same_axis(a.axis, b.axis);
        if !is_same || self.reach.is_finite() || square >= r * r {
            return false;
        }
        r - (r * r - square).sqrt() + FREE < 0.25 * self.tolerance
    }
}

fn require_finite(contacts: &[Contact]) -> Result<(), LocateError> {
    let bad = contacts.iter().position(|c| {
        let finite = c.position.is_finite() && c.feed_direction.is_finite() && c.feed.is_finite();
        !finite || !(1.0 - 1e-6..1.0 + 1e-6).contains(&c.normal.length())
    });
    match bad {
        Some(index) => Err(LocateError::NotFinite { index, place: contacts[index].position }),
        None => Ok(()),
    }
}

fn require_reachable(contacts: &[Contact], axes: &[DVec3]) -> Result<(), LocateError> {
    let away = |i: &usize| contacts[*i].normal.dot(axes[*i]) <= 0.0;
    let Some(first) = (0..contacts.len()).find(away) else { return Ok(()) };
    let cosine = contacts[first].normal.dot(axes[first]);
    Err(LocateError::BelowHorizon {
        count: (0..contacts.len()).filter(away).count(),
        total: contacts.len(),
        place: contacts[first].position,
        degrees: crate::geometry::math::acos_clamped(cosine).to_degrees(),
    })
}

/// Steps 1 and 2.
fn dense_path(
    contacts: &[Contact],
    axes: &[DVec3],
    options: &PassOptions,
    probe: &Probe,
) -> Vec<Dense> {
    let mut dense: Vec<Dense> = Vec::with_capacity(contacts.len());
    for (piece, (contact, &axis)) in contacts.iter().zip(axes).enumerate() {
        let touching =
            tip(&options.tool, contact.position, contact.normal, axis, options.allowance);
        let Placed { tip, raise, is_free, away } = probe.placed(touching, axis, contact.normal);
        let point = Dense {
            tip,
            axis,
            contact: contact.position,
            normal: contact.normal,
            raise,
            piece,
            at_contact: true,
            tested: true,
            is_free,
            away,
        };
        if let Some(corner) = point.away.and_then(|_| in_corner(&dense, &point, probe)) {
            let first = dense.iter().rposition(|d| d.away.is_some()).map_or(0, |i| i + 1);
            let rest = dense.split_off(first);
            if let Some(&before) = dense.last() {
                let piece = rest.first().map_or(corner.piece, |d| d.piece);
                between(&before, &Dense { piece, ..corner }, probe, DEEPEST, &mut dense);
            }
            // What cut the corner goes into it.
            let Dense { tip, axis, raise, is_free, away, .. } = corner;
            dense.extend(rest.into_iter().map(|d| Dense { tip, axis, raise, is_free, away, ..d }));
            dense.push(corner);
        }
        if let Some(&before) = dense.last() {
            between(&before, &point, probe, DEEPEST, &mut dense);
        }
        dense.push(point);
    }
    dense
}

/// The point in the corner of two walls, where the move from the last point that touches one to `b`, which touches
/// the other, cuts that corner.
fn in_corner(dense: &[Dense], b: &Dense, probe: &Probe) -> Option<Dense> {
    let last = dense.iter().rposition(|d| d.away.is_some())?;
    let a = &dense[last];
    let middle = midpoint(a, b);
    let corner = corner((a.tip, a.away?), (b.tip, b.away?), middle.axis)?;
    let leads_to =
        |from: &Dense, to: &Dense| to.away.is_some_and(|out| (corner - from.tip).dot(out) < 0.0);
    if !leads_to(a, b) || !leads_to(b, a) {
        return None;
    }
    let far = corner.distance(middle.tip);
    if far <= 0.25 * probe.tolerance || far >= CORNER * a.tip.distance(b.tip) {
        return None;
    }
    let way = |from: DVec3, places: &mut dyn Iterator<Item = DVec3>| {
        places.fold((0.0, from), |(length, from), to| (length + from.distance(to), to)).0
    };
    let there = way(a.tip, &mut [corner, b.tip].into_iter());
    let now = way(a.tip, &mut dense[last + 1..].iter().chain([b]).map(|d| d.tip));
    let placed = (now <= there + probe.tolerance)
        .then(|| probe.placed(corner, middle.axis, middle.normal))?;
    let Placed { tip, raise, is_free, away } = placed;
    let is_low = raise <= a.raise.max(b.raise);
    is_low.then_some(Dense { tip, raise, is_free, away: away.or(a.away), ..middle })
}

/// Greatest distance of a corner from the line between its walls, in lengths of that line.
const CORNER: f64 = 4.0;
/// Cosine of the angle between directions out of one straight wall.
const STRAIGHT: f64 = 1.0 - 1e-9;
/// Greatest travel of the tip, in travels of its contact, where the cutter turns about it.
const SWING: f64 = 2.0;
/// Penetration that a lifted cutter may still have, mm: a bound of [`CheckMesh::raise`].
const FREE: f64 = 2e-6;
/// Halvings of a piece between contacts; 2^12 parts of a long piece are shorter than any tolerance.
const DEEPEST: u32 = 12;

/// Appends the points needed between `a` and `b` so that no straight piece gouges; returns whether there are any.
fn between(a: &Dense, b: &Dense, probe: &Probe, depth: u32, out: &mut Vec<Dense>) -> bool {
    let step = b.tip - a.tip;
    let is_short = step.length() < probe.longest_step(a, b);
    if is_short && probe.is_between(a, b) {
        return false;
    }
    if !is_short && (depth == 0 || probe.is_jump(a, b)) {
        let is_blocked = !probe.is_straight_clear((a.tip, a.axis), (b.tip, b.axis));
        out.extend(is_blocked.then(|| Dense { raise: f64::INFINITY, ..midpoint(a, b) }));
        return is_blocked;
    }
    let mut middle = midpoint(a, b);
    let across = (step - middle.axis * step.dot(middle.axis)).length();
    if depth > 0 && across >= 0.25 * probe.tolerance && probe.is_ramp(a, b) {
        let Placed { tip, raise, is_free, away } =
            probe.placed(middle.tip - middle.axis * middle.raise, middle.axis, middle.normal);
        middle = Dense { tip, raise, is_free, away, ..middle };
        between(a, &middle, probe, depth - 1, out);
        out.push(middle);
        between(&middle, b, probe, depth - 1, out);
        return true;
    }
    let clear = probe.clears(middle.tip, middle.axis, 0.25 * probe.tolerance);
    if clear && (is_short || depth == 0) {
        return false;
    }
    if !clear && (across < 0.25 * probe.tolerance || depth == 0) {
        out.push(lifted_beside(a, b));
        return true;
    }
    if !clear {
        let Placed { tip, raise, is_free, away } =
            probe.placed(middle.tip, middle.axis, middle.normal);
        middle = Dense { tip, raise: middle.raise + raise, is_free, away, ..middle };
    }
    let mark = out.len();
    let first_half = between(a, &middle, probe, depth - 1, out);
    out.push(middle);
    let second_half = between(&middle, b, probe, depth - 1, out);
    if clear && !first_half && !second_half {
        out.truncate(mark);
        return false;
    }
    true
}

/// The midpoint of a piece; [`between`] keeps it only after testing it.
fn midpoint(a: &Dense, b: &Dense) -> Dense {
    Dense {
        tip: 0.5 * (a.tip + b.tip),
        axis: (a.axis + b.axis).try_normalize().unwrap_or(b.axis),
        contact: 0.5 * (a.contact + b.contact),
        normal: (a.normal + b.normal).try_normalize().unwrap_or(b.normal),
        raise: 0.5 * (a.raise + b.raise),
        piece: b.piece,
        at_contact: false,
        tested: true,
        is_free: false,
        away: None,
    }
}

/// The lower of two points, lifted along its axis to the height of the higher one: a lift up a wall.
fn lifted_beside(a: &Dense, b: &Dense) -> Dense {
    let climb = (b.tip - a.tip).dot(a.axis);
    let (low, axis) = if climb > 0.0 { (a, a.axis) } else { (b, b.axis) };
    let lift = (b.tip - a.tip).dot(axis).abs();
    Dense {
        tip: low.tip + axis * lift,
        axis,
        raise: low.raise + lift,
        piece: b.piece,
        at_contact: false,
        tested: false,
        is_free: false,
        away: None,
        ..*low
    }
}

/// Steps 3 and 4: indices into `dense` of the points that are kept.
fn reduce(
    dense: &[Dense],
    contacts: &[Contact],
    options: &PassOptions,
    probe: &Probe,
) -> Vec<usize> {
    if dense.is_empty() {
        return Vec::new();
    }
    let fixed = |k: usize| {
        let piece = dense[k].piece;
        // There the cutter retracts.
        let is_gap = |k: usize| dense.get(k).is_some_and(|d| d.raise == f64::INFINITY);
        k + 1 == dense.len()
            || is_gap(k)
            || is_gap(k + 1)
            || k > 0 && is_gap(k - 1)
            || dense[k].at_contact
                && contacts.get(piece + 1).is_some_and(|next| {
                    (next.feed, next.kind) != (contacts[piece].feed, contacts[piece].kind)
                })
    };
    let ends: Vec<usize> = (0..dense.len()).filter(|&k| fixed(k)).collect();
    let mut kept = vec![0];
    let mut start = 0;
    for end in ends {
        while start < end {
            let next = furthest(dense, start, end, options);
            split_where_cutting(dense, start, next, probe, &mut kept);
            start = next;
        }
    }
    kept
}

/// The farthest point, found by doubling and bisection, to which a straight piece from `start` may go.
fn furthest(dense: &[Dense], start: usize, end: usize, options: &PassOptions) -> usize {
    let allowed = 0.5 * options.tolerance;
    let within = |stop: usize| {
        (start + 1..stop).all(|k| deviation(dense, start, stop, k, &options.tool) <= allowed)
    };
    let mut good = start + 1;
    let mut step = 1;
    let mut bad = None;
    while good < end && bad.is_none() {
        let next = (good + step).min(end);
        if within(next) {
            good = next
        } else {
            bad = Some(next)
        }
        step *= 2;
    }
    let mut bad = bad.unwrap_or(good);
    while bad > good + 1 {
        let middle = good + (bad - good) / 2;
        if within(middle) { good = middle } else { bad = middle }
    }
    good
}

/// Tip and axis on the straight piece `a`-`b` nearest to dense point `k`.
fn on_chord(dense: &[Dense], a: usize, b: usize, k: usize, radius: f64) -> (DVec3, DVec3) {
    let (from, to, p) = (&dense[a], &dense[b], &dense[k]);
    let (chord, turn) = (to.tip - from.tip, (to.axis - from.axis) * radius);
    let length = chord.length_squared() + turn.length_squared();
    let along = chord.dot(p.tip - from.tip) + turn.dot(p.axis - from.axis) * radius;
    let u = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
    (from.tip + chord * u, from.axis.lerp(to.axis, u).try_normalize().unwrap_or(p.axis))
}

/// Whether two unit axes differ by rounding alone.
fn same_axis(a: DVec3, b: DVec3) -> bool {
    a.distance_squared(b) < 1e-24
}

/// Distance of dense point `k` from the straight piece `a`-`b`: that of the tip, or that along the normal of the
/// contact given by tip and axis, whichever is larger. Along the surface a contact may slide on the cutter.
fn deviation(dense: &[Dense], a: usize, b: usize, k: usize, tool: &Tool) -> f64 {
    let p = &dense[k];
    let (tip, axis) = on_chord(dense, a, b, k, tool.radius());
    let of_tip = tip.distance(p.tip);
    if same_axis(axis, p.axis) {
        return of_tip;
    }
    let contact = |t: DVec3, a: DVec3| t + contact_offset(tool, p.normal, a);
    let slip = contact(tip, axis) - contact(p.tip, p.axis);
    of_tip.max(slip.dot(p.normal).abs())
}

/// Appends `b`, and before it the points at which the piece `a`-`b` must be split so as not to gouge.
fn split_where_cutting(dense: &[Dense], a: usize, b: usize, probe: &Probe, kept: &mut Vec<usize>) {
    let cuts = |k: usize| {
        let (tip, axis) = on_chord(dense, a, b, k, probe.tool.radius());
        // A cutter shifted by half the tolerance penetrates by at most that much more.
        let p = &dense[k];
        let shifted = tip.distance(p.tip) <= 0.5 * probe.tolerance && same_axis(axis, p.axis);
        !(p.tested && shifted || probe.clears(tip, axis, 0.75 * probe.tolerance))
    };
    if b > a + 1 && (a + 1..b).any(cuts) {
        // Halves, not the worst point: the depth of the recursion stays logarithmic.
        let middle = a + (b - a) / 2;
        split_where_cutting(dense, a, middle, probe, kept);
        split_where_cutting(dense, middle, b, probe, kept);
    } else {
        kept.push(b);
    }
}

fn located(contacts: &[Contact], dense: &[Dense], before: Option<usize>, at: usize) -> Located {
    let d = &dense[at];
    let first = before.map_or(d.piece, |k| dense[k + 1].piece);
    Located {
        tip: d.tip,
        axis: d.axis,
        contact: d.contact,
        normal: d.normal,
        feed: contacts[d.piece].feed,
        raise: d.raise,
        is_of_contact: d.at_contact && d.away.is_none(),
        keys: (contacts[first].key, contacts[d.piece].key),
    }
}

fn lifted_spans(contacts: &[Contact], dense: &[Dense], tolerance: f64) -> Vec<LiftedSpan> {
    let mut spans: Vec<LiftedSpan> = Vec::new();
    let mut open = false;
    for d in dense.iter().filter(|d| d.at_contact) {
        let contact = &contacts[d.piece];
        if d.raise <= tolerance + contact.facet_error {
            open = false;
            continue;
        }
        let place = contact.position;
        match spans.last_mut().filter(|_| open) {
            Some(span) => {
                span.length += span.to.distance(place);
                span.to = place;
                if d.raise > span.raise {
                    (span.raise, span.place) = (d.raise, place);
                }
            }
            None => spans.push(LiftedSpan {
                from: place,
                to: place,
                length: 0.0,
                raise: d.raise,
                place,
            }),
        }
        open = true;
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::super::tilt::tool_axes;
    use super::*;
    use crate::cutter_location::axis::ToolAxis;
    use crate::cutter_location::check_mesh::CheckMesh;
    use crate::geometry::math::{cos, sin};

    const OPEN: f64 = f64::INFINITY;

    fn options(radius: f64, corner: f64, axis: ToolAxis) -> PassOptions {
        let tool = Tool::new(radius, corner).unwrap();
        PassOptions {
            tool,
            axis,
            axis_rate: OPEN,
            largest_tilt: 0.0,
            allowance: 0.0,
            tolerance: 0.005,
            reach: 40.0,
        }
    }

    fn located(
        contacts: &[Contact],
        options: &PassOptions,
        obstacles: &Obstacles,
    ) -> Result<LocatedPass, LocateError> {
        let axes = tool_axes(contacts, None, options, obstacles);
        locate_pass(contacts, &axes, options, obstacles)
    }

    fn wave(x: f64) -> f64 {
        3.0 * sin(x / 6.0)
    }

    fn wave_normal(x: f64) -> DVec3 {
        DVec3::new(-0.5 * cos(x / 6.0), 0.0, 1.0).normalize()
    }

    fn wave_mesh(n: u32) -> Obstacles {
        let mut positions = Vec::new();
        for i in 0..=n {
            let x = 80.0 * (f64::from(i) / f64::from(n) - 0.5);
            positions.extend([-20.0, 20.0].map(|y| DVec3::new(x, y, wave(x))));
        }
        let faces = (0..n)
            .flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]])
            .collect();
        Obstacles::of_part(CheckMesh::new(positions, faces))
    }

    fn wave_pass(n: u32) -> Vec<Contact> {
        (0..=n)
            .map(|i| {
                let x = 60.0 * (f64::from(i) / f64::from(n) - 0.5);
                let normal = wave_normal(x);
                Contact {
                    position: DVec3::new(x, 0.0, wave(x)),
                    normal,
                    feed_direction: DVec3::new(normal.z, 0.0, -normal.x),
                    key: i as usize,
                    feed: if i <= n / 3 { 20.0 } else { 10.0 },
                    kind: MoveKind::Cut,
                    facet_error: 0.0,
                }
            })
            .collect()
    }

    /// Largest penetration along the pass, by the cutter shrunk until it clears.
    fn penetration(pass: &LocatedPass, o: &PassOptions, check: &Obstacles) -> f64 {
        let probe = Probe::new(o, check);
        let mut worst: f64 = 0.0;
        for pair in pass.points.windows(2) {
            for i in 0..=6 {
                let u = f64::from(i) / 6.0;
                let (tip, axis) = (
                    pair[0].tip.lerp(pair[1].tip, u),
                    pair[0].axis.lerp(pair[1].axis, u).normalize(),
                );
                let mut depth = 0.0;
                while !probe.clears(tip, axis, depth) {
                    depth += 2.5e-4;
                }
                worst = worst.max(depth);
            }
        }
        worst
    }

    /// How deep a point lies inside the cutter, from its shape as a cylinder swollen by the corner.
    fn depth_inside(tool: &Tool, tip: DVec3, axis: DVec3, p: DVec3) -> f64 {
        let h = (p - tip).dot(axis) - tool.corner_radius();
        let rho = ((p - tip) - axis * (p - tip).dot(axis)).length();
        let beyond = rho - (tool.radius() - tool.corner_radius());
        if beyond <= 0.0 && h >= 0.0 {
            return tool.corner_radius() + h.min(-beyond);
        }
        let (out, below) = (beyond.max(0.0), (-h).max(0.0));
        tool.corner_radius() - (out * out + below * below).sqrt()
    }

    #[test]
    fn no_point_of_the_surface_lies_deeper_in_the_cutter_than_the_tolerance() {
        let mesh = wave_mesh(800);
        let contacts = wave_pass(400);
        for (radius, corner) in [(4.0, 4.0), (4.0, 0.0), (4.0, 1.0), (25.0, 25.0)] {
            for axis in [ToolAxis::Fixed(DVec3::Z), ToolAxis::Lead(0.2)] {
                let o = options(radius, corner, axis);
                let pass = located(&contacts, &o, &mesh).unwrap();
                for pair in pass.points.windows(2) {
                    let tip = pair[0].tip.lerp(pair[1].tip, 0.4);
                    let axis = pair[0].axis.lerp(pair[1].axis, 0.4).normalize();
                    let deepest = (0..=800)
                        .map(|i| 0.1 * f64::from(i) - 40.0)
                        .flat_map(|x| [-2.0, 0.0, 3.0].map(|y| DVec3::new(x, y, wave(x))))
                        .map(|p| depth_inside(&o.tool, tip, axis, p))
                        .fold(0.0, f64::max);
                    assert!(deepest <= o.tolerance, "{deepest} with {:?}", o.tool);
                }
            }
        }
    }

    #[test]
    fn the_path_is_sparse_and_stays_within_tolerance() {
        let mesh = wave_mesh(800);
        let contacts = wave_pass(1200);
        for (radius, corner) in [(4.0, 4.0), (4.0, 0.0), (4.0, 1.0)] {
            for axis in [ToolAxis::Fixed(DVec3::Z), ToolAxis::Lead(0.3)] {
                let o = options(radius, corner, axis);
                let pass = located(&contacts, &o, &mesh).unwrap();
                assert!(pass.points.len() < 400, "{} points", pass.points.len());
                let deepest = penetration(&pass, &o, &mesh);
                assert!(deepest <= o.tolerance, "cuts {deepest} deep");
                let keys: Vec<_> = pass.points.iter().map(|p| p.keys).collect();
                assert_eq!(keys[0], (0, 0));
                assert!(keys.windows(2).all(|k| k[1].0 <= k[0].1 + 1 && k[0].1 <= k[1].1));
                assert_eq!(keys[keys.len() - 1].1, 1200);
            }
        }
    }

    #[test]
    fn a_ball_follows_the_offset_curve_with_as_few_points_as_its_curvature_asks() {
        // Dome of radius 30 and ball of radius 5: tips lie on a circle of radius 35.
        let contacts: Vec<Contact> = (0..=1000)
            .map(|i| {
                let t = 0.6 * (f64::from(i) / 500.0 - 1.0);
                let normal = DVec3::new(sin(t), 0.0, cos(t));
                Contact {
                    position: normal * 30.0,
                    normal,
                    feed_direction: DVec3::new(cos(t), 0.0, -sin(t)),
                    key: i as usize,
                    feed: 10.0,
                    kind: MoveKind::Cut,
                    facet_error: 0.0,
                }
            })
            .collect();
        let o = options(5.0, 5.0, ToolAxis::Fixed(DVec3::Z));
        let nothing = Obstacles::of_part(CheckMesh::new(Vec::new(), Vec::new()));
        let pass = located(&contacts, &o, &nothing).unwrap();
        for p in &pass.points {
            assert!(((p.tip + DVec3::Z * 5.0).length() - 35.0).abs() < 1e-12);
        }
        // Chords of sagitta 0.0025 on radius 35.
        let chord = 2.0 * crate::geometry::math::acos(1.0 - 0.0025 / 35.0);
        let needed = (1.2 / chord).ceil() as usize;
        let pieces = pass.points.len() - 1;
        assert!((needed..=needed + needed / 10 + 1).contains(&pieces), "{pieces} for {needed}");
    }

    #[test]
    fn a_change_of_feed_keeps_its_point() {
        let contacts = wave_pass(1200);
        let o = options(4.0, 4.0, ToolAxis::Fixed(DVec3::Z));
        let pass = located(&contacts, &o, &wave_mesh(800)).unwrap();
        let last = pass.points.iter().rposition(|p| p.feed == 20.0).unwrap();
        assert_eq!(pass.points[last].keys.1, 400);
        assert!(pass.points[last + 1..].iter().all(|p| p.feed == 10.0));
    }

    #[test]
    fn where_the_cutter_does_not_fit_is_reported_once_a_span() {
        // Valleys of radius 36 / 3 = 12 at slope 0: a ball of 30 hangs above them.
        let contacts = wave_pass(600);
        let tight = options(30.0, 30.0, ToolAxis::Fixed(DVec3::Z));
        let mesh = wave_mesh(800);
        let pass = located(&contacts, &tight, &mesh).unwrap();
        assert!(!pass.lifted.is_empty() && pass.lifted.len() <= 3, "{}", pass.lifted.len());
        for span in &pass.lifted {
            assert!(span.raise > 0.5 && span.length > 5.0);
            assert!(span.place.z < 0.0, "the deepest misfit lies in a valley");
        }
        assert!(penetration(&pass, &tight, &mesh) <= tight.tolerance);
        let fits = options(4.0, 4.0, ToolAxis::Fixed(DVec3::Z));
        assert_eq!(located(&contacts, &fits, &mesh).unwrap().lifted, vec![]);
    }

    #[test]
    fn faceting_is_told_from_misfit() {
        let mesh = wave_mesh(40);
        let mut contacts = wave_pass(600);
        let o = options(4.0, 4.0, ToolAxis::Fixed(DVec3::Z));
        for c in &mut contacts {
            let left = 2.0 * (c.position.x / 2.0).floor();
            let at = |x: f64, y: f64| DVec3::new(x, y, wave(x));
            let corners = [at(left, -1.0), at(left + 2.0, -1.0), at(left + 2.0, 1.0)];
            let normals = corners.map(|p| wave_normal(p.x));
            c.facet_error = facet_error(corners, normals, 4.0);
            let u = 0.5 * (c.position.x - left);
            c.position.z = wave(left) + (wave(left + 2.0) - wave(left)) * u;
            c.normal = normals[0].lerp(normals[1], u).normalize();
        }
        let pass = located(&contacts, &o, &mesh).unwrap();
        let highest = pass.points.iter().map(|p| p.raise).fold(0.0, f64::max);
        assert!(highest > 0.005, "facets do raise the cutter: {highest}");
        assert_eq!(pass.lifted, vec![]);
    }

    #[test]
    fn a_wall_is_climbed_beside_it_and_walls_at_its_side_do_not_count() {
        let mesh = step();
        let along = |x: f64, y: f64, i: usize| Contact {
            position: DVec3::new(x, y, 0.0),
            normal: DVec3::Z,
            feed_direction: DVec3::X,
            key: i,
            feed: 10.0,
            kind: MoveKind::Cut,
            facet_error: 0.0,
        };
        let o = options(5.0, 5.0, ToolAxis::Fixed(DVec3::Z));
        let beside: Vec<_> = (0..50).map(|i| along(-5.0 + 1e-3, i as f64 * 0.2, i)).collect();
        let pass = located(&beside, &o, &mesh).unwrap();
        assert!(pass.lifted.is_empty() && pass.points.len() == 2, "{pass:?}");
        let into: Vec<_> = (0..100).map(|i| along(-20.0 + i as f64 * 0.19, 0.0, i)).collect();
        let pass = located(&into, &o, &mesh).unwrap();
        assert_eq!(pass.lifted.len(), 1);
        assert!(penetration(&pass, &o, &mesh) <= o.tolerance);
    }

    /// A floor up to x = 0, a wall of 8 mm, and the land behind it.
    fn step() -> Obstacles {
        let corner = |x: f64, z: f64| [-30.0, 30.0].map(|y| DVec3::new(x, y, z));
        let profile = [corner(-30.0, 0.0), corner(0.0, 0.0), corner(0.0, 8.0), corner(30.0, 8.0)];
        let faces = (0..3u32)
            .flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]])
            .collect();
        Obstacles::of_part(CheckMesh::new(profile.concat(), faces))
    }

    fn contact(position: DVec3, normal: DVec3, key: usize) -> Contact {
        let kind = MoveKind::Cut;
        Contact {
            position,
            normal,
            feed_direction: DVec3::Y,
            key,
            feed: 10.0,
            kind,
            facet_error: 0.0,
        }
    }

    /// Contacts on the rounding that a ball leaves in the corner, off by 20 um toward the wall: the ball is moved aside,
    /// by less than twice that, and is not lifted onto the land. The floor alone holds it up.
    #[test]
    fn a_ball_little_into_a_wall_is_moved_aside() {
        let o = options(5.0, 5.0, ToolAxis::Fixed(DVec3::Z));
        for below in [0.0, 0.004] {
            let centre = |y: f64| DVec3::new(-5.0 + 0.02, y, 5.0 - below);
            let normal = DVec3::new(-0.8, 0.0, 0.6);
            let contacts: Vec<_> = (0..20)
                .map(|i| contact(centre(0.2 * f64::from(i)) - normal * 5.0, normal, i as usize))
                .collect();
            let pass = located(&contacts, &o, &step()).unwrap();
            for l in &pass.points {
                assert!((-5.04..-5.0 + 0.0013).contains(&l.tip.x), "{}", l.tip);
                assert!(l.tip.z.abs() < 0.005, "{}", l.tip);
            }
            assert!(penetration(&pass, &o, &step()) <= o.tolerance);
        }
    }

    /// Over a sharp edge the ball swings by a quarter of a circle between contacts that are nearer to each other than
    /// the tolerance.
    #[test]
    fn a_ball_rolls_over_a_sharp_edge() {
        let o = options(5.0, 5.0, ToolAxis::Fixed(DVec3::Z));
        let place = |x: f64| DVec3::new(x, 0.0, 8.0);
        let (up, out) = (DVec3::Z, DVec3::new(-0.995, 0.0, 0.0999).normalize());
        let contacts =
            [contact(place(1.0), up, 0), contact(place(0.003), up, 1), contact(place(0.0), out, 2)];
        let pass = located(&contacts, &o, &step()).unwrap();
        for l in pass.points.iter().filter(|l| l.tip.x < 0.0) {
            let from_edge = (l.tip + DVec3::Z * 5.0).distance(DVec3::Z * 8.0);
            assert!(l.raise.is_finite() && (from_edge - 5.0).abs() < 0.005, "{l:?}");
        }
        assert!(penetration(&pass, &o, &step()) <= o.tolerance);
    }

    #[test]
    fn the_axis_turns_no_faster_than_allowed() {
        let mut contacts = wave_pass(600);
        for c in &mut contacts[300..] {
            c.feed_direction = -c.feed_direction;
        }
        let mut o = options(4.0, 0.0, ToolAxis::Lead(0.3));
        o.axis_rate = 0.15;
        let pass = located(&contacts, &o, &wave_mesh(800)).unwrap();
        for pair in pass.points.windows(2) {
            let turn = pair[0].axis.distance(pair[1].axis);
            let travel = pair[0].contact.distance(pair[1].contact);
            assert!(turn <= 0.16 * travel + 1e-9, "{turn} over {travel} mm");
        }
    }

    #[test]
    fn allowance_is_left_in_corners_too() {
        let plate = |y: f64| [-30.0, 0.0, 30.0].map(|x: f64| DVec3::new(x, y, x.abs()));
        let mesh = Obstacles::of_part(CheckMesh::new(
            [plate(-30.0), plate(30.0)].concat(),
            vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
        ));
        let mut o = options(2.0, 2.0, ToolAxis::Fixed(DVec3::Z));
        o.allowance = 0.5;
        let contact = Contact {
            position: DVec3::ZERO,
            normal: DVec3::Z,
            feed_direction: DVec3::Y,
            key: 0,
            feed: 1.0,
            kind: MoveKind::Cut,
            facet_error: 0.0,
        };
        let pass = located(&[contact], &o, &mesh).unwrap();
        // A ball of 2.5 in a right-angled valley has its centre 2.5 sqrt 2 above the bottom.
        assert!((pass.points[0].tip.z - (2.5 * 2.0f64.sqrt() - 2.0)).abs() < 1e-5);
    }

    #[test]
    fn a_surface_that_faces_away_is_refused_with_its_place() {
        let mut contacts = wave_pass(10);
        contacts[4].normal = -DVec3::Z;
        contacts[7].normal = DVec3::X;
        let o = options(4.0, 4.0, ToolAxis::Fixed(DVec3::Z));
        let error = located(&contacts, &o, &wave_mesh(10)).unwrap_err();
        let place = contacts[4].position;
        assert_eq!(error, LocateError::BelowHorizon { count: 2, total: 11, place, degrees: 180.0 });
    }
}
