//! `phototaxis farm`: one picture by many machines. What is to be done is written down as tasks with files between them; when and
//! where each runs is the business of HyperQueue or Slurm.

mod graph;
mod pace;
mod plan;
mod run;
mod scripts;

#[cfg(feature = "lab")]
pub(super) use graph::{Graph, Task};
#[cfg(feature = "lab")]
pub(super) use plan::write as write_graph;

use anyhow::Result;
use clap::Subcommand;
use std::process::ExitCode;

#[derive(Subcommand)]
pub(crate) enum FarmCommand {
    /// Write down what there is to do: plan.json, hyperqueue.toml and slurm.sh.
    Plan(plan::PlanArguments),
    /// Do it by HyperQueue, on its workers or on this machine alone.
    Run(run::RunArguments),
    /// Do one task of a plan, unless what it makes is there: what workers call.
    Task(run::TaskArguments),
}

impl FarmCommand {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        match self {
            FarmCommand::Plan(arguments) => plan::run(arguments),
            FarmCommand::Run(arguments) => run::run(arguments),
            FarmCommand::Task(arguments) => run::task(arguments),
        }
    }
}
