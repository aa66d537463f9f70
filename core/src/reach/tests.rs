use super::*;
use crate::geometry::DVec2;
use crate::geometry::math::{cos, sin};
use crate::mesh::FaceId;
use crate::surface::AnalyticSurface;
use crate::tool::Tool;

fn options(radius: f64, corner: f64) -> ReachOptions {
    ReachOptions {
        tool: Tool::new(radius, corner).unwrap(),
        allowance: 0.0,
        accuracy: 0.005,
        steepest: f64::to_radians(80.0),
        threads: 2,
    }
}

/// Two slopes of 45 degrees that meet in a groove along Y.
fn groove() -> Part {
    let at = |x: f64, y: f64| DVec3::new(x, y, x.abs());
    let positions = [-20.0, 0.0, 20.0].map(|x| [at(x, -20.0), at(x, 20.0)]).concat();
    let faces = vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
    Part { positions, faces }
}

/// A block from z = -10 to 0 with a square pocket 4 deep in its middle.
fn pocket() -> Part {
    let square = |half: f64, z: f64| {
        [(-half, -half), (half, -half), (half, half), (-half, half)]
            .map(|(x, y)| DVec3::new(x, y, z))
    };
    let positions =
        [square(20.0, -10.0), square(20.0, 0.0), square(10.0, 0.0), square(10.0, -4.0)].concat();
    let band = |a: u32, b: u32| {
        (0..4).flat_map(move |k| {
            let (i, j) = (k, (k + 1) % 4);
            [[a + i, a + j, b + j], [a + i, b + j, b + i]]
        })
    };
    let mut faces: Vec<[u32; 3]> =
        [(0, 4), (4, 8), (8, 12)].into_iter().flat_map(|(a, b)| band(a, b)).collect();
    faces.extend([[12, 13, 14], [12, 14, 15], [0, 2, 1], [0, 3, 2]]);
    Part { positions, faces }
}

/// Two slopes that fall at this angle, degrees, from an edge along Y, which is turned by a little.
fn ridge(slope: f64) -> Part {
    let slope = slope.to_radians();
    let at =
        |x: f64, y: f64| DVec3::new(x + 0.1 * y, y - 0.1 * x, -x.abs() * sin(slope) / cos(slope));
    let positions = [-8.0, 0.0, 8.0].map(|x| [at(x, -8.0), at(x, 8.0)]).concat();
    let faces = vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
    Part { positions, faces }
}

fn faces_of(surface: &Surface) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    (0..surface.connectivity().face_count() as u32).map(|f| surface.corners(FaceId(f)))
}

fn middle([a, b, c]: [DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

/// No face of a reached surface is turned over, seen from above.
fn assert_seen_from_above(surface: &Surface) {
    assert!(faces_of(surface).all(|c| area_normal(c).z > 0.0));
}

#[test]
fn a_ball_leaves_its_own_shape_in_a_groove() {
    let (part, radius) = (groove(), 3.0);
    let reached = reach(&part, &part, &options(radius, radius)).unwrap();
    assert_eq!(reached.pieces, 1);
    assert_seen_from_above(&reached.surface);
    let edge = radius * 0.5f64.sqrt();
    let expected = |x: f64| {
        if x.abs() >= edge {
            x.abs()
        } else {
            radius * 2f64.sqrt() - (radius * radius - x * x).sqrt()
        }
    };
    let places = reached.surface.positions().iter().copied();
    // At its ends the cutter comes lower.
    let places = places.chain(faces_of(&reached.surface).map(middle)).filter(|p| p.y.abs() < 17.0);
    for p in places {
        assert!((p.z - expected(p.x)).abs() < 2.0 * 0.005, "{p}: {}", expected(p.x));
    }
    let bridged = 2.0 * edge * 40.0;
    assert!(reached.aside.bridged < bridged * 1.2 && reached.aside.bridged > 0.6 * bridged);
    assert!((reached.aside.deepest_bridged - radius * (2f64.sqrt() - 1.0)).abs() < 0.02);
}

#[test]
fn a_flat_end_bridges_a_groove_level() {
    let part = groove();
    let reached = reach(&part, &part, &options(3.0, 0.0)).unwrap();
    let inside = reached.surface.positions().iter().filter(|p| p.y.abs() < 17.0);
    let low = inside.map(|p| p.z).fold(f64::INFINITY, f64::min);
    assert!((low - 3.0).abs() < 0.01, "{low}");
}

#[test]
fn a_pocket_is_reached_up_to_the_radius_of_its_corners() {
    let part = pocket();
    let reached = reach(&part, &part, &options(2.0, 2.0)).unwrap();
    assert_eq!(reached.pieces, 2);
    assert_seen_from_above(&reached.surface);
    let aside = reached.aside;
    // The bottom faces away; the walls are neither that nor in sight.
    assert!((aside.away - (1600.0 + 4.0 * 400.0 + 4.0 * 80.0)).abs() < 1e-6, "{aside:?}");
    assert_eq!((aside.steep, aside.shadowed), (0.0, 0.0));
    // Level up to where the fillets along the walls begin.
    let on_floor = faces_of(&reached.surface)
        .map(middle)
        .filter(|p| p.x.abs().max(p.y.abs()) < 7.9)
        .map(|p| (p.z + 4.0).abs());
    let worst = on_floor.fold(0.0, f64::max);
    assert!(worst < 2.0 * 0.005, "{worst}");
    let top: f64 = faces_of(&reached.surface)
        .filter(|c| c.iter().all(|p| p.z == 0.0))
        .map(|c| 0.5 * area_normal(c).length())
        .sum();
    assert!((top - 1200.0).abs() < 5.0, "{top}");
    assert_eq!(reached.rest.faces.len(), 4 + 24 - 8 - 2);
}

#[test]
fn where_the_cutter_fits_it_is_the_part() {
    let soup = AnalyticSurface::Bump { size: 30.0, height: 4.0, width: 5.0 }.mesh(0.3);
    let part = Part { positions: soup.positions, faces: soup.faces };
    let reached = reach(&part, &part, &options(2.0, 2.0)).unwrap();
    let height =
        |x: f64, y: f64| 4.0 * crate::geometry::math::exp(-(x * x + y * y) / (2.0 * 5.0 * 5.0));
    let off = faces_of(&reached.surface).map(middle).map(|p| (p.z - height(p.x, p.y)).abs());
    let worst = off.fold(0.0, f64::max);
    assert!(worst < 3.0 * 0.005, "{worst}");
    assert!((reached.surface.area() / 900.0 - 1.0).abs() < 0.1);
    assert_eq!(reached.aside.bridged, 0.0);
}

#[test]
fn what_lies_under_something_is_in_shadow() {
    // A plate of 20 x 20 with one of 10 x 10 over its middle.
    let plate = |half: f64, z: f64| {
        [(-half, -half), (half, -half), (half, half), (-half, half)]
            .map(|(x, y)| DVec3::new(x, y, z))
    };
    let part = Part {
        positions: [plate(10.0, 0.0), plate(5.0, 6.0)].concat(),
        faces: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
    };
    let reached = reach(&part, &part, &options(1.0, 1.0)).unwrap();
    assert_eq!(reached.pieces, 2);
    assert!(reached.aside.shadowed > 0.0);
    let low = faces_of(&reached.surface).filter(|c| middle(*c).z < 5.0);
    let area: f64 = low.map(|c| 0.5 * area_normal(c).length()).sum();
    // All around the upper one, with a fillet up to 80 degrees along it.
    let fillet = 40.0 * (f64::to_radians(80.0) - 1.0);
    assert!((area - 300.0 - fillet).abs() < 6.0, "{area}");
}

#[test]
fn nothing_in_sight_is_an_error() {
    let mut part = groove();
    part.faces.iter_mut().for_each(|f| f.swap(0, 1));
    let part = Part {
        positions: part.positions.iter().map(|p| DVec3::new(p.x, p.z, p.y)).collect(),
        ..part
    };
    let error = reach(&part, &part, &options(1.0, 1.0)).map(|r| r.pieces);
    assert!(matches!(error, Err(ReachError::Nothing { .. })), "{error:?}");
}

#[test]
fn threads_change_nothing() {
    let part = pocket();
    let of = |threads| reach(&part, &part, &ReachOptions { threads, ..options(2.0, 2.0) }).unwrap();
    let (one, two) = (of(1), of(2));
    assert_eq!(one.surface.positions(), two.surface.positions());
    assert_eq!(one.surface.connectivity().faces(), two.surface.connectivity().faces());
}

/// Boxes on a floor, turned, so that the cutter stands on upright edges on all sides.
fn boxes() -> Part {
    let mut part = Part::default();
    let mut add = |middle: DVec2, half: DVec3, turn: f64| {
        let along = DVec2::new(cos(turn), sin(turn));
        let corner = |k: u32| {
            let sign = |bit: u32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let place = middle + along * (sign(0) * half.x) + along.perp() * (sign(1) * half.y);
            place.extend(if k >> 2 & 1 == 1 { half.z } else { -1.0 })
        };
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [3, 2, 6, 7], [1, 3, 7, 5], [2, 0, 4, 6]];
        let faces = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        part.add(&Part { positions: (0..8).map(corner).collect(), faces: faces.collect() });
    };
    add(DVec2::ZERO, DVec3::new(15.0, 15.0, 0.0), 0.0);
    add(DVec2::new(-4.0, 1.0), DVec3::new(2.0, 3.0, 5.0), 0.4);
    add(DVec2::new(4.0, 2.5), DVec3::new(3.0, 1.0, 4.0), 1.1);
    add(DVec2::new(1.0, -5.0), DVec3::new(2.5, 2.5, 6.0), 0.7);
    part
}

/// The cutter that leaves one place leaves no other higher than it is.
#[test]
fn no_place_is_higher_than_what_is_left_by_a_cutter_beside_it() {
    let (part, radius) = (boxes(), 3.0);
    let reached = reach(&part, &part, &options(radius, radius)).unwrap();
    let (surface, of_cutter) = (&reached.surface, &reached.is_of_cutter);
    let mut worst: f64 = 0.0;
    for (face, _) in surface.connectivity().faces().iter().zip(of_cutter).filter(|f| *f.1) {
        for (own, other) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
            let at = |i: usize| surface.positions()[face[i].index()];
            let centre = at(other) + radius * surface.vertex_normals()[face[other].index()];
            let across = (at(own) - centre).truncate().length();
            if across < 0.98 * radius {
                let left = centre.z - (radius * radius - across * across).sqrt();
                worst = worst.max(at(own).z - left);
            }
        }
    }
    // Ten times the accuracy: corners at the outline are single searches, where it is the steepest.
    assert!(worst < 0.05, "{worst}");
}

/// Along upright walls the surface ends at their upper edges, not in the teeth of the net before them: less than 0.03 mm
/// before the 80 mm of them.
#[test]
fn a_level_top_is_reached_up_to_its_edges() {
    for half in [9.93, 9.95, 9.97, 9.99] {
        let mut part = pocket();
        for p in part.positions.iter_mut().filter(|p| p.x.abs() < 15.0) {
            *p = (p.truncate() * half / 10.0).extend(p.z);
        }
        let reached = reach(&part, &part, &options(3.0, 3.0)).unwrap();
        let is_top = |c: &[DVec3; 3]| c.iter().all(|p| p.z.abs() < 1e-3);
        let tops = faces_of(&reached.surface).filter(is_top);
        let found: f64 = tops.map(|c| 0.5 * area_normal(c).length()).sum();
        let before = (1600.0 - 4.0 * half * half - found) / 80.0;
        assert!((0.0..0.03).contains(&before), "{half}: {before}");
    }
}

/// Beside a wall a flat end reaches the floor from hardly any place but the one where its side touches the wall: the
/// floor is reached up to the walls all the same, but for the corners, and nothing else is bridged.
#[test]
fn a_flat_end_reaches_the_floor_up_to_the_walls() {
    let (half, depth) = (10.0, 4.0);
    let in_corners = 4.0 - core::f64::consts::PI;
    for (radius, corner) in [(3.0, 0.0), (2.3, 0.0), (3.0, 0.5)] {
        let reached = reach(&pocket(), &pocket(), &options(radius, corner)).unwrap();
        let low = faces_of(&reached.surface).filter(|c| middle(*c).z < 0.1 - depth);
        let floor: f64 = low.map(|c| 0.5 * area_normal(c).length()).sum();
        // Up to where the rounding of the cutter is 0.1 high.
        let (bottom, round) = (radius - corner, corner - 0.1);
        let lip = (corner * corner - round * round).max(0.0).sqrt();
        let (half, radius) = (half - corner + lip, bottom + lip);
        let expected = 4.0 * half * half - in_corners * radius * radius;
        let before = (expected - floor) / (8.0 * half);
        assert!(before.abs() < 0.03, "{radius} {corner}: {floor} of {expected}");
        if corner == 0.0 {
            let excess = reached.aside.bridged - in_corners * radius * radius;
            assert!(excess.abs() < 0.05 * radius * radius, "{radius}: {excess}");
        }
    }
}

/// A slot just as wide as a flat end is reached over its whole width.
#[test]
fn a_slot_as_wide_as_a_flat_end_is_reached() {
    let part = pocket();
    let slot = Part {
        positions: part.positions.iter().map(|p| DVec3::new(p.x, 0.3 * p.y, p.z)).collect(),
        ..part
    };
    let reached = reach(&slot, &slot, &options(3.0, 0.0)).unwrap();
    let low = faces_of(&reached.surface).filter(|c| middle(*c).z < -3.999);
    let floor: f64 = low.map(|c| 0.5 * area_normal(c).length()).sum();
    let expected = 14.0 * 6.0 + core::f64::consts::PI * 9.0;
    assert!((expected - floor).abs() < 0.01 * expected, "{floor} of {expected}");
}

/// A dome with facets of 40 degrees, then of 78, then of 83: what is machined up to 80 degrees ends along the edges to the last
/// ones, not at the places of the net, which are far apart in height there.
#[test]
fn the_outline_on_steep_facets_is_their_edge() {
    use crate::geometry::math::{cos, sin, tan};
    const SIDES: u32 = 17;
    let corner = |k: u32| {
        let angle = 0.3 + core::f64::consts::TAU * f64::from(k) / f64::from(SIDES);
        DVec2::new(cos(angle), sin(angle))
    };
    let mut z = 0.0;
    let mut positions = vec![DVec3::ZERO];
    let mut radius = 0.0;
    for (width, slope) in [(12.0, 40.0), (1.0, 78.0), (0.5, 83.0)] {
        radius += width;
        // The slope is that of the middle of a facet.
        z -= width * cos(core::f64::consts::PI / f64::from(SIDES)) * tan(f64::to_radians(slope));
        positions.extend((0..SIDES).map(|k| (radius * corner(k)).extend(z)));
    }
    let at = |ring: u32, k: u32| 1 + ring * SIDES + k % SIDES;
    let top = (0..SIDES).map(|k| [0, at(0, k), at(0, k + 1)]);
    let bands = (0..2).flat_map(|ring| {
        (0..SIDES).flat_map(move |k| {
            let [a, b] = [k, k + 1].map(|k| at(ring, k));
            let [c, d] = [k, k + 1].map(|k| at(ring + 1, k));
            [[a, c, d], [a, d, b]]
        })
    });
    let part = Part { faces: top.chain(bands).collect(), positions: positions.clone() };
    let reached = reach(&part, &part, &options(5.0, 5.0)).unwrap();
    let outlines = outlines(&reached.surface);
    let edge = positions[at(1, 0) as usize];
    assert_eq!(outlines.len(), 1);
    let off = outlines[0].iter().map(|p| (p.z - edge.z).abs()).fold(0.0, f64::max);
    assert!(off < 0.1, "{off} mm off the edge");
    let around =
        f64::from(SIDES) * positions[at(1, 0) as usize].distance(positions[at(1, 1) as usize]);
    assert!((length(&outlines[0]) / around - 1.0).abs() < 0.01, "{}", length(&outlines[0]));
}

/// The outline of a surface that lies askew to the net has no notches.
#[test]
fn the_outline_is_as_long_as_that_of_the_part() {
    use crate::geometry::math::{cos, sin};
    for turn in [0.1, 0.35, 0.5, 1.3] {
        let (along, size) = (DVec2::new(cos(turn), sin(turn)), 20.0);
        let at = |x: f64, y: f64| (along * x + along.perp() * y).extend(1.5 * x);
        let positions = vec![at(0.0, 0.0), at(size, 0.0), at(size, size), at(0.0, size)];
        let part = Part { positions: positions.clone(), faces: vec![[0, 1, 2], [0, 2, 3]] };
        let reached = reach(&part, &part, &options(2.0, 2.0)).unwrap();
        let found: f64 = outlines(&reached.surface).iter().map(|outline| length(outline)).sum();
        let (around, tolerance) = (length(&positions), 0.01);
        assert!((found / around - 1.0).abs() < tolerance, "{turn}: {found} of {around} mm");
    }
}

/// The places along every boundary.
fn outlines(surface: &Surface) -> Vec<Vec<DVec3>> {
    let places = |l: &Vec<VertexId>| l.iter().map(|v| surface.positions()[v.index()]).collect();
    surface.connectivity().boundary_loops().iter().map(places).collect()
}

/// Around a closed polyline, mm.
fn length(outline: &[DVec3]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| a.distance(*b)).sum()
}

/// Along the edge of a ridge the normal is upright, whichever face the needle found there.
#[test]
fn normals_at_an_edge_lie_between_those_of_its_faces() {
    for slope in [2.0, 5.0, 8.0] {
        let part = ridge(slope);
        let Reached { surface, .. } = reach(&part, &part, &options(3.0, 3.0)).unwrap();
        let places = surface.positions().iter().zip(surface.vertex_normals());
        let at_edge = places.filter(|(p, _)| p.y.abs() < 5.0 && (p.x - 0.1 * p.y).abs() < 1e-3);
        let lean = at_edge.map(|(_, n)| n.truncate().length()).fold(0.0, f64::max);
        assert!(lean < 0.5 * sin(f64::to_radians(slope)), "{slope}: {lean}");
    }
}
