//! `phototaxis keys`: what can be written in a scene file.

use crate::document::KeyInfo;
use crate::format::reference::{METHODS, Section, sections};
use anyhow::{Result, bail};
use clap::Args;
use std::fmt::Write;
use std::process::ExitCode;

#[derive(Args)]
pub(crate) struct KeysArguments {
    /// Only sections or keys with this in their name, for example guiding or exposure.
    word: Option<String>,
    /// As the tables of docs/scene-file.md.
    #[arg(long)]
    markdown: bool,
}

pub(crate) fn run(arguments: &KeysArguments) -> Result<ExitCode> {
    let word = arguments.word.as_deref().unwrap_or_default().to_lowercase();
    let print = if arguments.markdown { table } else { text };
    let found: String = sections().iter().map(|section| print(section, &word)).collect();
    if found.is_empty() {
        bail!("no section and no key of a scene file has `{word}` in its name");
    }
    super::print(found.trim_end())?;
    Ok(ExitCode::SUCCESS)
}

/// A section's heading and table; empty where `word` asks for none of its keys.
fn table(section: &Section, word: &str) -> String {
    let rows: String = asked_for(section, word).map(|info| info.row() + "\n").collect();
    let header = "| key | type | default | range | unit | meaning |\n|---|---|---|---|---|---|\n";
    if rows.is_empty() { rows } else { format!("## `{}`\n\n{header}{rows}\n", section.heading) }
}

fn asked_for<'a>(section: &'a Section, word: &'a str) -> impl Iterator<Item = &'a KeyInfo> {
    let whole = section.heading.contains(word);
    section.keys.iter().filter(move |info| whole || info.key.name.contains(word))
}

/// The keys of a section that `word` asks for, each with what may be written and what it means; empty where there are none.
fn text(section: &Section, word: &str) -> String {
    let mut lines = String::new();
    for info in asked_for(section, word) {
        let about = [info.kind.as_str(), info.range.as_str(), info.key.unit];
        let about: Vec<&str> = about.into_iter().filter(|part| !part.is_empty()).collect();
        let default = match info.default.as_str() {
            "" => String::new(),
            "required" => "; required".into(),
            default => format!("; default {default}"),
        };
        _ = writeln!(lines, "  {}: {}{default}\n      {}", info.key.name, about.join(", "), info.meaning());
        if info.key.name == "method" {
            METHODS.iter().for_each(|(name, meaning)| _ = writeln!(lines, "      {name}: {meaning}"));
        }
    }
    let heading = if lines.is_empty() { String::new() } else { format!("{}\n", section.heading) };
    (heading + &lines).replace('`', "")
}
