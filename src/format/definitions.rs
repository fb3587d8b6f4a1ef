//! `default.NAME=VALUE` among overrides: what a scene of Mitsuba calls `$NAME`, which `<default>` says where nobody does.

use crate::document::suggest::unknown;
use crate::{Error, Result};
use std::cell::Cell;

const PREFIX: &str = "default.";

/// One of them.
#[derive(Debug)]
pub(super) struct Definition {
    pub(crate) name: String,
    pub(crate) value: String,
    /// As of [`Error::Override`].
    index: usize,
    text: String,
    used: Cell<bool>,
}

/// All of them.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    pub(crate) list: Vec<Definition>,
}

impl Definition {
    pub(crate) fn use_it(&self) {
        self.used.set(true);
    }

    fn error(&self, message: impl Into<String>) -> Error {
        Error::Override { index: self.index, text: self.text.clone(), message: message.into() }
    }
}

impl Definitions {
    /// Parts them from other overrides, which are returned with their places among all.
    ///
    /// # Errors
    /// A definition without a name or a value.
    pub(crate) fn part(&mut self, overrides: &[String], first: usize) -> Result<(Vec<String>, Vec<usize>)> {
        let (mut rest, mut places) = (Vec::new(), Vec::new());
        for (index, text) in overrides.iter().enumerate() {
            let Some(said) = text.trim_start().strip_prefix(PREFIX) else {
                rest.push(text.clone());
                places.push(index);
                continue;
            };
            let (name, value) = said.split_once('=').unwrap_or((said, ""));
            let (name, value) = (name.trim().to_string(), unquoted(value.trim()).to_string());
            let definition =
                Definition { name, value, index: first + index, text: text.clone(), used: Cell::default() };
            if definition.name.is_empty() || definition.value.is_empty() {
                return Err(definition.error("expected default.NAME=VALUE, for example default.spp=64"));
            }
            self.list.push(definition);
        }
        Ok((rest, places))
    }

    /// The last one of this name.
    pub(crate) fn find(&self, name: &str) -> Option<&Definition> {
        self.list.iter().rfind(|definition| definition.name == name)
    }

    /// That each was asked for. `known` are the names that the scene has.
    ///
    /// # Errors
    /// For the first that was not.
    pub(crate) fn check_used<'a>(&self, known: impl Iterator<Item = &'a str>) -> Result<()> {
        // of several of one name the last was asked for
        let unused = |definition: &&Definition| !self.find(&definition.name).is_some_and(|last| last.used.get());
        let Some(left) = self.list.iter().find(unused) else { return Ok(()) };
        let names: Vec<&str> = known.filter(|name| self.find(name).is_none()).collect();
        let subject = format!("the scene has no `${}`", left.name);
        Err(left.error(if names.is_empty() { subject } else { unknown(&subject, &left.name, names) }))
    }
}

fn unquoted(value: &str) -> &str {
    value.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(value)
}
