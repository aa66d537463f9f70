//! Hubs of revolution made whole, and turns in space.

use super::super::shapes::{Cylinder, options};
use super::*;
use crate::geometry::math::atan2;
use crate::nurbs::NurbsParts;

const CYLINDER: Cylinder = Cylinder { radius: 50.0, length: 40.0 };

/// An arc of 90 degrees about z, radius 50, swept by 40 mm; u along the arc.
fn quarter() -> NurbsParts {
    let points = [(50.0, 0.0, 1.0), (50.0, 50.0, 0.5_f64.sqrt()), (0.0, 50.0, 1.0)];
    NurbsParts {
        degree: [2, 1],
        knots: [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]],
        points: points
            .map(|(x, y, _)| vec![DVec3::new(x, y, 0.0), DVec3::new(x, y, 40.0)])
            .to_vec(),
        weights: points.map(|(_, _, w)| vec![w; 2]).to_vec(),
    }
}

/// The same surface with its parameters in the other order.
fn swapped(parts: &NurbsParts) -> NurbsParts {
    let columns = parts.points[0].len();
    NurbsParts {
        degree: [parts.degree[1], parts.degree[0]],
        knots: [parts.knots[1].clone(), parts.knots[0].clone()],
        points: (0..columns).map(|j| parts.points.iter().map(|row| row[j]).collect()).collect(),
        weights: (0..columns).map(|j| parts.weights.iter().map(|row| row[j]).collect()).collect(),
    }
}

/// A cylinder along z over an ellipse, u around.
fn elliptic(x: f64, y: f64) -> NurbsSurface {
    let ellipse = NurbsCurve::ellipse(DVec3::ZERO, DVec3::X * x, DVec3::Y * y).unwrap();
    ellipse.extruded(DVec3::ZERO, DVec3::Z * 40.0).unwrap()
}

fn angle(place: DVec3) -> f64 {
    atan2(place.y, place.x).to_degrees()
}

#[test]
fn a_sector_becomes_the_whole_hub_whichever_parameter_runs_around() {
    for parts in [quarter(), swapped(&quarter())] {
        let sector = NurbsSurface::new(parts).unwrap();
        assert_eq!(sector.closed(), [false; 2]);
        let wheel = Wheel::new(&sector, &options(20), DVec3::X * 80.0).unwrap();
        assert!(wheel.hub.closed()[wheel.around]);
        for k in 0..36 {
            let turn = f64::from(k) * TAU / 36.0;
            let place = DVec3::new(50.0 * cos(turn), 50.0 * sin(turn), 17.0);
            let found = wheel.hub.point(wheel.nearest(place));
            assert!(found.distance(place) < 1e-9, "{found} is not {place}");
        }
        assert_eq!(wheel.ends(), (0.0, 1.0));
    }
}

/// With 16 blades on arcs of 90 degrees a pitch is a quarter of an arc, which the parameter misses by 0.9 degrees.
#[test]
fn neighbours_are_turned_in_space_and_not_by_the_parameter() {
    let blades = 16;
    let wheel = CYLINDER.wheel(blades);
    let pitch = 360.0 / f64::from(blades);
    let from = DVec2::new(0.0, 0.3);
    for pitches in [1, 5, -1] {
        let to = wheel.carried(from, pitches, 1e-6).unwrap();
        let off = angle(wheel.hub.point(to)) - pitch * f64::from(pitches);
        assert!(off.abs() < 1e-9, "{pitches}: {off} degrees off");
        assert!((to.y - from.y).abs() < 1e-12);
        let mut shifted = from;
        shifted[wheel.around] += wheel.period() * f64::from(pitches) / f64::from(blades);
        let off = (angle(wheel.hub.point(shifted)) - pitch * f64::from(pitches)).abs();
        assert!((0.85..0.95).contains(&off), "{pitches}: {off} degrees off");
    }
}

#[test]
fn carried_parameters_go_on_over_the_seam() {
    let wheel = CYLINDER.wheel(20);
    let mut at = DVec2::new(3.9, 0.5);
    for _ in 0..40 {
        let next = wheel.carried(at, 1, 1e-6).unwrap();
        let step = next.x - at.x;
        assert!((0.15..0.25).contains(&step), "{step}");
        at = next;
    }
    // Twice around.
    assert!((at.x - 3.9 - 2.0 * wheel.period()).abs() < 1e-9);
}

#[test]
fn places_turn_so_that_the_parameter_around_grows() {
    for parts in [quarter(), swapped(&quarter())] {
        let wheel = Wheel::new(&NurbsSurface::new(parts).unwrap(), &options(8), DVec3::X * 80.0);
        let wheel = wheel.unwrap();
        let at = DVec2::new(0.4, 0.6);
        let next = wheel.carried(at, 1, 1e-6).unwrap();
        assert!(next[wheel.around] > at[wheel.around]);
        let turned = wheel.turned(wheel.hub.point(at), 1);
        assert!(turned.distance(wheel.hub.point(next)) < 1e-9);
        let way = wheel.normal(at);
        assert!(wheel.turned_direction(way, 1).distance(wheel.normal(next)) < 1e-9);
    }
}

#[test]
fn the_normal_is_toward_the_blades() {
    for (distance, sign) in [(80.0, 1.0), (20.0, -1.0)] {
        let wheel = CYLINDER.wheel_with_tool(12, distance);
        for at in [DVec2::new(0.3, 0.2), DVec2::new(2.7, 0.9)] {
            let place = wheel.hub.point(at);
            let outward = DVec3::new(place.x, place.y, 0.0).normalize();
            assert!(wheel.normal(at).distance(outward * sign) < 1e-12, "tool at {distance}");
        }
    }
}

#[test]
fn surfaces_that_do_not_run_around_are_refused() {
    let line = NurbsCurve::line(DVec3::new(-30.0, 50.0, 0.0), DVec3::new(30.0, 50.0, 0.0)).unwrap();
    let plane = line.extruded(DVec3::ZERO, DVec3::Z * 40.0).unwrap();
    let sector = NurbsSurface::new(quarter()).unwrap();
    let beside = HubOptions { origin: DVec3::new(3.0, 0.0, 0.0), ..options(12) };
    for (surface, options) in [(plane, options(12)), (sector, beside)] {
        let refused = Wheel::new(&surface, &options, DVec3::new(80.0, 80.0, 0.0));
        assert!(matches!(refused, Err(HubError::NotAround { axis: DVec3::Z })), "{refused:?}");
    }
}

/// An ellipse is alike after half a turn, and not after a quarter.
#[test]
fn a_hub_that_is_not_of_revolution_is_taken_as_it_is() {
    let hub = elliptic(50.0, 40.0);
    let wheel = Wheel::new(&hub, &options(2), DVec3::X * 80.0).unwrap();
    assert_eq!(wheel.hub, hub);
    let at = DVec2::new(0.3, 0.5);
    let opposite = wheel.hub.point(wheel.carried(at, 1, 1e-6).unwrap());
    let place = wheel.hub.point(at);
    assert!(opposite.distance(DVec3::new(-place.x, -place.y, place.z)) < 1e-9);
    let wheel = Wheel::new(&hub, &options(4), DVec3::X * 80.0).unwrap();
    let Err(HubError::NotAlike { off, .. }) = wheel.carried(DVec2::new(0.0, 0.5), 1, 0.01) else {
        panic!("a quarter of a turn leaves the ellipse");
    };
    // From the end of the long axis beyond the end of the short one.
    assert!((off - 10.0).abs() < 1e-6, "{off}");
}
