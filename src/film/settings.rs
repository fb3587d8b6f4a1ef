//! How the film is asked for.

use crate::image::{Exposure, Tone};

/// Pixels along a side of a picture, at most.
pub const MAX_SIDE: u32 = 65536;

/// The size of the picture, and how samples become pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    pub width: u32,
    pub height: u32,
    pub filter: Filter,
    /// Of the PNG only: how much the picture is brightened.
    pub exposure: Exposure,
    /// Of the PNG only: how light becomes a colour of the screen.
    pub tone: Tone,
}

impl Default for FilmSettings {
    fn default() -> FilmSettings {
        FilmSettings {
            width: 1280,
            height: 720,
            filter: Filter::Box,
            exposure: Exposure::default(),
            tone: Tone::default(),
        }
    }
}

/// Pixel reconstruction filters. They are importance sampled, so that a sample belongs to one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// One pixel wide.
    Box,
    /// Radius one pixel.
    Tent,
    /// Truncated at the radius 1.5 pixels, standard deviation 0.5 pixels.
    Gaussian,
}

/// What becomes of the iterations' pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// Only the last counts (the paper).
    Last,
    /// All samples count alike.
    All,
    /// Each picture is weighted by the inverse of its estimated variance (Müller et al. 2017).
    InverseVariance,
}
