//! Text of SVG files.

use std::fmt::Write;

pub(crate) const INK: &str = "#24292f";
pub(crate) const FAINT: &str = "#6a737d";
pub(crate) const GRID: &str = "#e4e7ea";

/// Where text stands beside its point.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// An SVG file that is being written. Coordinates are pixels from the upper left corner.
pub(crate) struct Svg {
    text: String,
}

impl Svg {
    /// A white card with a title, which is its accessible name too.
    pub(crate) fn card(width: f64, height: f64, title: &str) -> Svg {
        let mut svg = Svg { text: String::new() };
        svg.add(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"Helvetica, Arial, sans-serif\" role=\"img\"><title>{}</title>",
            escape(title)
        ));
        svg.add(format_args!(
            "<rect x=\"0.5\" y=\"0.5\" width=\"{}\" height=\"{}\" rx=\"6\" fill=\"#ffffff\" stroke=\"#d0d7de\"/>",
            width - 1.0,
            height - 1.0
        ));
        svg
    }

    pub(crate) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn add(&mut self, part: std::fmt::Arguments) {
        self.text.write_fmt(part).expect("strings grow");
        self.text.push('\n');
    }

    pub(crate) fn text(&mut self, (x, y): (f64, f64), size: f64, color: &str, anchor: Anchor, text: &str) {
        self.add(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{color}\" text-anchor=\"{}\">{}</text>",
            anchor.name(),
            escape(text)
        ));
    }

    /// Text that runs upwards, centred on its point.
    pub(crate) fn upwards(&mut self, (x, y): (f64, f64), size: f64, color: &str, text: &str) {
        self.add(format_args!(
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" font-size=\"{size}\" fill=\"{color}\" \
             text-anchor=\"middle\">{}</text>",
            escape(text)
        ));
    }

    pub(crate) fn line(&mut self, from: (f64, f64), to: (f64, f64), color: &str, width: f64, dashes: &str) {
        self.path(&[from, to], color, width, dashes);
    }

    /// A line through points.
    pub(crate) fn path(&mut self, points: &[(f64, f64)], color: &str, width: f64, dashes: &str) {
        let dashed = if dashes.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dashes}\"") };
        self.add(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" \
             stroke-linejoin=\"round\"{dashed}/>",
            list(points)
        ));
    }

    pub(crate) fn area(&mut self, points: &[(f64, f64)], color: &str, opacity: f64) {
        self.add(format_args!("<polygon points=\"{}\" fill=\"{color}\" fill-opacity=\"{opacity}\"/>", list(points)));
    }

    /// A disc in its colour, or a ring of it.
    pub(crate) fn disc(&mut self, (x, y): (f64, f64), radius: f64, color: &str, hollow: bool) {
        let fill = if hollow { "#ffffff" } else { color };
        self.add(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"{fill}\" fill-opacity=\"0.85\" stroke=\"{color}\" \
             stroke-width=\"1.5\"/>"
        ));
    }

    pub(crate) fn bar(&mut self, (x, y): (f64, f64), (width, height): (f64, f64), color: &str) {
        self.add(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"1.5\" fill=\"{color}\" \
             fill-opacity=\"0.75\"/>"
        ));
    }
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        }
    }
}

fn list(points: &[(f64, f64)]) -> String {
    points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

/// Text as XML has it.
pub(crate) fn escape(text: &str) -> String {
    let visible: String = text.chars().filter(|c| !c.is_control()).collect();
    visible.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
