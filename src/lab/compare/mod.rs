//! Comparisons of methods: the same scenes and budgets, runs that take turns, and figures with intervals.
//!
//! A [`plan::Plan`] says what is compared. [`schedule::carry_out`] has a [`schedule::Executor`] make its runs, and keeps each
//! in a [`store::Store`]. [`cell::cells`] says what the runs of a cell mean together; [`results`] and [`chart`] show it,
//! [`gallery`] judges it.

pub(crate) mod bias;
pub(crate) mod cell;
pub(crate) mod chart;
pub(crate) mod executor;
pub mod file;
#[cfg(test)]
pub(crate) mod fixtures;
pub(crate) mod forecast;
pub(crate) mod gallery;
pub(crate) mod likeness;
pub(crate) mod measure;
pub(crate) mod memory;
pub(crate) mod overall;
pub(crate) mod plan;
pub(crate) mod record;
pub(crate) mod reference;
pub mod report;
pub(crate) mod results;
pub(crate) mod rgbe;
pub(crate) mod scene_cache;
pub(crate) mod schedule;
pub mod store;
pub(crate) mod sweep;
pub(crate) mod tables;
