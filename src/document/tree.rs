//! What a text file holds before it means anything: values, each with the place where it is written.

use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where something is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum At {
    /// Byte offset in the file.
    Text(usize),
    /// Index of the command line's override.
    Set(usize),
}

/// What is wrong, and where; [`super::Source::error`] makes a [`crate::Error`] of it.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    pub(crate) at: At,
    pub(crate) message: String,
}

impl Fault {
    pub(crate) fn new(at: At, message: impl Into<String>) -> Fault {
        Fault { at, message: message.into() }
    }
}

/// A value and its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) at: At,
    pub(crate) value: Value,
}

#[derive(Clone, Debug)]
pub(crate) enum Value {
    Null,
    Boolean(bool),
    Integer(i128),
    Float(f64),
    Date,
    String(String),
    Array(Vec<Node>),
    Table(Entries),
}

/// What a table holds, by key.
pub(crate) type Entries = BTreeMap<String, Entry>;

/// A key's place and what it is set to.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: At,
    pub(crate) node: Node,
}

impl Value {
    /// With its article, for messages.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Value::Null => "null",
            Value::Boolean(_) => "a boolean",
            Value::Integer(_) => "an integer",
            Value::Float(_) => "a number with a fraction",
            Value::Date => "a date",
            Value::String(_) => "a string",
            Value::Array(_) => "an array",
            Value::Table(_) => "a table",
        }
    }
}

/// Parses a TOML document; `place` says where a byte offset of it lies.
pub(crate) fn from_toml(text: &str, place: &dyn Fn(usize) -> At) -> Result<Node, Fault> {
    let root = DeTable::parse(text).map_err(|e| {
        let offset = e.span().map_or(text.len(), |s| s.start);
        Fault::new(place(offset), e.message())
    })?;
    Ok(Node { at: place(0), value: table(root.into_inner(), place)? })
}

fn table(entries: DeTable<'_>, place: &dyn Fn(usize) -> At) -> Result<Value, Fault> {
    let mut read = Entries::new();
    for (key, value) in entries {
        let at = place(key.span().start);
        let entry = Entry { key: at, node: node(value, place)? };
        read.insert(key.into_inner().into_owned(), entry);
    }
    Ok(Value::Table(read))
}

fn node(value: Spanned<DeValue<'_>>, place: &dyn Fn(usize) -> At) -> Result<Node, Fault> {
    let at = place(value.span().start);
    let too_long = || Fault::new(at, "this number has too many digits");
    let value = match value.into_inner() {
        DeValue::String(s) => Value::String(s.into_owned()),
        DeValue::Integer(i) => {
            let integer = i128::from_str_radix(i.as_str(), i.radix());
            Value::Integer(integer.map_err(|_| too_long())?)
        }
        DeValue::Float(f) => Value::Float(f.as_str().parse().map_err(|_| too_long())?),
        DeValue::Boolean(b) => Value::Boolean(b),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Table(entries) => table(entries, place)?,
        DeValue::Array(items) => {
            Value::Array(items.into_iter().map(|item| node(item, place)).collect::<Result<_, _>>()?)
        }
    };
    Ok(Node { at, value })
}
