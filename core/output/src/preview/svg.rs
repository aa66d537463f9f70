//! Drawing primitives: an SVG document with fixed decimals.

use super::colour::{self, Rgb};
use crate::report::escaped;
use evencut_core::geometry::DVec2;
use std::fmt::Write;

/// Where a text stands relative to its point.
#[derive(Copy, Clone, Debug)]
pub enum Anchor {
    /// The text starts there.
    Start,
    /// It is centred there.
    Middle,
    /// It ends there.
    End,
}

/// How a line is drawn.
#[derive(Copy, Clone, Debug)]
pub struct Stroke {
    /// Its colour.
    pub colour: Rgb,
    /// Its width, px.
    pub width: f64,
    /// Whether it is dashed.
    pub dashed: bool,
}

impl Stroke {
    /// A continuous line.
    pub const fn solid(colour: Rgb, width: f64) -> Self {
        Self { colour, width, dashed: false }
    }

    /// A dashed line.
    pub fn dashed(colour: Rgb, width: f64) -> Self {
        Self { colour, width, dashed: true }
    }
}

/// An SVG document under construction; px, y down.
pub struct Svg {
    text: String,
}

impl Svg {
    /// An empty picture with a light ground, its title and its description for readers of screens.
    pub fn new(width: f64, height: f64, title: &str, description: &str) -> Self {
        let mut svg = Self { text: String::new() };
        let (title, description) = (escaped(title), escaped(description));
        svg.put(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             role=\"img\" font-family=\"system-ui, 'DejaVu Sans', Arial, sans-serif\">\n\
             <title>{title}</title>\n<desc>{description}</desc>\n",
        ));
        svg.rectangle(DVec2::ZERO, DVec2::new(width, height), colour::GROUND);
        svg
    }

    /// Writing to a string cannot fail.
    fn put(&mut self, arguments: std::fmt::Arguments) {
        let _ = self.text.write_fmt(arguments);
    }

    /// A filled rectangle from corner `low`.
    pub fn rectangle(&mut self, low: DVec2, size: DVec2, fill: Rgb) {
        let (x, y, w, h) = (num(low.x), num(low.y), num(size.x), num(size.y));
        let fill = fill.hex();
        self.put(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{fill}\"/>\n"
        ));
    }

    /// A straight line.
    pub fn line(&mut self, from: DVec2, to: DVec2, stroke: Stroke) {
        let (x1, y1, x2, y2) = (num(from.x), num(from.y), num(to.x), num(to.y));
        let stroke = attributes(stroke);
        self.put(format_args!(
            "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {stroke}/>\n"
        ));
    }

    /// A circle.
    pub fn circle(&mut self, centre: DVec2, radius: f64, fill: Option<Rgb>, stroke: Stroke) {
        let (x, y, r) = (num(centre.x), num(centre.y), num(radius));
        let fill = fill.map_or_else(|| "none".to_owned(), Rgb::hex);
        // Dashes as long as those of lines would leave two of them on a small circle.
        let dash = if stroke.dashed { " stroke-dasharray=\"2.6 2\"" } else { "" };
        let stroke = attributes(Stroke { dashed: false, ..stroke });
        self.put(format_args!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" fill=\"{fill}\" {stroke}{dash}/>\n"
        ));
    }

    /// An open polyline.
    pub fn polyline(&mut self, points: &[DVec2], stroke: Stroke) {
        let points = coordinates(points);
        let stroke = attributes(stroke);
        self.put(format_args!(
            "<polyline points=\"{points}\" fill=\"none\" stroke-linejoin=\"round\" {stroke}/>\n"
        ));
    }

    /// A region bounded by closed polygons; what an even number of them encloses stays empty.
    pub fn region(&mut self, polygons: &[Vec<DVec2>], fill: Rgb, stroke: Option<Stroke>) {
        let mut data = String::new();
        for polygon in polygons.iter().filter(|p| !p.is_empty()) {
            let _ = write!(data, "M{}Z", coordinates(polygon));
        }
        let stroke = stroke.map_or_else(String::new, attributes);
        let fill = fill.hex();
        self.put(format_args!(
            "<path d=\"{data}\" fill=\"{fill}\" fill-rule=\"evenodd\" {stroke}/>\n"
        ));
    }

    /// The outlines of closed polygons.
    pub fn region_outline(&mut self, polygons: &[Vec<DVec2>], stroke: Stroke) {
        for polygon in polygons {
            let closed: Vec<DVec2> = polygon.iter().chain(polygon.first()).copied().collect();
            self.polyline(&closed, stroke);
        }
    }

    /// Lines given as path data in hundredths of a pixel.
    pub fn fine_lines(&mut self, data: &str, stroke: Stroke) {
        let hundredths = attributes(Stroke { width: 100.0 * stroke.width, ..stroke });
        self.put(format_args!(
            "<path transform=\"scale(.01)\" d=\"{data}\" fill=\"none\" \
             stroke-linejoin=\"round\" stroke-linecap=\"round\" {hundredths}/>\n"
        ));
    }

    /// A raster picture in a rectangle of its own proportions.
    pub fn image(&mut self, low: DVec2, size: DVec2, png: &[u8]) {
        self.picture(low, size, png, "");
    }

    /// A raster picture stretched over a rectangle.
    pub fn stretched_image(&mut self, low: DVec2, size: DVec2, png: &[u8]) {
        self.picture(low, size, png, "preserveAspectRatio=\"none\" ");
    }

    fn picture(&mut self, low: DVec2, size: DVec2, png: &[u8], how: &str) {
        let (x, y, w, h) = (num(low.x), num(low.y), num(size.x), num(size.y));
        let data = base64(png);
        self.put(format_args!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" \
             {how}href=\"data:image/png;base64,{data}\"/>\n"
        ));
    }

    /// A line of text on the baseline through `at`.
    pub fn text(&mut self, at: DVec2, anchor: Anchor, size: f64, text: &str) {
        self.coloured_text(at, anchor, size, colour::INK, text);
    }

    /// A line of text in a colour.
    pub fn coloured_text(&mut self, at: DVec2, anchor: Anchor, size: f64, ink: Rgb, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y, ink, text) = (num(at.x), num(at.y), ink.hex(), escaped(text));
        self.put(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size:.0}\" text-anchor=\"{anchor}\" \
             fill=\"{ink}\">{text}</text>\n"
        ));
    }

    /// The document.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// Two decimals at most, no negative zero.
fn num(x: f64) -> String {
    let text = format!("{x:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

fn coordinates(points: &[DVec2]) -> String {
    let mut text = String::new();
    for (i, p) in points.iter().enumerate() {
        let gap = if i == 0 { "" } else { " " };
        let _ = write!(text, "{gap}{},{}", num(p.x), num(p.y));
    }
    text
}

fn attributes(stroke: Stroke) -> String {
    let (colour, width) = (stroke.colour.hex(), num(stroke.width));
    let dash = if stroke.dashed {
        format!(" stroke-dasharray=\"{} {}\"", num(5.0 * stroke.width), num(4.0 * stroke.width))
    } else {
        String::new()
    };
    format!("stroke=\"{colour}\" stroke-width=\"{width}\"{dash}")
}

/// RFC 4648 base 64 with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

/// A step of 1, 2 or 5 times a power of ten that divides `range` into at most `most` pieces.
pub fn round_step(range: f64, most: f64) -> f64 {
    let wanted = range / most;
    let mut decade = 1.0;
    while decade * 10.0 <= wanted {
        decade *= 10.0;
    }
    while decade > wanted && decade > f64::MIN_POSITIVE {
        decade /= 10.0;
    }
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * decade >= wanted).unwrap_or(10.0);
    factor * decade
}

/// Time as min:s, with tenths where seconds do not tell times apart.
pub fn clock(time: f64) -> String {
    if time > 0.0 && time < 8.0 {
        return format!("0:{time:04.1}");
    }
    let seconds = time.round() as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_matches_the_rfc() {
        let pairs = [("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in pairs {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn steps_are_round() {
        assert_eq!(round_step(100.0, 5.0), 20.0);
        assert_eq!(round_step(97.0, 5.0), 20.0);
        assert_eq!(round_step(101.0, 5.0), 50.0);
        assert!((round_step(0.7, 4.0) - 0.2).abs() < 1e-12);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([num(-0.001), num(2.5), num(10.0)], ["0", "2.5", "10"]);
    }

    #[test]
    fn text_is_escaped() {
        let mut svg = Svg::new(10.0, 10.0, "a<b", "\"c\" & d");
        svg.text(DVec2::ZERO, Anchor::Start, 12.0, "x<y");
        let text = svg.finish();
        assert!(text.contains("<title>a&lt;b</title>") && text.contains(">x&lt;y</text>"));
        assert!(text.contains("&quot;c&quot; &amp; d"));
    }
}
