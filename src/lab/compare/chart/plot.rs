//! Points and lines over two axes.

use super::Style;
use super::axis::Axis;
use super::svg::{Anchor, FAINT, GRID, INK, Svg};

/// Size of a chart, and of the part of it that the axes enclose.
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 72.0;
const TOP: f64 = 62.0;
const BOTTOM: f64 = 58.0;
/// Letters of a name that the legend has room for.
const LETTERS: usize = 34;

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

/// A chart, or `None` where nothing of it can be shown. The y axis is logarithmic or linear, the x axis logarithmic.
pub(crate) fn plot(labels: &Labels, series: &[Series], logarithmic: bool) -> Option<String> {
    let points = || series.iter().flat_map(|s| &s.points);
    let x = Axis::logarithmic(points().map(|p| p.x))?;
    // An interval's end far below its point would squeeze all others.
    let end = |p: &Point| p.interval.map(|(low, high)| [low.max(p.y / 4.0), high.min(p.y * 4.0)]);
    let heights = points().flat_map(move |p| std::iter::once(p.y).chain(end(p).into_iter().flatten()));
    let heights = heights.chain(series.iter().filter_map(|s| s.level));
    let y = if logarithmic { Axis::logarithmic(heights) } else { Axis::linear(heights) }?;
    let longest = series.iter().map(|s| s.name.chars().count().min(LETTERS)).max().unwrap_or(0);
    let frame = Frame { x, y, right: WIDTH - 62.0 - 6.6 * longest as f64 };
    let height = HEIGHT.max(TOP + 20.0 + 20.0 * series.len() as f64);
    let mut svg = Svg::card(WIDTH, height, labels.title);
    frame.axes(&mut svg, labels);
    series.iter().for_each(|s| frame.band(&mut svg, s));
    series.iter().for_each(|s| frame.line(&mut svg, s));
    series.iter().enumerate().for_each(|(row, s)| frame.legend(&mut svg, row, s));
    Some(svg.finish())
}

struct Frame {
    x: Axis,
    y: Axis,
    right: f64,
}

impl Frame {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (LEFT + self.x.place(x) * (self.right - LEFT), HEIGHT - BOTTOM - self.y.place(y) * (HEIGHT - BOTTOM - TOP))
    }

    fn axes(&self, svg: &mut Svg, labels: &Labels) {
        svg.text((16.0, 27.0), 16.0, INK, Anchor::Start, labels.title);
        svg.text((16.0, 46.0), 11.5, FAINT, Anchor::Start, labels.note);
        for (value, text) in self.x.ticks() {
            let x = LEFT + self.x.place(value) * (self.right - LEFT);
            svg.line((x, TOP), (x, HEIGHT - BOTTOM), GRID, 1.0, "");
            svg.text((x, HEIGHT - BOTTOM + 17.0), 11.5, INK, Anchor::Middle, &text);
        }
        for (value, text) in self.y.ticks() {
            let y = HEIGHT - BOTTOM - self.y.place(value) * (HEIGHT - BOTTOM - TOP);
            svg.line((LEFT, y), (self.right, y), GRID, 1.0, "");
            svg.text((LEFT - 8.0, y + 4.0), 11.5, INK, Anchor::End, &text);
        }
        let corners = [(LEFT, TOP), (LEFT, HEIGHT - BOTTOM), (self.right, HEIGHT - BOTTOM)];
        svg.path(&corners, FAINT, 1.0, "");
        svg.text((0.5 * (LEFT + self.right), HEIGHT - 18.0), 12.5, INK, Anchor::Middle, labels.x);
        svg.upwards((20.0, 0.5 * (TOP + HEIGHT - BOTTOM)), 12.5, INK, labels.y);
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
            svg.line((LEFT, y), (self.right, y), color, 1.5, "5 4");
        }
        if series.joined {
            let points: Vec<(f64, f64)> = series.points.iter().map(|p| self.at(p.x, p.y)).collect();
            svg.path(&points, color, 2.0, dashes);
        }
        series.points.iter().for_each(|p| svg.disc(self.at(p.x, p.y), p.radius, color, p.hollow));
    }

    fn legend(&self, svg: &mut Svg, row: usize, series: &Series) {
        let (x, y) = (self.right + 14.0, TOP + 14.0 + 20.0 * row as f64);
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
