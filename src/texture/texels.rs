//! Texels as a file stored them, decoded one at a time.

use crate::image::picture::{Picture, Samples, rgb};
use crate::image::srgb;
use crate::io::canon::{Canon, texels};
use crate::math::Rgb;
use crate::simd::prefetch;

/// Rows of texels from the top, channels interleaved: grey, grey and alpha, RGB, or RGB and alpha.
#[derive(Clone, Debug)]
pub(super) struct Texels {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// 1 to 4.
    pub(crate) channels: usize,
    pub(crate) data: Samples,
}

/// What is known of all texels.
pub(super) struct Summary {
    /// Whether [`Texels::scalar`] is 1 for every texel.
    pub(crate) opaque: bool,
    /// The largest component of a colour; 0 where none is positive.
    pub(crate) peak: f32,
}

impl From<Picture> for Texels {
    fn from(picture: Picture) -> Texels {
        let Picture { width, height, channels, samples, notes: _ } = picture;
        Texels { width, height, channels, data: samples }
    }
}

impl Texels {
    /// Linear colour of the texel in column `x` and row `y` from the top.
    pub(crate) fn color(&self, x: usize, y: usize) -> Rgb {
        self.data.color(self.first(x, y), self.channels)
    }

    /// Asks for the texel in column `x` and row `y` from the top, which will be read soon.
    #[inline(always)]
    pub(crate) fn prefetch(&self, x: usize, y: usize) {
        let first = self.first(x, y);
        match &self.data {
            Samples::U8(data, _) => prefetch(data, first),
            Samples::U16(data, _) => prefetch(data, first),
            Samples::F32(data) => prefetch(data, first),
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
        grey(self.stored_color(x, y))
    }

    /// The stored values, not decoded.
    pub(crate) fn stored_color(&self, x: usize, y: usize) -> Rgb {
        let first = self.first(x, y);
        rgb(self.channels, |i| self.stored(first + i))
    }

    fn stored(&self, i: usize) -> f32 {
        match &self.data {
            Samples::U8(data, _) => f32::from(data[i]) / 255.0,
            Samples::U16(data, _) => f32::from(data[i]) / 65535.0,
            Samples::F32(data) => data[i],
        }
    }

    pub(crate) fn summary(&self) -> Summary {
        let (mut opaque, mut peak) = (true, 0.0f32);
        for y in 0..self.height {
            for x in 0..self.width {
                let color = self.color(x, y);
                peak = peak.max(color.max_element());
                opaque = opaque && self.scalar(x, y) == 1.0;
            }
        }
        Summary { opaque, peak }
    }

    /// Mean linear colour.
    #[cfg(test)]
    pub(crate) fn mean(&self) -> Rgb {
        let of_row = |y: usize| (0..self.width).map(|x| self.color(x, y).as_dvec3()).sum::<glam::DVec3>();
        ((0..self.height).map(of_row).sum::<glam::DVec3>() / (self.width * self.height) as f64).as_vec3()
    }

    pub(crate) fn bytes(&self) -> usize {
        match &self.data {
            Samples::U8(data, _) => data.len(),
            Samples::U16(data, _) => 2 * data.len(),
            Samples::F32(data) => 4 * data.len(),
        }
    }

    /// Over how texels are stored and what they are.
    pub(crate) fn content_hash(&self) -> u64 {
        texels([self.width, self.height], |canon| {
            canon.u64(self.channels as u64);
            match &self.data {
                Samples::U8(data, table) => {
                    curve(canon, 1, &table[..], &srgb::DECODE_8[..]);
                    canon.array(data);
                }
                Samples::U16(data, table) => {
                    curve(canon, 2, table, &srgb::DECODE_16);
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
}

/// The number of how texels are stored, and the table that decodes them where that is not sRGB's.
fn curve(canon: &mut Canon, stored: u64, table: &[f32], srgb: &[f32]) {
    let usual = std::ptr::eq(table, srgb);
    canon.u64(if usual { stored } else { stored + 3 });
    if !usual {
        canon.array(table);
    }
}

/// Luminance (ITU-R BT.709), exact for greys, so that white is not a hair below or above 1.
pub(super) fn grey(c: Rgb) -> f32 {
    c.y + 0.2126 * (c.x - c.y) + 0.0722 * (c.z - c.y)
}
