//! Channels between the blades of a blisk: its hub is finished with a ball end on five axes.
//!
//! - *Edge*: the closed line in which a blade, or its fillet, meets the hub.
//! - *Channel*: the piece of the hub between two blades that the cutter reaches: its sides are the edges' curves at the
//!   geodesic distance of the cutter's radius and a clearance.
//!
//! Steps, a file each: the edge as a B-spline in (u, v) (`edge`, `spline`); its geodesic offset (`geodesic`, `offset`), moved out where the blade leans over the
//! ball (`beside`);
//! sides of the channel, between one blade's curve and the next one's (`sides`, `layout`); its map to the unit square
//! (`channel`); passes (`strips`); tool axes between the blades (`axes`); points, extensions and links
//! (`path`); what the path leaves too high, and passes over that (`rest`). One channel is planned; the others are turned.
//!
//! Source: S-HUB, spec of the project, with its corrections: neighbours are turned in space, and passes leave a radial
//! channel along the meridian.

mod axes;
mod beside;
mod channel;
mod edge;
mod error;
mod geodesic;
mod layout;
mod offset;
mod passage;
mod path;
mod rest;
mod sampling;
#[cfg(test)]
mod shapes;
mod sides;
mod spline;
mod strips;
mod wheel;

pub use axes::{AxisField, AxisOptions, Stand};
pub use error::HubError;
pub use passage::{
    Blade, ChannelFigures, ChannelLines, ChannelOptions, Channels, Passage, PassageOptions,
};
pub use path::Shortened;
