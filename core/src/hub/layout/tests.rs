//! Channels between ellipses on a cylinder, by its development.

use super::super::shapes::Cylinder;
use super::*;
use core::f64::consts::{PI, TAU};

const HUB: Cylinder = Cylinder { radius: 50.0, length: 80.0 };
const BLADES: u32 = 12;
const CLEARANCE: f64 = 0.5;
const RADIUS: f64 = 2.0;

fn pitch() -> f64 {
    TAU * HUB.radius / f64::from(BLADES)
}

fn nothing() -> &'static Hindrance {
    static NOTHING: std::sync::OnceLock<Hindrance> = std::sync::OnceLock::new();
    NOTHING.get_or_init(Hindrance::default)
}

fn edges<'a>(
    wheel: &'a Wheel,
    blade: &'a ParameterCurve,
    splitter: Option<&'a ParameterCurve>,
    radius: f64,
) -> Edges<'a> {
    // Blades that stand straight.
    let blade = (blade, nothing());
    let splitter = splitter.map(|edge| (edge, nothing()));
    Edges { wheel, blade, splitter, radius, clearance: CLEARANCE, tolerance: 0.001 }
}

fn blade(wheel: &Wheel) -> ParameterCurve {
    HUB.ellipse(wheel, DVec2::new(40.0, 40.0), DVec2::new(3.0, 25.0))
}

fn area(points: &[DVec2]) -> f64 {
    let n = points.len();
    0.5 * (0..n).map(|i| points[i].perp_dot(points[(i + 1) % n])).sum::<f64>()
}

/// The distance of a place of the development from an ellipse, from many of its places.
fn from_ellipse(p: DVec2, centre: DVec2, half: DVec2) -> f64 {
    let at = |i: usize| {
        let angle = PI * i as f64 / 1000.0;
        let (s, c) = (crate::geometry::math::sin(angle), crate::geometry::math::cos(angle));
        centre + half * DVec2::new(c, s)
    };
    (0..2000).map(|i| at(i).distance(p)).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_sides_are_at_the_distance_of_cutter_and_clearance_from_both_blades() {
    let wheel = HUB.wheel(BLADES);
    let edge = blade(&wheel);
    let layout = edges(&wheel, &edge, None, RADIUS).layout().unwrap();
    let [part] = &layout.parts[..] else { panic!("{} parts", layout.parts.len()) };
    let (centre, half) = (DVec2::new(40.0, 40.0), DVec2::new(3.0, 25.0));
    for (right, at) in [(false, centre), (true, centre + DVec2::X * pitch())] {
        for p in part.channel.side(right) {
            let off = from_ellipse(HUB.flat(wheel.hub.point(p)), at, half);
            assert!((off - RADIUS - CLEARANCE).abs() < 0.01, "{off}");
        }
    }
    let (_, width) = layout.narrowest;
    let arc = pitch() - 2.0 * (half.x + RADIUS + CLEARANCE);
    let chord = 2.0 * HUB.radius * crate::geometry::math::sin(0.5 * arc / HUB.radius);
    assert!((width - chord).abs() < 0.01, "{width}: {chord}");
    let [outline] = &layout.loops()[..] else { panic!("one loop") };
    assert!(area(&outline.points) > 0.0);
    // Blades stand beside it, not in it.
    assert_eq!(layout.splitter_pitches, 0);
}

/// What is told of a channel that is too narrow can be done.
#[test]
fn where_it_is_too_narrow_the_largest_cutter_is_named_and_fits() {
    let wheel = HUB.wheel(BLADES);
    let edge = blade(&wheel);
    let found = edges(&wheel, &edge, None, 12.0).layout();
    let Err(HubError::TooNarrow { place, diameter, clearance, largest }) = found else {
        panic!("{found:?}")
    };
    assert_eq!((diameter, clearance), (24.0, CLEARANCE));
    // The blades are 6 mm thick, and both sides keep the clearance.
    let exact = pitch() - 6.0 - 2.0 * CLEARANCE;
    assert!((0.96 * exact..exact).contains(&largest), "{largest}: {exact}");
    let middle = HUB.flat(place) - DVec2::new(40.0 + 0.5 * pitch(), 40.0);
    assert!(middle.x.abs() < 1.0, "{middle}");
    assert!(edges(&wheel, &edge, None, 0.5 * largest).layout().is_ok());
}

/// The two parts beside a splitter have a side each along it, and together the area of the outline.
fn assert_parts(wheel: &Wheel, layout: &Layout) {
    let [first, last] = &layout.parts[..] else { panic!("{} parts", layout.parts.len()) };
    for part in [first, last] {
        assert!(part.channel.least_jacobian > 0.0);
    }
    let of = |part: &Part| area(&part.channel.outline().points);
    let loops = layout.loops();
    let whole: f64 = loops.iter().map(|l| area(&l.points)).sum();
    let parts = of(first) + of(last);
    assert!((parts / whole - 1.0).abs() < 0.01, "{parts} of {whole}");
    assert!(area(&loops[0].points) > 0.0 && loops[1..].iter().all(|l| area(&l.points) < 0.0));
    // From side to side.
    let middle = |part: &Part| wheel.hub.point(part.channel.at(0.5, 0.5));
    assert!(HUB.flat(middle(first)).x < HUB.flat(middle(last)).x);
}

#[test]
fn beside_a_splitter_that_ends_within_the_channel_both_parts_are_planned() {
    let wheel = HUB.wheel(BLADES);
    let edge = blade(&wheel);
    for pitches in [0.0, 3.0] {
        // Half a pitch behind the blade, some pitches farther on.
        let centre = DVec2::new(40.0 + (0.5 + pitches) * pitch(), 45.0);
        let half = DVec2::new(1.5, 10.0);
        let splitter = HUB.ellipse(&wheel, centre, half);
        let layout = edges(&wheel, &edge, Some(&splitter), RADIUS).layout().unwrap();
        assert_eq!(f64::from(layout.splitter_pitches), -pitches);
        assert_eq!(layout.loops().len(), 2);
        assert_parts(&wheel, &layout);
        let at = centre - DVec2::X * (pitches * pitch());
        for part in &layout.parts {
            for s in 0..=20 {
                for t in 0..=10 {
                    let p = part.channel.place(&wheel, f64::from(s) / 20.0, f64::from(t) / 10.0);
                    let off = from_ellipse(HUB.flat(p), at, half);
                    assert!(off > RADIUS + CLEARANCE - 0.05, "({s}, {t}): {off}");
                }
            }
        }
    }
}

#[test]
fn a_splitter_that_reaches_the_rim_leaves_one_loop_around_both_parts() {
    let wheel = HUB.wheel(BLADES);
    // Blades and splitter run on beyond the upper rim.
    let open = |x: f64, nose: f64, half: DVec2| {
        let top = 1.08 * HUB.length;
        let bottom = nose + half.y;
        let side = |sign: f64| {
            (0..40).map(move |i| {
                DVec2::new(x + sign * half.x, bottom + (top - bottom) * f64::from(i) / 40.0)
            })
        };
        let around = (1..180).map(|i| {
            let angle = PI * f64::from(i) / 180.0;
            let (s, c) = (crate::geometry::math::sin(angle), crate::geometry::math::cos(angle));
            DVec2::new(x - half.x * c, bottom - half.y * s)
        });
        let left: Vec<DVec2> = side(-1.0).collect();
        let points: Vec<DVec2> = left.into_iter().rev().chain(around).chain(side(1.0)).collect();
        HUB.curve(&wheel, &points, false)
    };
    let edge = open(40.0, 10.0, DVec2::new(2.0, 8.0));
    let splitter = open(40.0 + 0.5 * pitch(), 35.0, DVec2::new(1.5, 6.0));
    let layout = edges(&wheel, &edge, Some(&splitter), RADIUS).layout().unwrap();
    assert_eq!(layout.loops().len(), 1);
    assert_parts(&wheel, &layout);
    // Both end at the rim.
    let (_, high) = wheel.ends();
    for part in &layout.parts {
        for p in part.channel.across(ROWS - 1) {
            assert!((p[1 - wheel.around] - high).abs() < 1e-9);
        }
    }
}
