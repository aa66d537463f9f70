//! Pressure side of a twisted, tapered blade with NACA four-digit sections.

use super::lifted;
use crate::triangulate::{Domain, subdivided, triangulate};
use evencut_core::geometry::{DVec2, DVec3, math};
use evencut_core::mesh::TriangleSoup;

/// NACA 4412: camber 4 % at 40 % of the chord, 12 % thick.
const CAMBER: f64 = 0.04;
const CAMBER_AT: f64 = 0.4;
const THICKNESS: f64 = 0.12;
/// Chord at root and tip, mm.
const CHORD: (f64, f64) = (60.0, 40.0);
const SPAN: f64 = 100.0;
/// Half of the twist between root and tip, degrees.
const HALF_TWIST: f64 = 15.0;
/// Part of the chord that is machined; the round nose belongs to another operation.
const MACHINED: (f64, f64) = (0.06, 0.96);
const SPACING: f64 = 0.92;

/// The lower side of the sections, turned up, from root (y = 0) to tip.
///
/// # Source
/// Abbott and von Doenhoff, "Theory of Wing Sections" (1959), section 6.4: equations of the
/// NACA four-digit thickness distribution and mean line.
pub fn pressure_side() -> Result<TriangleSoup, String> {
    let corner = |chord: f64, part: f64, y: f64| DVec2::new(chord * (part - 0.5), y);
    let corners = [
        corner(CHORD.0, MACHINED.0, 0.0),
        corner(CHORD.0, MACHINED.1, 0.0),
        corner(CHORD.1, MACHINED.1, SPAN),
        corner(CHORD.1, MACHINED.0, SPAN),
    ];
    let domain = Domain { outer: subdivided(&corners, SPACING), holes: Vec::new() };
    Ok(lifted(&triangulate(&domain, SPACING)?, on_blade))
}

/// `p`: distance from mid-chord in the untwisted section, and along the span.
fn on_blade(p: DVec2) -> DVec3 {
    let along = p.y / SPAN;
    let chord = CHORD.0 + (CHORD.1 - CHORD.0) * along;
    let section = lower_side(p.x / chord + 0.5) * chord;
    let (x, z) = (section.x - 0.5 * chord, -section.y);
    let twist = (2.0 * along - 1.0) * HALF_TWIST.to_radians();
    let (sin, cos) = (math::sin(twist), math::cos(twist));
    DVec3::new(x * cos + z * sin, p.y, z * cos - x * sin)
}

/// Point of the lower side for mean-line abscissa `x`, in chords.
fn lower_side(x: f64) -> DVec2 {
    let half = 5.0
        * THICKNESS
        * (0.2969 * x.sqrt() + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1015 * x))));
    let (camber, slope) = mean_line(x);
    let cos = 1.0 / (1.0 + slope * slope).sqrt();
    DVec2::new(x + half * slope * cos, camber - half * cos)
}

/// Ordinate and slope of the mean line.
fn mean_line(x: f64) -> (f64, f64) {
    let rest = if x < CAMBER_AT { CAMBER_AT } else { 1.0 - CAMBER_AT };
    let t = (x - CAMBER_AT) / rest;
    (CAMBER * (1.0 - t * t), -2.0 * CAMBER * t / rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lower_ordinate_at_the_crest_of_the_mean_line() {
        // At the mean line's crest the slope is zero and the side lies straight below it; the
        // published ordinate of the 0012 section at 40 % is 5.803 %.
        let p = lower_side(0.4);
        assert!((p.x - 0.4).abs() < 1e-12);
        assert!((p.y - (0.04 - 0.05803)).abs() < 1e-5, "{p}");
    }
}
