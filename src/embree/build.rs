//! How acceleration structures are built.

use super::sys;

/// What an acceleration structure is built for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildOptions {
    /// Watertight ray queries: no ray slips between two triangles that share an edge, for about a quarter of the speed.
    pub robust: bool,
    pub quality: BuildQuality,
}

/// Time of the build against time of every ray after it. Rays meet the same triangles whatever it is, but for those that are
/// met at one distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// Triangles are sorted along a curve through space (Morton codes).
    Low,
    /// Split where the surface area heuristic expects the least work.
    #[default]
    Medium,
    /// The same, and large triangles are cut between parts of the structure.
    High,
}

impl BuildQuality {
    /// By their names in scene files.
    pub const NAMES: [(&'static str, BuildQuality); 3] =
        [("low", BuildQuality::Low), ("medium", BuildQuality::Medium), ("high", BuildQuality::High)];

    pub(super) fn as_embree(self) -> sys::RTCBuildQuality {
        match self {
            BuildQuality::Low => sys::RTC_BUILD_QUALITY_LOW,
            BuildQuality::Medium => sys::RTC_BUILD_QUALITY_MEDIUM,
            BuildQuality::High => sys::RTC_BUILD_QUALITY_HIGH,
        }
    }
}

#[cfg(test)]
#[path = "build_tests.rs"]
mod tests;
