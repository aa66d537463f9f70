//! Height maps as text: `csv` and `asc`.

use super::matrix::Matrix;
use std::fmt::Write;

/// µm in a mm.
pub const MICRO: f64 = 1e3;

/// The map as `x_mm,y_mm,z_um`, to 0.1 nm in height.
pub fn csv(map: &Matrix) -> Vec<u8> {
    let mut text = String::from("x_mm,y_mm,z_um\n");
    for (k, h) in map.heights.iter().enumerate() {
        let x = (k % map.counts[0]) as f64 * map.steps[0];
        let y = (k / map.counts[0]) as f64 * map.steps[1];
        // Writing to a string cannot fail.
        let _ = match h.is_nan() {
            true => writeln!(text, "{x:.6},{y:.6},"),
            false => writeln!(text, "{x:.6},{y:.6},{:.4}", h * MICRO),
        };
    }
    text.into_bytes()
}

/// The map as a matrix of heights in µm, to 0.1 pm, under a header in the manner of Gwyddion's text export: width and
/// height of the map in mm, which are the steps times the numbers of nodes.
pub fn asc(map: &Matrix) -> Vec<u8> {
    let size = |axis: usize| map.steps[axis] * map.counts[axis] as f64;
    let mut text = format!(
        "# Channel: Texture\n# Width: {:.9} mm\n# Height: {:.9} mm\n# Value units: um\n",
        size(0),
        size(1)
    );
    for row in map.heights.chunks(map.counts[0].max(1)) {
        for (i, h) in row.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            let _ = match h.is_nan() {
                true => write!(text, "{gap}nan"),
                false => write!(text, "{gap}{:.7}", h * MICRO),
            };
        }
        text.push('\n');
    }
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_the_nodes() {
        let heights = [0.0, 0.001, 0.002, 0.003, 0.004, 0.0050001];
        let map = Matrix { counts: [3, 2], steps: [0.1, 0.2], heights: &heights };
        let table = String::from_utf8(csv(&map)).unwrap();
        assert_eq!(table.lines().count(), 7);
        assert_eq!(table.lines().last(), Some("0.200000,0.200000,5.0001"));
        let matrix = String::from_utf8(asc(&map)).unwrap();
        assert!(matrix.contains("# Width: 0.300000000 mm"));
        assert_eq!(matrix.lines().last(), Some("3.0000000 4.0000000 5.0001000"));
        let gap = [f64::NAN, 0.001];
        let map = Matrix { counts: [2, 1], steps: [0.1, 0.1], heights: &gap };
        assert!(String::from_utf8(csv(&map)).unwrap().contains("\n0.000000,0.000000,\n"));
        assert!(String::from_utf8(asc(&map)).unwrap().ends_with("\nnan 1.0000000\n"));
    }
}
