//! Charts of a comparison: a white card, one colour for each method in all of them. On a page their classes say what is what, so
//! that it can show them on dark paper; and each is drawn a second time, narrow, for phones.

mod bars;
mod kinds;
pub(crate) mod pdf;
mod plot;
mod rows;
mod stack;

pub(crate) use plot::{Labels, Point, Series, plot};
pub(crate) use stack::{Sheet, Stack, stacks};

use super::cell::Cell;
use super::overall::Overall;
use super::plan::Plan;
use super::store::Store;
use crate::draw::COLORS;
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
    /// The same for a screen of 375 pixels.
    pub(crate) narrow: String,
}

/// What a chart has room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    /// 760 units, the legend beside the axes.
    Wide,
    /// 343 units, what a phone has: the legend below the axes.
    Narrow,
}

/// All charts of all scenes that have runs, after those of all scenes together; those that would show nothing are left out.
pub(crate) fn charts(plan: &Plan, store: &Store, cells: &[Cell], overall: &[Overall]) -> Vec<Chart> {
    let scenes = plan.scenes.iter().enumerate();
    let of_scene = |(index, entry): (usize, &super::plan::SceneEntry)| {
        let name = entry.name();
        let own: Vec<&Cell> = cells.iter().filter(|c| c.scene == name).collect();
        kinds::of_scene(plan, store, index, &name, &own)
    };
    kinds::of_all(plan, overall).into_iter().chain(scenes.flat_map(of_scene)).collect()
}

/// How a method is drawn: a colour; where these are used up, with other dashes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Style {
    color: &'static str,
    dashes: &'static str,
}

const DASHES: [&str; 4] = ["", "6 3", "2 3", "8 3 2 3"];

/// The style of a chart's n-th method.
pub(crate) fn style(method: usize) -> Style {
    Style { color: COLORS[method % COLORS.len()], dashes: DASHES[method / COLORS.len() % DASHES.len()] }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
