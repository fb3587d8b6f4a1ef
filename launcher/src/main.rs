//! `main` finds the best build for this processor, writes it to a file in memory, and lets it take the place of this
//! process (`fexecve`): arguments, environment, open files, process number and signals are the renderer's own.
//!
//! What builds there are, the environment variable MULTIVERS_BUILDS_DESCRIPTION_PATH tells while this is compiled.
#![no_main]

pub use multivers_runner::main;
