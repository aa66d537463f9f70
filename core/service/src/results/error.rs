//! Why there are no results.

use evencut_core::plan::PlanError;
use evencut_core::texture::engagement::TooConcave;
use evencut_core::texture::export::X3pError;
use evencut_core::texture::grid::{GridError, MOST_NODES};
use evencut_core::texture::window::WindowError;
use evencut_core::verify::VerifyError;
use evencut_output::gcode::GcodeError;
use evencut_output::post::PostError;
use thiserror::Error;

/// Why there are no results.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// The job cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The path cannot be written as a program.
    #[error(transparent)]
    Post(#[from] PostError),
    /// The program that was written cannot be read back.
    #[error(transparent)]
    Program(#[from] GcodeError),
    /// The path cannot be verified.
    #[error(transparent)]
    Verify(#[from] VerifyError),
    /// The texture cannot be simulated.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

/// Why there is no texture.
#[derive(Debug, Error)]
pub enum TextureError {
    /// The job has no window.
    #[error(
        "texture: the job has no [texture] table; give the place of a window, `at = [x, y, z]`"
    )]
    NoWindow,
    /// Spindle speed or feed is zero.
    #[error(
        "texture: a spindle speed of {spindle} rev/min and a feed of {feed} mm/min; both must be above 0"
    )]
    Still {
        /// Spindle speed, rev/min.
        spindle: f64,
        /// Feed, mm/min.
        feed: f64,
    },
    /// No move at feed takes time.
    #[error("texture: no feed move of the path takes time: its times do not increase")]
    NoTime,
    /// The path does not cut in the window.
    #[error(
        "texture: the path cuts nothing in the window, within {start} mm above and below the surface: it does not come \
         there, or it belongs to another surface"
    )]
    NotCut {
        /// Height of the material, mm.
        start: f64,
    },
    /// More nodes on a whole surface than a grid may have.
    #[error("{}", too_fine(*.nodes, *.spacing))]
    WholeTooFine {
        /// The requested number of nodes.
        nodes: f64,
        /// A spacing, mm, with which there are few enough.
        spacing: f64,
    },
    /// There is no window there.
    #[error(transparent)]
    Window(#[from] WindowError),
    /// The window has no grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The cutter is too large for the window.
    #[error(transparent)]
    TooConcave(#[from] TooConcave),
    /// The map is too large for its file.
    #[error(transparent)]
    X3p(#[from] X3pError),
}

/// The longest spacing allowed in a job, mm.
const LONGEST: f64 = 10.0;

/// Message for a whole surface with too many nodes, with the spacing that works if a job may ask for it.
fn too_fine(nodes: f64, spacing: f64) -> String {
    let remedy = if spacing <= LONGEST {
        format!("give a spacing of {spacing} mm or more, or a window")
    } else {
        "simulate a window of it".into()
    };
    format!(
        "texture: the whole surface needs {nodes:.0} nodes at this spacing, which must hold where its map is stretched \
         most; at most {MOST_NODES:.0} are allowed: {remedy}"
    )
}
