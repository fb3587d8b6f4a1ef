//! The comparison's file: TOML, described in docs/compare.md, read as scene files are.

use super::gallery::{Gallery, reading};
use super::plan::{Budget, Draft, Origin, Override, SceneEntry};
use crate::Result;
use crate::document::{
    At, Bounds, Entries, Entry, Fault, Node, Reader, Source, Value, from_toml, line_and_column, read_text,
};
use crate::guiding::settings::GuidingMethod;
use std::collections::BTreeMap;
use std::path::Path;

const SECONDS: Bounds = Bounds::new(|x| x > 0.0, "greater than 0");
pub(super) const SHARE: Bounds = Bounds::new(|x| x > 0.0 && x <= 1.0, "greater than 0 and at most 1");

/// Reads a comparison's file. Paths in it are relative to its folder.
///
/// # Errors
/// [`crate::Error::Io`], and [`crate::Error::Parse`] with line and column of what is wrong; the settings of methods are looked at
/// later, with the scene.
pub fn read(path: &Path) -> Result<Draft> {
    parse(&read_text(path)?, path)
}

/// As [`read`], of text that is called `path`.
///
/// # Errors
/// As [`read`].
pub(crate) fn parse(text: &str, path: &Path) -> Result<Draft> {
    let source = Source { path, text, overrides: &[] };
    let read = |root| File { source: &source }.draft(root);
    from_toml(text, &At::Text).and_then(read).map_err(|fault| source.error(fault))
}

/// Methods by name, and their names in the file's order.
#[derive(Default)]
struct Methods {
    defined: BTreeMap<String, Vec<Override>>,
    order: Vec<String>,
}

struct File<'a> {
    source: &'a Source<'a>,
}

impl File<'_> {
    fn draft(&self, root: Node) -> Result<Draft, Fault> {
        let mut t = Reader::new("the comparison", root)?;
        let mut draft = Draft { title: string(&mut t, "title")?, ..Draft::default() };
        draft.baseline = string(&mut t, "baseline")?;
        draft.runs = optional(&mut t, "runs", |t, slot| t.integer("runs", 1..=10_000, slot))?;
        draft.seed = optional(&mut t, "seed", |t, slot| t.integer("seed", 0..=1 << 53, slot))?;
        draft.reference_noise = number(&mut t, "reference_noise", SHARE)?;
        draft.reference_time = number(&mut t, "reference_time", SECONDS)?;
        draft.budgets = budgets(&mut t)?;
        draft.overrides = t.take("set").map_or(Ok(vec![]), |n| self.overrides("set", n))?;
        draft.methods = t.take("compare").map_or(Ok(vec![]), |n| strings("compare", n))?;
        let Methods { defined, order } = t.take("methods").map_or(Ok(Methods::default()), |n| self.methods(n))?;
        if draft.methods.is_empty() {
            draft.methods = order;
        }
        draft.defined = defined;
        for node in t.take("scene").map_or(Ok(vec![]), |n| n.tables("scene"))? {
            draft.scenes.push(self.scene(node)?);
        }
        draft.gallery = gallery(&mut t, &draft)?;
        t.finish()?;
        Ok(draft)
    }

    fn scene(&self, node: Node) -> Result<SceneEntry, Fault> {
        let mut t = Reader::new("[[scene]]", node)?;
        let folder = self.source.folder();
        let scene = SceneEntry {
            path: t.require("path")?.path("path", folder)?,
            name: string(&mut t, "name")?,
            reference: t.take("reference").map(|n| n.path("reference", folder)).transpose()?,
            reference_scene: t.take("reference_scene").map(|n| n.path("reference_scene", folder)).transpose()?,
            samples: optional(&mut t, "samples", |t, slot| t.integer("samples", 1..=1 << 30, slot))?,
            overrides: t.take("set").map_or(Ok(vec![]), |n| self.overrides("set", n))?,
        };
        if let (Some(_), Some(_)) = (&scene.reference, &scene.reference_scene) {
            return Err(Fault::new(
                t.place(&["reference_scene"]),
                "`reference` and `reference_scene` exclude each other",
            ));
        }
        t.finish()?;
        Ok(scene)
    }

    /// An empty table is the built-in method of that name.
    fn methods(&self, node: Node) -> Result<Methods, Fault> {
        let (mut defined, mut order) = (BTreeMap::new(), Vec::new());
        for (name, entry) in in_order(Reader::new("[methods]", node)?.into_entries()) {
            let overrides = self.overrides(&format!("methods.{name}"), entry.node)?;
            order.push(name.clone());
            if !overrides.is_empty() {
                defined.insert(name, overrides);
            }
        }
        Ok(Methods { defined, order })
    }

    /// `"guiding.method" = "grid"`, or the same with the dot outside of quotes.
    fn overrides(&self, label: &str, node: Node) -> Result<Vec<Override>, Fault> {
        let mut all = Vec::new();
        for (key, entry) in in_order(Reader::new(format!("[{label}]"), node)?.into_entries()) {
            self.flatten(key, entry, &mut all)?;
        }
        Ok(all)
    }

    fn flatten(&self, key: String, entry: Entry, all: &mut Vec<Override>) -> Result<(), Fault> {
        if let Value::Table(entries) = entry.node.value {
            let mut inner = in_order(entries).into_iter();
            return inner.try_for_each(|(k, e)| self.flatten(format!("{key}.{}", quoted(&k)), e, all));
        }
        let value = to_toml(&key, &entry.node)?.to_string();
        all.push(Override { key, value, origin: self.origin(entry.key) });
        Ok(())
    }

    fn origin(&self, at: At) -> Origin {
        let offset = match at {
            At::Text(offset) => offset,
            At::Set(_) => 0,
        };
        let (line, column) = line_and_column(self.source.text.as_bytes(), offset);
        Origin::File { path: self.source.path.to_path_buf(), line, column }
    }
}

/// The bounds of a matrix, and sentences about the draft's scenes and methods.
fn gallery(t: &mut Reader, draft: &Draft) -> Result<Option<Gallery>, Fault> {
    let built_in = GuidingMethod::NAMES.iter().map(|(name, _)| name.to_string());
    let methods: Vec<String> = draft.defined.keys().cloned().chain(built_in).collect();
    let scenes: Vec<String> = draft.scenes.iter().map(SceneEntry::name).collect();
    reading::gallery(t.take("gallery"), t.take("why"), &scenes, &methods)
}

fn in_order(entries: Entries) -> Vec<(String, Entry)> {
    let mut all: Vec<(String, Entry)> = entries.into_iter().collect();
    all.sort_by_key(|(_, entry)| entry.key);
    all
}

/// A key as it must be written after a dot.
fn quoted(key: &str) -> String {
    let bare = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if bare { key.to_string() } else { toml::Value::String(key.to_string()).to_string() }
}

fn to_toml(key: &str, node: &Node) -> Result<toml::Value, Fault> {
    Ok(match &node.value {
        Value::Boolean(b) => toml::Value::Boolean(*b),
        Value::Integer(i) => match i64::try_from(*i) {
            Ok(i) => toml::Value::Integer(i),
            Err(_) => return Err(Fault::new(node.at, format!("`{key}` has too many digits"))),
        },
        Value::Float(x) => toml::Value::Float(*x),
        Value::String(s) => toml::Value::String(s.clone()),
        Value::Array(items) => toml::Value::Array(items.iter().map(|i| to_toml(key, i)).collect::<Result<_, _>>()?),
        Value::Null | Value::Date | Value::Table(_) => return Err(node.mismatch(key, "a value of a scene file")),
    })
}

fn string(t: &mut Reader, key: &'static str) -> Result<Option<String>, Fault> {
    t.take(key).map(|n| n.string(key).map(str::to_string)).transpose()
}

pub(super) fn strings(key: &str, node: Node) -> Result<Vec<String>, Fault> {
    match &node.value {
        Value::Array(items) => items.iter().map(|item| item.string(key).map(str::to_string)).collect(),
        _ => Err(node.mismatch(key, "an array of strings")),
    }
}

pub(super) fn number(t: &mut Reader, key: &'static str, bounds: Bounds) -> Result<Option<f64>, Fault> {
    t.take(key).map(|n| n.number(key, bounds).map(written)).transpose()
}

/// The number as people write it, without the digits that `f32` adds.
fn written(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

/// What `read` makes of the slot, where the key is there.
fn optional<T: Default>(
    t: &mut Reader,
    key: &str,
    read: impl FnOnce(&mut Reader, &mut T) -> Result<(), Fault>,
) -> Result<Option<T>, Fault> {
    let mut slot = T::default();
    read(t, &mut slot)?;
    Ok(t.has(key).then_some(slot))
}

/// `time` or `spp`, a number or several.
fn budgets(t: &mut Reader) -> Result<Vec<Budget>, Fault> {
    let several = |node: Node| match node.value {
        Value::Array(items) => items,
        _ => vec![node],
    };
    let (time, spp) = (t.take("time"), t.take("spp"));
    if let (Some(_), Some(spp)) = (&time, &spp) {
        return Err(Fault::new(spp.at, "budgets are either of `time` or of `spp`"));
    }
    let timed = time.map_or(vec![], several).into_iter().map(|n| n.number("time", SECONDS).map(written));
    let seconds: Vec<Budget> = timed.map(|s| s.map(Budget::Seconds)).collect::<Result<_, _>>()?;
    let samples = spp.map_or(vec![], several).into_iter().map(|n| samples(&n));
    Ok([seconds, samples.collect::<Result<_, _>>()?].concat())
}

fn samples(node: &Node) -> Result<Budget, Fault> {
    match node.value {
        Value::Integer(i) if (1..=1 << 30).contains(&i) => Ok(Budget::Samples(i as u32)),
        _ => Err(Fault::new(node.at, format!("`spp` must be a whole number between 1 and {}", 1 << 30))),
    }
}
