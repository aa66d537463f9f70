//! Numbered places on a picture and the list of them.

use super::colour::{self, Rgb};
use super::svg::{Anchor, Stroke, Svg};
use super::view::Canvas;
use evencut_core::geometry::{DVec2, DVec3};

/// Radius of a number's circle, px.
const NUMBER: f64 = 8.0;
/// Radius of the ring around the place, px.
const RING: f64 = 5.0;
/// Height of a row of the list, px.
const ROW: f64 = 19.0;
/// Right ends of the list's columns, px.
const COLUMNS: [f64; 4] = [88.0, 145.0, 202.0, 259.0];

/// A place that is shown.
#[derive(Clone, Debug)]
pub struct Place {
    /// Where, mm.
    pub at: DVec3,
    /// What is there.
    pub value: String,
    /// Colour of that.
    pub ink: Rgb,
}

/// Marks the places on the picture whose surface begins at `origin`.
pub fn mark(svg: &mut Svg, canvas: &Canvas, origin: DVec2, places: &[Place]) {
    let at = |p: &Place| origin + canvas.view.place(p.at);
    let mut taken: Vec<DVec2> = places.iter().map(at).collect();
    let (low, high) = (origin - 0.5 * NUMBER, origin + canvas.size() + 0.5 * NUMBER);
    for (i, place) in places.iter().enumerate() {
        let centre = at(place);
        let label = free_spot(centre, &taken, [low, high]);
        taken.push(label);
        let way = (label - centre).normalize_or(DVec2::X);
        let dashed = !canvas.is_visible(place.at);
        // A light line under the dark one keeps the ring apart from dark colours.
        svg.circle(centre, RING, None, Stroke::solid(colour::GROUND, 3.0));
        svg.circle(centre, RING, None, Stroke { colour: colour::INK, width: 1.2, dashed });
        let (from, to) = (centre + RING * way, label - NUMBER * way);
        svg.line(from, to, Stroke::solid(colour::GROUND, 2.6));
        svg.line(from, to, Stroke::solid(colour::INK, 1.0));
        number(svg, label, i + 1, dashed);
    }
}

fn number(svg: &mut Svg, at: DVec2, number: usize, dashed: bool) {
    let rim = Stroke { colour: colour::INK, width: 1.2, dashed };
    svg.circle(at, NUMBER, Some(colour::GROUND), rim);
    svg.text(at + DVec2::new(0.0, 3.7), Anchor::Middle, 10.0, &number.to_string());
}

/// A place for a number near `centre` that keeps clear of what is taken and within the picture; the
/// clearest if none is free.
fn free_spot(centre: DVec2, taken: &[DVec2], [low, high]: [DVec2; 2]) -> DVec2 {
    const TURN: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let ways = [
        (TURN, -TURN),
        (-TURN, -TURN),
        (TURN, TURN),
        (-TURN, TURN),
        (0.0, -1.0),
        (1.0, 0.0),
        (-1.0, 0.0),
        (0.0, 1.0),
    ];
    let reach = [22.0, 34.0, 48.0, 64.0];
    let spots = reach.iter().flat_map(|r| ways.map(|w| centre + *r * DVec2::from(w)));
    let clearance = |spot: DVec2| {
        let nearest = taken.iter().map(|t| t.distance(spot)).fold(f64::INFINITY, f64::min);
        let inside = spot.clamp(low, high) == spot;
        if inside { nearest } else { nearest - 1e3 }
    };
    let mut best = (f64::NEG_INFINITY, centre);
    for spot in spots {
        let clear = clearance(spot);
        if clear >= 2.0 * NUMBER + 2.0 {
            return spot;
        }
        if clear > best.0 {
            best = (clear, spot);
        }
    }
    best.1
}

/// Height of the table of so many places, px.
pub fn height(places: usize) -> f64 {
    if places > 0 { ROW * (places as f64 + 2.0) } else { 0.0 }
}

/// The places as a table from the upper left corner `at`. `what`: the heading of the values with
/// their unit.
pub fn list(svg: &mut Svg, canvas: &Canvas, at: DVec2, what: &str, places: &[Place]) {
    if places.is_empty() {
        return;
    }
    let mut y = at.y + 12.0;
    for (right, heading) in COLUMNS.into_iter().zip([what, "x mm", "y mm", "z mm"]) {
        svg.text(DVec2::new(at.x + right, y), Anchor::End, 11.0, heading);
    }
    let mut hidden = false;
    for (i, place) in places.iter().enumerate() {
        y += ROW;
        let dashed = !canvas.is_visible(place.at);
        hidden |= dashed;
        number(svg, DVec2::new(at.x + NUMBER, y - 4.0), i + 1, dashed);
        let right = |column: usize| DVec2::new(at.x + COLUMNS[column], y);
        svg.coloured_text(right(0), Anchor::End, 12.0, place.ink, &place.value);
        for (column, x) in place.at.to_array().into_iter().enumerate() {
            svg.text(right(column + 1), Anchor::End, 12.0, &format!("{x:.2}").replace('-', "−"));
        }
    }
    if hidden {
        y += ROW;
        svg.text(DVec2::new(at.x, y), Anchor::Start, 11.0, "dashed: hidden by what stands before");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_apart() {
        let picture = [DVec2::ZERO, DVec2::new(700.0, 500.0)];
        let places: Vec<DVec2> =
            (0..10).map(|i| DVec2::new(300.0 + 6.0 * f64::from(i), 200.0)).collect();
        let mut taken = places.clone();
        for place in places {
            let spot = free_spot(place, &taken, picture);
            assert!(taken.iter().all(|t| t.distance(spot) >= 2.0 * NUMBER), "{spot}");
            taken.push(spot);
        }
    }

    #[test]
    fn numbers_stay_in_the_picture() {
        let picture = [DVec2::ZERO, DVec2::new(700.0, 500.0)];
        for corner in [DVec2::ZERO, DVec2::new(700.0, 0.0), DVec2::new(700.0, 500.0)] {
            let spot = free_spot(corner, &[corner], picture);
            assert_eq!(spot.clamp(picture[0], picture[1]), spot);
        }
    }
}
