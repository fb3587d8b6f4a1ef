//! Points and lines over two axes.

use super::{Size, Style};
use crate::draw::Axis;
use crate::draw::{Anchor, FAINT, GRID, INK, Svg, wrapped};

/// Letters of a name that the legend has room for.
const LETTERS: usize = 34;
/// Of a chart for phones: 375 pixels less the page's margins.
pub(super) const NARROW: f64 = 343.0;

/// A point, and how sure its height is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) interval: Option<(f64, f64)>,
    pub(crate) radius: f64,
    pub(crate) hollow: bool,
}

impl Point {
    pub(crate) fn new(x: f64, y: f64, interval: Option<(f64, f64)>) -> Point {
        Point { x, y, interval, radius: 3.5, hollow: false }
    }
}

/// What is shown of one method.
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) style: Style,
    /// From left to right, where they are joined.
    pub(crate) points: Vec<Point>,
    pub(crate) joined: bool,
    /// A height that holds for all x.
    pub(crate) level: Option<f64>,
}

/// What is written around the axes.
pub(crate) struct Labels<'a> {
    pub(crate) title: &'a str,
    pub(crate) note: &'a str,
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
}

/// Where the parts of a chart are, in units of the SVG.
struct Layout {
    width: f64,
    /// Of the axes' ends.
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    /// Upper left corner of the legend.
    legend: (f64, f64),
    height: f64,
    title: f64,
    /// Lines of the title and of the note.
    lines: (Vec<String>, Vec<String>),
}

impl Layout {
    fn new(size: Size, labels: &Labels, series: &[Series]) -> Layout {
        let longest = series.iter().map(|s| cut(&s.name).chars().count()).max().unwrap_or(0) as f64;
        let rows = 20.0 * series.len() as f64;
        match size {
            Size::Wide => {
                let right = 760.0 - 62.0 - 6.6 * longest;
                let lines = (vec![labels.title.into()], vec![labels.note.into()]);
                let (top, bottom) = (62.0, 382.0);
                let (legend, height) = ((right + 14.0, top + 14.0), 440f64.max(top + 20.0 + rows));
                Layout { width: 760.0, left: 72.0, right, top, bottom, legend, height, title: 16.0, lines }
            }
            Size::Narrow => {
                let lines = (wrapped(labels.title, 40), wrapped(labels.note, 54));
                let top = 30.0 + 18.0 * lines.0.len() as f64 + 14.0 * lines.1.len() as f64;
                let bottom = top + 240.0;
                let legend = (16.0, bottom + 66.0);
                let height = legend.1 + rows;
                Layout {
                    width: NARROW,
                    left: 62.0,
                    right: NARROW - 14.0,
                    top,
                    bottom,
                    legend,
                    height,
                    title: 14.0,
                    lines,
                }
            }
        }
    }

    /// Title and note.
    fn head(&self, svg: &mut Svg) {
        let mut y = 10.0;
        for line in &self.lines.0 {
            y += self.title + 1.0;
            svg.text((16.0, y), self.title, INK, Anchor::Start, line);
        }
        y += 5.0;
        for line in &self.lines.1 {
            y += 14.0;
            svg.text((16.0, y), 11.5, FAINT, Anchor::Start, line);
        }
    }
}

/// A chart, or `None` where nothing of it can be shown. The y axis is logarithmic or linear, the x axis logarithmic.
pub(crate) fn plot(size: Size, labels: &Labels, series: &[Series], logarithmic: bool) -> Option<String> {
    let points = || series.iter().flat_map(|s| &s.points);
    let x = Axis::logarithmic(points().map(|p| p.x))?;
    // An interval's end far below its point would squeeze all others.
    let end = |p: &Point| p.interval.map(|(low, high)| [low.max(p.y / 4.0), high.min(p.y * 4.0)]);
    let heights = points().flat_map(move |p| std::iter::once(p.y).chain(end(p).into_iter().flatten()));
    let heights = heights.chain(series.iter().filter_map(|s| s.level));
    let y = if logarithmic { Axis::logarithmic(heights) } else { Axis::linear(heights) }?;
    let frame = Frame { x, y, layout: Layout::new(size, labels, series) };
    let mut svg = Svg::card(frame.layout.width, frame.layout.height, labels.title);
    frame.layout.head(&mut svg);
    frame.axes(&mut svg, labels);
    series.iter().for_each(|s| frame.band(&mut svg, s));
    series.iter().for_each(|s| frame.line(&mut svg, s));
    series.iter().enumerate().for_each(|(row, s)| frame.legend(&mut svg, row, s));
    Some(svg.finish())
}

struct Frame {
    x: Axis,
    y: Axis,
    layout: Layout,
}

impl Frame {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let Layout { left, right, top, bottom, .. } = self.layout;
        (left + self.x.place(x) * (right - left), bottom - self.y.place(y) * (bottom - top))
    }

    fn axes(&self, svg: &mut Svg, labels: &Labels) {
        let Layout { left, right, top, bottom, .. } = self.layout;
        for (value, text) in self.x.ticks() {
            let x = left + self.x.place(value) * (right - left);
            svg.line((x, top), (x, bottom), GRID, 1.0, "");
            svg.text((x, bottom + 17.0), 11.5, INK, Anchor::Middle, &text);
        }
        for (value, text) in self.y.ticks() {
            let y = bottom - self.y.place(value) * (bottom - top);
            svg.line((left, y), (right, y), GRID, 1.0, "");
            svg.text((left - 8.0, y + 4.0), 11.5, INK, Anchor::End, &text);
        }
        svg.path(&[(left, top), (left, bottom), (right, bottom)], FAINT, 1.0, "");
        svg.text((0.5 * (left + right), bottom + 40.0), 12.5, INK, Anchor::Middle, labels.x);
        svg.upwards((left - 46.0, 0.5 * (top + bottom)), 12.5, INK, labels.y);
    }

    /// How sure a line is; of a single point, a stroke through it.
    fn band(&self, svg: &mut Svg, series: &Series) {
        let sure: Vec<(f64, f64, f64)> =
            series.points.iter().filter_map(|p| p.interval.map(|(low, high)| (p.x, low, high))).collect();
        if series.joined && sure.len() > 1 {
            let upper = sure.iter().map(|&(x, _, high)| self.at(x, high));
            let lower = sure.iter().rev().map(|&(x, low, _)| self.at(x, low));
            svg.area(&upper.chain(lower).collect::<Vec<_>>(), series.style.color, 0.14);
        } else {
            for (x, low, high) in sure {
                svg.line(self.at(x, low), self.at(x, high), series.style.color, 1.5, "");
            }
        }
    }

    fn line(&self, svg: &mut Svg, series: &Series) {
        let Style { color, dashes } = series.style;
        if let Some(level) = series.level {
            let (_, y) = self.at(1.0, level);
            svg.line((self.layout.left, y), (self.layout.right, y), color, 1.5, "5 4");
        }
        if series.joined {
            let points: Vec<(f64, f64)> = series.points.iter().map(|p| self.at(p.x, p.y)).collect();
            svg.path(&points, color, 2.0, dashes);
        }
        series.points.iter().for_each(|p| svg.disc(self.at(p.x, p.y), p.radius, color, p.hollow));
    }

    fn legend(&self, svg: &mut Svg, row: usize, series: &Series) {
        let (x, y) = (self.layout.legend.0, self.layout.legend.1 + 20.0 * row as f64);
        let Style { color, dashes } = series.style;
        let dashes = if series.level.is_some() { "5 4" } else { dashes };
        if series.joined || series.level.is_some() {
            svg.line((x, y), (x + 22.0, y), color, 2.0, dashes);
        }
        if !series.points.is_empty() {
            svg.disc((x + 11.0, y), 3.5, color, false);
        }
        svg.text((x + 29.0, y + 4.0), 12.0, INK, Anchor::Start, &cut(&series.name));
    }
}

/// A name that fits into the legend.
pub(crate) fn cut(name: &str) -> String {
    if name.chars().count() <= LETTERS {
        return name.to_string();
    }
    name.chars().take(LETTERS - 1).chain(['…']).collect()
}
