//! All tests from outside, in one binary: linking costs more than most of them.

mod agreement;
mod analytic;
mod cli;
mod common;
mod convergence;
mod determinism;
mod instances;
mod large;
mod paper;
mod persistence;
mod references;
mod report;
mod roulette;
mod scaling;
