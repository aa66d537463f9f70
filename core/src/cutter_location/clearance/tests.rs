use super::*;
use crate::geometry::math::{cos, sin};
use crate::tool::{Section, Tool};

/// Numbers between -1 and 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

fn of_triangle(corners: [DVec3; 3]) -> Hindrance {
    Hindrance::new(&corners, &[[0, 1, 2]])
}

fn distance(assembly: &Assembly, corners: [DVec3; 3]) -> f64 {
    clearance(&of_triangle(corners), assembly, DVec3::ZERO, DVec3::Z, f64::INFINITY).distance
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn ball() -> Assembly {
    Assembly::of_cutter(Tool::new(3.0, 3.0).unwrap(), 10.0)
}

fn holder() -> Assembly {
    let shank = Section { part: AssemblyPart::Shank, heights: [10.0, 40.0], radii: [2.0, 5.0] };
    let holder = Section { part: AssemblyPart::Holder, heights: [40.0, 60.0], radii: [12.0, 8.0] };
    Assembly { sections: vec![shank, holder], ..ball() }
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-7, "{a} is not {b}");
}

#[test]
fn of_a_ball_by_formula() {
    // Face, edge and corner below the ball with its middle at (0, 0, 3).
    close(distance(&ball(), [v(-5., -5., -2.), v(5., -5., -2.), v(0., 9., -2.)]), 2.0);
    close(distance(&ball(), [v(-9., 4., -1.), v(9., 4., -1.), v(0., 9., -9.)]), 32f64.sqrt() - 3.0);
    let corner = v(3., 4., -1.);
    let far = [corner, v(9., 9., -9.), v(4., 19., -9.)];
    close(distance(&ball(), far), corner.distance(v(0., 0., 3.)) - 3.0);
    // As deep as the ball is pierced.
    close(distance(&ball(), [v(-5., -5., 1.), v(5., -5., 1.), v(0., 9., 1.)]), -1.0);
}

#[test]
fn of_a_cylinder_by_formula() {
    // Side against a face, an edge across, an edge along, a corner.
    close(distance(&ball(), [v(5., -9., 4.), v(5., 9., 4.), v(5., 0., 9.)]), 2.0);
    close(distance(&ball(), [v(5., -9., 7.), v(5., 9., 7.), v(9., 0., 7.)]), 2.0);
    close(distance(&ball(), [v(5., 5., 4.), v(5., 5., 9.), v(9., 9., 7.)]), 50f64.sqrt() - 3.0);
    close(distance(&ball(), [v(4., 3., 6.), v(9., 9., 9.), v(9., 9., 4.)]), 2.0);
    // Rim of the top against a face that leans, above and beside.
    let s = 0.5f64.sqrt();
    let [middle, side, up] = [v(6., 0., 13.), v(0., 9., 0.), v(-9. * s, 0., 9. * s)];
    let leaning = [middle + side - up, middle - side - up, middle + up];
    close(distance(&ball(), leaning), 6.0 * s);
    // Top against a face.
    close(distance(&ball(), [v(-5., -5., 12.), v(5., -5., 12.), v(0., 9., 12.)]), 2.0);
}

#[test]
fn of_a_cone_by_formula() {
    let assembly = holder();
    // The cone's side rises from (2, 10) to (5, 40).
    let length = (9.0f64 + 900.0).sqrt();
    let (up, out) = (v(3. / length, 0., 30. / length), v(30. / length, 0., -3. / length));
    let middle = v(3.5, 0., 25.) + 1.5 * out;
    let face =
        [middle - 3. * up + v(0., 4., 0.), middle - 3. * up - v(0., 4., 0.), middle + 3. * up];
    close(distance(&assembly, face), 1.5);
    let edge = [middle + v(0., 4., 0.), middle - v(0., 4., 0.), middle + 4. * out];
    close(distance(&assembly, edge), 1.5);
    close(distance(&assembly, [middle, middle + 4. * out, middle + 4. * out + up]), 1.5);
    let found = clearance(&of_triangle(face), &assembly, DVec3::ZERO, DVec3::Z, 9.0);
    assert_eq!(found.part, AssemblyPart::Shank);
    // All along that line of the face it is as near.
    assert!(found.place.y.abs() < 1e-3 && (found.place - middle).dot(out).abs() < 1e-7);
}

#[test]
fn of_bull_and_flat_ends_by_formula() {
    let below = [v(-9., -9., -2.), v(9., -9., -2.), v(0., 9., -2.)];
    for corner in [0.0, 1.0] {
        let end = Assembly::of_cutter(Tool::new(4.0, corner).unwrap(), 10.0);
        close(distance(&end, below), 2.0);
        // The corner's circle has its middle at (4 - corner, corner).
        let low = v(8., 0., -3.);
        let seen = low.distance(v(4. - corner, 0., corner)) - corner;
        close(distance(&end, [low, v(19., 3., -9.), v(19., -3., -9.)]), seen);
    }
}

#[test]
fn a_piercing_wire_and_a_large_face_penetrate() {
    let assembly = holder();
    let needle = [v(-50., 0.1, 20.), v(50., 0., 20.), v(50., 0.1, 20.)];
    assert!(distance(&assembly, needle) < -2.0);
    // No side of it comes near.
    let (a, b, c) = (v(-500., -500., 20.), v(500., -500., 20.), v(0., 700., 22.));
    assert!(distance(&assembly, [a, b, c]) < -2.0);
    assert!(distance(&ball(), [a, b, c]) > 9.0);
}

#[test]
fn what_is_beyond_is_not_told_apart() {
    let face = of_triangle([v(5., -9., 4.), v(5., 9., 4.), v(5., 0., 9.)]);
    let found = |beyond| clearance(&face, &ball(), DVec3::ZERO, DVec3::Z, beyond).distance;
    assert_eq!(found(1.5), 1.5);
    close(found(2.5), 2.0);
    let nothing = Hindrance::new(&[], &[[0, 1, 2]]);
    assert_eq!(
        clearance(&nothing, &ball(), DVec3::ZERO, DVec3::Z, f64::INFINITY).distance,
        f64::INFINITY
    );
}

#[test]
fn above_the_end_only() {
    let below = of_triangle([v(-5., -5., -2.), v(5., -5., -2.), v(0., 9., -2.)]);
    let found = clearance_above_end(&below, &ball(), DVec3::ZERO, DVec3::Z, f64::INFINITY);
    close(found.distance, 5.0);
    assert_eq!(found.part, AssemblyPart::Cutter);
}

/// Distance of a place from the whole assembly, by a dense sampling of the outlines of its parts.
fn sampled(assembly: &Assembly, place: DVec3) -> f64 {
    let rho = (place.x * place.x + place.y * place.y).sqrt();
    let mut least = f64::INFINITY;
    let mut see = |r: f64, z: f64| {
        // All nearer to the axis belongs to it, too.
        least = least.min(((rho - r).max(0.0).powi(2) + (place.z - z).powi(2)).sqrt());
    };
    let steps = 1000;
    let (corner, bottom) = (assembly.tool.corner_radius(), assembly.tool.bottom_radius());
    for i in 0..=steps {
        let t = f64::from(i) / f64::from(steps);
        let angle = t * std::f64::consts::FRAC_PI_2;
        see(bottom + corner * sin(angle), corner - corner * cos(angle));
        see(assembly.tool.radius(), corner + t * (assembly.cutter_length - corner));
        for Section { heights: [a, b], radii: [r, s], .. } in &assembly.sections {
            see(r + t * (s - r), a + t * (b - a));
        }
    }
    least
}

#[test]
fn as_a_dense_sampling_finds_it() {
    let mut random = Random(7);
    let bull = Assembly { tool: Tool::new(4.0, 1.5).unwrap(), ..holder() };
    for assembly in [holder(), bull] {
        for _ in 0..20 {
            let middle = v(15.0 * random.next(), 15.0 * random.next(), 30.0 + 40.0 * random.next());
            let corners = [(); 3].map(|()| middle + 6.0 * random.vector());
            let found = distance(&assembly, corners);
            let n = 30;
            let mut least = f64::INFINITY;
            for i in 0..=n {
                for j in 0..=n - i {
                    let (s, t) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    let place =
                        corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]);
                    if least > 0.0 {
                        least = least.min(sampled(&assembly, place));
                    }
                }
            }
            if found > 0.0 {
                // Places are up to 0.35 mm from one that was sampled, and mostly seen at a slant.
                assert!(found <= least + 0.01 && found >= least - 0.35, "{found} {least}");
            } else {
                assert!(least < 0.35, "{found} {least}");
            }
        }
    }
}

/// The least signed distance over a triangle by nested searches that only need it convex.
fn nested(solid: &Solid, corners: &[DVec3; 3]) -> f64 {
    let pose = Pose { tip: DVec3::ZERO, axis: DVec3::Z };
    let thirds = |f: &dyn Fn(f64) -> f64| {
        let (mut a, mut b) = (0.0, 1.0);
        for _ in 0..80 {
            let (l, r) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
            if f(l) < f(r) {
                b = r;
            } else {
                a = l;
            }
        }
        f(0.5 * (a + b)).min(f(0.0)).min(f(1.0))
    };
    thirds(&|s| {
        let (from, to) = (corners[0].lerp(corners[1], s), corners[0].lerp(corners[2], s));
        thirds(&|t| solid.tangent(pose, from.lerp(to, t)).value)
    })
}

#[test]
fn exact_for_every_solid_and_place() {
    let mut random = Random(3);
    let solids = [
        Solid::new(AssemblyPart::Shank, [0.0, 10.0], [3.0, 3.0], 0.0),
        Solid::new(AssemblyPart::Shank, [0.0, 10.0], [2.0, 6.0], 0.0),
        Solid::new(AssemblyPart::Shank, [0.0, 10.0], [6.0, 0.0], 0.0),
        Solid::new(AssemblyPart::Shank, [2.0, 2.0], [4.0, 4.0], 1.0),
        Solid::new(AssemblyPart::Shank, [3.0, 3.0], [0.0, 0.0], 3.0),
        Solid::new(AssemblyPart::Shank, [0.0, 0.1], [9.0, 12.0], 0.0),
    ];
    let (mut clear, mut pierced) = (0, 0);
    for size in [0.01, 1.0, 8.0, 100.0] {
        for solid in &solids {
            for _ in 0..60 {
                let middle = 12.0 * random.vector() + v(0., 0., 5.);
                let corners = [(); 3].map(|()| middle + size * random.vector());
                let pose = Pose { tip: DVec3::ZERO, axis: DVec3::Z };
                let found = of_triangle(corners)
                    .nearest(solid, pose, f64::INFINITY, f64::NEG_INFINITY)
                    .unwrap();
                let is = nested(solid, &corners);
                let there = solid.tangent(pose, found.place).value;
                assert!((there - found.distance).abs() < 1e-7, "{there} {}", found.distance);
                if is > 1e-6 {
                    clear += 1;
                    assert!(
                        (found.distance - is).abs() < 1e-6,
                        "{} {is} {solid:?}",
                        found.distance
                    );
                } else if is < -1e-6 {
                    pierced += 1;
                    assert!(found.distance <= 0.0 && found.distance >= is - 1e-6);
                }
            }
        }
    }
    assert!(clear > 300 && pierced > 50, "{clear} {pierced}");
}

#[test]
fn the_tree_finds_what_all_triangles_give() {
    let mut random = Random(11);
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for k in 0..900 {
        let middle = 40.0 * random.vector() + v(0., 0., 30.);
        positions.extend([(); 3].map(|()| middle + 3.0 * random.vector()));
        faces.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let all = Hindrance::new(&positions, &faces);
    let mut others = faces.clone();
    others.reverse();
    let reversed = Hindrance::new(&positions, &others);
    for _ in 0..30 {
        let (tip, axis) = (60.0 * random.vector(), random.vector().normalize());
        let one = |f: &[u32; 3]| {
            let single = Hindrance::new(&positions, std::slice::from_ref(f));
            clearance(&single, &holder(), tip, axis, f64::INFINITY).distance
        };
        let least = faces.iter().map(one).fold(f64::INFINITY, f64::min);
        let found = clearance(&all, &holder(), tip, axis, f64::INFINITY);
        assert!((found.distance - least).abs() < 1e-7, "{} {least}", found.distance);
        let other = clearance(&reversed, &holder(), tip, axis, f64::INFINITY);
        assert!((found.distance - other.distance).abs() < 1e-7);
    }
}
