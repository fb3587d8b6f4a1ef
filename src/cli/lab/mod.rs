//! The laboratory's subcommands.

mod bench;
mod compare;
mod figures;
mod generate;
mod paper;
mod rates;

use clap::Subcommand;
use std::process::ExitCode;

#[derive(Subcommand)]
pub(crate) enum LabCommand {
    /// Measure this program here: its rays against Embree alone, what its time goes into, loading, a rival.
    Bench(bench::BenchArguments),
    /// Compare methods: error against time, with intervals, over several runs.
    Compare(Box<compare::CompareArguments>),
    /// Render the pictures of Tan's paper on the project's own scenes, with a table of what they cost.
    Paper(paper::PaperArguments),
    /// Chart how near each learning rule and rate comes to a light field that is known, by visits.
    Rates(rates::RatesArguments),
    /// Make every picture, chart and table of the documentation anew.
    Figures(figures::FiguresArguments),
    /// Write the project's own scenes.
    Generate(generate::GenerateArguments),
}

impl LabCommand {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        match self {
            LabCommand::Bench(arguments) => bench::run(arguments),
            LabCommand::Compare(arguments) => compare::run(arguments),
            LabCommand::Paper(arguments) => paper::run(arguments),
            LabCommand::Rates(arguments) => rates::run(arguments),
            LabCommand::Figures(arguments) => figures::run(arguments),
            LabCommand::Generate(arguments) => generate::run(arguments),
        }
    }
}
