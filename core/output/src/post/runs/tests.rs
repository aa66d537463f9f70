use super::*;
use evencut_core::geometry::math::{cos, sin};

const TOLERANCE: f64 = 0.002;

fn helix(radius: f64, pitch: f64, sense: f64, moves: usize, turn: f64) -> Vec<DVec3> {
    let at = |i: usize| {
        let t = turn * i as f64 / moves as f64;
        DVec3::new(3.0 + radius * cos(t), radius * sin(sense * t) - 1.0, 2.0 + pitch * t / TAU)
    };
    (0..=moves).map(at).collect()
}

#[test]
fn points_of_a_helix_are_one_arc_up_to_its_turn() {
    for sense in [1.0, -1.0] {
        let tips = helix(5.0, 0.7, sense, 360, TAU);
        let (moves, shape) = longest(&tips, TOLERANCE).unwrap();
        let Shape::Arc { centre, counter_clockwise } = shape else { panic!("{shape:?}") };
        assert!(centre.distance(DVec2::new(3.0, -1.0)) < 1e-3, "{centre}");
        assert_eq!(counter_clockwise, sense > 0.0);
        // 0.95 of half a turn in steps of a degree, and the last one that still fits.
        assert!((168..=171).contains(&moves), "{moves}");
    }
}

#[test]
fn points_of_a_line_are_one_move_and_a_corner_is_kept() {
    let mut tips: Vec<DVec3> = (0..50).map(|i| DVec3::new(0.1, 0.2, 0.03) * f64::from(i)).collect();
    let corner = tips[49];
    tips.extend((1..50).map(|i| corner + DVec3::new(-0.2, 0.1, 0.0) * f64::from(i)));
    assert_eq!(longest(&tips, TOLERANCE), Some((49, Shape::Line)));
    // Back along itself is no line.
    let back = [DVec3::ZERO, DVec3::X, DVec3::X * 0.5];
    assert_eq!(longest(&back, TOLERANCE), None);
    assert_eq!(longest(&tips[..2], TOLERANCE), None);
    assert_eq!(longest(&[], TOLERANCE), None);
}

/// All points of any run, and the run between them, are within the tolerance of the path; measured by points of the run.
#[test]
fn runs_of_a_spiral_on_a_slope_stay_within_the_tolerance() {
    let at = |i: usize| {
        let t = 0.01 * i as f64;
        let r = 2.0 + 0.1 * t;
        let (x, y) = (r * cos(t), r * sin(t));
        DVec3::new(x, y, 0.02 * x * x - 0.1 * y)
    };
    let tips: Vec<DVec3> = (0..3000).map(at).collect();
    let (mut from, mut blocks) = (0, 0);
    while from + 1 < tips.len() {
        let (moves, shape) = longest(&tips[from..], TOLERANCE).unwrap_or((1, Shape::Line));
        let run = &tips[from..=from + moves];
        let (first, last) = (run[0], run[moves]);
        for k in 0..=1000 {
            let u = f64::from(k) / 1000.0;
            let place = match shape {
                Shape::Line => first.lerp(last, u),
                Shape::Arc { centre, counter_clockwise } => {
                    let [p, q] = [first, last].map(|tip| tip.truncate() - centre);
                    let mut turn = atan2(p.perp_dot(q), p.dot(q));
                    if (turn > 0.0) != counter_clockwise {
                        turn += if counter_clockwise { TAU } else { -TAU };
                    }
                    let (s, c) = (sin(turn * u), cos(turn * u));
                    let turned = DVec2::new(p.x * c - p.y * s, p.x * s + p.y * c) + centre;
                    turned.extend(first.z + (last.z - first.z) * u)
                }
            };
            let off = run
                .windows(2)
                .map(|w| distance_to_segment(place, w[0], w[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(off <= 1.5 * TOLERANCE, "{off} at {from}");
        }
        from += moves;
        blocks += 1;
    }
    // Two thirds were asked for.
    assert!(3 * blocks < 2 * tips.len(), "{blocks}");
}
