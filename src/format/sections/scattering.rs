//! The types of scattering, read from the tables of materials. They are listed in [`crate::bsdf`].

use super::fields::KeyReader;
use crate::bsdf::{BsdfDescription, BsdfType};
use crate::document::{Fault, Reader};
use crate::fields::Fields;
use std::path::Path;

pub(in crate::format) use crate::bsdf::BsdfType as Kind;

pub(in crate::format) const KINDS: &[(&str, Kind)] = Kind::NAMES;

/// The types that have a key of this name of their own.
pub(in crate::format) fn kinds_with(key: &str) -> Vec<&'static str> {
    let has = |kind: Kind| {
        let mut probe = Reader::probe();
        let read = kind.read(&mut probe, &mut kind.bsdf(), Path::new(""));
        read.is_ok()
            && (probe.asked().iter().any(|info| info.key.name == key) || key == "two_sided" && kind.is_opaque())
    };
    KINDS.iter().filter(|(_, kind)| has(*kind)).map(|(name, _)| *name).collect()
}

impl BsdfType {
    /// Reads the type's own keys over `bsdf`, which is of this type.
    pub(crate) fn read(self, t: &mut Reader, bsdf: &mut BsdfDescription, base: &Path) -> Result<(), Fault> {
        bsdf.fields(&mut KeyReader { table: t, base })
    }
}
