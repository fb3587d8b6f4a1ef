//! What a picture's last bits and a render's speed depend on beside the scene and its settings: which build of this
//! program ran, on what processor, with which Embree.

use crate::Result;
use crate::embree::{Device, Isa};
use crate::image::exr::Attribute;
use crate::io::clock;
use serde::Serialize;
use std::collections::BTreeMap;

/// A build of the program together with what it runs on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Platform {
    /// Of the program.
    pub(crate) version: &'static str,
    /// What it was built from, in git's short form, `-dirty` where files had been changed; `None` where that was no
    /// repository.
    pub(crate) commit: Option<&'static str>,
    /// The level of x86-64 that the program was compiled for, or the name of another architecture.
    pub(crate) compiled_for: &'static str,
    /// The highest level of x86-64 that this processor has, or the name of another architecture.
    pub processor: &'static str,
    /// The processor's name, as the system tells it.
    pub(crate) cpu: Option<String>,
    /// Version of the Embree that runs.
    pub(crate) embree: String,
    /// The largest instruction set that it uses.
    pub(crate) embree_isa: &'static str,
    /// Rays of the widest packet that it has kernels for. Packets of 16 are asked in halves where it is 8; where it is 4, Embree takes
    /// them apart.
    pub(crate) embree_packet_width: usize,
}

/// Defines what levels there are: each is the one before it and these features.
macro_rules! levels {
    ($first:literal, $($level:literal: [$($feature:tt)+],)+) => {
        /// By what the compiler was told.
        fn compiled_for() -> &'static str {
            let mut level = $first;
            $(
                if cfg!(not(all($(target_feature = $feature),+))) {
                    return level;
                }
                level = $level;
            )+
            level
        }

        /// By what the processor says of itself.
        fn processor() -> &'static str {
            let mut level = $first;
            $(
                if !($(std::is_x86_feature_detected!($feature))&&+) {
                    return level;
                }
                level = $level;
            )+
            level
        }
    };
}

// As the psABI of x86-64 has them ("microarchitecture levels"), without what rustc has no stable name for.
#[cfg(target_arch = "x86_64")]
levels! {
    "x86-64",
    "x86-64-v2": ["cmpxchg16b" "popcnt" "sse3" "sse4.1" "sse4.2" "ssse3"],
    "x86-64-v3": ["avx" "avx2" "bmi1" "bmi2" "f16c" "fma" "lzcnt" "movbe"],
    "x86-64-v4": ["avx512f" "avx512bw" "avx512cd" "avx512dq" "avx512vl"],
}

#[cfg(not(target_arch = "x86_64"))]
fn compiled_for() -> &'static str {
    std::env::consts::ARCH
}

#[cfg(not(target_arch = "x86_64"))]
fn processor() -> &'static str {
    std::env::consts::ARCH
}

/// The processor's name, as Linux tells it.
fn cpu() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}

/// What keeps this machine from measuring well: more work than a quarter of its processors, on average over the last minute.
/// `None` where there is nothing, or the system does not tell.
pub fn busy() -> Option<String> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    let load: f64 = text.split_whitespace().next()?.parse().ok()?;
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    said_busy(load, processors)
}

fn said_busy(load: f64, processors: usize) -> Option<String> {
    (load > 0.25 * processors as f64).then(|| {
        format!(
            "this machine is busy: over the last minute {load:.1} programs wanted its {processors} processors; times will be \
             longer and less even than its own"
        )
    })
}

impl Platform {
    /// This program here, with Embree as it is for all devices that are not told otherwise.
    ///
    /// # Errors
    /// As [`Device::new`].
    pub fn here() -> Result<Platform> {
        let device = Device::new(1)?;
        Ok(Platform::of(&device))
    }

    /// This program here, with one Embree device.
    pub(crate) fn of(device: &Device) -> Platform {
        let version = device.version();
        Platform {
            version: env!("CARGO_PKG_VERSION"),
            commit: option_env!("PHOTOTAXIS_COMMIT"),
            compiled_for: compiled_for(),
            processor: processor(),
            cpu: cpu(),
            embree: format!("{}.{}.{}", version / 10000, version / 100 % 100, version % 100),
            embree_isa: device.isa().map_or(if cfg!(target_arch = "x86_64") { "sse2" } else { processor() }, Isa::name),
            embree_packet_width: device.packet_width(),
        }
    }

    /// In one line, without the program's name.
    pub(crate) fn summary(&self) -> String {
        let Platform { version, compiled_for, embree, embree_isa, .. } = self;
        let commit = self.commit.map_or(String::new(), |commit| format!(" ({commit})"));
        format!("{version}{commit}, compiled for {compiled_for}, Embree {embree} with {embree_isa}")
    }

    /// In one line what a figure was made with: the program, the processor, Embree and the date (UTC).
    pub(crate) fn stamp(&self) -> String {
        let cpu = self.cpu.as_deref().unwrap_or("unknown processor");
        format!("phototaxis {}, on {cpu}, {}", self.summary(), &clock::utc_now()[..10])
    }

    /// How Embree is asked for sixteen rays at a time.
    pub(crate) fn packets(&self) -> &'static str {
        match self.embree_packet_width {
            16 => "packets of 16 rays",
            8 => "packets of 16 rays in halves of 8",
            _ => "packets of 16 rays, which Embree takes apart",
        }
    }

    /// What can be done where the processor has more than the program was compiled for.
    pub(crate) fn advice(&self) -> Option<String> {
        let Platform { compiled_for, processor, .. } = self;
        (compiled_for != processor).then(|| {
            format!(
                "this program was compiled for {compiled_for}, and this processor has {processor}: a program that \
                 `make build` (for the processor at hand) or `make portable` (for all) makes is faster"
            )
        })
    }

    /// As it goes into the header of an EXR.
    pub(crate) fn attributes(&self) -> BTreeMap<String, Attribute> {
        let commit = self.commit.map(|commit| ("commit", commit));
        let all = [("compiledFor", self.compiled_for), ("embree", &self.embree), ("embreeIsa", self.embree_isa)];
        let text = |(name, value): (&str, &str)| (name.to_string(), Attribute::Text(value.to_string()));
        all.into_iter().chain(commit).map(text).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_embree_uses_is_what_it_was_held_to() {
        for isa in Isa::available() {
            let platform = Platform::of(&Device::held_to(Some(isa), 1).unwrap());
            assert_eq!(platform.embree_isa, isa.name());
            let width = match isa {
                Isa::Avx512 => 16,
                Isa::Avx | Isa::Avx2 => 8,
                Isa::Sse42 => 4,
            };
            assert_eq!(platform.embree_packet_width, width);
            assert_eq!(platform.packets().contains("halves"), width == 8);
            assert!(platform.summary().ends_with(&format!("with {}", isa.name())));
        }
    }

    #[test]
    fn a_stamp_names_all_that_a_figure_depends_on() {
        let platform = Platform::here().unwrap();
        let stamp = platform.stamp();
        let cpu = platform.cpu.as_deref().unwrap_or("unknown processor");
        for part in [platform.version, platform.embree_isa, &platform.embree, platform.compiled_for, cpu] {
            assert!(stamp.contains(part), "{part} is not in {stamp}");
        }
        assert_eq!(stamp.rsplit(", ").next().map(str::len), Some(10), "{stamp}");
    }

    #[test]
    fn busy_is_more_than_a_quarter_of_the_processors() {
        assert_eq!((said_busy(0.4, 2), said_busy(2.0, 8)), (None, None));
        assert!(said_busy(0.6, 2).unwrap().contains("0.6 programs wanted its 2 processors"));
    }

    #[test]
    fn a_program_for_less_than_the_processor_has_says_so() {
        let mut platform = Platform::here().unwrap();
        platform.compiled_for = platform.processor;
        assert_eq!(platform.advice(), None);
        (platform.compiled_for, platform.processor) = ("x86-64", "x86-64-v3");
        let advice = platform.advice().unwrap();
        assert!(["x86-64,", "x86-64-v3", "make build", "make portable"].iter().all(|word| advice.contains(word)));
    }
}
