//! Closed bodies whose faces look inward.

use crate::geometry::boxes::{Boxes, around};
use crate::geometry::{DVec3, OrderBy};
use crate::mesh::{component_of, judge};
use crate::surface::Part;

/// What is known of a connected component.
struct Body {
    is_closed: bool,
    /// Six times the volume, mm³.
    volume: f64,
    first: DVec3,
    low: DVec3,
    high: DVec3,
}

/// Turns over the closed bodies of a part whose faces look inward, but not voids, which lie within another body; how many
/// were turned.
pub fn turn_outward(part: &mut Part) -> usize {
    let Part { positions, faces } = &*part;
    let components = judge(positions, faces).components;
    let number = component_of(positions, faces, &components);
    let first = |c: u32| positions[faces[c as usize][0] as usize];
    let body = |first| Body { is_closed: true, volume: 0.0, first, low: first, high: first };
    let mut bodies: Vec<Body> = components.iter().map(|c| body(first(c.first_face))).collect();
    let mut sides: Vec<([u32; 2], i32, u32)> = Vec::with_capacity(3 * faces.len());
    for (face, &of) in faces.iter().zip(&number) {
        let body = &mut bodies[of as usize];
        let corners = face.map(|v| positions[v as usize]);
        for corner in corners {
            (body.low, body.high) = (body.low.min(corner), body.high.max(corner));
        }
        let [a, b, c] = corners.map(|p| p - body.first);
        body.volume += a.dot(b.cross(c));
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], if a < b { 1 } else { -1 }, of));
        }
    }
    sides.order_total();
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        if edge.iter().map(|side| side.1).sum::<i32>() != 0 {
            edge.iter().for_each(|side| bodies[side.2 as usize].is_closed = false);
        }
    }
    let closed = bodies.iter().zip(0..).filter(|(body, _)| body.is_closed);
    let boxes = Boxes::new(closed.map(|(body, i)| around(i, &[body.low, body.high])).collect());
    let is_void = |i: usize| {
        let own = &bodies[i];
        let holds = |b: &Body| b.low.cmple(own.low).all() && b.high.cmpge(own.high).all();
        boxes.holding(own.low).any(|b| b as usize != i && holds(&bodies[b as usize]))
    };
    let is_turned: Vec<bool> = (0..bodies.len())
        .map(|i| bodies[i].is_closed && bodies[i].volume < 0.0 && !is_void(i))
        .collect();
    for (face, of) in part.faces.iter_mut().zip(number) {
        if is_turned[of as usize] {
            face.swap(1, 2);
        }
    }
    is_turned.iter().filter(|turned| **turned).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube from `low`, its faces outward or inward.
    fn add_cube(part: &mut Part, low: DVec3, size: f64, is_inward: bool) {
        let first = part.positions.len() as u32;
        let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        part.positions.extend((0..8).map(|i| low + corner(i) * size));
        let sides: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        for [a, b, c, d] in sides.map(|s| s.map(|v| first + v)) {
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                part.faces.push(if is_inward { [a, c, b] } else { [a, b, c] });
            }
        }
    }

    #[test]
    fn bodies_that_are_inside_out_are_turned_and_voids_and_sheets_are_not() {
        let mut wanted = Part::default();
        add_cube(&mut wanted, DVec3::ZERO, 10.0, false);
        add_cube(&mut wanted, DVec3::splat(3.0), 2.0, true);
        add_cube(&mut wanted, DVec3::X * 20.0, 4.0, false);
        let mut part = Part::default();
        add_cube(&mut part, DVec3::ZERO, 10.0, false);
        add_cube(&mut part, DVec3::splat(3.0), 2.0, true);
        add_cube(&mut part, DVec3::X * 20.0, 4.0, true);
        assert_eq!(turn_outward(&mut part), 1);
        let sorted = |part: &Part| {
            let turned = |f: &[u32; 3]| {
                let least = (0..3).min_by_key(|k| f[*k]).unwrap();
                [0, 1, 2].map(|k| f[(least + k) % 3])
            };
            part.faces.iter().map(turned).collect::<Vec<_>>()
        };
        assert_eq!(sorted(&part), sorted(&wanted));
        assert_eq!(turn_outward(&mut part), 0);
        let mut open = Part::default();
        add_cube(&mut open, DVec3::ZERO, 10.0, true);
        open.faces.pop();
        assert_eq!(turn_outward(&mut open), 0);
    }
}
