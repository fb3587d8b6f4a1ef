//! The kinds of charts, scene by scene.

use super::bars::{Row, bars};
use super::plot::{Labels, Point, Series, plot};
use super::{Chart, Size, style};
use crate::lab::compare::cell::{Cell, Mean};
use crate::lab::compare::overall::Overall;
use crate::lab::compare::plan::{Plan, file_stem};
use crate::lab::compare::record::Run;
use crate::lab::compare::schedule::order;
use crate::lab::compare::store::Store;

const ERROR: &str = "relMSE (all pixels)";
const BAND: &str = "Means over runs; bands and strokes: 95 % intervals (Student's t of the logarithm)";
/// Rows of bars that a chart shows at most before it keeps to the largest budget.
const MOST_ROWS: usize = 48;

pub(super) fn of_scene(plan: &Plan, store: &Store, index: usize, name: &str, cells: &[&Cell]) -> Vec<Chart> {
    let view = View { plan, cells };
    let lengths = path_lengths(plan, store, index);
    let kinds = [
        ("error-time", "Error against time", view.error(|c| c.wall_seconds, "Wall time [s], learning included")),
        ("error-samples", "Error against samples", view.error(|c| c.samples, "Samples per pixel")),
        ("error-memory", "Error against the guide's memory", view.memory()),
        ("pareto", "Error, time and memory", view.pareto()),
        ("path-length", "Path length by iteration", lengths),
        ("efficiency", "Efficiency", view.efficiency()),
    ];
    let chart = |(kind, title, draw): (&'static str, &str, Draw)| {
        let title = format!("{title}: {name}");
        let (svg, narrow) = (draw(&title, Size::Wide)?, draw(&title, Size::Narrow)?);
        Some(Chart { id: format!("{kind}-{}", file_stem(name)), scene: Some(name.into()), title, kind, svg, narrow })
    };
    kinds.into_iter().filter_map(chart).collect()
}

/// The chart of all scenes together, where there are two or more.
pub(super) fn of_all(plan: &Plan, overall: &[Overall]) -> Option<Chart> {
    let mut rows = Vec::new();
    for budget in plan.budgets.iter().map(|budget| budget.name()) {
        let here = overall.iter().filter(|o| o.budget == budget && o.ratio.scenes > 1);
        let bars: Vec<Row> = here.filter_map(|o| mean_bar(plan, o)).collect();
        if !bars.is_empty() {
            rows.push(Row::Heading(budget));
            rows.extend(bars);
        }
    }
    let title = "Efficiency: geometric means over scenes".to_string();
    let note = "Strokes: 95 % intervals by the runs' spread, for these scenes";
    let label = format!("1 / (relMSE · seconds), that of {} = 1", plan.methods[plan.baseline].name);
    let draw = |size| bars(size, &title, note, &label, &rows);
    let (svg, narrow) = (draw(Size::Wide)?, draw(Size::Narrow)?);
    Some(Chart { id: "efficiency-all".into(), scene: None, title, kind: "efficiency", svg, narrow })
}

fn mean_bar(plan: &Plan, overall: &Overall) -> Option<Row> {
    let method = plan.methods.iter().position(|m| m.name == overall.method)?;
    let r = overall.ratio.ratio;
    let interval = r.low.zip(r.high);
    Some(Row::Bar { name: overall.method.clone(), style: style(method), value: r.value?, interval })
}

/// Draws a chart with the title it is given, where there is something to see.
type Draw<'a> = Box<dyn Fn(&str, Size) -> Option<String> + 'a>;

struct View<'a> {
    plan: &'a Plan,
    cells: &'a [&'a Cell],
}

impl<'a> View<'a> {
    /// The cells of each method, from the smallest budget to the largest.
    fn by_method(&self) -> impl Iterator<Item = (usize, &'a str, Vec<&'a Cell>)> + '_ {
        self.plan.methods.iter().enumerate().map(|(k, method)| {
            let own = self.cells.iter().copied().filter(|c| c.method == method.name).collect();
            (k, method.name.as_str(), own)
        })
    }

    fn series(&self, point: impl Fn(&Cell) -> Option<Point>, joined: bool) -> Vec<Series> {
        let of_method = |(k, name, own): (usize, &str, Vec<&Cell>)| Series {
            name: name.into(),
            style: style(k),
            points: own.into_iter().filter_map(&point).collect(),
            joined,
            level: None,
        };
        self.by_method().map(of_method).filter(|s| !s.points.is_empty()).collect()
    }

    fn error(&self, x: fn(&Cell) -> Mean, label: &'a str) -> Draw<'a> {
        let series = self.series(|c| Some(Point::new(x(c).mean?, positive(c.relmse)?, ends(c.relmse))), true);
        Box::new(move |title, size| plot(size, &Labels { title, note: BAND, x: label, y: ERROR }, &series, true))
    }

    /// Methods without a guide are a level line, at the error of their largest budget.
    fn memory(&self) -> Draw<'a> {
        let guided = |c: &Cell| c.guide_bytes.mean.filter(|b| *b > 0.0);
        let point = |c: &Cell| Some(Point::new(guided(c)? / 1048576.0, positive(c.relmse)?, ends(c.relmse)));
        let mut series = self.series(point, true);
        for (k, name, own) in self.by_method() {
            let last = own.last().filter(|c| c.guide_bytes.mean == Some(0.0)).and_then(|c| positive(c.relmse));
            if let Some(level) = last {
                let name = format!("{name} (no memory)");
                series.push(Series { name, style: style(k), points: vec![], joined: false, level: Some(level) });
            }
        }
        let note = "Points of a method: its budgets, the largest last; dashed level: no guide, at the largest budget";
        Box::new(move |title, size| {
            plot(size, &Labels { title, note, x: "Memory of the guide [MiB]", y: ERROR }, &series, true)
        })
    }

    /// A cell is on the front if no other is at least as good in error, time and memory, and better in one of them.
    fn pareto(&self) -> Draw<'a> {
        let costs = |c: &Cell| Some([positive(c.relmse)?, c.wall_seconds.mean?, c.guide_bytes.mean?]);
        let all: Vec<[f64; 3]> = self.cells.iter().filter_map(|c| costs(c)).collect();
        let largest = all.iter().map(|c| c[2]).fold(1.0, f64::max);
        let point = |c: &Cell| {
            let own = costs(c)?;
            let radius = 3.5 + 8.0 * (own[2] / largest).sqrt();
            let hollow = all.iter().any(|other| dominates(other, &own));
            Some(Point { radius, hollow, ..Point::new(own[1], own[0], None) })
        };
        let series = self.series(point, false);
        let mib = largest / 1048576.0;
        let note = format!(
            "Filled: on the Pareto front of all three; size of discs: the guide's memory, the largest {mib:.2} MiB"
        );
        Box::new(move |title, size| {
            plot(size, &Labels { title, note: &note, x: "Wall time [s], learning included", y: ERROR }, &series, true)
        })
    }

    fn efficiency(&self) -> Draw<'a> {
        let budgets: Vec<String> = self.plan.budgets.iter().map(|b| b.name()).collect();
        let many = budgets.len() * (self.plan.methods.len() + 1) > MOST_ROWS;
        let mut rows = Vec::new();
        for budget in &budgets[if many { budgets.len() - 1 } else { 0 }..] {
            let bars: Vec<Row> = self
                .by_method()
                .flat_map(|(k, _, own)| own.into_iter().filter_map(move |c| bar(k, c)))
                .filter_map(|(of, row)| (of == *budget).then_some(row))
                .collect();
            if !bars.is_empty() {
                rows.push(Row::Heading(budget.clone()));
                rows.extend(bars);
            }
        }
        let baseline = &self.plan.methods[self.plan.baseline].name;
        let label = format!("1 / (relMSE · seconds), that of {baseline} = 1");
        Box::new(move |title, size| {
            bars(size, title, "Ratios of means over runs; strokes: 95 % intervals", &label, &rows)
        })
    }
}

fn bar(method: usize, cell: &Cell) -> Option<(&str, Row)> {
    let ratio = cell.ratio;
    let row = Row::Bar {
        name: cell.method.clone(),
        style: style(method),
        value: ratio.value?,
        interval: ratio.low.zip(ratio.high).filter(|(low, high)| low < high),
    };
    Some((&cell.budget, row))
}

/// Segments of a path in each iteration of the runs at the largest budget, over the samples until its end.
fn path_lengths<'a>(plan: &'a Plan, store: &'a Store, scene: usize) -> Draw<'a> {
    let runs_of = |method: usize| -> Vec<&Run> {
        let slots = order(plan).into_iter().filter(move |s| (s.scene, s.method) == (scene, method));
        slots.filter(|s| s.budget == plan.budgets.len() - 1).filter_map(|s| store.find(plan, &s)).collect()
    };
    let series: Vec<Series> = (0..plan.methods.len())
        .map(|k| Series {
            name: plan.methods[k].name.clone(),
            style: style(k),
            points: iteration_points(&runs_of(k)),
            joined: true,
            level: None,
        })
        .filter(|s| !s.points.is_empty())
        .collect();
    let (x, y) = ("Samples per pixel so far", "Segments of a camera path");
    Box::new(move |title, size| plot(size, &Labels { title, note: BAND, x, y }, &series, false))
}

/// Iterations that all runs have.
fn iteration_points(runs: &[&Run]) -> Vec<Point> {
    let count = runs.iter().map(|r| r.iterations.len()).min().unwrap_or(0);
    let point = |k: usize| {
        let so_far = |r: &&Run| r.iterations[..=k].iter().map(|i| f64::from(i.samples)).sum::<f64>();
        let x = runs.iter().map(so_far).sum::<f64>() / runs.len() as f64;
        let lengths: Vec<f64> = runs.iter().map(|r| r.iterations[k].mean_path_length).collect();
        let mean = Mean::of(&lengths);
        Some(Point::new(x, mean.mean?, ends(mean)))
    };
    (0..count).filter_map(point).collect()
}

fn dominates(a: &[f64; 3], b: &[f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

fn positive(mean: Mean) -> Option<f64> {
    mean.mean.filter(|m| *m > 0.0)
}

fn ends(mean: Mean) -> Option<(f64, f64)> {
    mean.interval().map(|i| (i.low, i.high))
}
