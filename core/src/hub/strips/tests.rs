//! Strips on cylinders, whose widths follow from triangles and whose developments are plane.

use super::super::shapes::Cylinder;
use super::*;
use crate::geometry::math::acos_clamped;
use crate::tool::Tool;

const HUB: Cylinder = Cylinder { radius: 50.0, length: 80.0 };
const RADIUS: f64 = 3.0;
const CUSP: f64 = 0.01;

fn strip() -> Strip {
    let footprint = Footprint::new(Tool::new(RADIUS, RADIUS).unwrap(), 0.0);
    Strip { footprint, cusp: CUSP }
}

/// The strip of a pass along the cylinder, from outside or inside: the ball's centre, the axis and the cusp are a triangle.
fn exact_width(outside: bool) -> f64 {
    let sign = if outside { 1.0 } else { -1.0 };
    let (centre, cusp) = (HUB.radius + sign * RADIUS, HUB.radius + sign * CUSP);
    let cosine = (centre * centre + cusp * cusp - RADIUS * RADIUS) / (2.0 * centre * cusp);
    2.0 * HUB.radius * acos_clamped(cosine)
}

/// The width that passes are given.
fn width() -> f64 {
    SHARE * exact_width(true)
}

/// A channel along the axis, so many strips wide at its two ends, symmetric.
fn symmetric(wheel: &Wheel, strips: [f64; 2]) -> Channel {
    let half = |s: f64| 0.5 * width() * (strips[0] + (strips[1] - strips[0]) * s);
    let z = |s: f64| 10.0 + 50.0 * s;
    HUB.channel(wheel, |s| DVec2::new(40.0 - half(s), z(s)), |s| DVec2::new(40.0 + half(s), z(s)))
}

fn measured(wheel: &Wheel, channel: &Channel) -> Measured {
    Measured::new(wheel, channel, &strip())
}

/// A line in the development.
fn flat(wheel: &Wheel, channel: &Channel, line: &Line) -> Vec<DVec2> {
    let at = |i: usize| {
        let s = line.from + (line.to - line.from) * i as f64 / 200.0;
        HUB.flat(channel.place(wheel, s, line.at(s)))
    };
    (0..=200).map(at).collect()
}

fn distance(p: DVec2, line: &[DVec2]) -> f64 {
    let to_piece = |w: &[DVec2]| {
        let way = w[1] - w[0];
        let part = (p - w[0]).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
        p.distance(w[0] + way * part.clamp(0.0, 1.0))
    };
    line.windows(2).map(to_piece).fold(f64::INFINITY, f64::min)
}

/// The `t` of the lines that run at `s`, from side to side.
fn across(lines: &[Line], s: f64) -> Vec<f64> {
    lines.iter().filter(|l| (l.from..=l.to).contains(&s)).map(|l| l.at(s)).collect()
}

#[test]
fn a_strip_is_as_wide_as_its_cusp_allows() {
    for (tool, outside) in [(80.0, true), (20.0, false)] {
        let wheel = HUB.wheel_with_tool(12, tool);
        let channel = symmetric(&wheel, [8.0, 8.0]);
        let found = measured(&wheel, &channel).narrowest / SHARE;
        let exact = exact_width(outside);
        assert!((found / exact - 1.0).abs() < 1e-5, "{found}: {exact}");
    }
}

#[test]
fn length_area_and_floor_are_those_of_the_development() {
    let wheel = HUB.wheel(12);
    let channel = symmetric(&wheel, [4.0, 9.0]);
    let found = measured(&wheel, &channel);
    let longest = 9.0 * width();
    let area = 50.0 * 6.5 * width();
    assert!((found.longest / longest - 1.0).abs() < 1e-4, "{}: {longest}", found.longest);
    assert!((found.area / area - 1.0).abs() < 1e-4, "{}: {area}", found.area);
    // The sides spread by less than three degrees, which widens strips by less than a ten-thousandth.
    let floor = area / exact_width(true);
    assert!((found.floor / floor - 1.0).abs() < 1e-3, "{}: {floor}", found.floor);
}

/// N = ceil(L / s) + 1: with L = 12.5 s it is 14.
#[test]
fn passes_at_equal_parts_are_as_many_as_the_formula_says() {
    let wheel = HUB.wheel(12);
    let channel = symmetric(&wheel, [12.5, 12.5]);
    let lines = measured(&wheel, &channel).equal_parts();
    assert_eq!(lines.len(), 14);
    for (k, line) in lines.iter().enumerate() {
        assert_eq!((line.from, line.to, line.level), (0.0, 1.0, k));
        assert!((line.at(0.37) - k as f64 / 13.0).abs() < 1e-12);
        assert!((line.length(&wheel, &channel) - 50.0).abs() < 1e-6);
    }
    // As many where only one end is that wide.
    let channel = symmetric(&wheel, [3.3, 12.5]);
    assert_eq!(measured(&wheel, &channel).equal_parts().len(), 14);
}

/// Between parallel sides passes are a strip apart, but the last one, which lies in the middle of its gap.
#[test]
fn between_parallel_sides_passes_are_a_strip_apart() {
    let wheel = HUB.wheel(12);
    let strips = 12.5;
    let channel = symmetric(&wheel, [strips, strips]);
    let lines = measured(&wheel, &channel).strips(&wheel, &channel);
    // Each machines half a strip to both sides.
    assert!((13..=14).contains(&lines.len()), "{}", lines.len());
    let flats: Vec<Vec<DVec2>> = lines.iter().map(|l| flat(&wheel, &channel, l)).collect();
    let gaps: Vec<f64> = flats.windows(2).map(|w| (w[1][100].x - w[0][100].x) / width()).collect();
    let narrow: Vec<f64> = gaps.iter().copied().filter(|g| (g - 1.0).abs() > 2e-3).collect();
    let even = narrow.iter().all(|g| (g - narrow[0]).abs() < 4e-3 && (0.5..1.0).contains(g));
    assert!([0, 2].contains(&narrow.len()) && even, "{gaps:?}");
    for line in &flats {
        let x = line[100].x;
        assert!(line.iter().all(|p| (p.x - x).abs() < 2e-3 * width()), "it is straight");
        assert!((line[0].y - 10.0).abs() < 1e-6 && (line[200].y - 60.0).abs() < 1e-6);
    }
    let outermost = (flats[0][100].x - 40.0) / width() + 0.5 * strips;
    assert!((-1e-6..0.5 + 2e-3).contains(&outermost), "{outermost}");
}

/// In a channel that widens, no place is farther than half a strip from a pass, and passes begin on the way.
#[test]
fn where_a_channel_widens_passes_begin_and_none_are_too_far_apart() {
    let wheel = HUB.wheel(12);
    let strips = [3.3, 8.7];
    let channel = symmetric(&wheel, strips);
    let found = measured(&wheel, &channel);
    let lines = found.strips(&wheel, &channel);
    let flats: Vec<Vec<DVec2>> = lines.iter().map(|l| flat(&wheel, &channel, l)).collect();
    let half = 0.5 * exact_width(true);
    for i in 0..=40 {
        for j in 0..=60 {
            let (s, t) = (f64::from(i) / 40.0, f64::from(j) / 60.0);
            let place = HUB.flat(channel.place(&wheel, s, t));
            let off = flats.iter().map(|l| distance(place, l)).fold(f64::INFINITY, f64::min);
            assert!(off < 1.002 * half, "({s}, {t}): {off} of {half}");
        }
    }
    for s in [0.01, 0.53, 0.99] {
        let here = across(&lines, s);
        assert!(here.windows(2).all(|w| w[0] < w[1]), "in order: {here:?}");
        let wide = strips[0] + (strips[1] - strips[0]) * s;
        // Half a strip to either side of each, up to the sides; at most as with passes on the sides.
        assert!((wide.floor() as usize..=wide.ceil() as usize + 2).contains(&here.len()), "{s}");
    }
    let counts = [0.01, 0.53, 0.99].map(|s| across(&lines, s).len());
    assert!(counts[0] < counts[1] && counts[1] < counts[2], "{counts:?}");
    // None of them begins twice or ends: the channel only widens.
    assert!(lines.iter().all(|l| l.to == 1.0));
    let length = |lines: &[Line]| lines.iter().map(|l| l.length(&wheel, &channel)).sum::<f64>();
    let (shorter, equal) = (length(&lines), length(&found.equal_parts()));
    assert!(shorter < equal, "{shorter} of {equal} mm");
}

/// The outermost passes' neighbours are one strip from them, measured square to the sides.
#[test]
fn distances_are_those_of_the_development() {
    let wheel = HUB.wheel(12);
    let channel = symmetric(&wheel, [6.0, 11.0]);
    let lines = measured(&wheel, &channel).strips(&wheel, &channel);
    let flats: Vec<Vec<DVec2>> = lines.iter().map(|l| flat(&wheel, &channel, l)).collect();
    let n = flats.len();
    // Of either side: the outermost, and the one beside it.
    for (outer, inner) in [(0, 1), (n - 1, n - 2)] {
        assert!(lines[inner].from == 0.0 && lines[inner].to == 1.0);
        for p in &flats[inner][20..180] {
            let apart = distance(*p, &flats[outer]) / width();
            assert!((apart - 1.0).abs() < 4e-3, "{apart}");
        }
    }
}

/// Gaps of a strip are even, those of half a strip are not.
#[test]
fn the_even_share_is_that_of_the_area_between_passes_a_strip_apart() {
    let wheel = HUB.wheel(12);
    let channel = symmetric(&wheel, [10.0, 10.0]);
    let found = measured(&wheel, &channel);
    let line = |(level, t): (usize, f64)| Line { t: vec![t; ROWS], level, from: 0.0, to: 1.0 };
    let lines = |all: &[f64]| all.iter().copied().enumerate().map(line).collect::<Vec<Line>>();
    let mut even: Vec<f64> = (0..=10).map(|k| f64::from(k) / 10.0).collect();
    assert!((found.even_share(&lines(&even)) - 1.0).abs() < 1e-9);
    even.insert(5, 0.45);
    assert!((found.even_share(&lines(&even)) - 0.9).abs() < 1e-3);
    assert_eq!(found.even_share(&lines(&even[..1])), 0.0);
}
