//! The parameters of a smooth surface as its flat map.

use crate::flatten::Chart;
use crate::geometry::DVec2;
use crate::hub::{ChannelLines, Passage};
use crate::nurbs::NurbsSurface;
use crate::surface::Surface;

/// The parameters of the hub as a flat map, both in mm at the middle of the channel.
pub(super) fn parameters(surface: &Surface) -> Chart {
    let flat = (0..surface.positions().len()).map(|_| DVec2::ZERO);
    let mut flat: Vec<DVec2> = flat.collect();
    if let Some(own) = surface.parameters() {
        let scale = scale(own.surface(), own.corners());
        for (face, corners) in surface.connectivity().faces().iter().zip(own.corners()) {
            for (v, at) in face.iter().zip(corners) {
                flat[v.index()] = *at * scale;
            }
        }
    }
    Chart::new(surface, flat)
}

/// mm per parameter in the middle of the corners; the first one negative where faces run clockwise in the parameters.
fn scale(hub: &NurbsSurface, corners: &[[DVec2; 3]]) -> DVec2 {
    let all = || corners.iter().flatten();
    let middle = all().copied().sum::<DVec2>() / all().count().max(1) as f64;
    let [u, v] = hub.jet(middle).first.map(|way| way.length());
    let clockwise = corners.first().is_some_and(|[a, b, c]| (*b - *a).perp_dot(*c - *a) < 0.0);
    DVec2::new(if clockwise { -u } else { u }, v)
}

/// Flat mm of a chart of [`parameters`] per parameter.
pub(super) fn flat_per_parameter(surface: &Surface, chart: &Chart) -> Option<DVec2> {
    let own = surface.parameters()?;
    let scale = scale(own.surface(), own.corners());
    // The chart is the parameters but for a factor.
    let first = own.corners().first().map_or(DVec2::ONE, |c| c[0] * scale);
    let vertex = surface.connectivity().faces().first().map_or(0, |f| f[0].index());
    Some(scale * (chart.uv()[vertex].length() / first.length()))
}

/// The lines of a channel in its flat map, flat mm.
pub(super) fn lines(surface: &Surface, chart: &Chart, passage: &Passage) -> Option<ChannelLines> {
    let scale = flat_per_parameter(surface, chart)?;
    Some(passage.lines().moved(|at| at * scale))
}
