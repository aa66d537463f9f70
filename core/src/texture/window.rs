//! The window of a job: a rectangle about a place of the surface, along and across the feed there.
//!
//! Steps: (1) the place of the surface that is nearest to the one asked for; (2) the direction of the nearest pass, taken
//! to the flat map through the face there; (3) a node for parameters `(u, v)`, mm along and across the feed, is the place
//! of the surface over that flat point. The map is conformal, so that the sides of the window are square to each other;
//! it is scaled for the window's middle.
//!
//! On a NURBS surface places and normals are exact. On a mesh they are those of its facets, with normals between those
//! of the vertices, as the path has them too: the path is one over facets, and heights are measured from them. Where
//! facets are not fine the part has their steps as well; [`Window::facets`] says how high they are.

use super::grid::Node;
use crate::cutter_location::contact_offset;
use crate::flatten::{Chart, Locator};
use crate::geometry::{DVec2, DVec3, nearest_on_triangle};
use crate::mesh::FaceId;
use crate::surface::{CurvatureField, Surface, SurfacePoint};
use crate::tool::Tool;
use crate::toolpath::{MoveKind, PathPoint, Toolpath};
use thiserror::Error;

/// Places along a side of a window at which its facets are looked at.
const LOOKS: usize = 48;
/// Curvatures below this, 1/mm, are those of a plane.
const FLAT: f64 = 1e-6;

/// Why there is no window.
#[derive(Copy, Clone, Debug, PartialEq, Error)]
pub enum WindowError {
    /// The surface is too far away.
    #[error(
        "texture: the surface comes no nearer than {distance:.4} mm to the place of the window; `texture.at` must be on \
         it, within {allowed:.4} mm"
    )]
    OffSurface {
        /// Distance of the surface, mm.
        distance: f64,
        /// What is allowed, mm.
        allowed: f64,
    },
    /// The path has no pass.
    #[error("texture: the path has no pass that would give the window a direction")]
    NoPass,
}

/// A window of a surface.
#[derive(Clone, Debug)]
pub struct Window<'a> {
    surface: &'a Surface,
    chart: &'a Chart,
    locator: &'a Locator<'a>,
    /// Its middle on the surface, mm.
    pub middle: DVec3,
    /// Unit direction of the feed there.
    pub feed: DVec3,
    flat: DVec2,
    /// Flat mm per mm along the feed, and to its left.
    axes: [DVec2; 2],
}

impl<'a> Window<'a> {
    /// The window about the place nearest to `at`, mm, which may be `allowed` mm away.
    ///
    /// # Errors
    /// [`WindowError`]: no surface near, or no pass.
    pub fn new(
        surface: &'a Surface,
        chart: &'a Chart,
        locator: &'a Locator<'a>,
        (path, tool): (&Toolpath, &Tool),
        (at, allowed): (DVec3, f64),
    ) -> Result<Self, WindowError> {
        let place = nearest(surface, at);
        let middle = surface.position(place);
        let distance = middle.distance(at);
        // A NaN is nowhere.
        if distance.is_nan() || distance > allowed {
            return Err(WindowError::OffSurface { distance, allowed });
        }
        let feed = feed_at(path, tool, middle).ok_or(WindowError::NoPass)?;
        let (flat_feed, feed) = flat_direction(surface, chart, place.face, feed);
        let vertices = surface.connectivity().face(place.face);
        let flat = (0..3).map(|i| chart.uv()[vertices[i].index()] * place.weights[i]).sum();
        let along = flat_feed / chart.scale(surface, place);
        Ok(Self { surface, chart, locator, middle, feed, flat, axes: [along, along.perp()] })
    }

    /// The node `u` mm along the feed from the middle and `v` mm to its left; `None` beyond the surface.
    pub fn node(&self, uv: DVec2) -> Option<Node> {
        let point = self.point(uv)?;
        let normal = self.surface.normal(point);
        let place = self.surface.position(point);
        (normal != DVec3::ZERO).then_some(Node { place, normal })
    }

    fn point(&self, uv: DVec2) -> Option<SurfacePoint> {
        self.locator.locate(self.flat + self.axes[0] * uv.x + self.axes[1] * uv.y).ok()
    }

    /// Parameters of the middle, and the size, of the rectangle along and across the feed that holds the whole surface.
    pub fn whole(&self) -> (DVec2, DVec2) {
        let to = self.axes.map(|axis| axis / axis.length_squared());
        let at = |flat: &DVec2| DVec2::from(to.map(|axis| axis.dot(*flat - self.flat)));
        let (low, high) = self
            .chart
            .uv()
            .iter()
            .map(at)
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
        (0.5 * (low + high), high - low)
    }

    /// The shortest cell, mm, that even steps of the flat map over a rectangle of `size` mm keep with at most `most` nodes
    /// wherever the map is stretched; rounded up to two digits.
    pub fn finest_cell(&self, size: DVec2, most: f64) -> f64 {
        let [along, across] = self.stretch();
        let [a, b] = [size.x * along, size.y * across];
        // (a / c + 2) (b / c + 2) = most: an end, and one step more than a length divides into, along both.
        let [two, one, none] = [most - 4.0, -2.0 * (a + b), -a * b];
        round_up((-one + (one * one - 4.0 * two * none).sqrt()) / (2.0 * two))
    }

    /// Most mm on the surface in a mm of `u` and in one of `v`, of all faces.
    fn stretch(&self) -> [f64; 2] {
        let mut most = [0.0_f64; 2];
        for f in 0..self.surface.connectivity().face_count() {
            let face = FaceId(f as u32);
            let [a, b, c] = self.surface.corners(face);
            let vertices = self.surface.connectivity().face(face);
            let [fa, fb, fc] = vertices.map(|v| self.chart.uv()[v.index()]);
            let area = (fb - fa).perp_dot(fc - fa);
            for (most, axis) in most.iter_mut().zip(self.axes) {
                let along = axis.perp_dot(fc - fa) / area;
                let beside = (fb - fa).perp_dot(axis) / area;
                *most = most.max(((b - a) * along + (c - a) * beside).length());
            }
        }
        most
    }

    /// How far the facets of a mesh are off a smooth surface through its vertices in the rectangle of `size` mm about
    /// `(u, v)`, mm; 0 on a NURBS surface.
    ///
    /// # Source
    /// Boubekeur and Alexa, "Phong Tessellation" (2008), with half of the projection, which is exact for paraboloids.
    pub fn facets(&self, (middle, size): (DVec2, DVec2)) -> f64 {
        if self.surface.parameters().is_some() {
            return 0.0;
        }
        let at = |i: usize| (i as f64 + 0.5) / LOOKS as f64 - 0.5;
        let looks = (0..LOOKS * LOOKS)
            .filter_map(|k| self.point(middle + DVec2::new(at(k % LOOKS), at(k / LOOKS)) * size));
        looks.map(|point| self.off_smooth(point)).fold(0.0, f64::max)
    }

    fn off_smooth(&self, point: SurfacePoint) -> f64 {
        let place = self.surface.position(point);
        let vertices = self.surface.connectivity().face(point.face);
        let way = |i: usize| {
            let v = vertices[i].index();
            let normal = self.surface.vertex_normals()[v];
            normal * ((place - self.surface.positions()[v]).dot(normal) * point.weights[i])
        };
        0.5 * (way(0) + way(1) + way(2)).length()
    }

    /// Whether nothing of the surface within `distance` mm of the middle is curved.
    pub fn is_plane(&self, curvature: &CurvatureField, distance: f64) -> bool {
        let places = self.surface.positions().iter().zip(curvature.operators());
        let mut near = places.filter(|(p, _)| p.distance(self.middle) <= distance);
        near.all(|(_, k)| {
            let (least, most, _) = k.principal();
            least.abs() <= FLAT && most.abs() <= FLAT
        })
    }

    /// The least concave radius of the surface within `distance` mm of the middle, mm; `None` where nothing is concave.
    pub fn least_concave_radius(&self, curvature: &CurvatureField, distance: f64) -> Option<f64> {
        let places = self.surface.positions().iter().zip(curvature.operators());
        let near = places.filter(|(p, _)| p.distance(self.middle) <= distance);
        let k = near.map(|(_, k)| k.principal().0).fold(0.0, f64::min);
        (k < -FLAT).then_some(-1.0 / k)
    }
}

/// The next number with two digits, to be read by somebody.
fn round_up(length: f64) -> f64 {
    if !(length > 0.0 && length.is_finite()) {
        return f64::INFINITY;
    }
    let up = (0..18).find_map(|decimals| {
        let unit = 10f64.powi(decimals);
        (length * unit >= 10.0).then(|| (length * unit).ceil() / unit)
    });
    up.unwrap_or(length)
}

/// The place of a surface nearest to a point.
fn nearest(surface: &Surface, at: DVec3) -> SurfacePoint {
    let mut best = (f64::INFINITY, SurfacePoint { face: FaceId(0), weights: [1.0, 0.0, 0.0] });
    for f in 0..surface.connectivity().face_count() {
        let face = FaceId(f as u32);
        let corners = surface.corners(face);
        let weights = nearest_on_triangle(at, corners);
        let place: DVec3 = (0..3).map(|i| corners[i] * weights[i]).sum();
        let distance = place.distance_squared(at);
        if distance < best.0 {
            best = (distance, SurfacePoint { face, weights });
        }
    }
    best.1
}

/// Direction of the pass that comes nearest to a place.
fn feed_at(path: &Toolpath, tool: &Tool, at: DVec3) -> Option<DVec3> {
    let contact = |p: &PathPoint| p.tip + contact_offset(tool, p.normal, p.axis);
    let mut best: Option<(f64, DVec3)> = None;
    for pair in path.points.windows(2).filter(|pair| pair[1].kind == MoveKind::Cut) {
        let (a, b) = (contact(&pair[0]), contact(&pair[1]));
        let Some(direction) = (b - a).try_normalize() else { continue };
        let part = (at - a).dot(direction).clamp(0.0, a.distance(b));
        let distance = at.distance_squared(a + direction * part);
        if best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, direction));
        }
    }
    best.map(|(_, direction)| direction)
}

/// A direction along a face, as a unit vector of the flat map and of space.
fn flat_direction(
    surface: &Surface,
    chart: &Chart,
    face: FaceId,
    direction: DVec3,
) -> (DVec2, DVec3) {
    let [a, b, c] = surface.corners(face);
    let [fa, fb, fc] = surface.connectivity().face(face).map(|v| chart.uv()[v.index()]);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let along =
        (direction - normal * direction.dot(normal)).normalize_or((b - a).normalize_or_zero());
    // Weights of the two sides that add up to it.
    let area = (b - a).cross(c - a).dot(normal);
    let s = along.cross(c - a).dot(normal) / area;
    let t = (b - a).cross(along).dot(normal) / area;
    ((s * (fb - fa) + t * (fc - fa)).normalize_or(DVec2::X), along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::bff;
    use crate::mesh::{Connectivity, VertexId};
    use crate::surface::AnalyticSurface;
    use crate::texture::grid::{Discretisation, Grid};

    fn surface(analytic: &AnalyticSurface, edge: f64) -> Surface {
        let mesh = analytic.mesh(edge);
        let faces = mesh.faces.iter().map(|f| f.map(VertexId)).collect();
        Surface::new(Connectivity::new(mesh.positions.len(), faces).unwrap(), mesh.positions)
    }

    /// A pass of an upright ball along the diagonal.
    fn path() -> Toolpath {
        let point = |t: f64| PathPoint {
            kind: MoveKind::Cut,
            pass: 0,
            region: 0,
            tip: DVec3::new(t, t, 0.0),
            axis: DVec3::Z,
            normal: DVec3::Z,
            flat: None,
            feed: 1.0,
            mrr: 0.0,
            alpha: 0.0,
            time: t,
        };
        Toolpath { points: vec![point(-3.0), point(3.0)] }
    }

    #[test]
    fn a_window_lies_along_the_feed_and_has_its_size() {
        let tool = Tool::new(5.0, 5.0).unwrap();
        let cap = AnalyticSurface::SphereCap { radius: -40.0, diameter: 20.0 };
        for analytic in [AnalyticSurface::Plane { width: 20.0, depth: 20.0 }, cap] {
            let surface = surface(&analytic, 0.5);
            let chart = bff(&surface).unwrap();
            let locator = chart.locator(&surface);
            let at = DVec3::new(1.0, 0.5, 0.2);
            let window =
                Window::new(&surface, &chart, &locator, (&path(), &tool), (at, 1.0)).unwrap();
            let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
            assert!(window.feed.distance(diagonal) < 0.05);
            let node = |u: f64, v: f64| window.node(DVec2::new(u, v)).unwrap();
            let (along, across) = (
                node(0.5, 0.0).place - node(-0.5, 0.0).place,
                node(0.0, 0.5).place - node(0.0, -0.5).place,
            );
            assert!((along.length() - 1.0).abs() < 0.01 && (across.length() - 1.0).abs() < 0.01);
            assert!(along.dot(across).abs() < 0.02 && along.normalize().dot(window.feed) > 0.999);
            assert!(along.cross(across).z > 0.0);
            assert!(window.node(DVec2::new(90.0, 0.0)).is_none());
            let (whole, size) = window.whole();
            // All of it is in the rectangle, which it touches.
            let inside = |share: DVec2| window.node(whole + share * size);
            assert!(inside(DVec2::ZERO).is_some() && inside(DVec2::new(0.51, 0.0)).is_none());
            assert!(size.min_element() > 19.0 && size.max_element() < 29.0, "{size}");
            let far = (at + DVec3::Z * 9.0, 1.0);
            let off = Window::new(&surface, &chart, &locator, (&path(), &tool), far);
            assert!(matches!(off, Err(WindowError::OffSurface { .. })));
        }
    }

    #[test]
    fn facets_are_off_by_their_height_over_a_chord() {
        let tool = Tool::new(5.0, 5.0).unwrap();
        let of = |edge: f64| {
            let analytic = AnalyticSurface::SphereCap { radius: 40.0, diameter: 20.0 };
            let surface = surface(&analytic, edge);
            let chart = bff(&surface).unwrap();
            let locator = chart.locator(&surface);
            let at = (DVec3::ZERO, 1.0);
            let window = Window::new(&surface, &chart, &locator, (&path(), &tool), at).unwrap();
            let curvature = surface.curvature(None);
            assert_eq!(window.least_concave_radius(&curvature, 3.0), None);
            window.facets((DVec2::ZERO, DVec2::splat(3.0)))
        };
        // The middle of a triangle of side l stands l² / (6 R) under the sphere.
        let ratio = of(1.0) / (1.0 / (6.0 * 40.0));
        assert!(ratio > 0.8 && ratio < 1.3, "{ratio}");
        assert!((of(0.5) / of(1.0) - 0.25).abs() < 0.05);
    }

    #[test]
    fn the_finest_cell_of_a_stretched_map_has_just_few_enough_nodes() {
        let tool = Tool::new(5.0, 5.0).unwrap();
        let analytic = AnalyticSurface::SphereCap { radius: 10.0, diameter: 18.0 };
        let surface = surface(&analytic, 0.5);
        let chart = bff(&surface).unwrap();
        let locator = chart.locator(&surface);
        let window =
            Window::new(&surface, &chart, &locator, (&path(), &tool), (DVec3::ZERO, 1e9)).unwrap();
        let (middle, size) = window.whole();
        let node = |uv: DVec2| window.node(middle + uv).or(Some(Node::BEYOND));
        for most in [2e3, 2e4] {
            let cell = window.finest_cell(size, most);
            let nodes = |cell: f64| {
                let grid = Grid::new(size, cell, Discretisation::Uniform, 1, &node).unwrap();
                grid.nodes().len() as f64
            };
            println!("{cell} mm: {} of {most}", nodes(cell));
            assert!(nodes(cell) <= most && nodes(0.7 * cell) > most, "{cell}");
        }
        assert_eq!(round_up(1.2301), 1.3);
        assert_eq!(round_up(0.012), 0.012);
        assert_eq!(round_up(123.4), 124.0);
    }
}
