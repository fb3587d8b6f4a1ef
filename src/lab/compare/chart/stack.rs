//! Bars from zero, in one part or in several.

use super::plot::cut;
use super::rows::{BOTTOM, FIGURES, Frame, ROW, TOP, WIDTH};
use crate::draw::Axis;
use crate::draw::COLORS;
use crate::draw::{Anchor, FAINT, INK, Svg};

const LEGEND: f64 = 24.0;
/// Of parts beyond the list of colours.
const REST: &str = "#c3c8ce";

/// What is written about the bars.
pub(crate) struct Sheet<'a> {
    pub(crate) title: &'a str,
    pub(crate) note: &'a str,
    /// Of the axis.
    pub(crate) label: &'a str,
    /// Names of the parts; none for bars of one part.
    pub(crate) parts: &'a [&'a str],
}

/// A bar, part by part from zero; one without parts is a heading.
pub(crate) struct Stack {
    pub(crate) name: String,
    pub(crate) parts: Vec<f64>,
    /// Drawn over the end of the bar.
    pub(crate) interval: Option<(f64, f64)>,
    /// Written right of it.
    pub(crate) figures: String,
}

/// Horizontal bars over a linear axis; `None` where there is none to show.
pub(crate) fn stacks(sheet: &Sheet, rows: &[Stack]) -> Option<String> {
    let end = |row: &Stack| row.parts.iter().sum::<f64>().max(row.interval.map_or(0.0, |(_, high)| high));
    let axis = Axis::from_zero(rows.iter().map(end))?;
    let letters = rows.iter().filter(|row| !row.parts.is_empty()).map(|row| cut(&row.name).chars().count()).max()?;
    let top = TOP + if sheet.parts.is_empty() { 0.0 } else { LEGEND };
    let (left, bottom) = (40.0 + 6.6 * letters as f64, top + ROW * rows.len() as f64);
    let frame = Frame { axis, left, right: WIDTH - FIGURES, top, bottom };
    let mut svg = Svg::card(WIDTH, frame.bottom + BOTTOM, sheet.title);
    svg.text((16.0, 27.0), 16.0, INK, Anchor::Start, sheet.title);
    svg.text((16.0, 46.0), 11.5, FAINT, Anchor::Start, sheet.note);
    legend(&mut svg, sheet.parts);
    frame.axis(&mut svg, sheet.label);
    rows.iter().enumerate().for_each(|(k, row)| frame.stack_row(&mut svg, top + ROW * k as f64, row));
    Some(svg.finish())
}

fn color(part: usize) -> &'static str {
    COLORS.get(part).copied().unwrap_or(REST)
}

fn legend(svg: &mut Svg, parts: &[&str]) {
    let mut x = 16.0;
    for (k, name) in parts.iter().enumerate() {
        svg.bar((x, TOP - 6.0), (11.0, 11.0), color(k));
        svg.text((x + 16.0, TOP + 4.0), 11.5, INK, Anchor::Start, name);
        x += 32.0 + 6.2 * name.chars().count() as f64;
    }
}

impl Frame {
    fn stack_row(&self, svg: &mut Svg, y: f64, row: &Stack) {
        let middle = y + 0.5 * ROW;
        if row.parts.is_empty() {
            return svg.text((16.0, middle + 5.0), 12.5, INK, Anchor::Start, &row.name);
        }
        svg.text((self.left - 10.0, middle + 4.0), 12.0, INK, Anchor::End, &cut(&row.name));
        let mut from = 0.0;
        for (k, part) in row.parts.iter().enumerate() {
            let (a, b) = (self.at(from), self.at(from + part));
            svg.bar((a, y + 4.0), (b - a, ROW - 8.0), color(k));
            from += part;
        }
        if let Some((low, high)) = row.interval {
            svg.line((self.at(low), middle), (self.at(high), middle), INK, 1.5, "");
            for end in [low, high] {
                svg.line((self.at(end), middle - 4.0), (self.at(end), middle + 4.0), INK, 1.5, "");
            }
        }
        svg.text((WIDTH - FIGURES + 12.0, middle + 4.0), 11.5, INK, Anchor::Start, &row.figures);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, parts: &[f64], interval: Option<(f64, f64)>) -> Stack {
        Stack { name: name.into(), parts: parts.into(), interval, figures: "7".into() }
    }

    #[test]
    fn parts_lie_end_to_end_in_their_proportions() {
        let sheet = Sheet { title: "t", note: "n", label: "l", parts: &["a", "b"] };
        let svg = stacks(&sheet, &[row("heading", &[], None), row("bar", &[1.0, 3.0], Some((3.5, 4.5)))]).unwrap();
        let bars: Vec<Vec<f64>> = svg
            .lines()
            .filter(|line| line.contains("height=\"14.0\""))
            .map(|line| {
                let value = |key: &str| line.split(&format!(" {key}=\"")).nth(1)?.split('"').next()?.parse().ok();
                ["x", "width"].map(|key| value(key).unwrap()).to_vec()
            })
            .collect();
        assert_eq!(bars.len(), 2, "{svg}");
        assert!((bars[1][1] / bars[0][1] - 3.0).abs() < 0.01 && (bars[0][0] + bars[0][1] - bars[1][0]).abs() < 0.11);
        assert!(svg.contains(">heading<") && svg.contains(">7<"));
    }

    #[test]
    fn nothing_to_show_is_no_chart() {
        let sheet = Sheet { title: "t", note: "n", label: "l", parts: &[] };
        assert!(stacks(&sheet, &[]).is_none() && stacks(&sheet, &[row("only a heading", &[], None)]).is_none());
        assert!(stacks(&sheet, &[row("zero", &[0.0], None)]).is_none());
    }
}
