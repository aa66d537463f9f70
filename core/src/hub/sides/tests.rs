//! Flanks of ellipses and circles on a cylinder, by its development.

use super::super::shapes::Cylinder;
use super::*;
use crate::geometry::math::sin;
use core::f64::consts::TAU;

const CYLINDER: Cylinder = Cylinder { radius: 50.0, length: 80.0 };
/// Points of a curve lie this far apart at most, of a curve of 100 mm.
const BETWEEN: f64 = 0.1;

fn flats(wheel: &Wheel, flank: &[DVec2]) -> Vec<DVec2> {
    flank.iter().map(|p| CYLINDER.flat(wheel.hub.point(*p))).collect()
}

#[test]
fn flanks_of_an_ellipse_are_its_halves_from_nose_to_tail() {
    let wheel = CYLINDER.wheel(12);
    let (centre, half) = (DVec2::new(60.0, 40.0), DVec2::new(5.0, 20.0));
    let curve = CYLINDER.ellipse(&wheel, centre, half);
    let flanks = Flanks::new(&wheel, &curve, false).unwrap();
    for (flank, side) in [(&flanks.before, -1.0), (&flanks.behind, 1.0)] {
        let flank = flats(&wheel, flank);
        let (first, last) = (flank[0], flank[flank.len() - 1]);
        assert!(first.distance(centre - DVec2::Y * half.y) < BETWEEN, "{first}");
        assert!(last.distance(centre + DVec2::Y * half.y) < BETWEEN, "{last}");
        for p in &flank {
            let part = (*p - centre) / half;
            assert!((part.length() - 1.0).abs() < 1e-5 && part.x * side > -1e-2, "{p}");
        }
        assert!(flank.windows(2).all(|w| w[0].y < w[1].y + 1e-9));
    }
}

/// An ellipse has turned by 45 degrees from the direction around where it is `b² / sqrt(a² + b²)` off its centre along `b`.
#[test]
fn sides_begin_where_the_flank_has_turned_by_45_degrees() {
    let wheel = CYLINDER.wheel(12);
    let (centre, half) = (DVec2::new(60.0, 40.0), DVec2::new(5.0, 20.0));
    let curve = CYLINDER.ellipse(&wheel, centre, half);
    let flanks = Flanks::new(&wheel, &curve, true).unwrap();
    for flank in [&flanks.before, &flanks.behind] {
        let flank = flats(&wheel, flank);
        let ends = [(flank[0], -1.0), (flank[flank.len() - 1], 1.0)];
        for (end, sign) in ends {
            let wanted = centre.y + sign * half.y * half.y / half.length();
            assert!((end.y - wanted).abs() < BETWEEN, "{end}: {wanted}");
        }
    }
}

#[test]
fn flanks_end_at_the_rim() {
    let wheel = CYLINDER.wheel(12);
    // Its top is 6 mm beyond the upper rim.
    let (centre, radius) = (DVec2::new(60.0, 74.0), 12.0);
    let curve = CYLINDER.ellipse(&wheel, centre, DVec2::splat(radius));
    for for_cut in [false, true] {
        let flanks = Flanks::new(&wheel, &curve, for_cut).unwrap();
        for (flank, side) in [(&flanks.before, -1.0), (&flanks.behind, 1.0)] {
            let end = flank[flank.len() - 1];
            assert_eq!(end[1 - wheel.around], wheel.ends().1);
            let rise = CYLINDER.length - centre.y;
            let wanted = centre.x + side * (radius * radius - rise * rise).sqrt();
            let end = CYLINDER.flat(wheel.hub.point(end));
            // The chord between two points of the curve is crossed, not the curve.
            assert!((end.x - wanted).abs() < 1e-3, "{end}: {wanted}");
        }
    }
}

#[test]
fn flanks_are_the_same_after_a_pitch() {
    let blades = 12;
    let wheel = CYLINDER.wheel(blades);
    let (centre, half) = (DVec2::new(60.0, 40.0), DVec2::new(5.0, 20.0));
    let flanks = Flanks::new(&wheel, &CYLINDER.ellipse(&wheel, centre, half), true).unwrap();
    let next = flanks.carried(&wheel, 1, 1e-6).unwrap();
    let pitch = TAU * CYLINDER.radius / f64::from(blades);
    for (a, b) in flats(&wheel, &flanks.behind).iter().zip(flats(&wheel, &next.behind)) {
        assert!(b.distance(*a + DVec2::X * pitch) < 1e-8);
    }
}

/// Two circles on the cylinder are nearest to each other between their centres.
#[test]
fn the_narrowest_place_between_two_circles() {
    let blades = 12;
    let wheel = CYLINDER.wheel(blades);
    let centre = DVec2::new(20.0, 40.0);
    let pitch = TAU * CYLINDER.radius / f64::from(blades);
    for radius in [8.0, 12.0, 12.5] {
        let curve = CYLINDER.ellipse(&wheel, centre, DVec2::splat(radius));
        let flanks = Flanks::new(&wheel, &curve, true).unwrap();
        let next = flanks.carried(&wheel, 1, 1e-6).unwrap();
        let (place, width) = narrowest(&wheel, &flanks.behind, &next.before);
        let arc = pitch - 2.0 * radius;
        let exact = 2.0 * CYLINDER.radius * sin(0.5 * arc / CYLINDER.radius);
        assert!((width - exact).abs() < 1e-3, "{width}: {exact}");
        let place = CYLINDER.flat(place);
        assert!(place.distance(centre + DVec2::X * (0.5 * pitch)) < BETWEEN, "{place}");
    }
    // Circles that overlap.
    let curve = CYLINDER.ellipse(&wheel, centre, DVec2::splat(14.0));
    let flanks = Flanks::new(&wheel, &curve, true).unwrap();
    let next = flanks.carried(&wheel, 1, 1e-6).unwrap();
    assert!(narrowest(&wheel, &flanks.behind, &next.before).1 < 0.0);
}

#[test]
fn spaced_places_are_equally_far_apart() {
    let wheel = CYLINDER.wheel(12);
    let line: Vec<DVec2> =
        [0.0, 0.1, 0.5, 0.55, 1.0].map(|x| CYLINDER.at(DVec2::new(30.0, 70.0 * x + 5.0))).to_vec();
    let places = spaced(&wheel, &line, 8);
    for (k, place) in flats(&wheel, &places).into_iter().enumerate() {
        assert!(place.distance(DVec2::new(30.0, 5.0 + 10.0 * k as f64)) < 1e-9, "{place}");
    }
}
