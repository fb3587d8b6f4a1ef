//! Bars to either side of 1.

use super::plot::NARROW;
use super::plot::cut;
use super::rows::{BOTTOM, FIGURES, Frame, ROW, TOP, WIDTH};
use super::{Size, Style};
use crate::draw::{Anchor, FAINT, INK, Svg, wrapped};
use crate::draw::{Axis, short};

/// A bar, or a heading above some.
pub(crate) enum Row {
    Heading(String),
    Bar { name: String, style: Style, value: f64, interval: Option<(f64, f64)> },
}

/// Horizontal bars over a logarithmic axis; `None` where there is none to show.
pub(crate) fn bars(size: Size, title: &str, note: &str, label: &str, rows: &[Row]) -> Option<String> {
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
    let frame = match size {
        Size::Wide => Frame {
            axis,
            left: 40.0 + 6.6 * letters as f64,
            right: WIDTH - FIGURES,
            top: TOP,
            bottom: TOP + ROW * rows.len() as f64,
        },
        Size::Narrow => {
            let top = TOP + 14.0 * (wrapped(note, 54).len() - 1) as f64;
            Frame { axis, left: 16.0, right: NARROW - 16.0, top, bottom: top + rows.iter().map(tall).sum::<f64>() }
        }
    };
    let width = if size == Size::Wide { WIDTH } else { NARROW };
    let mut svg = Svg::card(width, frame.bottom + BOTTOM, title);
    svg.text((16.0, 27.0), if size == Size::Wide { 16.0 } else { 14.0 }, INK, Anchor::Start, title);
    for (k, line) in wrapped(note, if size == Size::Wide { 200 } else { 54 }).iter().enumerate() {
        svg.text((16.0, 46.0 + 14.0 * k as f64), 11.5, FAINT, Anchor::Start, line);
    }
    frame.axis(&mut svg, label);
    if size == Size::Wide {
        frame.one(&mut svg, frame.top, frame.bottom);
    }
    let mut y = frame.top;
    for row in rows {
        frame.bar_row(&mut svg, size, y, row);
        y += if size == Size::Wide { ROW } else { tall(row) };
    }
    Some(svg.finish())
}

/// Height of a row on a phone, where a bar's name and figures stand above it.
fn tall(row: &Row) -> f64 {
    if matches!(row, Row::Heading(_)) { ROW } else { 2.0 * ROW - 6.0 }
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
    fn one(&self, svg: &mut Svg, top: f64, bottom: f64) {
        let one = self.at(1.0);
        svg.line((one, top), (one, bottom), FAINT, 1.5, "");
    }

    fn bar_row(&self, svg: &mut Svg, size: Size, y: f64, row: &Row) {
        let first = y + 0.5 * ROW;
        let (name, style, value, interval) = match row {
            Row::Heading(text) => {
                svg.text((16.0, first + 5.0), 12.5, INK, Anchor::Start, text);
                return;
            }
            Row::Bar { name, style, value, interval } => (name, style, *value, *interval),
        };
        // on a phone the bar is in a line of its own, below its name
        let below = if size == Size::Wide { 0.0 } else { ROW - 6.0 };
        let (y, middle) = (y + below, first + below);
        match size {
            Size::Wide => svg.text((self.left - 10.0, middle + 4.0), 12.0, INK, Anchor::End, &cut(name)),
            Size::Narrow => svg.text((self.left, first + 6.0), 12.0, INK, Anchor::Start, &cut(name)),
        }
        if size == Size::Narrow {
            // not through the figures above
            self.one(svg, y, y + ROW);
        }
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
        match size {
            Size::Wide => svg.text((self.right + 12.0, middle + 4.0), 11.5, INK, Anchor::Start, &figures),
            Size::Narrow => svg.text((self.right, first + 6.0), 11.5, INK, Anchor::End, &figures),
        }
    }
}
