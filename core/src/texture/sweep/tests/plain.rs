//! A plain model of a ball's teeth: every node's normal is tested against what every element of every edge sweeps in
//! every time step.
//!
//! It has formulas of its own for all that, so that it is a witness. The bench of the sweep takes this same file: names
//! come from the module above.

use super::{Cutter, DVec3, Node, PI, PathPoint, TAU, cos, sin, tan};

/// A ball without run-out, whose edges and moves are cut into even pieces.
pub struct Plain<'a> {
    cutter: &'a Cutter,
    start: f64,
    /// Time steps of a move.
    pub steps: u32,
    element: f64,
    elements: u32,
}

impl<'a> Plain<'a> {
    /// `start`: height of the material; `element`: length of an element of the edge, and `end` of all of it, mm.
    pub fn new(cutter: &'a Cutter, start: f64, steps: u32, (element, end): (f64, f64)) -> Self {
        Self { cutter, start, steps, element, elements: (end / element).ceil() as u32 }
    }

    /// Lowers all nodes to what all edges sweep in a time step of a move; returns the number of quadrilaterals times
    /// that of nodes.
    pub fn step(
        &self,
        ends: [&PathPoint; 2],
        step: u32,
        nodes: &[Node],
        heights: &mut [f64],
    ) -> u64 {
        let [s0, s1] = [step, step + 1].map(|i| f64::from(i) / f64::from(self.steps));
        for tooth in 0..self.cutter.flutes {
            for k in 0..self.elements {
                let [a, b] = [k, k + 1].map(|k| self.point(ends, s0, (tooth, k)));
                let [d, c] = [k, k + 1].map(|k| self.point(ends, s1, (tooth, k)));
                for (node, height) in nodes.iter().zip(&mut *heights) {
                    for triangle in [[a, b, c], [a, c, d]] {
                        if let Some(h) = along(node, triangle, self.start) {
                            *height = height.min(h);
                        }
                    }
                }
            }
        }
        u64::from(self.cutter.flutes) * u64::from(self.elements) * nodes.len() as u64
    }

    /// A point of a tooth's edge a part `s` of the way.
    fn point(&self, [from, to]: [&PathPoint; 2], s: f64, (tooth, k): (u32, u32)) -> DVec3 {
        let t = from.time + (to.time - from.time) * s;
        let axis = from.axis.lerp(to.axis, s).normalize();
        let tip = from.tip.lerp(to.tip, s);
        let x = (DVec3::X - axis * axis.x).normalize();
        let y = axis.cross(x);
        let r = self.cutter.tool.radius();
        let spindle = self.cutter.spindle;
        let length = f64::from(k) * self.element;
        let alpha = length / r;
        let (out, up) = match alpha < 0.5 * PI {
            true => (r * sin(alpha), r - r * cos(alpha)),
            false => (r, r + length - 0.5 * PI * r),
        };
        let lag = (up - r) / r * tan(self.cutter.helix);
        let tooth = TAU * f64::from(tooth) / f64::from(self.cutter.flutes);
        let turn = lag + tooth + spindle.phase - TAU * spindle.speed * t;
        tip + axis * up + x * (out * cos(turn)) + y * (out * sin(turn))
    }
}

/// Where a node's normal meets a triangle, by Cramer's rule.
fn along(node: &Node, [a, b, c]: [DVec3; 3], start: f64) -> Option<f64> {
    let (e1, e2, way) = (b - a, c - a, node.place - a);
    let across = node.normal.cross(e2);
    let det = e1.dot(across);
    if det == 0.0 {
        return None;
    }
    let u = way.dot(across) / det;
    let q = way.cross(e1);
    let v = node.normal.dot(q) / det;
    let tolerance = -1e-9;
    let t = e2.dot(q) / det;
    (u >= tolerance && v >= tolerance && u + v <= 1.0 - tolerance && t.abs() <= start).then_some(t)
}
