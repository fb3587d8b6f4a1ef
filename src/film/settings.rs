//! How the film is asked for.

use crate::document::{Bounds, Fault, Reader, Value, key};
use crate::image::{Exposure, MOST_STOPS, Tone};
use std::ops::RangeInclusive;

/// Pixels along a side of a picture, at most.
pub const MAX_SIDE: u32 = 65536;
pub(crate) const SIDE: RangeInclusive<u64> = 1..=MAX_SIDE as u64;
const STOPS: Bounds = Bounds::new(|x| x.abs() <= MOST_STOPS as f64, "between -64 and 64");

/// The size of the picture, and how samples become pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) filter: Filter,
    /// The part that is rendered: x and y of its upper left pixel, width and height. `None`: all.
    pub(crate) crop: Option<[u32; 4]>,
    /// Of the PNG only: how much the picture is brightened.
    pub(crate) exposure: Exposure,
    /// Of the PNG only: how light becomes a colour of the screen.
    pub(crate) tone: Tone,
}

impl Default for FilmSettings {
    fn default() -> FilmSettings {
        FilmSettings {
            width: 1280,
            height: 720,
            filter: Filter::Box,
            crop: None,
            exposure: Exposure::default(),
            tone: Tone::default(),
        }
    }
}

impl FilmSettings {
    /// Width and height of the part that is rendered.
    pub(crate) fn rendered(&self) -> [u32; 2] {
        self.crop.map_or([self.width, self.height], |[_, _, width, height]| [width, height])
    }

    /// That the part which is rendered is a part, and not empty.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn check_crop(&self) -> Result<(), String> {
        let Some([x, y, width, height]) = self.crop else { return Ok(()) };
        let fits =
            |from: u32, length: u32, all: u32| length > 0 && from.checked_add(length).is_some_and(|end| end <= all);
        if fits(x, width, self.width) && fits(y, height, self.height) {
            return Ok(());
        }
        let (all_width, all_height) = (self.width, self.height);
        Err(format!("{width} × {height} pixels at ({x}, {y}) are no part of a picture of {all_width} × {all_height}"))
    }

    /// Takes these for width and height, as far as they are given.
    pub(crate) fn resize(&mut self, [width, height]: [Option<u32>; 2]) {
        (self.width, self.height) = (width.unwrap_or(self.width), height.unwrap_or(self.height));
    }

    /// Reads `[film]` over what there is.
    pub(crate) fn read(&mut self, t: &mut Reader) -> Result<(), Fault> {
        let filters = [("box", Filter::Box), ("tent", Filter::Tent), ("gaussian", Filter::Gaussian)];
        let width = key(
            "width",
            "of the picture; a render takes some 340 bytes a pixel, and more than there is free is refused",
        );
        t.integer(width.unit("pixels"), SIDE, &mut self.width)?;
        t.integer(key("height", "of the picture").unit("pixels"), SIDE, &mut self.height)?;
        let filter = "reconstruction: box one pixel wide; tent of radius 1; Gaussian of standard deviation 0.5, cut off at 1.5 pixels";
        t.choice(key("filter", filter), &filters, &mut self.filter)?;
        crop(t, self)?;
        exposure(t, &mut self.exposure)?;
        let tone = "how light becomes a colour of the PNG, see [pictures.md](pictures.md)";
        t.choice(key("tone", tone), &Tone::NAMES, &mut self.tone)
    }
}

/// A part of the picture.
fn crop(t: &mut Reader, film: &mut FilmSettings) -> Result<(), Fault> {
    let meaning =
        "the part that is rendered: x and y of its upper left pixel, width and height; the same pixels as of the whole";
    let key = key("crop", meaning).unit("pixels").optional();
    let Some(node) = t.ask(key, "`[x, y, width, height]`", "", "")? else { return Ok(()) };
    let whole = Bounds::new(|x| x.fract() == 0.0 && x >= 0.0 && x <= MAX_SIDE as f64, "whole numbers from 0 to 65536");
    let part = node.numbers::<4>("crop", whole)?.map(|x| x as u32);
    film.crop = Some(part);
    Ok(())
}

/// Stops, or "auto".
fn exposure(t: &mut Reader, slot: &mut Exposure) -> Result<(), Fault> {
    let meaning = "brightens the PNG; the EXR stays as it is. `\"auto\"` goes by what the picture shows; of a bare model it is the default";
    let key = key("exposure", meaning).unit("stops");
    let Some(node) = t.ask(key, "number or `\"auto\"`", slot.to_string(), STOPS.range())? else { return Ok(()) };
    *slot = match &node.value {
        Value::String(text) if text == "auto" => Exposure::Auto,
        Value::String(_) => return Err(node.mismatch("exposure", "a number or \"auto\"")),
        _ => Exposure::Stops(node.number("exposure", STOPS)?),
    };
    Ok(())
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Combine {
    /// Only the last counts (the paper).
    Last,
    /// All samples count alike.
    All,
    /// Each picture is weighted by the inverse of its estimated variance (Müller et al. 2017).
    InverseVariance,
}
