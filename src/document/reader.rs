//! Reads one table key by key. The keys that were asked for are the keys that exist: what is left over at the end is unknown,
//! and suggestions, the reference page and the program's help know the same list.

use super::key::{Key, KeyInfo};
use super::suggest::unknown;
use super::tree::{At, Entries, Entry, Fault, Node, Value};
use super::value::Bounds;
use crate::math::Rgb;
use glam::Vec3;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// A table that is being read. Methods with a slot leave it as it is where the key is absent.
pub(crate) struct Reader {
    label: String,
    at: At,
    entries: Entries,
    asked: Vec<KeyInfo>,
    /// The first required key that was asked for in vain.
    lacking: Option<&'static str>,
    /// Keys are taken where they mean nothing, too.
    lenient: bool,
    given: Vec<(&'static str, At)>,
}

impl Reader {
    /// `label` names the table in messages.
    pub(crate) fn new(label: impl Into<String>, node: Node) -> Result<Reader, Fault> {
        let label = label.into();
        match node.value {
            Value::Table(entries) => {
                Ok(Reader { label, at: node.at, entries, asked: vec![], lacking: None, lenient: false, given: vec![] })
            }
            other => Err(Fault::new(node.at, format!("{label} must be a table, found {}", other.kind()))),
        }
    }

    /// The same table, of which keys are taken where they mean nothing, too: what comes over it may give them a meaning.
    pub(crate) fn lenient(self, lenient: bool) -> Reader {
        Reader { lenient, ..self }
    }

    /// Whether it is read so.
    pub(crate) fn is_lenient(&self) -> bool {
        self.lenient
    }

    /// A table without keys, to learn which ones are asked for.
    pub(crate) fn probe() -> Reader {
        let (asked, given) = (vec![], vec![]);
        Reader {
            label: String::new(),
            at: At::Text(0),
            entries: Entries::new(),
            asked,
            lacking: None,
            lenient: false,
            given,
        }
    }

    /// The value of a key that is described elsewhere; it is known from here on.
    pub(crate) fn take(&mut self, key: &'static str) -> Option<Node> {
        self.asked.push(KeyInfo { key: key.into(), kind: String::new(), default: String::new(), range: String::new() });
        self.given(key)
    }

    fn given(&mut self, name: &'static str) -> Option<Node> {
        let node = self.entries.remove(name)?.node;
        self.given.push((name, node.at));
        Some(node)
    }

    /// The value of `key`, with what the reference says of it: what may be written, its default (unless the key says that) and
    /// its range.
    pub(crate) fn ask(
        &mut self,
        key: Key,
        kind: impl Into<String>,
        default: impl Into<String>,
        range: impl Into<String>,
    ) -> Result<Option<Node>, Fault> {
        let default = key.default.map_or_else(|| default.into(), str::to_string);
        self.asked.push(KeyInfo { key, kind: kind.into(), default, range: range.into() });
        let Some(node) = self.given(key.name) else {
            if key.required && key.unless.is_none() {
                self.lacking.get_or_insert(key.name);
            }
            return Ok(None);
        };
        match key.unless.filter(|_| !self.lenient) {
            Some(with) => Err(Fault::new(node.at, format!("`{}` in {} needs {with}", key.name, self.label))),
            None => Ok(Some(node)),
        }
    }

    /// The value of a key that must be there.
    pub(crate) fn require(&mut self, key: &'static str) -> Result<Node, Fault> {
        self.take(key).ok_or_else(|| self.missing(key))
    }

    /// That a key which was asked for is missing.
    pub(crate) fn missing(&self, key: &str) -> Fault {
        Fault::new(self.at, format!("{} needs `{key}`", self.label))
    }

    /// Whether a key that was asked for was there.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.given.iter().any(|(k, _)| *k == key)
    }

    /// Where the first of `keys` that was there is written, else the table.
    pub(crate) fn place(&self, keys: &[&str]) -> At {
        let at = |key: &&str| self.given.iter().find(|(k, _)| k == key).map(|(_, at)| *at);
        keys.iter().find_map(at).unwrap_or(self.at)
    }

    pub(crate) fn label(&self) -> &str {
        &self.label
    }

    /// The keys that have been asked for.
    pub(crate) fn asked(&self) -> &[KeyInfo] {
        &self.asked
    }

    /// The entries that nothing has asked for, in the order of the file.
    pub(crate) fn left_over(&self) -> Vec<(&str, &Entry)> {
        let mut left: Vec<(&str, &Entry)> = self.entries.iter().map(|(k, e)| (k.as_str(), e)).collect();
        left.sort_by_key(|(_, entry)| entry.key);
        left
    }

    /// All entries at once, for tables whose keys are names that the user gives.
    pub(crate) fn into_entries(self) -> Entries {
        self.entries
    }

    /// Refuses the table if a required key was asked for in vain. What is wrong with the keys that are there comes first.
    pub(crate) fn complete(&self) -> Result<(), Fault> {
        self.lacking.map_or(Ok(()), |key| Err(self.missing(key)))
    }

    /// Refuses the table if a required key is missing, and keys that nothing has asked for.
    pub(crate) fn finish(self) -> Result<(), Fault> {
        self.complete()?;
        match self.left_over().first() {
            None => Ok(()),
            Some((key, entry)) => {
                let subject = format!("unknown key `{key}` in {}", self.label);
                Err(Fault::new(entry.key, unknown(&subject, key, self.asked.iter().map(|info| info.key.name))))
            }
        }
    }

    pub(crate) fn flag(&mut self, key: impl Into<Key>, slot: &mut bool) -> Result<(), Fault> {
        let key = key.into();
        match self.ask(key, "boolean", slot.to_string(), "")? {
            None => Ok(()),
            Some(Node { value: Value::Boolean(b), .. }) => {
                *slot = b;
                Ok(())
            }
            Some(node) => Err(node.mismatch(key.name, "true or false")),
        }
    }

    pub(crate) fn number(&mut self, key: impl Into<Key>, bounds: Bounds, slot: &mut f32) -> Result<(), Fault> {
        let key = key.into();
        let node = self.ask(key, "number", slot.to_string(), bounds.range())?;
        node.map_or(Ok(()), |n| n.number(key.name, bounds).map(|x| *slot = x))
    }

    /// A whole number in `range`, which must fit into `T`.
    pub(crate) fn integer<T: TryFrom<u64> + ToString>(
        &mut self,
        key: impl Into<Key>,
        range: RangeInclusive<u64>,
        slot: &mut T,
    ) -> Result<(), Fault> {
        let (key, low, high) = (key.into(), range.start(), range.end());
        let Some(node) = self.ask(key, "integer", slot.to_string(), format!("{low} to {high}"))? else { return Ok(()) };
        let Value::Integer(i) = node.value else { return Err(node.mismatch(key.name, "an integer")) };
        let within = u64::try_from(i).ok().filter(|i| range.contains(i));
        *slot = within.and_then(|i| T::try_from(i).ok()).ok_or_else(|| {
            Fault::new(node.at, format!("`{}` must be between {low} and {high}, found {i}", key.name))
        })?;
        Ok(())
    }

    pub(crate) fn vector(&mut self, key: impl Into<Key>, bounds: Bounds, slot: &mut Vec3) -> Result<(), Fault> {
        let key = key.into();
        let node = self.ask(key, "`[x, y, z]`", slot.to_string(), bounds.range())?;
        node.map_or(Ok(()), |n| n.numbers::<3>(key.name, bounds).map(|v| *slot = v.into()))
    }

    /// A grey number or `[r, g, b]`.
    pub(crate) fn color(&mut self, key: impl Into<Key>, bounds: Bounds, slot: &mut Rgb) -> Result<(), Fault> {
        let key = key.into();
        let node = self.ask(key, "colour", shown(*slot), bounds.range())?;
        node.map_or(Ok(()), |n| n.color(key.name, bounds).map(|c| *slot = c))
    }

    /// One number for all three axes or one for each.
    pub(crate) fn factors(&mut self, key: impl Into<Key>, bounds: Bounds, slot: &mut Vec3) -> Result<(), Fault> {
        let key = key.into();
        let node = self.ask(key, "number or `[x, y, z]`", shown(*slot), bounds.range())?;
        node.map_or(Ok(()), |n| n.color(key.name, bounds).map(|v| *slot = v))
    }

    /// One of a list of names.
    pub(crate) fn choice<T: Copy + PartialEq>(
        &mut self,
        key: impl Into<Key>,
        names: &[(&str, T)],
        slot: &mut T,
    ) -> Result<(), Fault> {
        let key = key.into();
        let default =
            names.iter().find(|(_, value)| value == slot).map_or(String::new(), |(name, _)| format!("\"{name}\""));
        self.chosen_or(key, names, default).map(|chosen| *slot = chosen.unwrap_or(*slot))
    }

    /// As [`Reader::choice`]; `None` where the key is absent.
    pub(crate) fn chosen<T: Copy>(&mut self, key: impl Into<Key>, names: &[(&str, T)]) -> Result<Option<T>, Fault> {
        self.chosen_or(key.into(), names, String::new())
    }

    fn chosen_or<T: Copy>(&mut self, key: Key, names: &[(&str, T)], default: String) -> Result<Option<T>, Fault> {
        let kind: Vec<String> = names.iter().map(|(name, _)| format!("`\"{name}\"`")).collect();
        let Some(node) = self.ask(key, kind.join(", "), default, "")? else { return Ok(None) };
        self.named(key, &node, names).map(Some)
    }

    /// Several of a list of names, each once at most; or one name alone.
    pub(crate) fn choices<T: Copy + PartialEq>(
        &mut self,
        key: impl Into<Key>,
        names: &[(&str, T)],
        slot: &mut Vec<T>,
    ) -> Result<(), Fault> {
        let key = key.into();
        let kind: Vec<String> = names.iter().map(|(name, _)| format!("`\"{name}\"`")).collect();
        let Some(node) = self.ask(key, format!("array of {}", kind.join(", ")), "none", "")? else { return Ok(()) };
        slot.clear();
        let one = std::slice::from_ref(&node);
        for item in if let Value::Array(items) = &node.value { items } else { one } {
            let chosen = self.named(key, item, names)?;
            if slot.contains(&chosen) {
                return Err(Fault::new(
                    item.at,
                    format!("`{}` in {} is there twice", item.string(key.name)?, key.name),
                ));
            }
            slot.push(chosen);
        }
        Ok(())
    }

    fn named<T: Copy>(&self, key: Key, node: &Node, names: &[(&str, T)]) -> Result<T, Fault> {
        let name = node.string(key.name)?;
        let subject = format!("unknown {} `{name}` in {}", key.name, self.label);
        let known = || unknown(&subject, name, names.iter().map(|(n, _)| *n));
        let found = names.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
        found.ok_or_else(|| Fault::new(node.at, known()))
    }

    /// The name of a file, relative to the folder `base`.
    pub(crate) fn path(&mut self, key: impl Into<Key>, base: &Path) -> Result<Option<PathBuf>, Fault> {
        let key = key.into();
        self.ask(key, "string", "", "")?.map(|node| node.path(key.name, base)).transpose()
    }

    pub(crate) fn string(&mut self, key: impl Into<Key>) -> Result<Option<String>, Fault> {
        let key = key.into();
        self.ask(key, "string", "", "")?.map(|node| node.string(key.name).map(String::from)).transpose()
    }
}

/// A colour as one would write it.
fn shown(color: Rgb) -> String {
    let [r, g, b] = color.to_array();
    if r == g && g == b { r.to_string() } else { format!("[{r}, {g}, {b}]") }
}
