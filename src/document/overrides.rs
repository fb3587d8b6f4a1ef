//! `key=value` from the command line, read like a scene file with one key.

use super::tree::{At, Entries, Fault, Node, Value, from_toml};
use std::collections::btree_map::Entry as Slot;

/// All overrides as one tree; of two for the same key, the later counts.
pub(crate) fn overrides_tree(overrides: &[String]) -> Result<Node, Fault> {
    let mut all = Node { at: At::Set(0), value: Value::Table(Entries::new()) };
    for (index, text) in overrides.iter().enumerate() {
        merge(&mut all, one(text, At::Set(index))?);
    }
    Ok(all)
}

fn one(text: &str, at: At) -> Result<Node, Fault> {
    let shape = || Fault::new(at, "expected key=value, for example film.width=640");
    let (key, value) = split(text).ok_or_else(shape)?;
    if text.contains(['\n', '\r']) || value.is_empty() {
        return Err(shape());
    }
    let read = from_toml(text, &|_| at);
    if read.is_err() && is_bare(value) {
        return from_toml(&format!("{key} = \"{value}\""), &|_| at);
    }
    read
}

/// Key and value, parted at the first equals sign outside of quotes.
fn split(text: &str) -> Option<(&str, &str)> {
    let mut quote = None;
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (None, '=') => return Some((text[..i].trim(), text[i + 1..].trim())),
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), _) if open == c => quote = None,
            _ => (),
        }
    }
    None
}

/// Text that needs no quotes: it has nothing of a TOML string, array, table or comment.
fn is_bare(value: &str) -> bool {
    !value.contains(|c: char| "\"'[]{}=,#\\".contains(c) || c.is_control())
}

fn merge(into: &mut Node, from: Node) {
    match (&mut into.value, from.value) {
        (Value::Table(to), Value::Table(entries)) => {
            for (key, entry) in entries {
                match to.entry(key) {
                    Slot::Occupied(mut slot) => merge(&mut slot.get_mut().node, entry.node),
                    Slot::Vacant(slot) => {
                        slot.insert(entry);
                    }
                }
            }
        }
        (to, value) => {
            *to = value;
            into.at = from.at;
        }
    }
}
