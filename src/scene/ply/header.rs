//! What the text at the beginning of a PLY file says of the rest.

use crate::{Error, Result};
use std::path::Path;

/// Headers are shorter than this; what has no end by then is none.
pub(super) const LONGEST: usize = 1 << 20;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    const NAMES: [(&'static str, Kind); 16] = [
        ("char", Kind::I8),
        ("int8", Kind::I8),
        ("uchar", Kind::U8),
        ("uint8", Kind::U8),
        ("short", Kind::I16),
        ("int16", Kind::I16),
        ("ushort", Kind::U16),
        ("uint16", Kind::U16),
        ("int", Kind::I32),
        ("int32", Kind::I32),
        ("uint", Kind::U32),
        ("uint32", Kind::U32),
        ("float", Kind::F32),
        ("float32", Kind::F32),
        ("double", Kind::F64),
        ("float64", Kind::F64),
    ];

    /// In a binary file.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }

    pub(crate) fn is_whole(self) -> bool {
        !matches!(self, Kind::F32 | Kind::F64)
    }

    fn named(name: &str) -> Result<Kind, String> {
        let found = Kind::NAMES.iter().find(|(known, _)| *known == name);
        found.map(|(_, kind)| *kind).ok_or_else(|| format!("unknown type `{name}`"))
    }
}

/// A number of each thing of an element, or a list of numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// Of a list: the type of its length.
    pub(crate) length: Option<Kind>,
}

/// Things of one kind: vertices, faces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub(crate) name: String,
    pub(crate) count: usize,
    pub(crate) properties: Vec<Property>,
}

/// A header that was understood.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(crate) encoding: Encoding,
    pub(crate) elements: Vec<Element>,
    /// The picture that a comment names (MeshLab, OpenMVS).
    pub(crate) texture: Option<String>,
    /// Where the rest begins, in bytes and in lines.
    pub(crate) end: usize,
    pub(crate) lines: usize,
}

impl Header {
    /// Whether it can be tried to find faces without looking at all lists: they are the only ones, but for those of vertices.
    pub(crate) fn may_be_even(&self) -> bool {
        let at = |name: &str| self.elements.iter().position(|element| element.name == name);
        self.encoding != Encoding::Ascii && at("vertex").zip(at("face")).is_some_and(|(vertex, face)| vertex < face)
    }
}

/// Reads the header at the beginning of `bytes`.
///
/// # Errors
/// With the line that is wrong.
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Header> {
    let mut lines =
        Lines::new(bytes).ok_or_else(|| Error::parse(path, 1, 0, "not a PLY file: it must begin with `ply`"))?;
    let mut draft = Draft::default();
    loop {
        let fault = |lines: &Lines, message: String| Error::parse(path, lines.number, 0, message);
        let Some(line) = lines.next() else {
            return Err(fault(&lines, "the header has no end: `end_header` is missing".into()));
        };
        let Ok(line) = std::str::from_utf8(line) else {
            // comments may be in any encoding
            if line.starts_with(b"comment") || line.starts_with(b"obj_info") {
                continue;
            }
            return Err(fault(&lines, "this line of the header is not text".into()));
        };
        if line.trim() == "end_header" {
            let header = draft.finish(lines.at, lines.number).map_err(|message| fault(&lines, message))?;
            return Ok(header);
        }
        draft.line(line).map_err(|message| fault(&lines, message))?;
    }
}

/// The lines of a header, which end as its first one does.
struct Lines<'a> {
    bytes: &'a [u8],
    ending: &'static [u8],
    at: usize,
    /// Of the line that was given last, from 1.
    number: usize,
}

impl<'a> Lines<'a> {
    /// Those after `ply`; `None` where that is not the first.
    fn new(bytes: &'a [u8]) -> Option<Lines<'a>> {
        let rest = bytes.strip_prefix(b"ply")?;
        let endings: [&[u8]; 3] = [b"\r\n", b"\n", b"\r"];
        let ending = endings.into_iter().find(|ending| rest.starts_with(ending))?;
        Some(Lines { bytes: &bytes[..bytes.len().min(LONGEST)], ending, at: 3 + ending.len(), number: 1 })
    }

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let length = memchr::memmem::find(rest, self.ending)?;
        self.at += length + self.ending.len();
        self.number += 1;
        Some(&rest[..length])
    }
}

/// What the lines so far say.
#[derive(Default)]
struct Draft {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    texture: Option<String>,
}

impl Draft {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            [] | ["obj_info", ..] => (),
            ["comment", "TextureFile", ..] => {
                let name = line.split_once("TextureFile").map_or("", |(_, name)| name.trim());
                self.texture.get_or_insert(name.to_string());
            }
            ["comment", ..] => (),
            ["format", encoding, version] => self.format(encoding, version)?,
            ["element", name, count] => {
                let count = count.parse().map_err(|_| format!("`{count}` is not a number of elements"))?;
                if self.elements.iter().any(|element| element.name == name) {
                    return Err(format!("there are two elements `{name}`"));
                }
                self.elements.push(Element { name: name.to_string(), count, properties: Vec::new() });
            }
            ["property", "list", length, kind, name] => {
                let length = Kind::named(length)?;
                if !length.is_whole() {
                    return Err(format!("the length of the list `{name}` must be a whole number"));
                }
                self.property(Property { name: name.to_string(), kind: Kind::named(kind)?, length: Some(length) })?;
            }
            ["property", kind, name] => {
                self.property(Property { name: name.to_string(), kind: Kind::named(kind)?, length: None })?;
            }
            _ => return Err(format!("`{}` is no line of a header", line.trim().chars().take(40).collect::<String>())),
        }
        Ok(())
    }

    fn format(&mut self, encoding: &str, version: &str) -> Result<(), String> {
        let known = match encoding {
            "ascii" => Encoding::Ascii,
            "binary_little_endian" => Encoding::LittleEndian,
            "binary_big_endian" => Encoding::BigEndian,
            _ => return Err(format!("unknown format `{encoding}`")),
        };
        if version != "1.0" {
            return Err(format!("version {version} of the format is not known: there is 1.0"));
        }
        self.encoding = Some(known);
        Ok(())
    }

    fn property(&mut self, property: Property) -> Result<(), String> {
        let Some(element) = self.elements.last_mut() else {
            return Err(format!("the property `{}` belongs to no element", property.name));
        };
        if element.properties.iter().any(|known| known.name == property.name) {
            return Err(format!("there are two properties `{}` of `{}`", property.name, element.name));
        }
        element.properties.push(property);
        Ok(())
    }

    fn finish(self, end: usize, lines: usize) -> Result<Header, String> {
        let encoding = self.encoding.ok_or("the header does not say its `format`")?;
        Ok(Header { encoding, elements: self.elements, texture: self.texture, end, lines })
    }
}
