//! Writing SVG: shapes, letters whose width is known, and embedded pictures.
//!
//! Coordinates are pixels of the drawing, x to the right and y downwards.

#![expect(
    clippy::indexing_slicing,
    reason = "what is drawn is numbered by the lists it was laid out from"
)]

use std::fmt::Write;

use base64::Engine;

/// The built-in letters: a part of DejaVu Sans (see the data folder for source and licence).
pub(crate) const FONT: &[u8] = include_bytes!("../data/DejaVuSans-subset.ttf");

/// The name under which the built-in letters are found.
pub(crate) const FONT_FAMILY: &str = "DejaVu Sans";

/// Advance widths of the characters from ' ' to '~' in 1/2048 of the letter size.
const ADVANCES: [u16; 95] = [
    651, 821, 942, 1716, 1303, 1946, 1597, 563, 799, 799, 1024, 1716, 651, 739, 651, 690, 1303,
    1303, 1303, 1303, 1303, 1303, 1303, 1303, 1303, 1303, 690, 690, 1716, 1716, 1716, 1087, 2048,
    1401, 1405, 1430, 1577, 1294, 1178, 1587, 1540, 604, 604, 1343, 1141, 1767, 1532, 1612, 1235,
    1612, 1423, 1300, 1251, 1499, 1401, 2025, 1403, 1251, 1403, 799, 690, 799, 1716, 1024, 1024,
    1255, 1300, 1126, 1300, 1260, 721, 1300, 1298, 569, 569, 1186, 569, 1995, 1298, 1253, 1300,
    1300, 842, 1067, 803, 1298, 1212, 1675, 1212, 1212, 1075, 1303, 690, 1303, 1716,
];

/// Width of a text in pixels at a letter size in pixels.
///
/// Exact for ASCII, superscripts and the minus sign; other letters count as an average one.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let advance = |c: char| match c {
        ' '..='~' => ADVANCES[c as usize - 32],
        '⁰' | '¹' | '²' | '³' | '⁴'..='⁹' => 821,
        '⁻' => 1081,
        '−' | '×' | '→' | '±' | '≤' | '≥' => 1716,
        'µ' => 1303,
        _ => 1300,
    };
    text.chars().map(|c| f64::from(advance(c))).sum::<f64>() * size / 2048.0
}

/// Breaks a text at spaces into lines no wider than `width` pixels where words allow it.
pub(crate) fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// An upright rectangle: left, top, width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) w: f64,
    pub(crate) h: f64,
}

impl Rect {
    /// Right edge.
    pub(crate) fn right(&self) -> f64 {
        self.x + self.w
    }

    /// Bottom edge.
    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.h
    }

    /// Whether a point lies inside or on the edge.
    pub(crate) fn contains(&self, [x, y]: [f64; 2]) -> bool {
        x >= self.x && x <= self.right() && y >= self.y && y <= self.bottom()
    }

    /// The area two rectangles share.
    pub(crate) fn overlap(&self, other: &Rect) -> f64 {
        let w = self.right().min(other.right()) - self.x.max(other.x);
        let h = self.bottom().min(other.bottom()) - self.y.max(other.y);
        w.max(0.0) * h.max(0.0)
    }

    /// The rectangle grown by `by` pixels on each side.
    pub(crate) fn grown(&self, by: f64) -> Rect {
        Rect {
            x: self.x - by,
            y: self.y - by,
            w: self.w + 2.0 * by,
            h: self.h + 2.0 * by,
        }
    }
}

/// Which part of a text sits at the given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Anchor {
    /// The text's left end.
    Start,
    /// The text's middle.
    Middle,
    /// The text's right end.
    End,
}

/// How a text looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Letters {
    pub(crate) size: f64,
    pub(crate) colour: &'static str,
    pub(crate) anchor: Anchor,
}

/// How a shape looks: outline colour and width, dash pattern, fill.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen<'a> {
    pub(crate) stroke: &'a str,
    pub(crate) width: f64,
    pub(crate) dash: &'a str,
    pub(crate) fill: &'a str,
    pub(crate) opacity: f64,
}

impl<'a> Pen<'a> {
    /// A plain line.
    pub(crate) fn line(stroke: &'a str, width: f64) -> Self {
        Pen {
            stroke,
            width,
            dash: "",
            fill: "none",
            opacity: 1.0,
        }
    }

    /// A plain fill.
    pub(crate) fn fill(fill: &'a str) -> Self {
        Pen {
            fill,
            ..Pen::line("none", 0.0)
        }
    }

    /// The attributes that say so.
    fn attributes(&self) -> String {
        let mut out = format!(r#"fill="{}""#, self.fill);
        if self.stroke != "none" {
            let (stroke, width) = (self.stroke, number(self.width));
            out += &format!(r#" stroke="{stroke}" stroke-width="{width}" stroke-linejoin="round""#);
        }
        if !self.dash.is_empty() {
            out += &format!(r#" stroke-dasharray="{}""#, self.dash);
        }
        if self.opacity < 1.0 {
            out += &format!(r#" opacity="{}""#, number(self.opacity));
        }
        out
    }
}

/// A drawing under construction.
#[derive(Debug, Default)]
pub(crate) struct Svg {
    body: String,
    clips: usize,
}

impl Svg {
    /// Adds one element.
    fn push(&mut self, element: std::fmt::Arguments) {
        // Writing into a String cannot fail.
        let _ = writeln!(self.body, "{element}");
    }

    /// A rectangle.
    pub(crate) fn rect(&mut self, r: Rect, pen: Pen) {
        let [x, y, w, h] = [r.x, r.y, r.w, r.h].map(number);
        let look = pen.attributes();
        self.push(format_args!(
            r#"<rect x="{x}" y="{y}" width="{w}" height="{h}" {look}/>"#
        ));
    }

    /// A polyline, or a polygon where `closed`.
    pub(crate) fn path(&mut self, points: &[[f64; 2]], closed: bool, pen: Pen) {
        if points.len() < 2 {
            return;
        }
        let mut d = String::new();
        for (i, [x, y]) in points.iter().enumerate() {
            let verb = if i == 0 { 'M' } else { 'L' };
            let _ = write!(d, "{verb}{} {}", number(*x), number(*y));
        }
        if closed {
            d.push('Z');
        }
        let look = pen.attributes();
        self.push(format_args!(r#"<path d="{d}" {look}/>"#));
    }

    /// A straight line.
    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], pen: Pen) {
        self.path(&[from, to], false, pen);
    }

    /// A disc.
    pub(crate) fn disc(&mut self, [x, y]: [f64; 2], radius: f64, pen: Pen) {
        let [x, y, r] = [x, y, radius].map(number);
        let look = pen.attributes();
        self.push(format_args!(
            r#"<circle cx="{x}" cy="{y}" r="{r}" {look}/>"#
        ));
    }

    /// A text whose baseline starts, centres or ends at a point; `turned` reads upwards.
    pub(crate) fn text(&mut self, [x, y]: [f64; 2], text: &str, look: Letters, turned: bool) {
        let anchor = match look.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y) = (number(x), number(y));
        let (size, colour, text) = (number(look.size), look.colour, escape(text));
        let turn = match turned {
            true => format!(r#" transform="rotate(-90 {x} {y})""#),
            false => String::new(),
        };
        self.push(format_args!(
            r#"<text x="{x}" y="{y}" font-size="{size}" fill="{colour}" text-anchor="{anchor}"{turn}>{text}</text>"#
        ));
    }

    /// A PNG stretched over a rectangle.
    pub(crate) fn png(&mut self, r: Rect, png: &[u8]) {
        let [x, y, w, h] = [r.x, r.y, r.w, r.h].map(number);
        let data = base64::engine::general_purpose::STANDARD.encode(png);
        self.push(format_args!(
            r#"<image x="{x}" y="{y}" width="{w}" height="{h}" preserveAspectRatio="none" style="image-rendering:smooth" href="data:image/png;base64,{data}"/>"#
        ));
    }

    /// Draws with everything outside `r` cut away.
    pub(crate) fn clipped(&mut self, r: Rect, draw: impl FnOnce(&mut Svg)) {
        self.clips += 1;
        let id = self.clips;
        let [x, y, w, h] = [r.x, r.y, r.w, r.h].map(number);
        self.push(format_args!(
            r#"<clipPath id="clip{id}"><rect x="{x}" y="{y}" width="{w}" height="{h}"/></clipPath>"#
        ));
        self.push(format_args!(r##"<g clip-path="url(#clip{id})">"##));
        draw(self);
        self.push(format_args!("</g>"));
    }

    /// The document, on a white ground.
    pub(crate) fn finish(self, width: f64, height: f64) -> String {
        let (w, h) = (number(width), number(height));
        format!(
            concat!(
                r#"<svg xmlns="http://www.w3.org/2000/svg" width="{}" height="{}" viewBox="0 0 {} {}" "#,
                r#"font-family="'{}', Verdana, sans-serif">"#,
                "\n<rect width=\"{}\" height=\"{}\" fill=\"white\"/>\n{}</svg>\n"
            ),
            w, h, w, h, FONT_FAMILY, w, h, self.body
        )
    }
}

/// A coordinate with at most two decimals and no trailing zeros.
fn number(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// A text with the characters XML reserves written as entities, control characters left out.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars().filter(|c| !c.is_control()) {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use crate::svg::{Anchor, FONT, Letters, Rect, Svg, text_width, wrap};

    #[test]
    fn widths_agree_with_the_font() {
        // The reference is where the rendering library puts the end of the last letter.
        let mut fonts = resvg::usvg::fontdb::Database::new();
        fonts.load_font_data(FONT.to_vec());
        let options = resvg::usvg::Options {
            fontdb: std::sync::Arc::new(fonts),
            ..Default::default()
        };
        for text in ["Hxxx irradiance 0.125 W/mm|", "H10⁻⁵ −3.5 × 10² µm|"] {
            let look = Letters {
                size: 20.0,
                colour: "black",
                anchor: Anchor::Start,
            };
            let mut svg = Svg::default();
            svg.text([10.0, 50.0], text, look, false);
            let tree = resvg::usvg::Tree::from_str(&svg.finish(600.0, 100.0), &options).unwrap();
            let ink = tree.root().children()[1].abs_bounding_box();
            let width = f64::from(ink.width());
            assert!((width - text_width(text, 20.0)).abs() < 0.5, "{width}");
        }
    }

    #[test]
    fn long_texts_break_at_spaces() {
        let lines = wrap("one two three four", 10.0, 60.0);
        assert!(lines.len() > 1 && lines.iter().all(|l| text_width(l, 10.0) <= 60.0));
        assert_eq!(lines.join(" "), "one two three four");
    }

    #[test]
    fn reserved_characters_are_written_as_entities() {
        let mut svg = Svg::default();
        let look = Letters {
            size: 10.0,
            colour: "black",
            anchor: Anchor::End,
        };
        svg.text([0.0, 0.0], "a<b & c>\u{7}d", look, false);
        assert!(svg.finish(1.0, 1.0).contains("a&lt;b &amp; c&gt;d"));
    }

    #[test]
    fn rectangles_overlap_by_their_common_area() {
        let [x, y, w, h] = [0.0, 0.0, 2.0, 2.0];
        let a = Rect { x, y, w, h };
        let b = Rect {
            x: 1.0,
            y: 1.5,
            w,
            h,
        };
        assert_eq!((a.overlap(&b), b.overlap(&a)), (0.5, 0.5));
        assert_eq!(a.overlap(&b.grown(-1.0)), 0.0);
    }
}
