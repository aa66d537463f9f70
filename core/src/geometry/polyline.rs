//! Polylines in the plane.

use super::DVec2;

/// The closed polygon with the points left out that stay within `tolerance` of the chords.
///
/// Ramer 1972, Douglas and Peucker 1973, from the first point and the one farthest from it.
pub fn simplify_closed(points: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let Some(&first) = points.first() else { return Vec::new() };
    let n = points.len();
    let far = (0..n)
        .max_by(|&a, &b| {
            let d = |i: usize| (points[i] - first).length_squared();
            d(a).total_cmp(&d(b)).then(b.cmp(&a))
        })
        .unwrap_or(0);
    if far == 0 || n < 4 {
        return points.to_vec();
    }
    let at = |i: usize| points[i % n];
    let mut kept = vec![false; n];
    (kept[0], kept[far]) = (true, true);
    keep_far(at, &mut kept, vec![(0, far), (far, n)], tolerance);
    (0..n).filter(|&i| kept[i]).map(|i| points[i]).collect()
}

/// The open polyline with the points left out that stay within `tolerance` of the chords.
pub fn simplify_open(points: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let mut kept = vec![false; points.len()];
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    (kept[0], kept[last]) = (true, true);
    keep_far(|i| points[i], &mut kept, vec![(0, last)], tolerance);
    (0..points.len()).filter(|&i| kept[i]).map(|i| points[i]).collect()
}

/// Marks the points farther than `tolerance` from the chords of the spans.
fn keep_far(
    at: impl Fn(usize) -> DVec2,
    kept: &mut [bool],
    mut spans: Vec<(usize, usize)>,
    tolerance: f64,
) {
    while let Some((from, to)) = spans.pop() {
        let farthest = (from + 1..to)
            .map(|i| (i, distance_to_segment(at(i), at(from), at(to))))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        if let Some((i, d)) = farthest
            && d > tolerance
        {
            kept[i] = true;
            spans.extend([(from, i), (i, to)]);
        }
    }
}

/// Distance of `p` from the segment `a b`.
pub fn distance_to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let (way, offset) = (b - a, p - a);
    let square = way.length_squared();
    let t = if square > 0.0 { (offset.dot(way) / square).clamp(0.0, 1.0) } else { 0.0 };
    (offset - way * t).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::math;

    #[test]
    fn a_circle_keeps_what_the_tolerance_needs() {
        let circle: Vec<_> = (0..1000)
            .map(|i| core::f64::consts::TAU * i as f64 / 1000.0)
            .map(|a| DVec2::new(10.0 * math::cos(a), 10.0 * math::sin(a)))
            .collect();
        let few = simplify_closed(&circle, 0.01);
        assert!((50..180).contains(&few.len()), "{}", few.len());
        for p in &circle {
            let nearest = (0..few.len())
                .map(|i| distance_to_segment(*p, few[i], few[(i + 1) % few.len()]))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest <= 0.01 + 1e-12);
        }
    }

    #[test]
    fn a_square_keeps_its_corners() {
        let side = |a: DVec2, b: DVec2| (0..10).map(move |i| a.lerp(b, i as f64 / 10.0));
        let c = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| DVec2::new(x, y));
        let square: Vec<_> = (0..4).flat_map(|i| side(c[i], c[(i + 1) % 4])).collect();
        assert_eq!(simplify_closed(&square, 1e-6), c);
    }
}
