//! What the judge found, as colours on the shaded surface.

use super::colour;
use super::heat_scale::{APART, Depths, LEGEND_WIDTH, MISSING, OVER, PLAIN, Scale, number};
use super::marks::{Mark, Rank, field};
use super::path_layers::{rate, scale_bar};
use super::placement::Placement;
use super::places::{self, Place};
use super::png;
use super::svg::{Anchor, Svg};
use super::view::{Canvas, Shape, View, triad};
use evencut_core::geometry::{DVec2, DVec3, OrderBy};
use evencut_core::toolpath::Toolpath;
use evencut_core::units::per_minute;
use evencut_core::verify::{Facets, Figures, MRR_NOISE, Outcome, Rate, Spot, Verification};

const MARGIN: f64 = 30.0;
/// Upper left corner of the drawn surface, px.
const ORIGIN: DVec2 = DVec2::new(MARGIN, 84.0);
/// Room that the lines of figures need, px.
const LEAST_WIDTH: f64 = 440.0;
/// Raster pixels a px. A pixel is a byte and noise cannot be compressed: with the room of a view
/// this bounds the picture by 1.3 MB in base 64.
const FINENESS: f64 = 1.5;
/// A smaller part of the surface may be hidden without a word.
const SHOWN: f64 = 1e-3;
/// Places shown at most.
const MOST_PLACES: usize = 10;
/// Distance of places beyond the judge's list, px.
const APART_PX: f64 = 60.0;
/// What sums of durations may be off, s.
const CLOCK: f64 = 1e-6;
/// mm in µm.
const MICRO: f64 = 1e3;

/// What a picture says besides its colours.
struct Words {
    title: &'static str,
    description: &'static str,
    /// Two lines of figures.
    figures: [String; 2],
    /// Heading of the values of places.
    value: &'static str,
}

/// What is left on the surface, in µm: gouges violet, nothing pale, more darker up to the limit and
/// red above it, hatched where no move came; the worst places numbered and listed.
///
/// `design`, `rest`: as they were judged. `limit`: on the scallop height, mm; without one the scale
/// ends above the largest residual. `tolerance`: by how much the limit may be exceeded and the
/// surface be cut into, mm. At most 1.5 MB.
pub fn residual_map(
    design: Facets,
    rest: Facets,
    verification: &Verification,
    limit: Option<f64>,
    tolerance: f64,
) -> String {
    let (figures, samples) = (&verification.figures, &verification.samples);
    let shape = Shape::of_part(design, rest);
    let view = View::of(&shape, &gouged(figures, tolerance));
    let canvas = Canvas::new(&shape, view, FINENESS);
    let scale = residual_scale(shape.has_rest(), verification, limit, tolerance);
    let marks = residual_marks(samples, &scale, tolerance);
    let mut lines = residual_lines(figures, limit, tolerance);
    lines[1] += &hidden(&canvas, samples);
    let words = Words {
        title: "Height left on the surface",
        description: "Residual on the shaded surface in micrometres, with its worst places.",
        figures: lines,
        value: "µm",
    };
    let places = residual_places(verification, &canvas, &scale, tolerance);
    sheet(&canvas, &field(&canvas, marks), &scale, &words, &places)
}

/// Places cut into that the picture must show, mm.
fn gouged(figures: &Figures, tolerance: f64) -> Vec<DVec3> {
    figures.gouge.iter().filter(|g| g.height < -tolerance).map(|g| g.place).collect()
}

/// Where [`residual_map`] shows places.
pub(super) fn residual_placement(
    design: Facets,
    rest: Facets,
    verification: &Verification,
    tolerance: f64,
) -> Placement {
    let shape = Shape::of_part(design, rest);
    View::of(&shape, &gouged(&verification.figures, tolerance)).placement(ORIGIN)
}

/// Where [`rate_map`] shows places.
pub(super) fn rate_placement(design: Facets, rest: Facets) -> Placement {
    View::of(&Shape::of_part(design, rest), &[]).placement(ORIGIN)
}

/// Place of a sample, mm.
fn place(sample: &Outcome) -> DVec3 {
    DVec3::from(sample.position.map(f64::from))
}

/// `has_rest`: whether the part has more than what is machined.
pub(super) fn residual_scale(
    has_rest: bool,
    verification: &Verification,
    limit: Option<f64>,
    tolerance: f64,
) -> Scale {
    let samples = &verification.samples;
    let judged = samples.iter().filter(|s| s.machined && !s.inaccessible && s.is_cut());
    let largest = judged.map(|s| f64::from(s.residual)).fold(0.0, f64::max);
    let deepest = verification.figures.gouge.map_or(0.0, |g| -g.height);
    let mut others = vec![(MISSING, "no move came there")];
    if samples.iter().any(|s| s.machined && s.inaccessible) {
        others.push((APART, "inaccessible"));
    }
    if has_rest {
        others.push((PLAIN, "not machined"));
    }
    Scale {
        title: "Height left",
        unit: "µm",
        ramp: colour::of_height,
        over: colour::WARNING,
        depths: Some(Depths { tolerance: MICRO * tolerance, deepest: MICRO * deepest }),
        others,
        ..Scale::new(limit.map(|l| MICRO * l), MICRO * tolerance, MICRO * largest)
    }
}

fn residual_marks<'a>(
    samples: &'a [Outcome],
    scale: &'a Scale,
    tolerance: f64,
) -> impl Iterator<Item = (DVec3, Mark)> + 'a {
    samples.iter().filter_map(move |s| Some((place(s), residual_mark(s, scale, tolerance)?)))
}

/// The mark of a sample; what is only guarded has one where it is cut into.
pub(super) fn residual_mark(sample: &Outcome, scale: &Scale, tolerance: f64) -> Option<Mark> {
    let height = f64::from(sample.residual);
    // Below a bridge the cutter may go as long as it stays off the part, which is judged by itself.
    let residual = if sample.is_of_part() { height } else { height.max(0.0) };
    let value = MICRO * residual;
    let (rank, tone) = if residual < -tolerance {
        return Some(Mark {
            rank: Rank::Gouge,
            value: -sample.residual,
            tone: scale.gouge(-value),
        });
    } else if !sample.machined {
        return None;
    } else if sample.inaccessible {
        (Rank::Apart, APART)
    } else if !sample.is_cut() {
        (Rank::Untouched, MISSING)
    } else {
        let tone = scale.tone(value);
        (if tone == OVER { Rank::Above } else { Rank::Within }, tone)
    };
    Some(Mark { rank, value: sample.residual, tone })
}

fn residual_lines(figures: &Figures, limit: Option<f64>, tolerance: f64) -> [String; 2] {
    let micro = |mm: f64| number(MICRO * mm);
    let untouched = figures.largest.filter(|l| !l.is_cut).map_or("", |_| " (untouched)");
    let mut first = format!(
        "max {} µm{untouched}, 99 % of the area below {} µm, mean {} µm",
        micro(figures.largest.map_or(0.0, |l| l.height)),
        micro(figures.p99),
        micro(figures.mean)
    );
    if let Some(limit) = limit {
        let share = 100.0 * figures.above / figures.area.max(f64::MIN_POSITIVE);
        first += &format!("; {} above the limit of {} µm", percent(share), micro(limit));
    }
    let gouge = match figures.gouge {
        Some(g) if g.height < -tolerance => {
            format!("cut into by {} µm, {} mm²", micro(-g.height), area(figures.gouged))
        }
        _ => format!("nowhere cut into by more than {} µm", micro(tolerance)),
    };
    let walls = match figures.walls.and_then(|walls| walls.deepest) {
        Some(d) if d.height > tolerance => format!("; walls cut into by {:.2} mm", d.height),
        _ => String::new(),
    };
    let second = format!(
        "{gouge}{walls}; no move came to {} mm²; inaccessible: {} mm²",
        area(figures.untouched.0),
        area(figures.inaccessible.area)
    );
    [first, second]
}

/// How much of what is machined this view does not show.
fn hidden(canvas: &Canvas, samples: &[Outcome]) -> String {
    let machined = || samples.iter().filter(|s| s.machined);
    let hidden = machined().filter(|s| canvas.pixel(place(s)).is_none());
    let area = |samples: &mut dyn Iterator<Item = &Outcome>| -> f64 {
        samples.map(|s| f64::from(s.area)).sum()
    };
    let share = area(&mut { hidden }) / area(&mut machined()).max(f64::MIN_POSITIVE);
    if share > SHOWN {
        format!("; hidden in this view: {}", percent(100.0 * share))
    } else {
        String::new()
    }
}

/// A share in percent; small ones count too.
fn percent(value: f64) -> String {
    match value {
        0.0 => "0 %".into(),
        small if small < 1.0 => format!("{small:.3} %"),
        _ => format!("{value:.1} %"),
    }
}

/// An area in mm².
fn area(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.2}") }
}

/// The worst gouge, one untouched place, and what is too high, or else what is highest.
///
/// The judge's spots come first. Untouched places are all alike and may fill its list: then
/// samples above the limit, apart in the picture, follow the first of them.
fn residual_places(
    verification: &Verification,
    canvas: &Canvas,
    scale: &Scale,
    tolerance: f64,
) -> Vec<Place> {
    let figures = &verification.figures;
    let gouge = figures.gouge.iter().filter(|g| g.height < -tolerance);
    let untouched = figures.spots.iter().filter(|s| !s.is_cut).take(1);
    let touched = figures.spots.iter().filter(|s| s.is_cut);
    let highest = figures.largest.iter().filter(|_| figures.spots.is_empty());
    let mut spots: Vec<Spot> =
        gouge.chain(untouched).chain(touched).chain(highest).copied().take(MOST_PLACES).collect();
    if figures.spots.iter().any(|s| !s.is_cut) {
        add_highest(&mut spots, &verification.samples, scale, APART_PX / canvas.view.scale);
    }
    spots.iter().map(|s| residual_place(s, scale)).collect()
}

/// Adds the highest samples above the limit, at least `apart` mm from others.
fn add_highest(spots: &mut Vec<Spot>, samples: &[Outcome], scale: &Scale, apart: f64) {
    let over = |s: &&Outcome| {
        let judged = s.machined && !s.inaccessible && s.is_cut();
        judged && scale.is_over(MICRO * f64::from(s.residual))
    };
    let mut over: Vec<&Outcome> = samples.iter().filter(over).collect();
    over.order_by(|a, b| b.residual.total_cmp(&a.residual));
    for sample in over {
        if spots.len() >= MOST_PLACES {
            return;
        }
        let (place, height) = (place(sample), f64::from(sample.residual));
        let spot = Spot { place, height, of: sample.by, is_cut: true };
        if spots.iter().all(|s| s.place.distance(spot.place) > apart) {
            spots.push(spot);
        }
    }
}

fn residual_place(spot: &Spot, scale: &Scale) -> Place {
    let micro = MICRO * spot.height;
    let (value, ink) = match spot.is_cut {
        _ if micro < 0.0 => (number(micro), colour::GOUGES[1]),
        false => ("untouched".to_owned(), colour::INK),
        _ if scale.is_over(micro) => (number(micro), colour::WARNING),
        _ => (number(micro), colour::INK),
    };
    Place { at: spot.place, value, ink }
}

/// The measured removal rate when each place was opened, in mm³/min, that is when half of the stock
/// over it was gone; red above the limit, hatched where that never happened.
///
/// `design`, `rest`, `path`: as they were judged. `limit`: on the removal rate, mm³/s; without one
/// the scale ends above the peak. At most 1.5 MB.
pub fn rate_map(
    design: Facets,
    rest: Facets,
    verification: &Verification,
    path: &Toolpath,
    limit: Option<f64>,
) -> String {
    let measured = &verification.rate;
    let shape = Shape::of_part(design, rest);
    let canvas = Canvas::new(&shape, View::of(&shape, &[]), FINENESS);
    let scale = rate_scale(shape.has_rest(), measured, limit);
    let samples = verification.samples.iter().filter(|s| s.machined);
    let marks = samples.map(|s| (place(s), rate_mark(opening_rate(s, path, measured), &scale)));
    let words = Words {
        title: "Removal rate on the surface",
        description: "Measured removal rate when each place was opened, on the shaded surface.",
        figures: rate_lines(measured, limit),
        value: "mm³/min",
    };
    sheet(&canvas, &field(&canvas, marks), &scale, &words, &rate_places(measured, &scale))
}

/// `has_rest`: whether the part has more than what is machined.
pub(super) fn rate_scale(has_rest: bool, measured: &Rate, limit: Option<f64>) -> Scale {
    let mut others = vec![(MISSING, "never opened at feed")];
    if has_rest {
        others.push((PLAIN, "not machined"));
    }
    let in_minutes = limit.map(per_minute);
    let slack = (MRR_NOISE - 1.0) * in_minutes.unwrap_or(0.0);
    let peak = measured.peak.map_or(0.0, |p| p.measured);
    Scale {
        title: "Measured removal rate",
        unit: "mm³/min",
        others,
        ..Scale::new(in_minutes, slack, per_minute(peak))
    }
}

pub(super) fn rate_mark(rate: Option<f64>, scale: &Scale) -> Mark {
    let Some(rate) = rate else { return Mark { rank: Rank::Apart, value: 0.0, tone: MISSING } };
    let tone = scale.tone(per_minute(rate));
    let rank = if tone == OVER { Rank::Above } else { Rank::Within };
    Mark { rank, value: rate as f32, tone }
}

/// The rate in the window in which the cutter passed a place and opened it, mm³/s.
pub(super) fn opening_rate(sample: &Outcome, path: &Toolpath, measured: &Rate) -> Option<f64> {
    let of = sample.opened_by? as usize;
    let (from, to) = (path.points.get(of)?, path.points.get(of + 1)?);
    let way = to.tip - from.tip;
    // Long moves have many windows: the one beside the sample counts.
    let passed = (place(sample) - from.tip).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
    let time = from.time + passed.clamp(0.0, 1.0) * (to.time - from.time);
    let next = measured.windows.partition_point(|w| w.time[1] + CLOCK < time);
    measured.windows.get(next).filter(|w| w.time[0] <= time + CLOCK).map(|w| w.measured)
}

fn rate_lines(measured: &Rate, limit: Option<f64>) -> [String; 2] {
    let peak = measured.peak.map_or(0.0, |p| p.measured);
    let mut first = format!("peak {} mm³/min (tool tip at 1)", rate(per_minute(peak)));
    if let Some(limit) = limit.filter(|&l| l > 0.0) {
        let minute = rate(per_minute(limit));
        first += &format!(", {:.2} of the limit of {minute} mm³/min", peak / limit);
    }
    first += &format!("; removed {:.1} cm³", 1e-3 * measured.volume);
    let rms = rate(per_minute(measured.rms_difference));
    [first, format!("differs from the rate that the path states by {rms} mm³/min (RMS)")]
}

fn rate_places(measured: &Rate, scale: &Scale) -> Vec<Place> {
    let place = |peak: &evencut_core::verify::Window| {
        let value = per_minute(peak.measured);
        let ink = if scale.is_over(value) { colour::OVER_LIMIT } else { colour::INK };
        Place { at: peak.place, value: rate(value), ink }
    };
    measured.peak.iter().map(place).collect()
}

/// The picture, its legend, its figures and its places.
fn sheet(
    canvas: &Canvas,
    field: &[Option<Mark>],
    scale: &Scale,
    words: &Words,
    places: &[Place],
) -> String {
    let drawn = canvas.view.drawn().max(DVec2::new(LEAST_WIDTH, 0.0));
    let side = ORIGIN + DVec2::new(drawn.x + MARGIN, 0.0);
    let list = side + DVec2::new(0.0, scale.height() + MARGIN);
    let column = list.y - side.y + places::height(places.len());
    let size = DVec2::new(
        side.x + LEGEND_WIDTH + MARGIN,
        ORIGIN.y + (drawn.y + 2.5 * MARGIN).max(column) + MARGIN,
    );
    let mut svg = Svg::new(size.x, size.y, words.title, words.description);
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, words.title);
    for (line, y) in words.figures.iter().zip([50.0, 67.0]) {
        svg.text(DVec2::new(MARGIN, y), Anchor::Start, 12.0, line);
    }
    let (w, h) = (canvas.raster.width as u32, canvas.raster.height as u32);
    let picture = png::encode(w, h, &scale.indices(canvas, field), &scale.palette());
    svg.image(ORIGIN, canvas.size(), &picture);
    places::mark(&mut svg, canvas, ORIGIN, places);
    scale.legend(&mut svg, side);
    places::list(&mut svg, canvas, list, words.value, places);
    scale_bar(&mut svg, DVec2::new(MARGIN, size.y - 24.0), canvas.view.scale, "mm");
    triad(&mut svg, &canvas.view, DVec2::new(side.x - 80.0, size.y - 50.0));
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use evencut_core::toolpath::{MoveKind, PathPoint};
    use evencut_core::verify::{VerifyOptions, verify};

    const TOLERANCE: f64 = 0.002;
    const NOTHING: Facets = Facets { positions: &[], faces: &[] };
    const CORNERS: [DVec3; 4] = [
        DVec3::ZERO,
        DVec3::new(20.0, 0.0, 0.0),
        DVec3::new(20.0, 20.0, 0.0),
        DVec3::new(0.0, 20.0, 0.0),
    ];
    const PLANE: Facets = Facets { positions: &CORNERS, faces: &[[0, 1, 2], [0, 2, 3]] };

    /// Passes along x over the plane, 1 mm apart, up to `y`.
    fn passes(y: f64) -> Toolpath {
        let mut time = 0.0;
        let points = (0..=(2.0 * y) as usize + 1).map(|i| {
            time += if i % 2 == 1 { 3.0 } else { 0.05 };
            PathPoint {
                kind: MoveKind::Cut,
                pass: 0,
                region: 0,
                tip: DVec3::new(
                    if i % 4 == 1 || i % 4 == 2 { 40.0 } else { -20.0 },
                    (i / 2) as f64,
                    0.0,
                ),
                axis: DVec3::Z,
                normal: DVec3::Z,
                flat: None,
                feed: 20.0,
                mrr: 10.0,
                alpha: 0.0,
                time,
            }
        });
        Toolpath { points: points.collect() }
    }

    fn judged(path: &Toolpath, rest: Facets) -> Verification {
        let options = VerifyOptions {
            tool: evencut_core::tool::Tool::new(5.0, 5.0).unwrap(),
            length: f64::INFINITY,
            tells_rate: true,
            depth: 0.5,
            earlier: None,
            allowance: 0.0,
            scallop: Some(0.03),
            tolerance: TOLERANCE,
            mrr_limit: None,
            load: None,
            spacing: 0.2,
            up: DVec3::Z,
            inaccessible: Vec::new(),
            bridges: Vec::new(),
            walls: None,
            above: None,
            stock: None,
            avoided: Vec::new(),
            threads: 1,
        };
        verify(path, PLANE, rest, &options, &mut |_| {}).unwrap()
    }

    /// Pixels of each rank before the picture is encoded.
    fn ranks(verification: &Verification) -> [usize; 5] {
        let shape = Shape::of_part(PLANE, NOTHING);
        let canvas = Canvas::new(&shape, View::of(&shape, &[]), FINENESS);
        let scale = residual_scale(shape.has_rest(), verification, Some(0.03), TOLERANCE);
        let field = field(&canvas, residual_marks(&verification.samples, &scale, TOLERANCE));
        let count = |rank| field.iter().flatten().filter(|m| m.rank == rank).count();
        [Rank::Apart, Rank::Within, Rank::Above, Rank::Untouched, Rank::Gouge].map(count)
    }

    #[test]
    fn a_clean_plane_is_within() {
        let [apart, within, others @ ..] = ranks(&judged(&passes(20.0), NOTHING));
        assert!(within > 100_000 && apart == 0 && others == [0; 3], "{within} {others:?}");
    }

    #[test]
    fn single_faults_show() {
        let clean = judged(&passes(20.0), NOTHING);
        let changed = |change: fn(&mut Outcome)| {
            let mut verification = clean.clone();
            let middle = verification.samples.len() / 2;
            change(&mut verification.samples[middle]);
            ranks(&verification)
        };
        // At least 3 px across.
        let least = (3.0 * FINENESS * 3.0 * FINENESS) as usize;
        assert!(changed(|s| s.residual = -0.01)[4] >= least);
        // Below a bridge the part lies lower.
        let bridged = changed(|s| (s.residual, s.is_bridge) = (-0.01, true));
        assert_eq!(bridged, ranks(&clean));
        assert!(changed(|s| s.residual = 0.033)[2] >= least);
        assert!(changed(|s| s.by = None)[3] >= least);
    }

    #[test]
    fn half_a_path_leaves_half_untouched() {
        let verification = judged(&passes(5.0), NOTHING);
        let [_, within, _, untouched, _] = ranks(&verification);
        assert!(untouched > within / 2);
        let text = residual_map(PLANE, NOTHING, &verification, Some(0.03), TOLERANCE);
        assert!(text.contains("no move came there") && text.contains(">untouched<"));
    }

    #[test]
    fn the_legend_tells_unit_and_limit() {
        let verification = judged(&passes(20.0), NOTHING);
        let text = residual_map(PLANE, NOTHING, &verification, Some(0.03), TOLERANCE);
        assert!(text.contains(">µm<") && text.contains(">30 limit<"));
        assert!(text.contains("; 0 % above the limit of 30 µm"));
        let text = residual_map(PLANE, NOTHING, &verification, None, TOLERANCE);
        assert!(text.contains(">µm<") && !text.contains("limit"));
        let text = rate_map(PLANE, NOTHING, &verification, &passes(20.0), Some(10.0));
        assert!(text.contains(">mm³/min<") && text.contains(">600 limit<"));
    }

    #[test]
    fn a_rest_is_shown_beside() {
        let corners = CORNERS.map(|c| c + DVec3::new(20.0, 0.0, 0.0));
        let rest = Facets { positions: &corners, faces: PLANE.faces };
        let verification = judged(&passes(20.0), rest);
        let text = residual_map(PLANE, rest, &verification, Some(0.03), TOLERANCE);
        assert!(text.contains("not machined"));
        assert!(
            !residual_map(PLANE, NOTHING, &verification, None, TOLERANCE).contains("not machined")
        );
    }

    #[test]
    fn places_open_at_the_rate_of_their_window() {
        let path = passes(20.0);
        let verification = judged(&path, NOTHING);
        let rates: Vec<Option<f64>> = verification
            .samples
            .iter()
            .map(|s| opening_rate(s, &path, &verification.rate))
            .collect();
        assert!(rates.iter().all(Option::is_some));
        // Beyond the first passes a pass takes 1 mm by 0.5 mm at 20 mm/s.
        let later = verification.samples.iter().zip(&rates).filter(|(s, _)| s.position[1] > 8.0);
        let later: Vec<f64> = later.filter_map(|(_, r)| *r).collect();
        let mean = later.iter().sum::<f64>() / later.len() as f64;
        assert!((mean / 10.0 - 1.0).abs() < 0.1, "{mean}");
    }

    #[test]
    fn strange_paths_and_limits_are_drawn() {
        let verification = judged(&passes(5.0), NOTHING);
        let none = Toolpath::default();
        for limit in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-9] {
            let rates = rate_map(PLANE, NOTHING, &verification, &none, Some(limit));
            let heights = residual_map(NOTHING, NOTHING, &verification, Some(limit), limit);
            assert!(rates.ends_with("</svg>\n") && heights.ends_with("</svg>\n"));
        }
    }

    #[test]
    fn a_million_wild_samples_stay_small_and_alike() {
        let mut verification = judged(&passes(20.0), NOTHING);
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state as f32 / u32::MAX as f32
        };
        let one = verification.samples[0];
        let wild = |_| Outcome {
            cut_before: false,
            position: [20.0 * random(), 20.0 * random(), 0.0],
            residual: 0.04 * random() - 0.005,
            ..one
        };
        verification.samples = (0..1_000_000).map(wild).collect();
        let draw = || residual_map(PLANE, NOTHING, &verification, Some(0.03), TOLERANCE);
        let text = draw();
        assert!(text.len() < 1_500_000, "{}", text.len());
        assert!(text == draw());
    }
}
