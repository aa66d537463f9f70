//! Triangles as read → the surface to be machined, or what is wrong with them.
//!
//! The part is placed (scale, rotate, translate), repaired and turned to the tool's side; the
//! job's selection picks faces and a component of them; what is left must be one oriented
//! manifold piece with a boundary and without handles. Holes are fine.

use super::error::{FARTHEST, SurfaceError};
use super::fault::{Fault, several_pieces, topology_faults};
use super::manifold::Surface;
use super::parametrisation::Parametrisation;
use super::select::{Picked, pick};
use super::warning::{self, Warning};
use crate::geometry::{DMat3, DVec2, DVec3, OrderBy, rotation};
use crate::job::SurfaceOptions;
use crate::mesh::repair::{is_flat, turn_faces};
use crate::mesh::{Connectivity, TriangleSoup, VertexId, repair};
use crate::nurbs::NurbsSurface;

/// The surface and what came with it.
#[derive(Clone, Debug)]
pub struct Built {
    /// The piece to be machined.
    pub surface: Surface,
    /// The whole part it belongs to, placed and welded: what the tool must not gouge.
    pub part: Part,
    /// Texture coordinates of the corners of the surface's faces, if the file gave them.
    pub texture: Option<Vec<[DVec2; 3]>>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

/// A part and what of it is selected, of whatever kind.
#[derive(Clone, Debug)]
pub struct Whole {
    /// The whole part, placed and welded: what the tool must not gouge.
    pub part: Part,
    /// What is to be machined of it.
    pub machined: Part,
    /// That as a surface, if it is one that can be laid flat as it is.
    pub surface: Result<Surface, SurfaceError>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

/// A whole part, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// `#V` vertex positions, mm.
    pub positions: Vec<DVec3>,
    /// `#F` triples of vertices, of the same orientation as the surface; any topology.
    pub faces: Vec<[u32; 3]>,
}

impl Part {
    /// Adds the faces of another.
    pub fn add(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.faces.extend(other.faces.iter().map(|f| f.map(|v| v + first)));
    }

    /// The faces that are not of `surface`, which was picked from this part.
    pub fn without(&self, surface: &Surface) -> Self {
        let (positions, faces) = surface.triangles();
        self.without_faces(&Self { positions: positions.to_vec(), faces })
    }

    /// The faces that are not of another part, which was picked from this one.
    pub fn without_faces(&self, picked: &Self) -> Self {
        if picked.faces.len() == self.faces.len() {
            return Self::default();
        }
        let key = |corners: [DVec3; 3]| {
            let mut bits = corners.map(|p| p.to_array().map(f64::to_bits));
            bits.order_total();
            bits
        };
        let keys = |part: &Self, f: &[u32; 3]| key(f.map(|v| part.positions[v as usize]));
        let mut machined: Vec<_> = picked.faces.iter().map(|f| keys(picked, f)).collect();
        machined.order_total();
        let rest = |f: &&[u32; 3]| machined.binary_search(&keys(self, f)).is_err();
        let faces = self.faces.iter().filter(rest).copied().collect();
        Self { positions: self.positions.clone(), faces }
    }
}

/// Builds the surface that `options` describe from triangles in the file's units.
///
/// # Errors
/// [`SurfaceError`] when the selection is empty or the selected piece cannot be machined; all
/// faults of the piece are reported together.
pub fn build(soup: TriangleSoup, options: &SurfaceOptions) -> Result<Built, SurfaceError> {
    let Placed { part, mut warnings, selected } = placed(soup, options)?;
    let (surface, texture, of_surface) = selected.surface()?;
    warnings.extend(of_surface);
    Ok(Built { surface, part, texture, warnings })
}

/// As [`build`] for a selection that need not be one piece that can be laid flat.
///
/// # Errors
/// [`SurfaceError`] when nothing is selected.
pub fn build_whole(soup: TriangleSoup, options: &SurfaceOptions) -> Result<Whole, SurfaceError> {
    Ok(whole(placed(soup, options)?, None))
}

/// `smooth`: of what the part is a mesh, whose texture coordinates are the parameters.
fn whole(placed: Placed, smooth: Option<NurbsSurface>) -> Whole {
    let Placed { part, mut warnings, selected } = placed;
    let TriangleSoup { positions, faces, .. } = &selected.picked.piece;
    let machined = Part { positions: positions.clone(), faces: faces.clone() };
    let surface = selected.surface().and_then(|(mut surface, texture, of_surface)| {
        if let Some((smooth, corners)) = smooth.zip(texture) {
            surface = surface.with_parametrisation(Parametrisation::new(smooth, corners));
            check_normals(&surface)?;
        }
        warnings.extend(of_surface);
        Ok(surface)
    });
    Whole { part, machined, surface, warnings }
}

/// A part in place, and what of it a job selects.
struct Placed {
    part: Part,
    warnings: Vec<Warning>,
    selected: Selected,
}

/// The whole part, and the faces of it that `options` select.
fn placed(soup: TriangleSoup, options: &SurfaceOptions) -> Result<Placed, SurfaceError> {
    check_indices(&soup)?;
    let faces_read = soup.faces.len();
    let repaired = repair(place(soup, options)?);
    if repaired.mesh.faces.is_empty() {
        return Err(SurfaceError::NoArea { faces: faces_read });
    }
    let (mut mesh, repairs) = (repaired.mesh, repaired.repairs);
    if options.flip {
        turn_faces(&mut mesh, |_| true);
    }
    let warnings = warning::of_part(&mesh, &repairs);
    let part = Part { positions: mesh.positions.clone(), faces: mesh.faces.clone() };
    let picked = pick(mesh, &options.select)?;
    Ok(Placed { part, warnings, selected: Selected { picked, tolerance: repairs.tolerance } })
}

/// The faces of a part that a job selects.
struct Selected {
    picked: Picked,
    tolerance: f64,
}

type WithTexture = (Surface, Option<Vec<[DVec2; 3]>>, Vec<Warning>);

impl Selected {
    /// The surface, with warnings about it.
    fn surface(self) -> Result<WithTexture, SurfaceError> {
        let Self { picked, tolerance } = self;
        let faults = faults(&picked, tolerance);
        if !faults.is_empty() {
            return Err(SurfaceError::Unusable(faults));
        }
        let mut warnings = warning::of_selection(&picked);
        let TriangleSoup { positions, faces, texture } = picked.piece;
        let faces = faces.into_iter().map(|face| face.map(VertexId)).collect();
        let connectivity = Connectivity::new(positions.len(), faces)?;
        let surface = Surface::new(connectivity, positions);
        check_normals(&surface)?;
        warnings.extend(warning::of_surface(&surface));
        Ok((surface, texture, warnings))
    }
}

/// As [`build_placed`] from a mesh of `surface` whose texture coordinates are the parameters.
///
/// # Errors
/// As [`build_whole`].
pub fn build_parametric(
    soup: TriangleSoup,
    surface: NurbsSurface,
    options: &SurfaceOptions,
) -> Result<Whole, SurfaceError> {
    Ok(whole(placed(soup, &in_place(options))?, Some(surface)))
}

/// As [`build_whole`] for triangles that are already placed.
///
/// # Errors
/// As [`build_whole`].
pub fn build_placed(soup: TriangleSoup, options: &SurfaceOptions) -> Result<Whole, SurfaceError> {
    build_whole(soup, &in_place(options))
}

/// Options that leave what is already placed where it is.
fn in_place(options: &SurfaceOptions) -> SurfaceOptions {
    SurfaceOptions { scale: 1.0, rotate: DVec3::ZERO, translate: DVec3::ZERO, ..options.clone() }
}

/// A mesh in the coordinates of the surface's file, placed as that is, repaired and turned outward; nothing of it is
/// machined.
///
/// # Errors
/// [`SurfaceError`] when no face of it has an area, or it is broken.
pub fn build_beside(soup: TriangleSoup, options: &SurfaceOptions) -> Result<Part, SurfaceError> {
    check_indices(&soup)?;
    let faces = soup.faces.len();
    let mesh = repair(place(soup, options)?).mesh;
    if mesh.faces.is_empty() {
        return Err(SurfaceError::NoArea { faces });
    }
    Ok(Part { positions: mesh.positions, faces: mesh.faces })
}

/// Rotation and scale of `options`; the translation comes after.
pub fn placement(options: &SurfaceOptions) -> DMat3 {
    rotation(options.rotate) * options.scale
}

/// There are faces, and their vertices exist.
pub(super) fn check_indices(soup: &TriangleSoup) -> Result<(), SurfaceError> {
    if soup.faces.is_empty() {
        return Err(SurfaceError::NoFaces);
    }
    let vertices = soup.positions.len();
    for (face, corners) in soup.faces.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|v| **v as usize >= vertices) {
            return Err(SurfaceError::BadIndex { face, vertex, vertices });
        }
    }
    Ok(())
}

/// Scale, rotations about X, Y, Z in this order, translation.
fn place(mut soup: TriangleSoup, options: &SurfaceOptions) -> Result<TriangleSoup, SurfaceError> {
    let matrix = placement(options);
    for (vertex, p) in soup.positions.iter_mut().enumerate() {
        *p = matrix * *p + options.translate;
        // Negated, so that NaN is refused too.
        if !(p.abs().max_element() < FARTHEST && p.is_finite()) {
            return Err(SurfaceError::TooFar { vertex, at: *p });
        }
    }
    Ok(soup)
}

/// Everything that keeps the picked piece from being machined.
fn faults(picked: &Picked, tolerance: f64) -> Vec<Fault> {
    let judgement = &picked.judgement;
    let mut faults: Vec<Fault> = several_pieces(judgement, &picked.piece).into_iter().collect();
    faults.extend(topology_faults(judgement));
    let positions = &picked.piece.positions;
    let flat = || picked.piece.faces.iter().filter(|f| is_flat(positions, **f, tolerance));
    if let Some(face) = flat().next() {
        let at = positions[face[0] as usize];
        faults.push(Fault::Flat { count: flat().count(), at, tolerance });
    }
    faults
}

fn check_normals(surface: &Surface) -> Result<(), SurfaceError> {
    let without = |i: &usize| surface.vertex_normals()[*i] == DVec3::ZERO;
    let mut missing = (0..surface.positions().len()).filter(without);
    match missing.next() {
        None => Ok(()),
        Some(v) => Err(SurfaceError::Unusable(vec![Fault::NoNormal {
            count: 1 + missing.count(),
            at: surface.positions()[v],
        }])),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::geometry::math::{cos, sin};
    use crate::job::{Component, Faces, Selection, SurfaceSource};
    use crate::surface::AnalyticSurface;

    fn options(select: Selection) -> SurfaceOptions {
        SurfaceOptions {
            source: SurfaceSource::File(String::new()),
            scale: 1.0,
            rotate: DVec3::ZERO,
            translate: DVec3::ZERO,
            select,
            curvature_radius: None,
            steepest: None,
            flip: false,
            face: Faces::Only,
            chord: None,
        }
    }

    /// The unit cube, every side two triangles, outward.
    fn cube() -> TriangleSoup {
        let positions = (0..8)
            .map(|i| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into()))
            .collect();
        let sides =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        TriangleSoup { positions, faces, texture: None }
    }

    fn upward(degrees: f64) -> Selection {
        let normal_within = Some((f64::to_radians(degrees), DVec3::Z));
        Selection { normal_within, ..Selection::default() }
    }

    #[test]
    fn the_top_of_a_cube_is_picked_by_its_normal() {
        let built = build(cube(), &options(upward(10.0))).unwrap();
        assert!((built.surface.area() - 1.0).abs() < 1e-12);
        assert!(built.surface.positions().iter().all(|p| p.z == 1.0));
        assert_eq!(built.part.faces.len(), 12);
    }

    #[test]
    fn a_cube_as_it_is_has_no_boundary() {
        let error = build(cube(), &options(Selection::default())).unwrap_err();
        assert_eq!(error, SurfaceError::Unusable(vec![Fault::Closed { faces: 12, slits: 0 }]));
    }

    #[test]
    fn rotation_is_about_x_then_y_then_z_then_moved() {
        let mut options = options(upward(10.0));
        // X turns -Y's side up; the others then turn within and around.
        options.rotate = DVec3::new(-FRAC_PI_2, 0.0, FRAC_PI_2);
        options.scale = 2.0;
        options.translate = DVec3::new(0.0, 0.0, 5.0);
        let built = build(cube(), &options).unwrap();
        // (x, y, z) -> about X by -90: (x, z, -y) -> about Z by 90: (-z, x, -y).
        assert!(built.surface.positions().iter().all(|p| (p.z - 5.0).abs() < 1e-12));
        let (low, high) = crate::mesh::repair::bounding_box(built.surface.positions());
        assert!((low - DVec3::new(-2.0, 0.0, 5.0)).length() < 1e-12);
        assert!((high - DVec3::new(0.0, 2.0, 5.0)).length() < 1e-12);
    }

    #[test]
    fn flip_machines_the_inside() {
        let mut inside = options(upward(10.0));
        inside.flip = true;
        let built = build(cube(), &inside).unwrap();
        assert!(built.surface.positions().iter().all(|p| p.z == 0.0));
        assert!(built.surface.vertex_normals().iter().all(|n| *n == DVec3::Z));
    }

    #[test]
    fn an_empty_selection_says_what_would_not_be_empty() {
        let mut select = upward(10.0);
        select.normal_within = Some((0.1, DVec3::new(0.6, 0.0, 0.8)));
        let message = build(cube(), &options(select)).unwrap_err().to_string();
        assert!(message.contains("none of 12 faces"), "{message}");
        assert!(message.contains("between 36.8699 and 143.1301 degrees"), "{message}");
        let select = Selection {
            within_box: Some((DVec3::splat(3.0), DVec3::splat(4.0))),
            ..Selection::default()
        };
        let message = build(cube(), &options(select)).unwrap_err().to_string();
        assert!(message.contains("(3, 3, 3) to (4, 4, 4)"), "{message}");
        assert!(message.contains("reaches from (0, 0, 0) to (1, 1, 1)"), "{message}");
    }

    #[test]
    fn components_are_picked_by_size_or_index() {
        let mut two = AnalyticSurface::Plane { width: 4.0, depth: 4.0 }.mesh(1.0);
        let big = AnalyticSurface::Plane { width: 8.0, depth: 8.0 }.mesh(1.0);
        let first = two.positions.len() as u32;
        two.positions.extend(big.positions.iter().map(|p| p + DVec3::X * 20.0));
        two.faces.extend(big.faces.iter().map(|f| f.map(|v| v + first)));
        let area = |component| {
            let select = Selection { component, ..Selection::default() };
            build(two.clone(), &options(select)).map(|built| built.surface.area().round())
        };
        assert_eq!(area(Component::Largest), Ok(64.0));
        assert_eq!(area(Component::Index(1)), Ok(16.0));
        assert_eq!(
            area(Component::Index(2)),
            Err(SurfaceError::NoSuchComponent { index: 2, count: 2 })
        );
        assert!(area(Component::Only).unwrap_err().to_string().contains("2 connected pieces"));
    }

    #[test]
    fn faces_that_a_selection_leaves_touching_are_parted() {
        // Four faces around a vertex, of which two opposite ones face up.
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let positions = vec![
            at(0.0, 0.0, 0.0),
            at(1.0, -1.0, 0.0),
            at(1.0, 1.0, 0.0),
            at(-1.0, 1.0, 0.0),
            at(-1.0, -1.0, 0.0),
            at(0.0, 0.5, 9.0),
            at(0.0, -0.5, -9.0),
        ];
        let faces = vec![[0, 1, 2], [0, 2, 5], [0, 5, 3], [0, 3, 4], [0, 4, 6], [0, 6, 1]];
        let soup = TriangleSoup { positions, faces, texture: None };
        let select = Selection { component: Component::Largest, ..upward(20.0) };
        let built = build(soup, &options(select)).unwrap();
        assert_eq!(built.surface.connectivity().face_count(), 1);
        assert!(built.warnings.contains(&Warning::Split { count: 1 }));
    }

    #[test]
    fn a_torus_has_a_handle_even_with_a_hole() {
        let n = 12;
        let vertex = |i: u32, j: u32| (i % n) * n + j % n;
        let positions = (0..n * n)
            .map(|v| {
                let (a, b) = (f64::from(v / n) / 12.0, f64::from(v % n) / 12.0);
                let (a, b) = (a * std::f64::consts::TAU, b * std::f64::consts::TAU);
                DVec3::new((3.0 + cos(b)) * cos(a), (3.0 + cos(b)) * sin(a), sin(b))
            })
            .collect();
        let quads = (0..n * n).map(|v| {
            let (i, j) = (v / n, v % n);
            [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]
        });
        let mut faces: Vec<[u32; 3]> =
            quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        faces.truncate(faces.len() - 1);
        let soup = TriangleSoup { positions, faces, texture: None };
        let error = build(soup, &options(Selection::default())).unwrap_err();
        assert_eq!(error, SurfaceError::Unusable(vec![Fault::Handles { genus: 1 }]));
    }
}
