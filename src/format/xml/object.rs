//! Objects with properties, as the reader asks for them. What it has not asked for in the end is named in a warning.

use crate::error::SourceLocation;
use crate::math::Rgb;
use crate::{Error, Result};
use glam::{DAffine3, DVec3};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Whose scene it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Dialect {
    /// Of this version.
    Mitsuba(f64),
    Nori,
}

impl Dialect {
    /// Versions of Mitsuba before 2 have other defaults.
    pub(crate) fn is_old(self) -> bool {
        matches!(self, Dialect::Mitsuba(version) if version < 2.0)
    }
}

impl Default for Dialect {
    fn default() -> Dialect {
        Dialect::Mitsuba(3.0)
    }
}

/// What a property may be.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Flag(bool),
    Number(f64),
    Text(String),
    /// What `filename` means.
    File(PathBuf),
    Vector(DVec3),
    /// Linear.
    Color(Rgb),
    Transform(DAffine3),
    Object(Rc<Object>),
    /// To the object with this id.
    Ref(String),
}

/// Something that an object says.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    /// Empty where it has none.
    pub(crate) name: String,
    pub(crate) at: SourceLocation,
    pub(crate) value: Value,
    used: Cell<bool>,
}

impl Item {
    pub(crate) fn new(name: String, at: SourceLocation, value: Value) -> Item {
        Item { name, at, value, used: Cell::new(false) }
    }
}

/// `<bsdf type="diffuse">` with all that is in it.
#[derive(Clone, Debug)]
pub(crate) struct Object {
    pub(crate) tag: String,
    pub(crate) kind: String,
    pub(crate) id: Option<String>,
    pub(crate) at: SourceLocation,
    pub(crate) items: Vec<Item>,
}

impl Object {
    pub(crate) fn new(tag: &str, kind: &str, at: SourceLocation) -> Object {
        Object { tag: tag.to_string(), kind: kind.to_string(), id: None, at, items: Vec::new() }
    }

    /// For messages.
    pub(crate) fn label(&self) -> String {
        match &self.id {
            Some(id) => format!("{} `{}` (`{id}`)", self.tag, self.kind),
            None => format!("{} `{}`", self.tag, self.kind),
        }
    }

    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        self.at.error(message)
    }

    /// The property of this name.
    pub(crate) fn find(&self, name: &str) -> Option<&Item> {
        let found = self.items.iter().rfind(|item| item.name == name)?;
        found.used.set(true);
        Some(found)
    }

    fn mismatch<T>(&self, item: &Item, wanted: &str) -> Result<T> {
        Err(item.at.error(format!("`{}` of the {} must be {wanted}", item.name, self.label())))
    }

    pub(crate) fn number(&self, name: &str, default: f64) -> Result<f64> {
        Ok(self.maybe_number(name)?.unwrap_or(default))
    }

    pub(crate) fn maybe_number(&self, name: &str) -> Result<Option<f64>> {
        match self.find(name) {
            None => Ok(None),
            Some(Item { value: Value::Number(number), .. }) => Ok(Some(*number)),
            Some(item) => self.mismatch(item, "a number"),
        }
    }

    pub(crate) fn flag(&self, name: &str, default: bool) -> Result<bool> {
        match self.find(name) {
            None => Ok(default),
            Some(Item { value: Value::Flag(flag), .. }) => Ok(*flag),
            Some(item) => self.mismatch(item, "true or false"),
        }
    }

    pub(crate) fn text(&self, name: &str) -> Result<Option<&str>> {
        match self.find(name) {
            None => Ok(None),
            Some(Item { value: Value::Text(text), .. }) => Ok(Some(text)),
            Some(item) => self.mismatch(item, "a string"),
        }
    }

    /// The file that `filename` names.
    pub(crate) fn file(&self) -> Result<&Path> {
        match self.find("filename") {
            None => Err(self.error(format!("the {} needs `filename`", self.label()))),
            Some(Item { value: Value::File(path), .. }) => Ok(path),
            Some(item) => self.mismatch(item, "a string"),
        }
    }

    pub(crate) fn vector(&self, name: &str) -> Result<Option<DVec3>> {
        match self.find(name) {
            None => Ok(None),
            Some(Item { value: Value::Vector(vector), .. }) => Ok(Some(*vector)),
            Some(item) => self.mismatch(item, "a point or a vector"),
        }
    }

    pub(crate) fn transform(&self, name: &str) -> Result<Option<DAffine3>> {
        match self.find(name) {
            None => Ok(None),
            Some(Item { value: Value::Transform(transform), .. }) => Ok(Some(*transform)),
            Some(item) => self.mismatch(item, "a transform"),
        }
    }

    /// A colour, not negative, without a picture.
    pub(crate) fn color(&self, name: &str, default: Rgb) -> Result<Rgb> {
        let Some(item) = self.find(name) else { return Ok(default) };
        let color = match item.value {
            Value::Number(grey) => Rgb::splat(grey as f32),
            Value::Color(color) => color,
            _ => return self.mismatch(item, "a colour"),
        };
        if color.min_element() >= 0.0 && color.is_finite() { Ok(color) } else { self.mismatch(item, "0 or more") }
    }

    /// Passes over what means nothing here, without a word.
    pub(crate) fn ignore(&self, names: &[&str]) {
        names.iter().for_each(|name| _ = self.find(name));
    }
}

/// A whole scene's objects.
pub(crate) struct Objects {
    pub(crate) root: Rc<Object>,
    ids: HashMap<String, Rc<Object>>,
    pub(crate) dialect: Dialect,
    warnings: RefCell<Vec<String>>,
}

impl Objects {
    pub(crate) fn new(root: Rc<Object>, ids: HashMap<String, Rc<Object>>, dialect: Dialect) -> Objects {
        Objects { root, ids, dialect, warnings: RefCell::default() }
    }

    /// As of [`Dialect::is_old`].
    pub(crate) fn is_old(&self) -> bool {
        self.dialect.is_old()
    }

    pub(crate) fn warn(&self, at: &SourceLocation, message: impl std::fmt::Display) {
        let warning = format!("{}:{}: {message}", at.path.display(), at.line);
        let mut warnings = self.warnings.borrow_mut();
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }

    pub(crate) fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner()
    }

    /// The object that an item is or refers to.
    ///
    /// # Errors
    /// An id that nothing has.
    pub(crate) fn object(&self, item: &Item) -> Result<Option<Rc<Object>>> {
        match &item.value {
            Value::Object(object) => Ok(Some(object.clone())),
            Value::Ref(id) => match self.ids.get(id) {
                Some(object) => Ok(Some(object.clone())),
                None => Err(item.at.error(format!("nothing has the id `{id}`"))),
            },
            _ => Ok(None),
        }
    }

    /// The objects of this tag that an object has, with their names.
    pub(crate) fn children(&self, of: &Object, tag: &str) -> Result<Vec<(String, Rc<Object>)>> {
        let mut found = Vec::new();
        for item in &of.items {
            if let Some(object) = self.object(item)?.filter(|object| object.tag == tag) {
                item.used.set(true);
                found.push((item.name.clone(), object));
            }
        }
        Ok(found)
    }

    /// The first object of this tag that an object has.
    pub(crate) fn child(&self, of: &Object, tag: &str) -> Result<Option<Rc<Object>>> {
        Ok(self.children(of, tag)?.into_iter().next().map(|(_, object)| object))
    }

    /// Warns of what has not been asked for.
    pub(crate) fn finish(&self, object: &Object) {
        for item in object.items.iter().filter(|item| !item.used.get()) {
            let what = match &item.value {
                Value::Object(inner) if item.name.is_empty() => format!("the {}", inner.label()),
                Value::Ref(id) if item.name.is_empty() => format!("the reference to `{id}`"),
                _ => format!("`{}`", item.name),
            };
            self.warn(&item.at, format!("{what} of the {} means nothing here", object.label()));
        }
    }
}
