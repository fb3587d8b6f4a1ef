//! Documents before they mean anything: text of TOML or JSON becomes a tree of values with their places, and a [`Reader`]
//! takes keys from its tables and refuses what is wrong at its place.

mod json;
mod key;
mod overrides;
mod reader;
mod source;
pub(crate) mod suggest;
mod tree;
mod units;
mod value;

pub(crate) use json::from_json;
pub(crate) use key::{Key, KeyInfo, key};
pub(crate) use overrides::overrides_tree;
pub(crate) use reader::Reader;
#[cfg(feature = "lab")]
pub(crate) use source::line_and_column;
pub(crate) use source::{Source, read_text};
pub(crate) use suggest::{list, nearest};
pub(crate) use tree::{At, Entries, Entry, Fault, Node, Value, from_toml};
pub(crate) use value::{Bounds, COORDINATE, FINITE, NOT_NEGATIVE, POSITIVE, UNIT};
