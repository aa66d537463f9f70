//! Pictures of a finished path, as SVG text whose bytes depend on nothing but the input.
//!
//! [`flat_map`] shows the path in the plane, [`surface_view`] on the surface, [`mrr_chart`] the
//! removal rate along time. All are drawn on a light ground, in units of the screen, and colour the
//! removal rate on the same scale.

mod colour;
mod flat_map;
mod mrr_chart;
mod path_layers;
mod png;
mod shading;
mod surface_view;
mod svg;

pub use flat_map::flat_map;
pub use mrr_chart::mrr_chart;
pub use surface_view::surface_view;

#[cfg(test)]
mod samples;
