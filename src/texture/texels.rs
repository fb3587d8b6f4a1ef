//! Texels as a file stored them, decoded one at a time.

use crate::image::srgb;
use crate::io::canon::texels;
use crate::math::Rgb;

/// Rows of texels from the top, channels interleaved: grey, grey and alpha, RGB, or RGB and alpha.
#[derive(Clone, Debug)]
pub(super) struct Texels {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// 1 to 4.
    pub(crate) channels: usize,
    pub(crate) data: Samples,
}

/// `width * height * channels` values.
#[derive(Clone, Debug)]
pub(super) enum Samples {
    /// sRGB.
    U8(Vec<u8>),
    /// sRGB.
    U16(Vec<u16>),
    /// Linear.
    F32(Vec<f32>),
}

impl Texels {
    /// Linear colour of the texel in column `x` and row `y` from the top.
    pub(crate) fn color(&self, x: usize, y: usize) -> Rgb {
        let first = self.first(x, y);
        match &self.data {
            Samples::U8(data) => {
                let table = &*srgb::DECODE_8;
                self.rgb(|i| table[usize::from(data[first + i])])
            }
            Samples::U16(data) => {
                let table = srgb::DECODE_16.as_slice();
                self.rgb(|i| table[usize::from(data[first + i])])
            }
            Samples::F32(data) => self.rgb(|i| data[first + i]),
        }
    }

    /// Alpha, or the luminance of the stored values.
    pub(crate) fn scalar(&self, x: usize, y: usize) -> f32 {
        match self.channels {
            2 | 4 => self.stored(self.first(x, y) + self.channels - 1),
            _ => self.stored_luminance(x, y),
        }
    }

    /// Luminance of the stored values, not decoded.
    pub(crate) fn stored_luminance(&self, x: usize, y: usize) -> f32 {
        let first = self.first(x, y);
        grey(self.rgb(|i| self.stored(first + i)))
    }

    fn stored(&self, i: usize) -> f32 {
        match &self.data {
            Samples::U8(data) => f32::from(data[i]) / 255.0,
            Samples::U16(data) => f32::from(data[i]) / 65535.0,
            Samples::F32(data) => data[i],
        }
    }

    /// Mean linear colour, and whether `scalar` is 1 for every texel.
    pub(crate) fn summary(&self) -> (Rgb, bool) {
        let mut sum = glam::DVec3::ZERO;
        let mut opaque = true;
        for y in 0..self.height {
            for x in 0..self.width {
                sum += self.color(x, y).as_dvec3();
                opaque = opaque && self.scalar(x, y) == 1.0;
            }
        }
        ((sum / (self.width * self.height) as f64).as_vec3(), opaque)
    }

    pub(crate) fn bytes(&self) -> usize {
        match &self.data {
            Samples::U8(data) => data.len(),
            Samples::U16(data) => 2 * data.len(),
            Samples::F32(data) => 4 * data.len(),
        }
    }

    /// Over how texels are stored and what they are.
    pub(crate) fn content_hash(&self) -> u64 {
        texels([self.width, self.height], |canon| {
            canon.u64(self.channels as u64);
            match &self.data {
                Samples::U8(data) => {
                    canon.u64(1);
                    canon.array(data);
                }
                Samples::U16(data) => {
                    canon.u64(2);
                    canon.array(data);
                }
                Samples::F32(data) => {
                    canon.u64(3);
                    canon.array(data);
                }
            }
        })
    }

    fn first(&self, x: usize, y: usize) -> usize {
        (y * self.width + x) * self.channels
    }

    fn rgb(&self, channel: impl Fn(usize) -> f32) -> Rgb {
        if self.channels < 3 { Rgb::splat(channel(0)) } else { Rgb::new(channel(0), channel(1), channel(2)) }
    }
}

/// Luminance (ITU-R BT.709), exact for greys, so that white is not a hair below or above 1.
pub(super) fn grey(c: Rgb) -> f32 {
    c.y + 0.2126 * (c.x - c.y) + 0.0722 * (c.z - c.y)
}
