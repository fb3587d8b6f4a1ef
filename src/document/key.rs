//! A key of a document: what reads it, refuses it and documents it, in one value.

/// A key and what is to be said of it. A plain name is a key without words.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    /// Markdown for the reference page and the program's help; empty where the key is described elsewhere.
    pub(crate) meaning: &'static str,
    /// Of the number, in words; empty for none.
    pub(crate) unit: &'static str,
    /// A default that the slot does not show.
    pub(crate) default: Option<&'static str>,
    /// Whether the table is refused without it.
    pub(crate) required: bool,
    /// Where the key means nothing: what would have to be said for it to mean something.
    pub(crate) unless: Option<&'static str>,
    /// For what it is there at all; empty for everything.
    pub(crate) with: &'static str,
}

/// A key with its meaning.
pub(crate) const fn key(name: &'static str, meaning: &'static str) -> Key {
    Key { name, meaning, unit: "", default: None, required: false, unless: None, with: "" }
}

impl Key {
    pub(crate) const fn unit(self, unit: &'static str) -> Key {
        Key { unit, ..self }
    }

    /// The table is refused without this key.
    pub(crate) const fn required(self) -> Key {
        Key { required: true, default: Some("required"), ..self }
    }

    /// Without this key something else happens than any value of it would make happen.
    pub(crate) const fn optional(self) -> Key {
        Key { default: Some("none"), ..self }
    }

    /// The key means something only with `with` (`method = "sdtree"`), which `holds` or not; it is refused where it does not.
    pub(crate) const fn only(self, holds: bool, with: &'static str) -> Key {
        Key { unless: if holds { None } else { Some(with) }, with, ..self }
    }
}

impl From<&'static str> for Key {
    fn from(name: &'static str) -> Key {
        key(name, "")
    }
}

/// A line of the reference: a [`Key`] with what its reader knows of it.
#[derive(Clone, Debug)]
pub(crate) struct KeyInfo {
    pub(crate) key: Key,
    /// What may be written ("number", "`[x, y, z]`", the names of a choice).
    pub(crate) kind: String,
    pub(crate) default: String,
    pub(crate) range: String,
}
