//! Pictures in memory.

use crate::math::Rgb;
use glam::Vec3;
use rayon::prelude::*;

/// A picture, row after row; row 0 is the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub width: usize,
    pub height: usize,
    /// `width * height` pixels.
    pub data: Vec<Rgb>,
}

impl Image {
    /// A black picture.
    pub(crate) fn new(width: usize, height: usize) -> Image {
        Image { width, height, data: vec![Rgb::ZERO; width * height] }
    }

    /// The pixel in column `x` from the left and row `y` from the top.
    ///
    /// # Panics
    /// Outside of the picture.
    #[inline]
    pub(crate) fn pixel(&self, x: usize, y: usize) -> Rgb {
        assert!(x < self.width, "column {x} of {}", self.width);
        self.data[y * self.width + x]
    }
}

/// Channels of a picture file that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Prefix of the channels' names; empty for the picture itself.
    pub(crate) name: String,
    /// Suffix and one value per pixel, row 0 on top. An empty suffix: the layer's name is the channel's.
    pub(crate) channels: Vec<(String, Vec<f32>)>,
}

/// Pixels with an infinite or undefined number in any channel.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct NonFinite {
    /// How many.
    pub(crate) pixels: usize,
    /// Where the first of them is, row by row from the upper left, and a channel of it that is not finite.
    pub(crate) channel: String,
    pub(crate) x: usize,
    pub(crate) y: usize,
}

impl std::fmt::Display for NonFinite {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let NonFinite { pixels, channel, x, y } = self;
        let are = if *pixels == 1 { "pixel is" } else { "pixels are" };
        write!(f, "{pixels} {are} not finite; the first is ({x}, {y}), in channel {channel}")
    }
}

impl Layer {
    /// Channels `R`, `G`, `B`.
    pub fn color(name: &str, pixels: &[Rgb]) -> Layer {
        Layer::split(name, ["R", "G", "B"], pixels)
    }

    /// Channels `X`, `Y`, `Z`.
    pub(crate) fn vector(name: &str, pixels: &[Vec3]) -> Layer {
        Layer::split(name, ["X", "Y", "Z"], pixels)
    }

    /// One channel: `suffix` is `"Y"` by convention, or empty where the name stands alone (depth `Z`).
    pub(crate) fn scalar(name: &str, suffix: &str, values: Vec<f32>) -> Layer {
        Layer { name: name.to_owned(), channels: vec![(suffix.to_owned(), values)] }
    }

    /// What is not finite among layers of a picture with rows of `width` pixels; `None` where all is.
    pub(crate) fn non_finite(layers: &[Layer], width: usize) -> Option<NonFinite> {
        let channels: Vec<(String, &[f32])> = layers.iter().flat_map(Layer::named_channels).collect();
        let pixels = channels.first().map_or(0, |(_, values)| values.len());
        let broken = |&i: &usize| channels.iter().any(|(_, values)| !values[i].is_finite());
        let first = (0..pixels).find(broken)?;
        let (channel, _) = channels.iter().find(|(_, values)| !values[first].is_finite())?;
        let pixels = (first..pixels).into_par_iter().filter(broken).count();
        Some(NonFinite { pixels, channel: channel.clone(), x: first % width, y: first / width })
    }

    fn named_channels(&self) -> impl Iterator<Item = (String, &[f32])> {
        self.channels.iter().map(|(suffix, values)| (self.channel_name(suffix), &values[..]))
    }

    fn split(name: &str, suffixes: [&str; 3], pixels: &[Vec3]) -> Layer {
        let channel = |i: usize| (suffixes[i].to_owned(), pixels.iter().map(|p| p[i]).collect());
        Layer { name: name.to_owned(), channels: (0..3).map(channel).collect() }
    }

    /// Three channels as vectors, one for each pixel; `None` where one of them is missing.
    pub(crate) fn vectors(&self, suffixes: [&str; 3]) -> Option<Vec<Vec3>> {
        let channel = |suffix: &str| self.channels.iter().find(|(own, _)| own == suffix).map(|(_, values)| values);
        let (x, y, z) = (channel(suffixes[0])?, channel(suffixes[1])?, channel(suffixes[2])?);
        Some(x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Vec3::new(x, y, z)).collect())
    }

    /// The colours of a layer that has `R`, `G` and `B`.
    pub(crate) fn colors(&self) -> Option<Vec<Rgb>> {
        self.vectors(["R", "G", "B"])
    }

    /// The full name of the channel with this suffix: `name.suffix`, or the one that is not empty.
    pub(crate) fn channel_name(&self, suffix: &str) -> String {
        match (self.name.as_str(), suffix) {
            ("", suffix) => suffix.to_owned(),
            (name, "") => name.to_owned(),
            (name, suffix) => format!("{name}.{suffix}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_named_by_convention() {
        let pixels = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0)];
        let color = Layer::color("albedo", &pixels);
        assert_eq!(color.channels[2], ("B".to_owned(), vec![3.0, 6.0]));
        assert_eq!(color.channel_name("B"), "albedo.B");
        assert_eq!(Layer::color("", &pixels).channel_name("R"), "R");
        assert_eq!(Layer::vector("N", &pixels).channels[1], ("Y".to_owned(), vec![2.0, 5.0]));
        assert_eq!(Layer::scalar("Z", "", vec![]).channel_name(""), "Z");
    }

    #[test]
    fn what_is_not_finite_is_counted_and_named() {
        let mut color = Layer::color("", &[Vec3::ONE; 6]);
        let mut depth = Layer::scalar("", "Z", vec![0.0; 6]);
        let found = |color: &Layer, depth: &Layer| Layer::non_finite(&[color.clone(), depth.clone()], 3);
        assert_eq!(found(&color, &depth), None);
        (depth.channels[0].1[4], color.channels[1].1[5], color.channels[2].1[5]) = (f32::NAN, f32::INFINITY, f32::NAN);
        let both = found(&color, &depth).unwrap();
        assert_eq!(both, NonFinite { pixels: 2, channel: "Z".into(), x: 1, y: 1 });
        assert_eq!(both.to_string(), "2 pixels are not finite; the first is (1, 1), in channel Z");
        depth.channels[0].1[4] = 1.0;
        assert_eq!(
            found(&color, &depth).unwrap().to_string(),
            "1 pixel is not finite; the first is (2, 1), in channel G"
        );
        assert_eq!(Layer::non_finite(&[], 3), None);
    }

    #[test]
    fn pixels_are_stored_row_after_row() {
        let mut image = Image::new(3, 2);
        image.data[5] = Rgb::ONE;
        assert_eq!(image.pixel(2, 1), Rgb::ONE);
        assert_eq!(image.pixel(2, 0), Rgb::ZERO);
    }
}
