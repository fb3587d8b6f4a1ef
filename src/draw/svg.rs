//! Text of SVG files.

use std::fmt::Write;

pub(crate) const INK: &str = "#24292f";
pub(crate) const FAINT: &str = "#6a737d";
pub(crate) const GRID: &str = "#e4e7ea";
const PAPER: &str = "#ffffff";
const BORDER: &str = "#d0d7de";

/// Colours that colour-blind readers tell apart (Okabe & Ito 2008), darkened where white paper asks for it.
pub(crate) const COLORS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#a6448a", "#c98a00", "#56b4e9", "#333333", "#8a6f4d"];

/// The class of what is filled (`f`) or drawn (`s`) in a colour: a page gives it another one by that name, on dark paper.
fn class(kind: char, color: &str) -> String {
    let known = [(INK, "ink"), (FAINT, "faint"), (GRID, "grid"), (PAPER, "paper"), (BORDER, "grid")];
    let named = known.iter().find(|(known, _)| *known == color).map(|(_, name)| name.to_string());
    let numbered = || COLORS.iter().position(|known| *known == color).map(|k| format!("m{k}"));
    named.or_else(numbered).map_or(String::new(), |name| format!("{kind}-{name}"))
}

/// Text in lines of at most `letters`, broken at blanks.
pub(crate) fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= letters => *line += &format!(" {word}"),
            _ => lines.push(word.to_string()),
        }
    }
    lines
}

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
            "<rect x=\"0.5\" y=\"0.5\" width=\"{}\" height=\"{}\" rx=\"6\" fill=\"{PAPER}\" stroke=\"{BORDER}\" \
             class=\"f-paper s-grid\"/>",
            width - 1.0,
            height - 1.0
        ));
        svg
    }

    /// What programs read and nobody sees: where the drawing comes from.
    pub(crate) fn with_metadata(svg: &str, says: &str) -> String {
        svg.replacen("</title>", &format!("</title><metadata>{}</metadata>", escape(says)), 1)
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
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{color}\" class=\"{}\" text-anchor=\"{}\">{}</text>",
            class('f', color),
            anchor.name(),
            escape(text)
        ));
    }

    /// Text that runs upwards, centred on its point.
    pub(crate) fn upwards(&mut self, (x, y): (f64, f64), size: f64, color: &str, text: &str) {
        self.add(format_args!(
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" font-size=\"{size}\" fill=\"{color}\" \
             class=\"{}\" text-anchor=\"middle\">{}</text>",
            class('f', color),
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
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" class=\"{}\" \
             stroke-linejoin=\"round\"{dashed}/>",
            list(points),
            class('s', color)
        ));
    }

    pub(crate) fn area(&mut self, points: &[(f64, f64)], color: &str, opacity: f64) {
        self.add(format_args!(
            "<polygon points=\"{}\" fill=\"{color}\" class=\"{}\" fill-opacity=\"{opacity}\"/>",
            list(points),
            class('f', color)
        ));
    }

    /// A disc in its colour, or a ring of it.
    pub(crate) fn disc(&mut self, (x, y): (f64, f64), radius: f64, color: &str, hollow: bool) {
        let fill = if hollow { PAPER } else { color };
        self.add(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"{fill}\" fill-opacity=\"0.85\" stroke=\"{color}\" \
             class=\"{} {}\" stroke-width=\"1.5\"/>",
            class('f', fill),
            class('s', color)
        ));
    }

    pub(crate) fn bar(&mut self, (x, y): (f64, f64), (width, height): (f64, f64), color: &str) {
        self.add(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"1.5\" fill=\"{color}\" \
             class=\"{}\" fill-opacity=\"0.75\"/>",
            class('f', color)
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
