//! What is reported of the texture of a window.

use evencut_core::texture::parameters::{Profile, SECTIONS};
use serde::Serialize;

/// Fewest cells that show the mark of a tooth.
const FEWEST: f64 = 4.0;
/// Turns of the cutter whose marks a line along the feed is to hold, and feeds per tooth: a cusp in each section.
const TURNS: f64 = 2.0;
const TEETH: f64 = SECTIONS as f64;
/// Tolerances below the surface that a path comes to where it belongs to it.
const SUNK: f64 = 3.0;
/// Facets that are higher than this part of Sz are worth a word.
const ROUGH: f64 = 0.1;
/// Depth that is rounding, mm.
const ROUNDING: f64 = 1e-6;

/// The texture of a window.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TextureFigures {
    /// The window.
    pub window: WindowFigures,
    /// Cutting data.
    pub cutting: CuttingFigures,
    /// Parameters of ISO 25178-2, over the mean plane.
    pub areal: ArealFigures,
    /// Profile parameters of the lines along the feed.
    pub along: ProfileFigures,
    /// Of those across it.
    pub across: ProfileFigures,
    /// What the simulation took.
    pub work: WorkFigures,
    /// What deserves a second look.
    pub notes: Vec<String>,
}

/// The window.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct WindowFigures {
    /// Its middle, mm.
    pub middle_mm: [f64; 3],
    /// Unit direction of the feed there.
    pub feed: [f64; 3],
    /// Numbers of nodes along and across the feed.
    pub nodes: [u64; 2],
    /// Mean lengths of cells along and across the feed, mm.
    pub spacing_mm: [f64; 2],
    /// The shortest and the longest cell, mm.
    pub cells_mm: [f64; 2],
    /// Height of the material before, mm.
    pub start_mm: f64,
    /// Nodes of the grid beyond the surface, where all of it was asked for.
    pub beyond: u64,
    /// Nodes that nothing cut; they have no height and count in no parameter.
    pub uncut: u64,
    /// How far facets of the mesh are off a smooth surface, µm.
    pub facets_um: f64,
}

/// Cutting data.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CuttingFigures {
    /// Feed per tooth, mm.
    pub feed_per_tooth_mm: f64,
    /// Side step of a straight pass on a plane, mm.
    pub side_step_mm: f64,
    /// Spindle speed, rev/min.
    pub spindle_rpm: f64,
    /// Teeth.
    pub flutes: u32,
    /// Least concave radius near the window, mm; null where nothing is concave.
    pub least_concave_radius_mm: Option<f64>,
}

/// Areal parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ArealFigures {
    /// Arithmetic mean height, µm.
    pub sa_um: f64,
    /// Root mean square height, µm.
    pub sq_um: f64,
    /// Maximum height, highest over lowest, µm.
    pub sz_um: f64,
    /// Skewness.
    pub ssk: f64,
    /// Kurtosis.
    pub sku: f64,
}

/// Profile parameters, means over all lines.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProfileFigures {
    /// Arithmetic mean deviation, µm.
    pub ra_um: f64,
    /// Root mean square deviation, µm.
    pub rq_um: f64,
    /// Mean of highest over lowest of five sections, µm.
    pub rz_um: f64,
    /// Total height, highest over lowest of the whole line, µm.
    pub rt_um: f64,
}

/// What the simulation took.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct WorkFigures {
    /// Time steps.
    pub steps: u64,
    /// Points of an edge.
    pub edge_points: u64,
    /// Quadrilaterals near a tile of the grid.
    pub quads: u64,
    /// Nodes tested against a quadrilateral.
    pub tests: u64,
}

impl WindowFigures {
    /// Which nodes have no height, in words after their number.
    fn gaps(&self) -> String {
        let told = |count: u64, why: &str| match count {
            0 => String::new(),
            _ => format!(", {count} of them {why}"),
        };
        told(self.beyond, "beyond the surface") + &told(self.uncut, "not cut")
    }
}

impl ProfileFigures {
    /// Of the heights along a line.
    pub fn of(profile: &Profile) -> Self {
        let [ra_um, rq_um, rz_um, rt_um] =
            [profile.ra, profile.rq, profile.rz, profile.rt].map(|x| 1e3 * x);
        Self { ra_um, rq_um, rz_um, rt_um }
    }
}

impl TextureFigures {
    /// What deserves a second look. `lowest`: height of the deepest node without run-out, mm; `tolerance`: how far the path
    /// may be off the surface, mm.
    pub fn warnings(&self, lowest: f64, tolerance: f64) -> Vec<String> {
        let mut notes = Vec::new();
        let window = &self.window;
        if lowest < -(SUNK * tolerance).max(ROUNDING) {
            notes.push(format!(
                "the teeth come {:.1} µm below the surface, but the path at most {:.1} µm: path and surface do not \
                 belong together, or the path cuts into the part",
                -1e3 * lowest,
                1e3 * tolerance
            ));
        }
        if 1e3 * tolerance > ROUGH * self.areal.sz_um {
            notes.push(format!(
                "the path consists of straight moves up to {:.1} µm (cut.tolerance) off the surface, which shows \
                 in the heights; with a smaller tolerance only the tooth marks show",
                1e3 * tolerance
            ));
        }
        let finest = self.cutting.feed_per_tooth_mm / FEWEST;
        if window.spacing_mm[0] > finest * (1.0 + 1e-6) {
            notes.push(format!(
                "cells of {:.4} mm along the feed are too long to show a feed per tooth of {:.4} mm: give a texture.spacing \
                 of {finest:.4} mm or less",
                window.spacing_mm[0], self.cutting.feed_per_tooth_mm
            ));
        }
        if window.uncut > 0 {
            notes.push(format!(
                "{} of {} nodes were not cut, still {} mm high or more: they have no height and are left out of all \
                 parameters and of the colours",
                window.uncut,
                window.nodes[0] * window.nodes[1] - window.beyond,
                window.start_mm
            ));
        }
        if window.facets_um > ROUGH * self.areal.sz_um {
            notes.push(format!(
                "facets of the mesh are {:.3} µm off a smooth surface; the path follows them, and so does the part: a \
                 finer mesh leaves only the tooth marks",
                window.facets_um
            ));
        }
        let along = window.spacing_mm[0] * (window.nodes[0] - 1) as f64;
        let teeth = f64::from(self.cutting.flutes);
        let wanted = self.cutting.feed_per_tooth_mm * (TURNS * teeth).max(TEETH);
        if along < wanted * (1.0 - 1e-6) {
            notes.push(format!(
                "the window is {along:.3} mm along the feed; for Ra and Rz along it should have {wanted:.3} mm, two turns of \
                 the cutter and five feeds per tooth"
            ));
        }
        let across = window.spacing_mm[1] * (window.nodes[1] - 1) as f64;
        let wanted = SECTIONS as f64 * self.cutting.side_step_mm;
        if across < wanted * (1.0 - 1e-6) {
            notes.push(format!(
                "the window is {across:.3} mm across the feed; for Rz across it should have {wanted:.3} mm, five side steps"
            ));
        }
        notes
    }

    /// The main parameters in a line.
    pub fn caption(&self) -> String {
        let (a, l, c) = (&self.areal, &self.along, &self.across);
        format!(
            "Sa {:.3}, Sz {:.3}; along the feed Ra {:.3}, Rz {:.3}; across Ra {:.3}, Rz {:.3} µm",
            a.sa_um, a.sz_um, l.ra_um, l.rz_um, c.ra_um, c.rz_um
        )
    }

    /// Labels and what is written under them.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let (w, c, a) = (&self.window, &self.cutting, &self.areal);
        let [x, y, z] = w.middle_mm;
        let profile = |p: &ProfileFigures| {
            let ProfileFigures { ra_um, rq_um, rz_um, rt_um } = p;
            format!("Ra {ra_um:.3}  Rq {rq_um:.3}  Rz {rz_um:.3}  Rt {rt_um:.3} µm")
        };
        let mut lines = vec![
            (
                "window",
                format!(
                    "{} x {} nodes{}, {:.4} x {:.4} mm apart, about ({x:.3}, {y:.3}, {z:.3})",
                    w.nodes[0],
                    w.nodes[1],
                    w.gaps(),
                    w.spacing_mm[0],
                    w.spacing_mm[1],
                ),
            ),
            (
                "teeth",
                format!(
                    "{} at {:.0} rev/min, feed per tooth {:.4} mm, side step {:.4} mm",
                    c.flutes, c.spindle_rpm, c.feed_per_tooth_mm, c.side_step_mm
                ),
            ),
            (
                "areal",
                format!(
                    "Sa {:.3}  Sq {:.3}  Sz {:.3} µm  Ssk {:.2}  Sku {:.2}",
                    a.sa_um, a.sq_um, a.sz_um, a.ssk, a.sku
                ),
            ),
            ("along feed", profile(&self.along)),
            ("across", profile(&self.across)),
        ];
        lines.extend(self.notes.iter().map(|note| ("note", note.clone())));
        lines
    }

    /// A short summary for a reader.
    pub fn summary(&self) -> String {
        self.lines().iter().map(|(label, value)| format!("{label:<12}{value}\n")).collect()
    }
}
