//! Pictures of a finished path, as SVG text whose bytes depend on nothing but the input.
//!
//! [`flat_map`] shows the path in the plane, [`surface_view`] on the surface, [`mrr_chart`] the
//! removal rate along time; [`channel_view`] and [`clearance_chart`] are those of a hub; [`residual_map`] and [`rate_map`] show what the judge found. All are drawn on a light ground, in units of the screen, and colour the
//! removal rate on the same scale.

mod channel_view;
mod clearance_chart;
mod colour;
mod comparison;
mod flat_map;
mod heat_map;
mod heat_scale;
mod linked;
mod marks;
mod mrr_chart;
mod path_layers;
mod placement;
mod places;
mod png;
mod regions_map;
mod shading;
mod surface_view;
mod svg;
mod tensor_map;
mod texture_map;
mod texture_png;
mod tool_drawing;
mod view;

pub use channel_view::{ChannelScene, channel_view};
pub use clearance_chart::{Clearances, clearance_chart};
pub use comparison::{Bars, comparison};
pub use flat_map::{FlatLines, flat_map};
pub use heat_map::{rate_map, residual_map};
pub use linked::{Drawn, Linked, MeshTable, PathTable, SampleTable};
pub use mrr_chart::{ChartPlacement, mrr_chart};
pub use placement::Placement;
pub use regions_map::{RegionPicture, RegionsPicture, regions_map};
pub use surface_view::surface_view;
pub use tensor_map::{PointKind, PointMark, TensorPicture, tensor_map};
pub use texture_map::{TexturePanel, texture_map, texture_panels};
pub use texture_png::texture_png;
pub use tool_drawing::tool_drawing;

#[cfg(test)]
mod samples;
