//! Where the surface comes from, how it is placed, and which of its faces are machined.

use super::resolver::Resolver;
use crate::geometry::DVec3;
use crate::job::file::{
    AnalyticTable, ComponentKey, ComponentRule, FaceKey, FaceRule, SelectTable, Units,
};
use crate::job::surface::{
    AnalyticKind, AnalyticOptions, AnalyticParameters, Component, Faces, Selection, SurfaceOptions,
    SurfaceSource,
};
use crate::job::units::{INCH, radians};

/// Formats by the ending of the file's name.
const FORMATS: [&str; 7] = ["stl", "obj", "ply", "off", "json", "step", "stp"];
/// Those of meshes.
pub(super) const MESH_FORMATS: [&str; 4] = ["stl", "obj", "ply", "off"];

/// Largest number of mesh edges along a surface given by a formula: four million vertices.
const LARGEST_GRID: f64 = 2000.0;

/// Difference of a squared length from 1 that rounding explains; such directions are kept as they
/// are, so that a resolved job reads back to the same bits.
const UNIT_LENGTH: f64 = 1e-15;

impl Resolver<'_> {
    pub(super) fn surface(&mut self) -> Option<SurfaceOptions> {
        let table = &self.file.surface;
        let source = self.source();
        let step = matches!(&source, Some(SurfaceSource::File(name)) if is_step(name));
        let is_file = matches!(source, Some(SurfaceSource::File(_))) && !step;
        self.check_faces(step);
        let unit = match table.units {
            Some(Units::Inch) if is_file => INCH,
            None if is_file => self.unit,
            _ => 1.0,
        };
        let scale = table.scale.unwrap_or(1.0) * unit;
        if !(1e-6..=1e6).contains(&scale) {
            let message = format!("with the file's unit, lengths are multiplied with {scale}");
            self.fault("surface.scale", message, "the product may be from 1e-6 to 1e6");
        }
        Some(SurfaceOptions {
            source: source?,
            scale,
            rotate: DVec3::from(table.rotate.unwrap_or_default().map(radians)),
            translate: self.point(table.translate.unwrap_or_default()),
            select: self.selection(),
            face: faces(table.face.as_ref()),
            chord: table.chord.map(|c| c * self.unit),
            curvature_radius: table.curvature_radius.map(|r| r * self.unit),
            steepest: table.steepest.map(radians),
            flip: table.flip.unwrap_or(false),
        })
    }

    /// The keys that STEP files have, and that they do not have.
    fn check_faces(&mut self, step: bool) {
        if !step && self.places.has("surface.face") {
            let help = "only STEP files (.step, .stp) have faces to choose from";
            self.fault("surface.face", "the surface is not a STEP file", help);
        }
        let is_several =
            matches!(faces(self.file.surface.face.as_ref()), Faces::Several(_) | Faces::All);
        if step && is_several && !self.places.has("surface.steepest") {
            let help = "several faces are machined as a cutter reaches them from above: give `steepest = 80.0`, or \
                        the number of one face";
            self.fault("surface.face", "several faces are no single surface", help);
        }
        let has_file = self.places.has("surface.file");
        if step && self.places.has("surface.units") {
            let help = "remove it; `surface.scale` changes the size";
            self.fault("surface.units", "a STEP file states its own unit", help);
        }
        let name = self.file.surface.file.as_deref().unwrap_or("");
        let smooth = step || ends_in(name, &["json"]);
        if !smooth && has_file && self.places.has("surface.chord") {
            let help = "only NURBS surfaces (.json, .step, .stp) are made into triangles";
            self.fault("surface.chord", "the surface is a mesh already", help);
        }
    }

    fn source(&mut self) -> Option<SurfaceSource> {
        let table = &self.file.surface;
        let has_file = self.places.has("surface.file");
        let has_formula = self.places.has("surface.analytic");
        if has_file && has_formula {
            let message = format!("a formula beside {}", self.named("surface.file"));
            self.fault("surface.analytic", message, "keep one of the two");
            return None;
        }
        if has_formula && self.places.has("surface.units") {
            let help = "a formula has the job's `units`";
            self.fault("surface.units", "is the unit of a mesh file, and there is none", help);
        }
        match (&table.file, &table.analytic) {
            (Some(file), _) => {
                self.check_file("surface.file", file, &FORMATS);
                Some(SurfaceSource::File(file.clone()))
            }
            (None, Some(analytic)) => self.analytic(analytic).map(SurfaceSource::Analytic),
            (None, None) => {
                if !has_file && !has_formula && self.places.found("surface") {
                    let help = "give `file = \"part.stl\"`, or a formula in [surface.analytic]";
                    self.fault("surface", "neither `file` nor `analytic` is given", help);
                }
                None
            }
        }
    }

    pub(super) fn check_file(&mut self, key: &str, file: &str, formats: &[&str]) {
        if file.chars().any(char::is_control) {
            self.fault(key, "contains a control character", "give the file's name");
        } else if !ends_in(file, formats) {
            let message = format!("{file:?} does not end in the name of a known format");
            let help = format!("available: {}", formats.join(", "));
            self.fault(key, message, help);
        }
    }

    fn analytic(&mut self, table: &AnalyticTable) -> Option<AnalyticOptions> {
        let kind = table.kind?;
        let default = AnalyticParameters::default();
        let written = [
            ("radius", table.radius),
            ("tube_radius", table.tube_radius),
            ("height", table.height),
        ];
        for (name, value) in written {
            if value.is_some() && !uses(kind).contains(&name) {
                let message = format!("a {} does not have this number", kind_name(kind));
                let help = format!("it has: size, resolution, {}", uses(kind).join(", "));
                let help = help.trim_end_matches(", ");
                self.fault(&format!("surface.analytic.{name}"), message, help);
            }
        }
        let size = self.length(table.size, default.size);
        let resolution = default.resolution.min(size / FACETS);
        let parameters = AnalyticParameters {
            size,
            radius: self.length(table.radius, default.radius),
            tube_radius: self.length(table.tube_radius, default.tube_radius),
            height: self.length(table.height, default.height),
            resolution: self.length(table.resolution, resolution),
        };
        self.check_analytic(kind, &parameters);
        Some(AnalyticOptions { kind, parameters })
    }

    fn check_analytic(&mut self, kind: AnalyticKind, p: &AnalyticParameters) {
        if p.size / p.resolution > LARGEST_GRID {
            let message =
                format!("{} over a size of {}", self.show(p.resolution), self.show(p.size));
            let help = format!(
                "give at least size / {LARGEST_GRID}, {}",
                self.show(p.size / LARGEST_GRID)
            );
            self.fault("surface.analytic.resolution", message, help);
        }
        if p.resolution > 0.25 * p.size {
            let message =
                format!("{} over a size of {}", self.show(p.resolution), self.show(p.size));
            self.fault("surface.analytic.resolution", message, "give at most size / 4");
        }
        let round = matches!(kind, AnalyticKind::SphereCap | AnalyticKind::Cylinder);
        if round && p.size >= 2.0 * p.radius {
            let message =
                format!("{}, but the radius is {}", self.show(p.size), self.show(p.radius));
            self.fault("surface.analytic.size", message, "give less than twice the radius");
        }
        let is_hilly =
            matches!(kind, AnalyticKind::Saddle | AnalyticKind::MonkeySaddle | AnalyticKind::Bump);
        if is_hilly && p.height.abs() > p.size {
            let message = format!("{} over a size of {}", self.show(p.height), self.show(p.size));
            self.fault("surface.analytic.height", message, "give at most the size");
        }
        if kind == AnalyticKind::TorusPatch && p.tube_radius >= p.radius {
            let message =
                format!("{}, but the radius is {}", self.show(p.tube_radius), self.show(p.radius));
            self.fault("surface.analytic.tube_radius", message, "give less than the radius");
        }
    }

    fn selection(&mut self) -> Selection {
        let Some(table) = &self.file.surface.select else { return Selection::default() };
        Selection {
            normal_within: self.normal_cone(table),
            within_box: self.selection_box(table),
            component: match table.component {
                None | Some(ComponentKey::Rule(ComponentRule::Only)) => Component::Only,
                Some(ComponentKey::Rule(ComponentRule::Largest)) => Component::Largest,
                Some(ComponentKey::Index(index)) => Component::Index(index),
            },
        }
    }

    fn normal_cone(&mut self, table: &SelectTable) -> Option<(f64, DVec3)> {
        let direction = DVec3::from(table.of.unwrap_or([0.0, 0.0, 1.0]));
        let length = direction.length();
        if length < 1e-9 {
            let help = "give a direction such as [0, 0, 1]";
            self.fault("surface.select.of", format!("a vector of length {length}"), help);
        }
        if table.of.is_some() && !self.places.has("surface.select.normal_within") {
            let help = "give `normal_within = 75.0`, or remove `of`";
            self.fault("surface.select.of", "a direction without `normal_within`", help);
        }
        let is_unit = (direction.length_squared() - 1.0).abs() <= UNIT_LENGTH;
        let unit = if is_unit { direction } else { direction.normalize_or_zero() };
        table.normal_within.map(|angle| (radians(angle), unit))
    }

    fn selection_box(&mut self, table: &SelectTable) -> Option<(DVec3, DVec3)> {
        let corners = table.within_box?;
        self.check_box("surface.select.box", corners);
        let [least, greatest] = corners.map(|corner| self.point(corner));
        Some((least, greatest))
    }

    pub(super) fn check_box(&mut self, key: &str, [least, greatest]: [[f64; 3]; 2]) {
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let (a, b) = (least[axis], greatest[axis]);
            if a >= b {
                let help = "the first corner is the least, the second the greatest";
                self.fault(key, format!("empty along {name}: {a} to {b}"), help);
            }
        }
    }
}

fn faces(key: Option<&FaceKey>) -> Faces {
    match key {
        None => Faces::Only,
        Some(FaceKey::Number(number)) => Faces::One(*number),
        Some(FaceKey::Numbers(numbers)) => match numbers.as_slice() {
            [number] => Faces::One(*number),
            _ => Faces::Several(numbers.clone()),
        },
        Some(FaceKey::Rule(FaceRule::All)) => Faces::All,
    }
}

/// Whether a file name has one of the endings, in any case.
fn ends_in(name: &str, endings: &[&str]) -> bool {
    let ending = name.rsplit_once('.').map(|(_, e)| e.to_ascii_lowercase());
    ending.is_some_and(|e| endings.contains(&e.as_str()))
}

/// Whether a file is a STEP file by its name.
pub(in crate::job) fn is_step(name: &str) -> bool {
    ends_in(name, &["step", "stp"])
}

pub(super) fn kind_name(kind: AnalyticKind) -> String {
    let name = match kind {
        AnalyticKind::Plane => "plane",
        AnalyticKind::SphereCap => "sphere-cap",
        AnalyticKind::Cylinder => "cylinder",
        AnalyticKind::TorusPatch => "torus-patch",
        AnalyticKind::Saddle => "saddle",
        AnalyticKind::MonkeySaddle => "monkey-saddle",
        AnalyticKind::Bump => "bump",
    };
    name.to_owned()
}

/// Facets along a small surface, unless the job says otherwise: fewer show in the cusps.
const FACETS: f64 = 100.0;

/// The numbers of a formula besides `size` and `resolution`.
pub(in crate::job) fn uses(kind: AnalyticKind) -> &'static [&'static str] {
    match kind {
        AnalyticKind::Plane => &[],
        AnalyticKind::SphereCap | AnalyticKind::Cylinder => &["radius"],
        AnalyticKind::TorusPatch => &["radius", "tube_radius"],
        AnalyticKind::Saddle | AnalyticKind::MonkeySaddle => &["height"],
        AnalyticKind::Bump => &["radius", "height"],
    }
}
