//! The tool from the side: cutter, shank and holder, with their dimensions.

use super::colour::{self, Rgb};
use super::svg::{Anchor, Stroke, Svg};
use core::f64::consts::FRAC_PI_2;
use evencut_core::geometry::{DVec2, math};
use evencut_core::tool::{Assembly, AssemblyPart};

const SIZE: DVec2 = DVec2::new(420.0, 460.0);
/// Room around the drawing, px.
const MARGIN: f64 = 40.0;
/// Room right of it for dimensions, px.
const DIMENSIONS: f64 = 150.0;
const CUTTER: Rgb = Rgb([0xd9, 0x92, 0x2b]);
const SHANK: Rgb = Rgb([0xb8, 0xc0, 0xc8]);
const HOLDER: Rgb = Rgb([0x6e, 0x7a, 0x86]);
/// Points on the rounding of the cutter's corner.
const ROUNDING: u32 = 24;
/// Least distance between the lines of two labels, px.
const APART: f64 = 16.0;

/// The tool as it is to be set up. Its dimensions are in mm; lengths are those from the tip.
pub fn tool_drawing(assembly: &Assembly) -> String {
    let mut svg = Svg::new(
        SIZE.x,
        SIZE.y,
        "Tool",
        "Cutter, shank and holder from the side, with lengths from the tip.",
    );
    let outline = |half: &[DVec2]| -> Vec<DVec2> {
        let other = half.iter().rev().map(|p| DVec2::new(-p.x, p.y));
        half.iter().copied().chain(other).collect()
    };
    let (radius, corner) = (assembly.tool.radius(), assembly.tool.corner_radius());
    let mut cutter: Vec<DVec2> = (0..=ROUNDING)
        .map(|i| FRAC_PI_2 * f64::from(i) / f64::from(ROUNDING))
        .map(|t| {
            DVec2::new(radius - corner + corner * math::sin(t), corner - corner * math::cos(t))
        })
        .collect();
    cutter.push(DVec2::new(radius, assembly.cutter_length));
    let height = assembly.height();
    let wide = 2.0 * assembly.largest_radius();
    let room = SIZE - DVec2::new(2.0 * MARGIN + DIMENSIONS, 2.0 * MARGIN);
    let scale = (room.x / wide).min(room.y / height);
    let middle = MARGIN + 0.5 * room.x;
    let place = |p: DVec2| DVec2::new(middle + scale * p.x, SIZE.y - MARGIN - scale * p.y);
    let mut draw = |half: &[DVec2], fill: Rgb| {
        let polygon: Vec<DVec2> = outline(half).into_iter().map(place).collect();
        svg.region(&[polygon], fill, Some(Stroke::solid(colour::INK, 1.0)));
    };
    draw(&cutter, CUTTER);
    for section in &assembly.sections {
        let [low, high] = section.heights;
        let [lower, upper] = section.radii;
        let half = [DVec2::new(lower, low), DVec2::new(upper, high)];
        draw(&half, if section.part == AssemblyPart::Holder { HOLDER } else { SHANK });
    }
    let axis = [place(DVec2::new(0.0, -0.02 * height)), place(DVec2::new(0.0, 1.02 * height))];
    svg.line(axis[0], axis[1], Stroke::dashed(colour::INK, 0.8));
    labels(&mut svg, assembly, place);
    svg.finish()
}

/// Heights at which something begins, each with a line and what it is.
fn labels(svg: &mut Svg, assembly: &Assembly, place: impl Fn(DVec2) -> DVec2) {
    let tool = &assembly.tool;
    let (d, r) = (2.0 * tool.radius(), tool.corner_radius());
    let mut marks = vec![
        (0.0, format!("⌀ {d:.2}, r {r:.2}")),
        (assembly.cutter_length, format!("{:.2} cutter", assembly.cutter_length)),
    ];
    let ends = |part: AssemblyPart| assembly.sections.iter().filter(move |s| s.part == part);
    if let Some(shank) = ends(AssemblyPart::Shank).next() {
        marks.push((shank.heights[1], format!("{:.2} stickout", shank.heights[1])));
    }
    if ends(AssemblyPart::Holder).next().is_some() {
        marks.push((assembly.height(), format!("{:.2} holder", assembly.height())));
    }
    let right = SIZE.x - DIMENSIONS + 8.0;
    let mut free = SIZE.y - MARGIN + APART;
    for (height, label) in marks {
        let at = place(DVec2::new(0.0, height));
        let text = at.y.min(free - APART);
        free = text;
        svg.line(at, DVec2::new(right - 26.0, at.y), Stroke::dashed(colour::FAINT, 1.0));
        svg.line(
            DVec2::new(right - 26.0, at.y),
            DVec2::new(right - 6.0, text),
            Stroke::solid(colour::FAINT, 1.0),
        );
        svg.text(DVec2::new(right, text + 4.0), Anchor::Start, 13.0, &label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evencut_core::tool::{Section, Tool};

    #[test]
    fn it_shows_all_parts_and_their_lengths() {
        let tool = Tool::new(5.0, 1.0).unwrap();
        let section = |part, heights, radii| Section { part, heights, radii };
        let sections = vec![
            section(AssemblyPart::Shank, [20.0, 45.0], [5.0; 2]),
            section(AssemblyPart::Holder, [45.0, 60.0], [10.0, 14.0]),
            section(AssemblyPart::Holder, [60.0, 100.0], [25.0; 2]),
        ];
        let svg = tool_drawing(&Assembly { tool, cutter_length: 20.0, sections });
        assert_eq!(svg.matches("<path").count(), 4);
        for label in ["⌀ 10.00, r 1.00", "20.00 cutter", "45.00 stickout", "100.00 holder"] {
            assert!(svg.contains(label), "{label}");
        }
        assert!(!svg.contains("NaN"));
        let alone = tool_drawing(&Assembly::of_cutter(tool, 20.0));
        assert!(!alone.contains(" holder<") && !alone.contains(" stickout<"));
    }
}
