//! An axial blisk as NURBS: its hub, one of its blades, and the fillet at that blade's root.
//!
//! - *Section*: NACA 0012 whose trailing edge is closed and rounded, at a height above the hub. It is drawn in the plane of
//!   circumferential and axial coordinates, turned by the stagger, laid on the cylinder of that radius, and moved along
//!   the radius onto the hub, or as high above it. It runs counter-clockwise as seen from outside.
//! - *Footprint*: the section at height 0, on the hub.
//! - *Fillet edge*: where the fillet ends on the hub: the footprint's parallel, one fillet radius away along geodesics.
//!
//! Across, the fillet is a rational quadratic: it leaves the hub at its edge, in the hub's tangent plane, and ends on the
//! blade one radius above the hub; on a flat hub below an upright blade it is a quarter of a circle. Around the blade
//! all are cubic splines through points at equal steps, C2 and closed.
//!
//! The source has a cylinder of radius 50 mm, 20 blades of chord 30 mm at 45 degrees, and fillets of 3 mm. Neighbouring
//! fillets are then less than 3 mm apart, and hardly a ball cutter reaches the hub between them. Here the hub has a radius
//! of 90 mm, and they are 11.5 mm apart: balls of radius 3 and 4 mm pass.
//!
//! Source: Abbott and von Doenhoff, "Theory of Wing Sections" (1959), section 6.4: the thickness of the NACA four-digit
//! sections; with -0.1036 as last coefficient it vanishes at the trailing edge. Piegl and Tiller, "The NURBS Book",
//! 2nd edition, chapters 7 and 8.5: conics and surfaces of revolution.

use evencut_core::geometry::math::{atan2, cos, sin};
use evencut_core::geometry::{DVec2, DVec3};
use serde_json::{Value, json};

/// The meridian is an ellipse about this distance from the axis, mm.
const MIDDLE: f64 = 50.0;
/// Its half axes along the radius and along the axis of rotation, mm.
const HALF_AXES: DVec2 = DVec2::new(40.0, 60.0);
/// Half of the hub's length, mm: it ends about 10 mm beyond the fillets.
const HALF_LENGTH: f64 = 25.0;
/// Radius of the hub half way between its ends, mm.
const RADIUS: f64 = MIDDLE + HALF_AXES.x;
/// Chord before its trailing edge is rounded, mm, and greatest thickness by it.
const CHORD: f64 = 30.0;
const THICKNESS: f64 = 0.12;
/// Part of the chord from which the trailing edge is rounded.
const ROUNDED_FROM: f64 = 0.93;
/// Angle between chord and axis at the hub, and what is added up to the tip, degrees.
const STAGGER: f64 = 45.0;
const TWIST: f64 = 5.0;
/// Height of the blades above the hub, mm.
const HEIGHT: f64 = 25.0;
/// Radius of the fillet, mm.
const FILLET: f64 = 3.0;
/// Points around a section. Fewer: a spline that leaves the hub; more: larger files.
const POINTS: usize = 200;
/// Share of a section's parameter in either half of the rounded trailing edge.
const EDGE: f64 = 0.1;
/// Steps of a geodesic; its error falls with their square.
const STEPS: usize = 64;
/// Steps of the parameter along a section when its length is measured.
const MEASURED: usize = 6000;

/// Radius of the hub at a distance along the axis, mm.
fn hub_radius(z: f64) -> f64 {
    let part = z / HALF_AXES.y;
    MIDDLE + HALF_AXES.x * (1.0 - part * part).sqrt()
}

/// Unit normal of the hub, outward.
fn hub_normal(p: DVec3) -> DVec3 {
    let part = p.z / HALF_AXES.y;
    let slope = -HALF_AXES.x / HALF_AXES.y * part / (1.0 - part * part).sqrt();
    let out = DVec3::new(p.x, p.y, 0.0).normalize();
    (out - DVec3::Z * slope).normalize()
}

/// The place of the hub near a place beside it.
fn onto_hub(mut p: DVec3) -> DVec3 {
    for _ in 0..8 {
        let n = hub_normal(p);
        let above = DVec2::new(p.x, p.y).length() - hub_radius(p.z);
        // `above` is measured along the radius.
        p -= n * (above * DVec2::new(n.x, n.y).length());
    }
    p
}

/// Half the section's thickness and its slope at the square root of the part of the chord, in chords; both sides are
/// one smooth function of a root that is negative on the lower side.
fn half_thickness(root: f64) -> f64 {
    let x = root * root;
    let rest = x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1036 * x)));
    5.0 * THICKNESS * (0.2969 * root + rest * root.signum())
}

/// A section, counter-clockwise, for a parameter from 0 to 1: from the middle of the trailing edge, mm; the origin is
/// half way along the chord.
///
/// From [`ROUNDED_FROM`] on the thickness falls to nothing as `sqrt(1 - u^4)`, `u` from 0 to 1 over its own length: the
/// curvature goes over without a jump, which a circle's would not, and the tip has about half the thickness as radius.
fn section(t: f64) -> DVec2 {
    let length = 2.0 * half_thickness(ROUNDED_FROM.sqrt());
    // From -1 below to 1 above.
    let on_edge = |root: f64| {
        let u = 1.0 - root * root;
        let x = ROUNDED_FROM + length * u;
        let round = root * ((1.0 + u) * (1.0 + u * u)).sqrt();
        DVec2::new(x, half_thickness(x.sqrt()) * round)
    };
    let at = if t < EDGE {
        on_edge(t / EDGE)
    } else if t > 1.0 - EDGE {
        on_edge((t - 1.0) / EDGE)
    } else {
        let root = ROUNDED_FROM.sqrt() * (1.0 - 2.0 * (t - EDGE) / (1.0 - 2.0 * EDGE));
        DVec2::new(root * root, half_thickness(root))
    };
    (at - DVec2::new(0.5, 0.0)) * CHORD
}

/// The blade at a parameter of its section and a height above the hub, mm.
fn blade(t: f64, height: f64) -> DVec3 {
    let at = section(t);
    let stagger = (STAGGER + TWIST * height / HEIGHT).to_radians();
    let (sine, cosine) = (sin(stagger), cos(stagger));
    let (around, z) = (at.x * sine - at.y * cosine, at.x * cosine + at.y * sine);
    let angle = around / (RADIUS + height);
    let radius = hub_radius(z) + height;
    DVec3::new(radius * cos(angle), radius * sin(angle), z)
}

/// The footprint's parallel at a distance along the hub, mm, and the unit direction there, away from the blade.
///
/// A geodesic is the path of a body that slides on the hub without force: it goes straight, and is put back.
fn parallel(t: f64, distance: f64) -> (DVec3, DVec3) {
    let small = 1e-5;
    let mut p = blade(t, 0.0);
    // Around the end of the parameter.
    let [before, after] = [t - small, t + small].map(|t| blade(t - t.floor(), 0.0));
    let mut way = (after - before).cross(hub_normal(p)).normalize();
    let step = distance / STEPS as f64;
    for _ in 0..STEPS {
        // The next place, from half the change of direction on either side.
        let next = onto_hub(p + way * step);
        let chord = (next - p).normalize();
        // The direction is mirrored in the chord.
        let turned = chord * (2.0 * chord.dot(way)) - way;
        way = turned.reject_from_normalized(hub_normal(next)).normalize();
        p = next;
    }
    (p, way)
}

/// Parameters of the points around a section, at equal steps of the length half way between footprint and fillet edge.
fn parameters() -> Vec<f64> {
    let at = |k: usize| k as f64 / MEASURED as f64;
    let corners: Vec<DVec2> = (0..=MEASURED).map(|k| section(at(k))).collect();
    let mut lengths = vec![0.0];
    let mut last = DVec2::Y;
    let mut length = 0.0;
    for pair in corners.windows(2) {
        let way = pair[1] - pair[0];
        let turn = atan2(last.perp_dot(way), last.dot(way));
        length += way.length() + 0.5 * FILLET * turn;
        lengths.push(length);
        last = way;
    }
    let of = |i: usize| {
        let wanted = length * i as f64 / POINTS as f64;
        let k = lengths.partition_point(|l| *l <= wanted).clamp(1, MEASURED);
        let part = (wanted - lengths[k - 1]) / (lengths[k] - lengths[k - 1]);
        at(k - 1) + (at(k) - at(k - 1)) * part
    };
    (0..POINTS).map(of).collect()
}

/// Control points of the closed cubic spline with knots at whole numbers through points, the first three once more at the
/// end.
fn closed_spline(points: &[DVec3]) -> Vec<DVec3> {
    let n = points.len();
    let mut controls = points.to_vec();
    // A point is a sixth of its control point's neighbours and two thirds of it; every round adds a digit, nearly.
    for _ in 0..64 {
        for i in 0..n {
            let beside = controls[(i + n - 1) % n] + controls[(i + 1) % n];
            controls[i] = 1.5 * points[i] - 0.25 * beside;
        }
    }
    // The first point is that between the first three control points.
    (0..n + 3).map(|i| controls[(i + n - 1) % n]).collect()
}

/// Surface of columns of control points: a closed cubic around, Bézier curves across.
fn surface(rows: &[Vec<DVec3>], weights: &[f64]) -> Vec<u8> {
    let count = POINTS + 3;
    let knots: Vec<i32> = (-3..=POINTS as i32 + 3).collect();
    let degree = rows.len() - 1;
    let across: Vec<i32> = (0..2 * rows.len()).map(|k| (k > degree).into()).collect();
    let point = |p: DVec3, w: f64| {
        let [x, y, z] = p.to_array().map(|x| rounded(x, 1e5));
        if weights.is_empty() { json!([x, y, z]) } else { json!([x, y, z, w]) }
    };
    let weight = |j: usize| weights.get(j).copied().unwrap_or(1.0);
    let column =
        |i: usize| rows.iter().enumerate().map(|(j, row)| point(row[i], weight(j))).collect();
    let controls: Vec<Vec<Value>> = (0..count).map(column).collect();
    file(&json!({
        "degree_u": 3, "degree_v": degree, "knots_u": knots, "knots_v": across,
        "control_points": controls,
    }))
}

/// A number with a few decimals; zeros are zeros.
fn rounded(x: f64, per_unit: f64) -> f64 {
    (x * per_unit).round() / per_unit + 0.0
}

fn file(surface: &Value) -> Vec<u8> {
    let mut text = surface.to_string();
    text.push('\n');
    text.into_bytes()
}

/// The hub: the meridian turned about Z, u around and v along the axis; its normal is outward.
pub fn hub() -> Vec<u8> {
    let sine = HALF_LENGTH / HALF_AXES.y;
    let cosine = (1.0 - sine * sine).sqrt();
    let meridian = [
        (MIDDLE + HALF_AXES.x * cosine, -HALF_LENGTH, 1.0),
        (MIDDLE + HALF_AXES.x / cosine, 0.0, cosine),
        (MIDDLE + HALF_AXES.x * cosine, HALF_LENGTH, 1.0),
    ];
    let half = core::f64::consts::FRAC_1_SQRT_2;
    // Corners and middles of the sides of a square.
    let around = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let column = |(i, (x, y)): (usize, &(i32, i32))| {
        let weight = if i % 2 == 1 { half } else { 1.0 };
        let point = |(radius, z, w): (f64, f64, f64)| {
            let place = [radius * f64::from(*x), radius * f64::from(*y), z];
            let [x, y, z] = place.map(|x| rounded(x, 1e9));
            json!([x, y, z, rounded(w * weight, 1e12)])
        };
        meridian.map(point)
    };
    let controls: Vec<[Value; 3]> = around.iter().enumerate().map(column).collect();
    file(&json!({
        "degree_u": 2, "degree_v": 2,
        "knots_u": [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], "knots_v": [0, 0, 0, 1, 1, 1],
        "control_points": controls,
    }))
}

/// The fillet of the blade at y = 0, u around the blade and v from the hub up to the blade; its normal is outward.
pub fn fillet() -> Vec<u8> {
    let at = parameters();
    let edge: Vec<(DVec3, DVec3)> = at.iter().map(|t| parallel(*t, FILLET)).collect();
    let corner: Vec<DVec3> = edge.iter().map(|(p, way)| *p - *way * FILLET).collect();
    let edge: Vec<DVec3> = edge.iter().map(|e| e.0).collect();
    let top: Vec<DVec3> = at.iter().map(|t| blade(*t, FILLET)).collect();
    let half = rounded(core::f64::consts::FRAC_1_SQRT_2, 1e12);
    surface(&[edge, corner, top].map(|row| closed_spline(&row)), &[1.0, half, 1.0])
}

/// The blade at y = 0 from the top of its fillet to its tip, which is open; its normal is outward.
pub fn blade_surface() -> Vec<u8> {
    let at = parameters();
    let row = |k: i32| {
        let height = FILLET + (HEIGHT - FILLET) * f64::from(k) / 3.0;
        at.iter().map(|t| blade(*t, height)).collect::<Vec<_>>()
    };
    let through = [row(0), row(1), row(2), row(3)];
    // The cubic through points at thirds of its parameter.
    let mix = |weights: [f64; 4]| {
        let of = |i: usize| (0..4).map(|k| through[k][i] * (weights[k] / 6.0)).sum();
        (0..POINTS).map(of).collect::<Vec<DVec3>>()
    };
    let (second, third) = (mix([-5.0, 18.0, -9.0, 2.0]), mix([2.0, -9.0, 18.0, -5.0]));
    let [first, _, _, last] = through;
    surface(&[first, second, third, last].map(|row| closed_spline(&row)), &[])
}

#[cfg(test)]
mod tests {
    use super::*;
    use evencut_core::nurbs::{NurbsSurface, read_json};

    const BLADES: usize = 20;

    fn read(file: &[u8]) -> NurbsSurface {
        read_json(file).unwrap().surface
    }

    /// Parameters of a surface: `u` of `n` around, and `v` from 0 to 1.
    fn at(u: usize, n: usize, v: f64) -> DVec2 {
        DVec2::new(u as f64 / n as f64 * POINTS as f64, v)
    }

    fn above_hub(p: DVec3) -> f64 {
        DVec2::new(p.x, p.y).length() - hub_radius(p.z)
    }

    fn line(surface: &NurbsSurface, n: usize, v: f64) -> Vec<DVec3> {
        (0..n).map(|k| surface.point(at(k, n, v))).collect()
    }

    /// Smallest distance of a point from a closed polyline.
    fn distance(p: DVec3, line: &[DVec3]) -> f64 {
        let to = |k: usize| {
            let (a, way) = (line[k], line[(k + 1) % line.len()] - line[k]);
            p.distance(a + way * ((p - a).dot(way) / way.length_squared()).clamp(0.0, 1.0))
        };
        (0..line.len()).map(to).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_files_are_small() {
        let sizes = [hub(), fillet(), blade_surface()].map(|f| f.len());
        assert!(sizes.iter().sum::<usize>() < 60_000, "{sizes:?}");
    }

    #[test]
    fn the_section_has_the_published_ordinates() {
        // The 0012 section at 30 %, where it is thickest, and its nose's radius of 1.58 %.
        assert!((half_thickness(0.3f64.sqrt()) - 0.06002).abs() < 2e-5);
        let y = half_thickness(1e-3);
        assert!((0.5 * y * y / 1e-6 - 0.0158).abs() < 1e-4);
        let length = section(0.0).x / CHORD + 0.5;
        assert!(length > 0.94 && length < 1.0, "{length}");
        // It is smooth where the rounding begins.
        for t in [EDGE, 1.0 - EDGE, 0.5] {
            let way = |t: f64, d: f64| ((section(t + d) - section(t)) / d).normalize();
            assert!((way(t, 1e-6) - way(t, -1e-6)).length() < 1e-3, "{t}");
        }
    }

    #[test]
    fn the_hub_is_the_ellipse_turned() {
        let hub = read(&hub());
        assert_eq!(hub.closed(), [true, false]);
        for k in 0..400 {
            let at = DVec2::new(f64::from(k % 20) * 0.2, f64::from(k / 20) / 19.0);
            let p = hub.point(at);
            assert!(above_hub(p).abs() < 1e-6, "{p}");
            assert!(hub.normal(at).dot(hub_normal(p)) > 1.0 - 1e-9);
        }
        assert!((hub.point(DVec2::new(0.0, 1.0)).z - HALF_LENGTH).abs() < 1e-9);
    }

    #[test]
    fn the_fillet_ends_on_the_hub_and_is_tangent_to_it() {
        let (fillet, n) = (read(&fillet()), 1000);
        assert_eq!(fillet.closed(), [true, false]);
        let foot: Vec<DVec3> = (0..20_000).map(|k| blade(f64::from(k) / 20_000.0, 0.0)).collect();
        let (mut off, mut turn, mut ends) = (0.0f64, 0.0f64, 0.0f64);
        let mut parallel = (f64::INFINITY, 0.0f64);
        for k in 0..n {
            let p = fillet.point(at(k, n, 0.0));
            off = off.max(above_hub(p).abs());
            turn = turn.max(fillet.normal(at(k, n, 0.0)).angle_between(hub_normal(p)));
            ends = ends.max(p.z.abs());
            let d = distance(p, &foot);
            parallel = (parallel.0.min(d), parallel.1.max(d));
        }
        println!("off the hub {off:.6}, {turn:.6} rad, parallel {parallel:?}, ends at {ends:.2}");
        assert!(off < 1e-3 && turn.to_degrees() < 0.5);
        // Least close is the rounded trailing edge, for its curvature.
        assert!(parallel.0 > FILLET - 2e-3 && parallel.1 < FILLET + 2e-3);
        assert!((HALF_LENGTH - ends - 10.0).abs() < 1.5);
    }

    #[test]
    fn blade_and_fillet_meet_and_face_the_air() {
        let (fillet, blade_file, n) = (read(&fillet()), read(&blade_surface()), 1000);
        let (mut bend, mut least, mut most) = (0.0f64, f64::INFINITY, 0.0f64);
        let mut facing = 1.0f64;
        for k in 0..n {
            let (top, foot) = (at(k, n, 1.0), at(k, n, 0.0));
            assert!(fillet.point(top).distance(blade_file.point(foot)) < 1e-9);
            let (above, below) = (blade_file.normal(foot), fillet.normal(top));
            bend = bend.max(above.angle_between(below));
            // From the blade to the fillet's edge, and away from the hub.
            let up = hub_normal(fillet.point(foot));
            let out = (fillet.point(foot) - fillet.point(top)).reject_from(up).normalize();
            facing = facing.min(above.dot(out)).min(below.dot(out));
            let between = (out + up).normalize();
            assert!(fillet.normal(at(k, n, 0.5)).dot(between) > 0.95, "{k}");
            // Its section is nearly a quarter of a circle.
            let half = fillet.point(at(k, n, 0.5));
            let chord = 0.5 * (fillet.point(foot) + fillet.point(top));
            let sagitta = half.distance(chord);
            (least, most) = (least.min(sagitta), most.max(sagitta));
        }
        println!(
            "bend at the blade {:.3} degrees, sagitta {least:.3} to {most:.3}",
            bend.to_degrees()
        );
        println!("facing {facing:.4}");
        assert!(bend.to_degrees() < 1.0 && facing > 0.9);
        // Of a quarter of a circle: r (1 - cos 45).
        let quarter = FILLET * (1.0 - core::f64::consts::FRAC_1_SQRT_2);
        assert!((least - quarter).abs() < 0.12 && (most - quarter).abs() < 0.12);
    }

    #[test]
    fn the_blade_is_the_section_at_every_height() {
        let surface = read(&blade_surface());
        let mut worst = 0.0f64;
        for v in [0.0, 0.15, 0.5, 0.8, 1.0] {
            let height = FILLET + (HEIGHT - FILLET) * v;
            let formula: Vec<DVec3> =
                (0..20_000).map(|k| blade(f64::from(k) / 20_000.0, height)).collect();
            let far = line(&surface, 300, v).into_iter().map(|p| distance(p, &formula));
            worst = far.fold(worst, f64::max);
        }
        println!("blade {worst:.6}");
        assert!(worst < 5e-3);
    }

    /// A ball of radius 4 fits on the hub between the fillets of neighbours, with more than half a millimetre to spare.
    #[test]
    fn a_ball_passes_between_neighbours() {
        let edge = line(&read(&fillet()), 2000, 0.0);
        let turn = core::f64::consts::TAU / BLADES as f64;
        let turned = |p: &DVec3| {
            let (s, c) = (sin(turn), cos(turn));
            DVec3::new(p.x * c - p.y * s, p.x * s + p.y * c, p.z)
        };
        let next: Vec<DVec3> = edge.iter().map(turned).collect();
        let gap = edge.iter().step_by(2).map(|p| distance(*p, &next)).fold(f64::INFINITY, f64::min);
        println!("gap {gap:.3}");
        assert!(gap > 11.5 && gap < 11.6, "{gap}");
    }
}
