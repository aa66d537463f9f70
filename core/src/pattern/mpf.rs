//! Machining potential field: bands of passes, each beginning where strips are the widest.
//!
//! - *Efficiency* of a pass: its strip width as a fraction of the widest strip at the same places, mean over the
//!   pass.
//! - *Band*: a start curve and the passes beside it, on both sides, as far as they are efficient.
//!
//! Steps: of several curves along the best feed direction through what is left, the one with the largest mean strip
//! width begins a band; offset passes join it while their efficiency is at least 0.95; the lines half a pass beyond
//! the last ones separate the band from the rest, in which the next one begins.
//!
//! # Source
//! Chiou and Lee, "A machining potential field approach to tool path generation for multi-axis sculptured
//! surface machining", Computer-Aided Design 34 (2002).

use super::start::{Trace, long_side};
use crate::flatten::Locator;
use crate::geometry::DVec2;
use crate::level_set::{Accuracy, PassField, PassMesh, passes};
use crate::mesh::FaceId;

/// Efficiency below which a band ends.
const EFFICIENCY: f64 = 0.95;
/// Start curves that are compared.
const CURVES: usize = 24;
/// Shortest start curve, as a fraction of the size of what is left.
const SHORTEST: f64 = 0.5;
/// Most bands; what is then left is one more.
const MOST_BANDS: usize = 12;
/// Fraction of the surface that is too small for another band.
const REST: f64 = 0.02;
/// How far lines run beyond the boundary, passes: passes end a little before it.
const OVER: f64 = 0.2;
/// Bisection steps to the place where a line leaves what is left.
const HALVINGS: usize = 40;

/// The division of a surface into bands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bands {
    /// Flat lines between them, each ending on the boundary or on an earlier one.
    pub cuts: Vec<Vec<DVec2>>,
    /// Their flat start curves.
    pub starts: Vec<Vec<DVec2>>,
}

/// The bands of a surface; `locator` is over the mesh's flat faces.
pub fn bands(mesh: &PassMesh, locator: &Locator) -> Bands {
    let mut growth = Growth::new(mesh, locator);
    let mut bands = Bands::default();
    for _ in 0..MOST_BANDS {
        let Some(curve) = growth.start_curve() else { break };
        let Ok(field) = PassField::from_curve(mesh, locator, &curve, Accuracy::Full) else { break };
        let (low, high) = growth.efficient(&field);
        bands.starts.push(curve);
        bands.cuts.extend(growth.take(field, (low, high)));
        if growth.left_share() < REST {
            break;
        }
    }
    bands
}

/// The parts of a surface that bands cover so far.
struct Growth<'a> {
    mesh: &'a PassMesh,
    locator: &'a Locator<'a>,
    areas: Vec<f64>,
    is_left: Vec<bool>,
    /// Fields of the bands, and the levels between which they cover the surface.
    taken: Vec<(PassField, f64, f64)>,
}

impl<'a> Growth<'a> {
    fn new(mesh: &'a PassMesh, locator: &'a Locator<'a>) -> Self {
        let area = |f: usize| {
            let corners = mesh.connectivity().face(FaceId(f as u32));
            let [a, b, c] = corners.map(|v| mesh.positions()[v.index()]);
            0.5 * (b - a).cross(c - a).length()
        };
        let count = mesh.connectivity().face_count();
        let areas = (0..count).map(area).collect();
        Self { mesh, locator, areas, is_left: vec![true; count], taken: Vec::new() }
    }

    fn left(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.is_left.len()).filter(|&f| self.is_left[f])
    }

    fn left_share(&self) -> f64 {
        self.left().map(|f| self.areas[f]).sum::<f64>() / self.areas.iter().sum::<f64>()
    }

    fn centre(&self, face: usize) -> DVec2 {
        let corners = self.mesh.connectivity().face(FaceId(face as u32));
        corners.map(|v| self.mesh.uv()[v.index()]).into_iter().sum::<DVec2>() / 3.0
    }

    /// mm per flat mm over a face.
    fn scale(&self, face: usize) -> f64 {
        let corners = self.mesh.connectivity().face(FaceId(face as u32));
        let [a, b, c] = corners.map(|v| self.mesh.uv()[v.index()]);
        (2.0 * self.areas[face] / (b - a).perp_dot(c - a).abs()).sqrt()
    }

    /// Of the curves along the best feed direction through places all over what is left the one with the
    /// largest mean strip width, lengthened to the boundary.
    fn start_curve(&self) -> Option<Vec<DVec2>> {
        let area: f64 = self.left().map(|f| self.areas[f]).sum();
        let trace = Trace { mesh: self.mesh, locator: self.locator };
        let fallback = long_side(self.mesh);
        let mut best: Option<(f64, Vec<DVec2>)> = None;
        // Places evenly by area, in the order of the faces.
        let (mut sum, mut next) = (0.0, 0.5);
        for f in self.left() {
            sum += self.areas[f];
            if sum < next * area / CURVES as f64 {
                continue;
            }
            next += 1.0;
            let curve = self.clipped(trace.through(self.centre(f), fallback), self.centre(f));
            let (width, length) = self.mean_width(&curve);
            let is_long = length >= SHORTEST * area.sqrt();
            let score = if is_long { width } else { 1e-3 * width };
            if width > 0.0 && best.as_ref().is_none_or(|(most, _)| score > *most) {
                best = Some((score, curve));
            }
        }
        best.map(|(_, curve)| trace.lengthened(curve))
    }

    /// The part of a curve about `place` that lies in what is left.
    fn clipped(&self, curve: Vec<DVec2>, place: DVec2) -> Vec<DVec2> {
        let near = (0..curve.len()).min_by(|&a, &b| {
            curve[a].distance_squared(place).total_cmp(&curve[b].distance_squared(place))
        });
        let Some(near) = near else { return curve };
        let is_left = |p: &&DVec2| self.contains(**p);
        let mut out: Vec<DVec2> = curve[..near].iter().rev().take_while(is_left).copied().collect();
        out.reverse();
        out.extend(curve[near..].iter().take_while(is_left));
        out
    }

    /// Whether no band covers a place.
    fn contains(&self, p: DVec2) -> bool {
        let Ok(at) = self.locator.locate(p) else { return false };
        let corners = self.mesh.connectivity().face(at.face);
        self.taken.iter().all(|(field, low, high)| {
            let value: f64 =
                (0..3).map(|i| field.values()[corners[i].index()] * at.weights[i]).sum();
            !(*low..=*high).contains(&value)
        })
    }

    /// Mean of the widest strips along a curve, mm, and its length, mm.
    fn mean_width(&self, curve: &[DVec2]) -> (f64, f64) {
        let (mut sum, mut length) = (0.0, 0.0);
        for pair in curve.windows(2) {
            let Ok(at) = self.locator.locate(pair[0].midpoint(pair[1])) else { continue };
            let Some(metric) = self.mesh.flat_metric(at.face) else { continue };
            let scale = self.scale(at.face.index());
            let way = scale * pair[0].distance(pair[1]);
            sum += way * scale / metric.least();
            length += way;
        }
        (if length > 0.0 { sum / length } else { 0.0 }, length)
    }

    /// The levels half a pass beyond the last efficient passes on both sides of the start curve.
    fn efficient(&self, field: &PassField) -> (f64, f64) {
        // By pass: area, and area times efficiency.
        let mut sides: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
        for f in self.left() {
            let Some((middle, efficiency)) = self.efficiency(field, f) else { continue };
            let pass = middle.abs().round() as usize;
            let side = &mut sides[usize::from(middle < 0.0)];
            side.resize(side.len().max(pass + 1), (0.0, 0.0));
            side[pass].0 += self.areas[f];
            side[pass].1 += self.areas[f] * efficiency;
        }
        let last = |side: &[(f64, f64)]| {
            let is_efficient = |(area, sum): &&(f64, f64)| *area > 0.0 && *sum >= EFFICIENCY * area;
            // The start curve itself belongs to the band in any case.
            side.iter().skip(1).take_while(is_efficient).count() as f64
        };
        (-0.5 - last(&sides[1]), 0.5 + last(&sides[0]))
    }

    /// Level in the middle of a face, and strip width across the field's levels as a fraction of the widest.
    fn efficiency(&self, field: &PassField, face: usize) -> Option<(f64, f64)> {
        let id = FaceId(face as u32);
        let corners = self.mesh.connectivity().face(id);
        let [u, v, w] = corners.map(|v| field.values()[v.index()]);
        let [a, b, c] = corners.map(|v| self.mesh.uv()[v.index()]);
        let across = ((b - a).perp() * (w - u) - (c - a).perp() * (v - u)).try_normalize()?;
        let metric = self.mesh.flat_metric(id)?;
        let middle = (u + v + w) / 3.0;
        middle.is_finite().then(|| (middle, metric.least() / metric.length(across)))
    }

    /// Removes what lies between two levels from what is left; returns the lines there.
    fn take(&mut self, field: PassField, (low, high): (f64, f64)) -> Vec<Vec<DVec2>> {
        let lines = passes(self.mesh, &field, &[low, high]);
        let cuts = lines.iter().flat_map(|pass| {
            let mut line: Vec<DVec2> = pass.line().collect();
            if !pass.is_closed {
                self.run_over(&mut line);
            }
            self.parts_left(&line)
        });
        let cuts = cuts.collect();
        let value = |v: crate::mesh::VertexId| field.values()[v.index()];
        for f in 0..self.is_left.len() {
            let corners = self.mesh.connectivity().face(FaceId(f as u32));
            let middle = corners.map(value).into_iter().sum::<f64>() / 3.0;
            if (low..=high).contains(&middle) {
                self.is_left[f] = false;
            }
        }
        self.taken.push((field, low, high));
        cuts
    }

    /// Extends both ends of a line beyond the boundary.
    fn run_over(&self, line: &mut Vec<DVec2>) {
        for _ in 0..2 {
            line.reverse();
            let [.., before, last] = line[..] else { continue };
            let Ok(at) = self.locator.locate(last) else { continue };
            let Some(metric) = self.mesh.flat_metric(at.face) else { continue };
            line.push(last + (last - before).normalize_or_zero() * (OVER / metric.mean()));
        }
    }

    /// The stretches of a line in what is left; a stretch ends on the line of an earlier band.
    fn parts_left(&self, line: &[DVec2]) -> Vec<Vec<DVec2>> {
        // Beyond the boundary is nobody's.
        let is_left = |p: DVec2| self.locator.locate(p).is_err() || self.contains(p);
        let mut parts = Vec::new();
        let mut part: Vec<DVec2> = Vec::new();
        for (i, &p) in line.iter().enumerate() {
            let here = is_left(p);
            if i > 0 && here != is_left(line[i - 1]) {
                let (mut inner, mut outer) = if here { (p, line[i - 1]) } else { (line[i - 1], p) };
                for _ in 0..HALVINGS {
                    let middle = inner.midpoint(outer);
                    if is_left(middle) { inner = middle } else { outer = middle }
                }
                part.push(outer);
            }
            if here {
                part.push(p);
            } else {
                parts.push(core::mem::take(&mut part));
            }
        }
        parts.push(part);
        parts.retain(|p| p.len() > 1);
        parts
    }
}
