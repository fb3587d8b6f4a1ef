//! Pictures: in memory, in files, and how far two of them are apart.

pub(crate) mod cryptomatte;
pub mod exr;
pub(crate) mod flip;
mod layers;
pub mod metrics;
pub(crate) mod packed;
pub(crate) mod picture;
pub mod png;
mod resample;
pub mod srgb;
mod tone;
mod view;

pub use layers::{Image, Layer, NonFinite};
pub(crate) use resample::Rectangle;
pub(crate) use tone::Tone;
pub(crate) use view::{Exposure, MOST_STOPS, ViewTransform, automatic_stops};

#[cfg(test)]
pub(crate) mod tests {
    //! Finds the test scenes, which are not part of the package.

    use std::path::{Path, PathBuf};

    /// Files below the folder of scenes whose names end with `suffix`; `None`, after saying so, where there is no such folder.
    pub(crate) fn scene_files(suffix: &str) -> Option<Vec<PathBuf>> {
        let root = std::env::var_os("PHOTOTAXIS_SCENES")
            .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"), PathBuf::from);
        if !root.is_dir() {
            eprintln!("SKIPPED: no folder of scenes at {}", root.display());
            return None;
        }
        let mut files = Vec::new();
        let mut folders = vec![root];
        while let Some(folder) = folders.pop() {
            for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if path.is_dir() {
                    folders.push(path);
                } else if path.to_string_lossy().ends_with(suffix) {
                    files.push(path);
                }
            }
        }
        assert!(!files.is_empty(), "the scenes have no {suffix}");
        Some(files)
    }
}
