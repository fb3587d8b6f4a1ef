//! Comparisons of methods: the same scenes and budgets, runs that take turns, and figures with intervals.
//!
//! A [`plan::Plan`] says what is compared. [`schedule::carry_out`] has a [`schedule::Executor`] make its runs, and keeps each
//! in a [`store::Store`]. [`cell::cells`] says what the runs of a cell mean together; [`results`] and [`chart`] show it,
//! [`gallery`] judges it.

pub mod bias;
pub mod cell;
pub mod chart;
pub mod executor;
pub mod file;
#[cfg(test)]
pub(crate) mod fixtures;
pub mod gallery;
pub mod measure;
pub mod memory;
pub mod plan;
pub mod record;
pub mod reference;
pub mod report;
pub mod results;
pub mod rgbe;
pub mod scene_cache;
pub mod schedule;
pub mod store;
pub mod sweep;
