use super::*;
use crate::cutter_location::clearance;
use crate::geometry::DVec2;
use crate::geometry::math::{atan2, hypot};
use crate::nurbs::{MeshOptions, NurbsSurface, Trim, mesh, read_json};
use crate::shared_data::shared_data;
use crate::tool::{Section, Tool};

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A ball end with a shank as thick up to `height`, mm.
fn straight(radius: f64, height: f64) -> Assembly {
    let shank =
        Section { part: AssemblyPart::Shank, heights: [4.0 * radius, height], radii: [radius; 2] };
    let cutter = Assembly::of_cutter(Tool::new(radius, radius).unwrap(), 4.0 * radius);
    Assembly { sections: vec![shank], ..cutter }
}

fn options(clearance: f64) -> AxisOptions {
    AxisOptions {
        clearance,
        allowance: 0.0,
        steepest: 75.0 / 180.0 * std::f64::consts::PI,
        threads: 1,
    }
}

/// Triangles of surfaces over (s, t), each from 0 to 1 in `n` by `m` cells.
struct Soup {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

impl Soup {
    fn new() -> Self {
        Self { positions: Vec::new(), faces: Vec::new() }
    }

    fn with(mut self, n: u32, m: u32, at: impl Fn(f64, f64) -> DVec3) -> Self {
        let base = self.positions.len() as u32;
        for i in 0..=n {
            for j in 0..=m {
                self.positions.push(at(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
            }
        }
        for i in 0..n {
            for j in 0..m {
                let a = base + i * (m + 1) + j;
                self.faces.extend([[a, a + 1, a + m + 1], [a + 1, a + m + 2, a + m + 1]]);
            }
        }
        self
    }

    fn hindrance(&self) -> Hindrance {
        Hindrance::new(&self.positions, &self.faces)
    }
}

/// Walls along x at both sides: `half` mm off at the bottom, leaning outward by `lean`, `height` high.
fn walls(half: f64, lean: f64, height: f64) -> Hindrance {
    let wall = |side: f64| {
        move |s: f64, t: f64| {
            v(400.0 * s - 170.0, side * (half + t * height * sin(lean)), t * height * cos(lean))
        }
    };
    Soup::new().with(80, 20, wall(1.0)).with(80, 20, wall(-1.0)).hindrance()
}

/// Stands on the plane z = 0, from y = -reach to reach.
fn flat(rows: usize, columns: usize, reach: f64) -> Vec<Stand> {
    let at = |i: usize, count: usize| i as f64 / (count - 1) as f64;
    let stand = |i: usize, j: usize| Stand {
        contact: v(60.0 * at(i, rows), reach * (2.0 * at(j, columns) - 1.0), 0.0),
        normal: DVec3::Z,
        along: DVec3::X,
    };
    (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| stand(i, j)).collect()
}

/// How far the axis leans toward +y, rad.
fn sideways(axis: DVec3) -> f64 {
    atan2(axis.y, axis.z)
}

#[test]
fn between_parallel_walls_in_the_middle_and_away_from_the_wall() {
    let (rows, columns) = (7, 5);
    let tool = straight(3.0, 60.0);
    // The ball is 0.5 mm off the wall at the border.
    let stands = flat(rows, columns, 8.0 - 3.5);
    let hindrance = walls(8.0, 0.0, 50.0);
    let field = AxisField::new(&stands, rows, columns, &hindrance, &tool, &options(0.5)).unwrap();
    assert_eq!(field.size(), (rows, columns));
    for row in 0..rows {
        let lean = |column: usize| sideways(field.axes()[row * columns + column]);
        assert!(lean(2).abs() < 0.004, "{}", lean(2));
        assert!(lean(0) > 0.01 && lean(4) < -0.01, "{} {}", lean(0), lean(4));
        assert!(lean(1) > 0.0 && lean(3) < 0.0);
        // Nothing asks it to lean along the channel.
        assert!((0..columns).all(|j| field.axes()[row * columns + j].x.abs() < 0.02));
    }
    assert!(field.clearances().iter().all(|c| *c >= 0.5 - 1e-6));
    assert!(field.axis(3.0, 2.0).distance(field.axes()[3 * columns + 2]) < 1e-14);
    for threads in [2, 5] {
        let options = AxisOptions { threads, ..options(0.5) };
        let other = AxisField::new(&stands, rows, columns, &hindrance, &tool, &options).unwrap();
        assert_eq!(other, field);
    }
}

#[test]
fn the_bisector_between_leaning_walls() {
    // The V leans as a whole: one wall by 5 degrees, the other by 35.
    let degree = std::f64::consts::PI / 180.0;
    let wall = |y: f64, lean: f64| {
        move |s: f64, t: f64| v(400.0 * s - 170.0, y + t * 60.0 * sin(lean), t * 60.0 * cos(lean))
    };
    let soup =
        Soup::new().with(40, 20, wall(5.0, 35.0 * degree)).with(40, 20, wall(-5.0, 5.0 * degree));
    let stands = flat(5, 3, 1.0);
    let tool = straight(3.0, 50.0);
    let field = AxisField::new(&stands, 5, 3, &soup.hindrance(), &tool, &options(0.3)).unwrap();
    for row in 0..5 {
        let lean = sideways(field.axes()[3 * row + 1]) / degree;
        assert!((lean - 20.0).abs() < 2.0, "{lean}");
    }
}

/// A channel 12 mm wide whose walls twist by 0.6 degrees per mm along x, its stands between them, and the soup.
fn twisted(rows: usize, columns: usize) -> (Vec<Stand>, Soup) {
    let turned = |x: f64, y: f64, z: f64| {
        let angle = 0.6 * std::f64::consts::PI / 180.0 * (x - 30.0);
        v(x, y * cos(angle) - z * sin(angle), y * sin(angle) + z * cos(angle))
    };
    let wall =
        move |side: f64| move |s: f64, t: f64| turned(90.0 * s - 15.0, side * 7.0, 50.0 * t - 6.0);
    let soup = Soup::new().with(90, 56, wall(1.0)).with(90, 56, wall(-1.0));
    let stand = |i: usize, j: usize| {
        let x = 60.0 * i as f64 / (rows - 1) as f64;
        let y = 3.5 * (2.0 * j as f64 / (columns - 1) as f64 - 1.0);
        Stand {
            contact: turned(x, y, 0.0),
            normal: turned(x, 0.0, 1.0) - turned(x, 0.0, 0.0),
            along: DVec3::X,
        }
    };
    let stands = (0..rows)
        .flat_map(|i| (0..columns).map(move |j| (i, j)))
        .map(|(i, j)| stand(i, j))
        .collect();
    (stands, soup)
}

#[test]
fn a_twisted_channel_is_smooth_and_clear_between_the_nodes() {
    let (rows, columns) = (24, 7);
    let (stands, soup) = twisted(rows, columns);
    let (hindrance, tool) = (soup.hindrance(), straight(3.0, 45.0));
    let wanted = 0.3;
    let field =
        AxisField::new(&stands, rows, columns, &hindrance, &tool, &options(wanted)).unwrap();
    let (fine, _) = twisted(10 * (rows - 1) + 1, 6 * (columns - 1) + 1);
    let (fine_rows, fine_columns) = (10 * (rows - 1) + 1, 6 * (columns - 1) + 1);
    let axis = |i: usize, j: usize| field.axis(i as f64 / 10.0, j as f64 / 6.0);
    let (mut fastest, mut nearest) = (0.0f64, f64::INFINITY);
    for i in 0..fine_rows {
        for j in 0..fine_columns {
            let (a, stand) = (axis(i, j), &fine[i * fine_columns + j]);
            let tip = stand.contact + 3.0 * (stand.normal - a);
            nearest = nearest.min(clearance_above_end(&hindrance, &tool, tip, a, 9.0).distance);
            if i > 0 {
                let way = stand.contact.distance(fine[(i - 1) * fine_columns + j].contact);
                fastest = fastest.max(acos_clamped(a.dot(axis(i - 1, j))) / way);
            }
        }
    }
    let per_mm = fastest * 180.0 / std::f64::consts::PI;
    println!("twisted: {nearest:.3} mm clear, {per_mm:.2} degrees per mm");
    assert!(field.largest_turn() < 0.08, "{}", field.largest_turn());
    // The walls turn by 0.6 degrees per mm.
    assert!(per_mm < 1.2, "{per_mm}");
    assert!(nearest > wanted - 0.05, "{nearest}");
}

#[test]
fn a_channel_too_narrow_for_the_shank_is_refused() {
    let stands = flat(3, 3, 0.5);
    let mut tool = straight(3.0, 60.0);
    tool.sections[0].radii = [4.0; 2];
    let error = AxisField::new(&stands, 3, 3, &walls(4.0, 0.0, 50.0), &tool, &options(0.5));
    let Err(error) = error else { panic!("not refused") };
    let HubError::NoAxis { part, clearance, refused, .. } = &error else { panic!("{error}") };
    assert_eq!((*part, *refused), (AssemblyPart::Shank, 9));
    assert!(*clearance < 0.01, "{clearance}");
    println!("{error}");
    assert!(error.to_string().contains("thinner clears here"), "{error}");
}

#[test]
fn a_holder_that_comes_down_between_the_walls_is_refused_with_a_length() {
    let mut tool = straight(3.0, 40.0);
    tool.sections.push(Section {
        part: AssemblyPart::Holder,
        heights: [40.0, 80.0],
        radii: [15.0; 2],
    });
    let stands = flat(3, 3, 0.5);
    let error = AxisField::new(&stands, 3, 3, &walls(6.0, 0.0, 50.0), &tool, &options(0.5));
    let Err(error) = error else { panic!("not refused") };
    println!("{error}");
    assert!(error.to_string().contains("sticks out 20 mm farther"), "{error}");
    assert!(matches!(error, HubError::NoAxis { part: AssemblyPart::Holder, .. }));
}

#[test]
fn nothing_in_the_way_leaves_the_normal() {
    let nothing = Hindrance::new(&[], &[]);
    let field =
        AxisField::new(&flat(2, 2, 1.0), 2, 2, &nothing, &straight(3.0, 60.0), &options(0.5));
    let field = field.unwrap();
    assert!(field.axes().iter().all(|a| a.distance(DVec3::Z) < 1e-9));
    assert!(field.clearances().iter().all(|c| *c == f64::INFINITY));
    assert!(field.axis(f64::NAN, 7.0).distance(DVec3::Z) < 1e-9);
}

#[test]
fn what_is_no_grid_is_refused() {
    let (nothing, tool) = (Hindrance::new(&[], &[]), straight(3.0, 60.0));
    let of = |stands: &[Stand], rows, columns, options: AxisOptions| {
        AxisField::new(stands, rows, columns, &nothing, &tool, &options)
    };
    let stands = flat(2, 2, 1.0);
    assert!(matches!(of(&stands, 2, 3, options(0.5)), Err(HubError::AxisGrid { .. })));
    assert!(matches!(of(&[], 0, 0, options(0.5)), Err(HubError::AxisGrid { .. })));
    assert!(matches!(of(&stands, 2, 2, options(f64::NAN)), Err(HubError::AxisOption { .. })));
    let mut bad = stands.clone();
    bad[3].normal = DVec3::ZERO;
    let fault = HubError::AxisStand { row: 1, column: 1 };
    assert_eq!(of(&bad, 2, 2, options(0.5)), Err(fault));
}

#[test]
fn between_the_nodes_the_axis_turns_without_a_jump() {
    let (rows, columns) = (5, 4);
    let axes: Vec<DVec3> = (0..rows * columns)
        .map(|k| v(sin(1.7 * k as f64) * 0.3, cos(2.9 * k as f64) * 0.3, 1.0).normalize())
        .collect();
    let field = AxisField { rows, columns, axes, clearances: Vec::new() };
    let h = 1e-5;
    for (row, column) in [(1.0, 1.3), (2.0, 2.0), (3.0, 0.4), (1.6, 1.0)] {
        for (dr, dc) in [(h, 0.0), (0.0, h)] {
            let at = |s: f64| field.axis(row + s * dr, column + s * dc);
            let (before, after) = ((at(0.0) - at(-1.0)) / h, (at(1.0) - at(0.0)) / h);
            assert!(before.distance(after) < 1e-3, "{before} {after}");
            assert!((at(0.5).length() - 1.0).abs() < 1e-12);
        }
    }
}

/// Time of a grid as channels have it. `cargo test --release -p evencut-core --lib hub::axes -- --ignored --nocapture`
#[test]
#[ignore = "measures time"]
fn time_of_a_channel() {
    let (stands, soup) = twisted(24, 7);
    let start = std::time::Instant::now();
    let hindrance = soup.hindrance();
    let built = start.elapsed();
    let field = AxisField::new(&stands, 24, 7, &hindrance, &straight(3.0, 45.0), &options(0.3));
    let least = field.unwrap().clearances().iter().copied().fold(f64::INFINITY, f64::min);
    println!(
        "{} triangles: tree {built:?}, all {:?}, {least:.3} mm",
        soup.faces.len(),
        start.elapsed()
    );
}

/// Stands between two main blades of an impeller (axis X, 15 blades) whose root has the parameter v = 0: on the hub, at
/// shares `from` to `to` of the way from one blade to the other.
fn impeller_stands(
    blade: &NurbsSurface,
    hub: &NurbsSurface,
    rows: usize,
    columns: usize,
    (from, to): (f64, f64),
) -> Vec<Stand> {
    let ((low, high), (hub_low, hub_high)) = (blade.domain(), hub.domain());
    let angle = |p: DVec3| atan2(p.y, p.z);
    let polar = |x: f64, r: f64, angle: f64| v(x, r * sin(angle), r * cos(angle));
    // Where the hub has this x and radius.
    let on_hub = |x: f64, r: f64, angle: f64| {
        let at = |k: u32| {
            DVec2::new(hub_low.x + f64::from(k) / 2000.0 * (hub_high.x - hub_low.x), hub_low.y)
        };
        let off = |k: u32| {
            let p = hub.point(at(k));
            (p.x - x).powi(2) + (hypot(p.y, p.z) - r).powi(2)
        };
        let k = (0..=2000).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap();
        let (p, n) = (hub.point(at(k)), hub.normal(at(k)));
        let turn = angle - atan2(p.y, p.z);
        let turned =
            |d: DVec3| v(d.x, d.y * cos(turn) + d.z * sin(turn), d.z * cos(turn) - d.y * sin(turn));
        // Outward, or toward the eye where it faces that way.
        let outward = n.dot(v(-0.3, p.y, p.z)).signum() * n;
        (polar(p.x, hypot(p.y, p.z), angle), turned(outward))
    };
    let row = |i: usize| {
        let s = 0.12 + 0.74 * i as f64 / (rows - 1) as f64;
        // Both sides of the blade at the same share of the way from its leading edge.
        let side = |sign: f64| {
            let u = low.x + (0.5 + 0.5 * sign * s) * (high.x - low.x);
            blade.point(DVec2::new(u, low.y))
        };
        let [a, b] = [side(1.0), side(-1.0)];
        let (upper, lower) = if angle(a) > angle(b) { (a, b) } else { (b, a) };
        (upper, lower)
    };
    let mut stands = Vec::new();
    for i in 0..rows {
        let (upper, lower) = row(i);
        let pitch = TAU / 15.0;
        for j in 0..columns {
            let t = from + (to - from) * j as f64 / (columns - 1) as f64;
            let at = |p: DVec3, q: DVec3| {
                let angle = angle(p) + t * (angle(q) + pitch - angle(p));
                let x = p.x + t * (q.x - p.x);
                let r = hypot(p.y, p.z) + t * (hypot(q.y, q.z) - hypot(p.y, p.z));
                on_hub(x, r, angle)
            };
            let (contact, normal) = at(upper, lower);
            let (next_upper, next_lower) = row((i + 1).min(rows - 1));
            let (previous_upper, previous_lower) = row(i.saturating_sub(1));
            let along = at(next_upper, next_lower).0 - at(previous_upper, previous_lower).0;
            stands.push(Stand { contact, normal, along });
        }
    }
    stands
}

#[test]
fn between_the_blades_of_an_impeller() {
    let Some(folder) = shared_data("nurbs") else { return };
    let read = |name: &str| read_json(&std::fs::read(folder.join(name)).unwrap()).unwrap().surface;
    let (blade, hub) = (read("hecc_main_blade.json"), read("hecc_hub_sector.json"));
    let (low, high) = blade.domain();
    let how = MeshOptions { chord: 0.02, longest: 0.016, ..MeshOptions::default() };
    let soup = mesh(&blade, Trim::Rectangle(low, high), how).unwrap().soup;
    let turn = TAU / 15.0;
    let turned =
        |p: &DVec3| v(p.x, p.y * cos(turn) + p.z * sin(turn), p.z * cos(turn) - p.y * sin(turn));
    let count = soup.positions.len() as u32;
    let positions: Vec<DVec3> =
        soup.positions.iter().copied().chain(soup.positions.iter().map(turned)).collect();
    let next = soup.faces.iter().map(|f| f.map(|i| i + count));
    let faces: Vec<[u32; 3]> = soup.faces.iter().copied().chain(next).collect();
    let hindrance = Hindrance::new(&positions, &faces);
    let (rows, columns) = (24, 7);
    let stands = impeller_stands(&blade, &hub, rows, columns, (0.3, 0.7));
    let tool = straight(3.0, 80.0);
    let ball = Assembly::of_cutter(tool.tool, 3.0);
    let end = stands.iter().map(|s| {
        let tip = s.contact + 3.0 * s.normal - 3.0 * s.normal;
        clearance(&hindrance, &ball, tip, s.normal, f64::INFINITY).distance
    });
    let end = end.fold(f64::INFINITY, f64::min);
    let start = std::time::Instant::now();
    let field = AxisField::new(&stands, rows, columns, &hindrance, &tool, &options(0.3));
    let time = start.elapsed();
    println!("impeller: {} triangles, ball {end:.3} mm clear, {time:?}", faces.len());
    let field = field.unwrap_or_else(|error| panic!("{error}"));
    let least = field.clearances().iter().copied().fold(f64::INFINITY, f64::min);
    let mut turns = 0.0f64;
    for i in 1..rows {
        for j in 0..columns {
            let k = i * columns + j;
            let way = stands[k].contact.distance(stands[k - columns].contact);
            let turn = acos_clamped(field.axes[k].dot(field.axes[k - columns])) / way;
            turns = turns.max(turn);
        }
    }
    let lean = (0..rows * columns).map(|k| acos_clamped(field.axes[k].dot(stands[k].normal)));
    let lean = lean.fold(0.0, f64::max) * 360.0 / TAU;
    println!("impeller: {least:.3} mm, {:.2} degrees per mm, lean {lean:.1}", turns * 360.0 / TAU);
    assert!(least >= 0.3 - 1e-6);
    // Midway between the nodes, too.
    let (fine_rows, fine_columns) = (2 * rows - 1, 2 * columns - 1);
    let fine = impeller_stands(&blade, &hub, fine_rows, fine_columns, (0.3, 0.7));
    let between = (0..fine.len()).map(|k| {
        let (i, j) = (k / fine_columns, k % fine_columns);
        let a = field.axis(0.5 * i as f64, 0.5 * j as f64);
        let tip = fine[k].contact + 3.0 * (fine[k].normal - a);
        clearance_above_end(&hindrance, &tool, tip, a, 9.0).distance
    });
    let between = between.fold(f64::INFINITY, f64::min);
    println!("impeller: {between:.3} mm between the nodes");
    assert!(between > 0.25, "{between}");
}
