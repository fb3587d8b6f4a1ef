//! How the film is asked for.

use crate::document::{Bounds, Fault, Reader, key};
use std::ops::RangeInclusive;

/// Pixels along a side.
pub(crate) const SIDE: RangeInclusive<u64> = 1..=65536;
const STOPS: Bounds = Bounds::new(|x| x.abs() <= 64.0, "between -64 and 64");

/// The size of the picture, and how samples become pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    pub width: u32,
    pub height: u32,
    pub filter: Filter,
    /// Of the PNG only: stops by which the picture is brightened.
    pub exposure: f32,
}

impl Default for FilmSettings {
    fn default() -> FilmSettings {
        FilmSettings { width: 1280, height: 720, filter: Filter::Box, exposure: 0.0 }
    }
}

impl FilmSettings {
    /// Reads `[film]` over what there is.
    pub(crate) fn read(&mut self, t: &mut Reader) -> Result<(), Fault> {
        let filters = [("box", Filter::Box), ("tent", Filter::Tent), ("gaussian", Filter::Gaussian)];
        let width = key(
            "width",
            "of the picture; a render takes some 256 bytes a pixel, and more than there is free is refused",
        );
        t.integer(width.unit("pixels"), SIDE, &mut self.width)?;
        t.integer(key("height", "of the picture").unit("pixels"), SIDE, &mut self.height)?;
        let filter = "reconstruction: box one pixel wide; tent of radius 1; Gaussian of standard deviation 0.5, cut off at 1.5 pixels";
        t.choice(key("filter", filter), &filters, &mut self.filter)?;
        let exposure = key("exposure", "brightens the PNG; the EXR stays as it is");
        t.number(exposure.unit("stops"), STOPS, &mut self.exposure)
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
