//! All tests from outside, in one binary: linking costs more than most of them.

#[cfg(not(feature = "lab"))]
compile_error!("the tests need the laboratory: cargo test --release --features lab, or make test");

mod agreement;
mod analytic;
mod blender;
mod cli;
mod common;
mod convergence;
mod determinism;
mod extremes;
mod instances;
mod large;
mod layers;
mod masked;
mod materials;
mod paper;
mod persistence;
mod radiance_layers;
mod references;
mod report;
mod roulette;
mod scaling;
mod screens;
mod sizes;
mod stopping;
mod textures;
