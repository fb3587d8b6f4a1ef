//! Pictures in files of any format that is read: textures and surroundings.
//!
//! The content decides what a file is, never its name. Samples stay as they are stored (8 or 16 bits, or floats), and beside
//! them stands what decodes them to linear light: the curve of sRGB unless the file says otherwise.

mod formats;
mod load;
#[cfg(test)]
mod tests;
mod transfer;

pub(crate) use load::{load, load_bytes, split_layer};

use crate::math::Rgb;
use std::sync::Arc;

/// What [`load`] can read, for messages.
pub(crate) const FORMATS: &str =
    "PNG, JPEG, OpenEXR, TGA, BMP, TIFF, GIF, WebP, Radiance HDR, DDS, PNM, ICO, QOI or farbfeld";

/// A picture as it was stored in its file.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// 1 to 4: grey, grey and alpha, RGB, or RGB and alpha.
    pub(crate) channels: usize,
    /// Rows from the top, channels interleaved: `width * height * channels` values.
    pub(crate) samples: Samples,
    /// What a user should know of how the file was read.
    pub(crate) notes: Vec<String>,
}

/// Values of a picture. Tables decode colours to linear light by their stored values; alpha is never decoded.
#[derive(Clone, Debug)]
pub(crate) enum Samples {
    U8(Vec<u8>, Arc<[f32; 256]>),
    /// The table has 65536 entries.
    U16(Vec<u16>, Arc<[f32]>),
    /// Linear.
    F32(Vec<f32>),
}

impl Picture {
    /// Linear colours of all pixels, row by row from the top.
    pub(crate) fn colors(&self) -> Vec<Rgb> {
        let step = self.channels;
        (0..self.width * self.height).map(|pixel| self.samples.color(pixel * step, step)).collect()
    }
}

impl Picture {
    /// The picture with another curve from stored values, which count from 0 to 1, to linear light. Floats are linear as they are.
    pub(crate) fn with_curve(self, curve: impl Fn(f32) -> f32) -> Picture {
        let samples = match self.samples {
            Samples::U8(values, _) => Samples::U8(values, Arc::new(std::array::from_fn(|k| curve(k as f32 / 255.0)))),
            Samples::U16(values, _) => {
                Samples::U16(values, (0..=u16::MAX).map(|k| curve(f32::from(k) / 65535.0)).collect())
            }
            floats => floats,
        };
        Picture { samples, ..self }
    }

    /// The picture with this done to the linear light of every value.
    pub(crate) fn mapped(self, change: impl Fn(f32) -> f32) -> Picture {
        let samples = match self.samples {
            Samples::U8(values, table) => Samples::U8(values, Arc::new(table.map(change))),
            Samples::U16(values, table) => Samples::U16(values, table.iter().map(|x| change(*x)).collect()),
            Samples::F32(values) => Samples::F32(values.into_iter().map(change).collect()),
        };
        Picture { samples, ..self }
    }

    /// The picture mirrored about the diagonal from its upper left corner.
    pub(crate) fn transposed(&self) -> Picture {
        self.rearranged([self.height, self.width], |x, y| [y, x])
    }

    /// The picture with its mirror image to its right, above it, or both: what repeats where every second copy is mirrored.
    pub(crate) fn mirrored(&self, [across, up]: [bool; 2]) -> Picture {
        let (width, height) = (self.width, self.height);
        let above = if up { height } else { 0 };
        let size = [width * (1 + usize::from(across)), height + above];
        self.rearranged(size, |x, y| {
            [if x < width { x } else { 2 * width - 1 - x }, if y < above { above - 1 - y } else { y - above }]
        })
    }

    /// A picture of this width and height; `source` tells which pixel of this one each of its pixels is.
    fn rearranged(&self, [width, height]: [usize; 2], source: impl Fn(usize, usize) -> [usize; 2]) -> Picture {
        fn taken<T: Copy>(values: &[T], firsts: impl Iterator<Item = usize>, step: usize) -> Vec<T> {
            firsts.flat_map(|first| values[first..first + step].iter().copied()).collect()
        }
        let step = self.channels;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let firsts = pixels.map(|(x, y)| source(x, y)).map(|[x, y]| (y * self.width + x) * step);
        let samples = match &self.samples {
            Samples::U8(values, table) => Samples::U8(taken(values, firsts, step), table.clone()),
            Samples::U16(values, table) => Samples::U16(taken(values, firsts, step), table.clone()),
            Samples::F32(values) => Samples::F32(taken(values, firsts, step)),
        };
        Picture { width, height, samples, notes: self.notes.clone(), ..*self }
    }

    /// The mean of the linear colours.
    pub(crate) fn mean(&self) -> Rgb {
        let pixels = self.width * self.height;
        let colors = (0..pixels).map(|pixel| self.samples.color(pixel * self.channels, self.channels).as_dvec3());
        (colors.sum::<glam::DVec3>() / pixels as f64).as_vec3()
    }
}

impl Samples {
    /// Linear colour of the pixel of `channels` values that begins at `first`.
    #[inline]
    pub(crate) fn color(&self, first: usize, channels: usize) -> Rgb {
        match self {
            Samples::U8(data, table) => rgb(channels, |i| table[usize::from(data[first + i])]),
            Samples::U16(data, table) => rgb(channels, |i| table[usize::from(data[first + i])]),
            Samples::F32(data) => rgb(channels, |i| data[first + i]),
        }
    }
}

/// Grey for one or two channels.
#[inline]
pub(crate) fn rgb(channels: usize, value: impl Fn(usize) -> f32) -> Rgb {
    if channels < 3 { Rgb::splat(value(0)) } else { Rgb::new(value(0), value(1), value(2)) }
}
