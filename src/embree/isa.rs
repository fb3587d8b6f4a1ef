//! Instruction sets that Embree may use.

use crate::{Error, Result};
use std::str::FromStr;
use std::sync::OnceLock;

/// The environment variable that names the instruction set of devices that are not told one.
pub const ISA_VARIABLE: &str = "PHOTOTAXIS_ISA";

/// An instruction set that Embree can be held to: it then uses this one and smaller ones, whatever the processor has.
///
/// Pictures differ between instruction sets in their last bits, and so in their noise: Embree tests triangles in another
/// order and with other roundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Isa {
    Sse42,
    Avx,
    Avx2,
    Avx512,
}

/// Of the whole process; empty until it is chosen.
static CHOSEN: OnceLock<Isa> = OnceLock::new();

impl Isa {
    /// From the smallest to the largest.
    pub const ALL: [Isa; 4] = [Isa::Sse42, Isa::Avx, Isa::Avx2, Isa::Avx512];

    /// As Embree's own setting `max_isa` has it.
    pub fn name(self) -> &'static str {
        match self {
            Isa::Sse42 => "sse4.2",
            Isa::Avx => "avx",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }

    /// Those that this processor has, from the smallest to the largest; none where it is no x86-64.
    pub fn available() -> impl Iterator<Item = Isa> {
        Isa::ALL.into_iter().filter(|isa| isa.is_there())
    }

    /// Holds all devices of this process that are made from now on. Only the first call counts.
    pub(crate) fn choose(self) {
        CHOSEN.get_or_init(|| self);
    }

    /// What devices are held to: what was chosen, else what the environment variable says, else nothing.
    ///
    /// # Errors
    /// A variable that names no instruction set, or one that this processor lacks.
    pub(crate) fn chosen() -> Result<Option<Isa>> {
        if let Some(isa) = CHOSEN.get() {
            return Ok(Some(*isa));
        }
        let Some(value) = std::env::var_os(ISA_VARIABLE) else { return Ok(None) };
        let isa = value.to_string_lossy().parse().map_err(|why| Error::Embree(format!("{ISA_VARIABLE}: {why}")))?;
        Ok(Some(isa))
    }

    /// The features that Embree asks for.
    #[cfg(target_arch = "x86_64")]
    fn is_there(self) -> bool {
        macro_rules! has {
            ($($feature:tt)+) => { true $(&& std::is_x86_feature_detected!($feature))+ };
        }
        match self {
            Isa::Sse42 => has!("sse4.2" "popcnt"),
            Isa::Avx => Isa::Sse42.is_there() && has!("avx"),
            Isa::Avx2 => Isa::Avx.is_there() && has!("avx2" "fma" "f16c" "bmi1" "bmi2" "lzcnt"),
            Isa::Avx512 => Isa::Avx2.is_there() && has!("avx512f" "avx512dq" "avx512cd" "avx512bw" "avx512vl"),
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn is_there(self) -> bool {
        false
    }
}

impl FromStr for Isa {
    type Err = String;

    /// Takes the names of [`Isa::available`].
    fn from_str(text: &str) -> Result<Isa, String> {
        let available: Vec<&str> = Isa::available().map(Isa::name).collect();
        let values = match &available[..] {
            [] => "this processor has none of those that can be chosen".to_string(),
            names => format!("possible values on this processor: {}", names.join(", ")),
        };
        match Isa::ALL.into_iter().find(|isa| isa.name() == text) {
            Some(isa) if isa.is_there() => Ok(isa),
            Some(isa) => Err(format!("this processor lacks {}; {values}", isa.name())),
            None => Err(format!("there is no instruction set {text:?}; {values}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_where_the_processor_has_the_set() {
        for isa in Isa::ALL {
            let there = Isa::available().any(|other| other == isa);
            assert_eq!(isa.name().parse::<Isa>().ok(), there.then_some(isa));
        }
        for wrong in ["", "AVX2", "avx1024", "neon"] {
            let error = wrong.parse::<Isa>().unwrap_err();
            assert!(Isa::available().all(|isa| error.contains(isa.name())), "{error}");
        }
    }
}
