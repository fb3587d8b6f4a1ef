//! `key=value` from the command line, read like a scene file with one key.

use super::tree::{At, Entries, Entry, Fault, Node, Value, from_toml};
use std::collections::btree_map::Entry as Slot;

/// All overrides as one tree; of two for the same key, the later counts.
pub(super) fn tree(overrides: &[String]) -> Result<Node, Fault> {
    let mut all = Node { at: At::Set(0), value: Value::Table(Entries::new()) };
    for (index, text) in overrides.iter().enumerate() {
        merge(&mut all, one(text, At::Set(index))?);
    }
    Ok(all)
}

fn one(text: &str, at: At) -> Result<Node, Fault> {
    let shape = || Fault::new(at, "expected key=value, for example film.width=640");
    if text.contains(['\n', '\r']) {
        return Err(shape());
    }
    let (key, value) = text.split_once('=').ok_or_else(shape)?;
    let read = from_toml(text, &|_| at);
    if read.is_err() && is_bare(value) {
        return from_toml(&format!("{key} = \"{}\"", value.trim()), &|_| at);
    }
    read
}

/// Text that needs no quotes: it has nothing of a TOML string, array, table or comment.
fn is_bare(value: &str) -> bool {
    !value.trim().is_empty()
        && !value.contains(|c: char| "\"'[]{}=,#\\".contains(c) || c.is_control())
}

fn merge(into: &mut Node, from: Node) {
    let (Value::Table(to), Value::Table(entries)) = (&mut into.value, &from.value) else {
        *into = from;
        return;
    };
    for (key, entry) in entries.clone() {
        match to.entry(key) {
            Slot::Vacant(slot) => {
                slot.insert(entry);
            }
            Slot::Occupied(mut slot) => {
                let Entry { node, .. } = slot.get_mut();
                merge(node, entry.node);
            }
        }
    }
}
