//! The regions of a divided surface, and how evenly its map and theirs are.

use super::colour::{self, Rgb};
use super::path_layers::scale_bar;
use super::png;
use super::shading::Side;
use super::svg::{Anchor, Stroke, Svg};
use super::view::{Canvas, Shape, View, triad};
use crate::report::DivisionFigures;
use evencut_core::geometry::{DVec2, DVec3, cross2, math};
use evencut_core::surface::Surface;

const MARGIN: f64 = 30.0;
/// Room of a view, px.
const ROOM: DVec2 = DVec2::new(430.0, 400.0);
/// Height of the heading of a view.
const HEADING: f64 = 30.0;
/// Upper edge of the upper views.
const TOP: f64 = 74.0;
/// Raster pixels a px of the whole view.
const FINENESS: f64 = 1.5;
/// Shades of a colour.
const TONES: u8 = 14;
/// Brightness of the darkest shade.
const DARKEST: f64 = 0.55;
/// Steps of the scale of stretch.
const STEPS: u8 = 15;
/// Stretch at the ends of the scale, times the mean.
const WIDEST: f64 = 2.0;

/// Fills of regions: pale enough for shading, neighbours that any eye distinguishes.
///
/// # Source
/// Tol, "Colour Schemes" (2021), scheme light, with two greys left out.
pub(super) const FILLS: [Rgb; 7] = [
    Rgb([0x77, 0xaa, 0xdd]),
    Rgb([0xee, 0x88, 0x66]),
    Rgb([0xee, 0xdd, 0x88]),
    Rgb([0x44, 0xbb, 0x99]),
    Rgb([0xff, 0xaa, 0xbb]),
    Rgb([0x99, 0xdd, 0xff]),
    Rgb([0xbb, 0xcc, 0x33]),
];
/// Stretch at the low end, in the middle, at the high end.
///
/// # Source
/// Tol, "Colour Schemes" (2021), scheme BuRd.
const LOW: Rgb = Rgb([0x21, 0x66, 0xac]);
const EVEN: Rgb = Rgb([0xf7, 0xf7, 0xf7]);
const HIGH: Rgb = Rgb([0xb2, 0x18, 0x2b]);

/// A divided surface as it is drawn. Stretches are those of flat maps: mm on the surface per flat mm.
#[derive(Clone, Debug)]
pub struct RegionsPicture<'a> {
    /// `#V` positions, mm.
    pub positions: &'a [DVec3],
    /// `#F` triples of vertices.
    pub faces: &'a [[u32; 3]],
    /// `#F` numbers: a line is drawn between faces of different ones.
    pub labels: &'a [u32],
    /// `#F` stretches of the flat map of the undivided surface.
    pub undivided_stretch: Vec<f64>,
    /// The regions.
    pub regions: Vec<RegionPicture<'a>>,
    /// The order in which they get their colours: indices of all regions.
    pub order: &'a [usize],
}

/// A region as it is drawn.
#[derive(Clone, Debug)]
pub struct RegionPicture<'a> {
    /// Its faces.
    pub faces: &'a [u32],
    /// Stretch of its own flat map on each of them.
    pub stretch: Vec<f64>,
    /// The regions beside it, which get other colours.
    pub neighbours: Vec<usize>,
}

/// Three shaded views: the regions in their colours, the stretch of the flat map of the whole, and
/// that of the regions' own flat maps; each stretch divided by its mean. `reported`: what is reported of them.
pub fn regions_map(
    surface: &Surface,
    divided: &RegionsPicture,
    reported: &DivisionFigures,
) -> String {
    let shape = Shape::of(surface);
    let canvas = Canvas::new(&shape, View::of(&shape, &[]), FINENESS);
    let seen = Seen::of(&canvas, divided);
    let scale = (ROOM / canvas.view.drawn()).min_element();
    let size = canvas.view.drawn() * scale;
    let second = TOP + size.y + 2.0 * HEADING;
    let whole = DVec2::new(3.0 * MARGIN + 2.0 * ROOM.x, second + size.y + 2.0 * MARGIN);
    let mut svg = Svg::new(
        whole.x,
        whole.y,
        "Regions",
        "The surface coloured by region, and the stretch of its flat map before and after.",
    );
    svg.text(DVec2::new(MARGIN, 30.0), Anchor::Start, 16.0, "Regions that map evenly");
    let column = [MARGIN, 2.0 * MARGIN + ROOM.x];
    let mut view = |corner: DVec2, heading: &str, tones: &[u8], palette: &[Rgb]| {
        svg.text(corner - DVec2::new(0.0, 12.0), Anchor::Start, 13.0, heading);
        let indices = seen.indices(&canvas, tones, palette.len());
        let (w, h) = (canvas.raster.width, canvas.raster.height);
        let picture = png::encode(w as u32, h as u32, &indices, palette);
        svg.image(corner, canvas.size() * scale, &picture);
    };
    let count = reported.count;
    let fills = region_tones(divided);
    let counted = format!("{count} region{}", if count == 1 { "" } else { "s" });
    view(DVec2::new(column[0], TOP), &counted, &fills, &palette(&FILLS));
    let steps = step_colours();
    let heading = format!("Undivided: uniformity {:.2}", reported.undivided.uniformity);
    view(DVec2::new(column[0], second), &heading, &tones_before(divided), &palette(&steps));
    let heading = format!("Regions: uniformity at least {:.2}", reported.uniformity_min);
    view(DVec2::new(column[1], second), &heading, &tones_after(divided), &palette(&steps));
    figures(&mut svg, reported, DVec2::new(column[1], TOP));
    legend(&mut svg, DVec2::new(column[1], TOP + size.y - 40.0));
    scale_bar(&mut svg, DVec2::new(MARGIN, whole.y - 20.0), canvas.view.scale * scale, "mm");
    triad(&mut svg, &canvas.view, DVec2::new(whole.x - 70.0, TOP + 30.0));
    svg.finish()
}

/// What the regions are like, in words.
fn figures(svg: &mut Svg, reported: &DivisionFigures, at: DVec2) {
    let (after, before) = (&reported.spacing, &reported.undivided);
    let area: f64 = reported.pieces.iter().map(|p| p.area_mm2).sum();
    let ratios = reported.pieces.iter().map(|p| p.area_mm2 * (p.stretch_max / p.stretch_min));
    let ratio = ratios.sum::<f64>() / area;
    let rows = [
        ("", "undivided".to_owned(), "regions".to_owned()),
        (
            "uniformity, mean",
            format!("{:.2}", before.uniformity),
            format!("{:.2}", reported.uniformity_mean),
        ),
        (
            "stretch, largest / smallest",
            format!("{:.1}", before.stretch_max / before.stretch_min),
            format!("{ratio:.2}"),
        ),
        (
            "stepover / allowed, mean",
            format!("{:.3}", before.spacing.mean),
            format!("{:.3}", after.mean),
        ),
        (
            "stepover / allowed, deviation",
            format!("{:.3}", before.spacing.deviation),
            format!("{:.3}", after.deviation),
        ),
    ];
    for (i, (label, before, after)) in rows.iter().enumerate() {
        let y = at.y + 20.0 + 22.0 * i as f64;
        svg.text(DVec2::new(at.x, y), Anchor::Start, 12.0, label);
        svg.text(DVec2::new(at.x + 250.0, y), Anchor::End, 12.0, before);
        svg.text(DVec2::new(at.x + 325.0, y), Anchor::End, 12.0, after);
        if i == 0 {
            let from = DVec2::new(at.x, y + 7.0);
            svg.line(from, from + DVec2::new(325.0, 0.0), Stroke::solid(colour::FAINT, 1.0));
        }
    }
}

/// The scale of stretch.
fn legend(svg: &mut Svg, at: DVec2) {
    svg.text(at - DVec2::new(0.0, 12.0), Anchor::Start, 13.0, "Stretch of the flat map / its mean");
    let (width, height) = (300.0, 14.0);
    let step = width / f64::from(STEPS);
    for (i, fill) in (0u8..).zip(step_colours()) {
        // A little more, so that no ground shows between the steps.
        let corner = at + DVec2::new(step * f64::from(i), 0.0);
        svg.rectangle(corner, DVec2::new(step + 0.3, height), fill);
    }
    let range = math::ln(WIDEST);
    for (value, label) in [(0.5, "≤ 0.5"), (0.7, "0.7"), (1.0, "1"), (1.4, "1.4"), (2.0, "≥ 2")]
    {
        let x = at.x + width * 0.5 * (1.0 + math::ln(value) / range);
        let from = DVec2::new(x, at.y + height);
        svg.line(from, from + DVec2::new(0.0, 4.0), Stroke::solid(colour::INK, 1.0));
        svg.text(from + DVec2::new(0.0, 17.0), Anchor::Middle, 12.0, label);
    }
}

/// A fill for every face, so that neighbouring regions differ while there are enough.
fn region_tones(divided: &RegionsPicture) -> Vec<u8> {
    let mut tone = vec![u8::MAX; divided.regions.len()];
    for &k in divided.order {
        let neighbours = &divided.regions[k].neighbours;
        let taken = |t: &u8| neighbours.iter().filter(|&&n| tone[n] == *t).count();
        // The least used by neighbours; of those, one after the other.
        let first = k as u8 % FILLS.len() as u8;
        let all = (0..FILLS.len() as u8).map(|t| (t + first) % FILLS.len() as u8);
        tone[k] = all.min_by_key(taken).unwrap_or(0);
    }
    let mut of_face = vec![0; divided.faces.len()];
    for (region, tone) in divided.regions.iter().zip(tone) {
        region.faces.iter().for_each(|&f| of_face[f as usize] = tone);
    }
    of_face
}

/// Steps of the scale for every face, by the map of the whole.
fn tones_before(divided: &RegionsPicture) -> Vec<u8> {
    let all: Vec<u32> = (0..divided.faces.len() as u32).collect();
    let mut tones = vec![0; divided.faces.len()];
    put_steps(divided, &all, &divided.undivided_stretch, &mut tones);
    tones
}

/// Steps of the scale for every face, by the maps of the regions.
fn tones_after(divided: &RegionsPicture) -> Vec<u8> {
    let mut tones = vec![0; divided.faces.len()];
    for region in &divided.regions {
        put_steps(divided, region.faces, &region.stretch, &mut tones);
    }
    tones
}

/// Sets the steps of faces from the logarithms of their stretch, less the mean.
fn put_steps(divided: &RegionsPicture, faces: &[u32], stretch: &[f64], tones: &mut [u8]) {
    let values = || stretch.iter().map(|&s| math::ln(s));
    let areas = || faces.iter().map(|&f| divided.area(f as usize));
    let sum: f64 = values().zip(areas()).map(|(v, a)| v * a).sum();
    let mean = sum / areas().sum::<f64>();
    for (&f, v) in faces.iter().zip(values()) {
        let share = 0.5 * (1.0 + (v - mean) / math::ln(WIDEST));
        tones[f as usize] = (share * f64::from(STEPS)).clamp(0.0, f64::from(STEPS - 1)) as u8;
    }
}

impl RegionsPicture<'_> {
    /// Area of a face, mm².
    fn area(&self, face: usize) -> f64 {
        let [a, b, c] = self.faces[face].map(|v| self.positions[v as usize]);
        0.5 * (b - a).cross(c - a).length()
    }
}

fn step_colours() -> Vec<Rgb> {
    let half = f64::from(STEPS - 1) / 2.0;
    let colour = |i: u8| {
        let t = (f64::from(i) - half) / half;
        EVEN.mix(if t < 0.0 { LOW } else { HIGH }, t.abs())
    };
    (0..STEPS).map(colour).collect()
}

/// Index 0 is transparent, 1 the lines between regions; then the tones of every colour, and of the inner
/// side.
fn palette(colours: &[Rgb]) -> Vec<Rgb> {
    let shaded = |base: Rgb| {
        let part = |i: u8| DARKEST + (1.0 - DARKEST) * f64::from(i) / f64::from(TONES - 1);
        (0..TONES).map(move |i| Rgb([0; 3]).mix(base, part(i)))
    };
    let all = colours.iter().copied().chain([colour::INNER]);
    [Rgb([255; 3]), colour::INK].into_iter().chain(all.flat_map(shaded)).collect()
}

/// The face that is seen in every pixel.
struct Seen {
    /// `u32::MAX` where none is.
    faces: Vec<u32>,
    /// Whether a line between regions runs there.
    lines: Vec<bool>,
}

impl Seen {
    fn of(canvas: &Canvas, divided: &RegionsPicture) -> Self {
        let (width, height) = (canvas.raster.width, canvas.raster.height);
        let mut faces = vec![u32::MAX; width * height];
        let mut nearest = vec![f64::NEG_INFINITY; width * height];
        let toward = canvas.view.toward_viewer;
        let corner = |v: u32| {
            let p = divided.positions[v as usize];
            (canvas.view.place(p) * canvas.fineness, p.dot(toward))
        };
        for (f, face) in (0u32..).zip(divided.faces) {
            let [a, b, c] = face.map(corner);
            let area = cross2(a.0, b.0, c.0);
            if area == 0.0 || !area.is_finite() {
                continue;
            }
            let (low, high) = (a.0.min(b.0).min(c.0), a.0.max(b.0).max(c.0));
            let pixels = |low: f64, high: f64, count: usize| {
                let clip = |x: f64| x.clamp(0.0, count as f64) as usize;
                clip((low - 0.5).ceil())..clip((high + 0.5).floor())
            };
            for y in pixels(low.y, high.y, height) {
                for x in pixels(low.x, high.x, width) {
                    let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let weights = [(b, c), (c, a), (a, b)].map(|(s, t)| cross2(s.0, t.0, p) / area);
                    let near = weights[0] * a.1 + weights[1] * b.1 + weights[2] * c.1;
                    let pixel = y * width + x;
                    if weights.iter().all(|&w| w >= 0.0) && near > nearest[pixel] {
                        (nearest[pixel], faces[pixel]) = (near, f);
                    }
                }
            }
        }
        let label = |pixel: usize| {
            faces.get(pixel).filter(|&&f| f != u32::MAX).map(|&f| divided.labels[f as usize])
        };
        let is_line = |pixel: usize| {
            let here = label(pixel);
            let beside = [pixel + 1, pixel + width, pixel + width + 1];
            here.is_some() && beside.iter().any(|&q| label(q).is_some_and(|l| Some(l) != here))
        };
        let lines = (0..faces.len()).map(is_line).collect();
        Self { faces, lines }
    }

    /// Indices into a [`palette`] of so many colours; `tones`: of the faces.
    fn indices(&self, canvas: &Canvas, tones: &[u8], colours: usize) -> Vec<u8> {
        // The last ones are those of the inner side.
        let inner = (colours / usize::from(TONES)) as u8 - 1;
        let index = |(pixel, &face): (usize, &u32)| {
            let Some((side, brightness)) = canvas.raster.look(pixel) else { return 0 };
            let Some(&tone) = tones.get(face as usize) else { return 0 };
            if self.lines[pixel] {
                return 1;
            }
            let tone = if side == Side::Inner { inner } else { tone };
            let shade = (brightness * f64::from(TONES - 1)).round() as u8;
            2 + tone * TONES + shade
        };
        self.faces.iter().enumerate().map(index).collect()
    }
}
