//! Charts of a comparison, as SVG and PNG: a white card, so that they read the same on light and dark pages, one colour
//! for each method in all of them.

mod axis;
mod bars;
mod kinds;
mod plot;
mod raster;
mod rows;
mod stack;
mod svg;

pub(crate) use plot::{Labels, Point, Series, plot};
pub(crate) use raster::png;
pub(crate) use stack::{Sheet, Stack, stacks};

use super::cell::Cell;
use super::plan::Plan;
use super::store::Store;
use serde::Serialize;

/// One chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Chart {
    /// Unique, and fit for a file's name.
    pub(crate) id: String,
    pub(crate) scene: Option<String>,
    pub(crate) title: String,
    /// error-time, error-samples, error-memory, pareto, path-length or efficiency.
    pub(crate) kind: &'static str,
    pub(crate) svg: String,
}

/// All charts of all scenes that have runs; those that would show nothing are left out.
pub(crate) fn charts(plan: &Plan, store: &Store, cells: &[Cell]) -> Vec<Chart> {
    let scenes = plan.scenes.iter().enumerate();
    let of_scene = |(index, entry): (usize, &super::plan::SceneEntry)| {
        let name = entry.name();
        let own: Vec<&Cell> = cells.iter().filter(|c| c.scene == name).collect();
        kinds::of_scene(plan, store, index, &name, &own)
    };
    scenes.flat_map(of_scene).collect()
}

/// How a method is drawn: colours that colour-blind readers tell apart (Okabe & Ito 2008, darkened where white paper asks
/// for it); where these are used up, with other dashes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Style {
    color: &'static str,
    dashes: &'static str,
}

const COLORS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#a6448a", "#c98a00", "#56b4e9", "#333333", "#8a6f4d"];
const DASHES: [&str; 4] = ["", "6 3", "2 3", "8 3 2 3"];

/// The style of a chart's n-th method.
pub(crate) fn style(method: usize) -> Style {
    Style { color: COLORS[method % COLORS.len()], dashes: DASHES[method / COLORS.len() % DASHES.len()] }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
