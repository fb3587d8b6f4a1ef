//! Bars to either side of 1.

use super::Style;
use super::axis::{Axis, short};
use super::plot::cut;
use super::rows::{BOTTOM, FIGURES, Frame, ROW, TOP, WIDTH};
use super::svg::{Anchor, FAINT, INK, Svg};

/// A bar, or a heading above some.
pub(crate) enum Row {
    Heading(String),
    Bar { name: String, style: Style, value: f64, interval: Option<(f64, f64)> },
}

/// Horizontal bars over a logarithmic axis; `None` where there is none to show.
pub(crate) fn bars(title: &str, note: &str, label: &str, rows: &[Row]) -> Option<String> {
    let values = rows.iter().filter_map(|row| match row {
        Row::Heading(_) => None,
        Row::Bar { value, interval, .. } => Some((*value, *interval)),
    });
    let ends = |(value, interval): (f64, Option<(f64, f64)>)| {
        let (low, high) = interval.unwrap_or((value, value));
        [low.max(value / 4.0), value, high.min(value * 4.0)]
    };
    let all: Vec<f64> = values.flat_map(ends).collect();
    if all.is_empty() {
        return None;
    }
    let axis = Axis::logarithmic(all.into_iter().chain([1.0]))?;
    let letters = rows.iter().map(|r| matches!(r, Row::Bar { .. }).then(|| r.letters()).unwrap_or(0)).max()?;
    let frame = Frame { axis, left: 40.0 + 6.6 * letters as f64, top: TOP, bottom: TOP + ROW * rows.len() as f64 };
    let mut svg = Svg::card(WIDTH, frame.bottom + BOTTOM, title);
    svg.text((16.0, 27.0), 16.0, INK, Anchor::Start, title);
    svg.text((16.0, 46.0), 11.5, FAINT, Anchor::Start, note);
    frame.axis(&mut svg, label);
    frame.one(&mut svg);
    rows.iter().enumerate().for_each(|(k, row)| frame.bar_row(&mut svg, TOP + ROW * k as f64, row));
    Some(svg.finish())
}

impl Row {
    fn letters(&self) -> usize {
        match self {
            Row::Heading(name) | Row::Bar { name, .. } => cut(name).chars().count(),
        }
    }
}

impl Frame {
    /// Where efficiencies are equal.
    fn one(&self, svg: &mut Svg) {
        let one = self.at(1.0);
        svg.line((one, self.top), (one, self.bottom), FAINT, 1.5, "");
    }

    fn bar_row(&self, svg: &mut Svg, y: f64, row: &Row) {
        let middle = y + 0.5 * ROW;
        let (name, style, value, interval) = match row {
            Row::Heading(text) => {
                svg.text((16.0, middle + 5.0), 12.5, INK, Anchor::Start, text);
                return;
            }
            Row::Bar { name, style, value, interval } => (name, style, *value, *interval),
        };
        svg.text((self.left - 10.0, middle + 4.0), 12.0, INK, Anchor::End, &cut(name));
        let (from, to) = (self.at(value.min(1.0)), self.at(value.max(1.0)));
        svg.bar((from, y + 4.0), ((to - from).max(1.0), ROW - 8.0), style.color);
        let mut figures = format!("{} ×", short(value));
        if let Some((low, high)) = interval {
            svg.line((self.at(low), middle), (self.at(high), middle), INK, 1.5, "");
            // without its end, a stroke goes on beyond the axis
            for end in [low, high].into_iter().filter(|end| self.axis.shows(*end)) {
                svg.line((self.at(end), middle - 4.0), (self.at(end), middle + 4.0), INK, 1.5, "");
            }
            figures += &format!("  [{}, {}]", short(low), short(high));
        }
        svg.text((WIDTH - FIGURES + 12.0, middle + 4.0), 11.5, INK, Anchor::Start, &figures);
    }
}
