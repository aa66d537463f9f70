//! The texture that the teeth of a cutter leave on a surface.
//!
//! A planned path, the cutter with its teeth and the spindle speed give the height map of a window of the surface; that
//! gives the parameters of ISO 25178 and ISO 4287 and files for metrology. The modules stand in the order of the
//! source's steps: the cutting [`edge`], the [`kinematics`] of its points, the effective edge ([`engagement`]), the
//! [`grid`] of the window, the [`steps`] of time and edge, and the [`sweep`] itself.

pub mod edge;
pub mod engagement;
pub mod export;
pub mod grid;
pub mod kinematics;
pub mod parameters;
pub mod steps;
pub mod sweep;
mod tile;
pub mod window;
