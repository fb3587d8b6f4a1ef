//! Pictures in memory.

use crate::math::Rgb;
use glam::Vec3;

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
    pub fn new(width: usize, height: usize) -> Image {
        Image { width, height, data: vec![Rgb::ZERO; width * height] }
    }

    /// The pixel in column `x` from the left and row `y` from the top.
    ///
    /// # Panics
    /// Outside of the picture.
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> Rgb {
        assert!(x < self.width, "column {x} of {}", self.width);
        self.data[y * self.width + x]
    }
}

/// Channels of a picture file that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Prefix of the channels' names; empty for the picture itself.
    pub name: String,
    /// Suffix and one value per pixel, row 0 on top. An empty suffix: the layer's name is the channel's.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl Layer {
    /// Channels `R`, `G`, `B`.
    pub fn color(name: &str, pixels: &[Rgb]) -> Layer {
        Layer::split(name, ["R", "G", "B"], pixels)
    }

    /// Channels `X`, `Y`, `Z`.
    pub fn vector(name: &str, pixels: &[Vec3]) -> Layer {
        Layer::split(name, ["X", "Y", "Z"], pixels)
    }

    /// One channel: `suffix` is `"Y"` by convention, or empty where the name stands alone (depth `Z`).
    pub fn scalar(name: &str, suffix: &str, values: Vec<f32>) -> Layer {
        Layer { name: name.to_owned(), channels: vec![(suffix.to_owned(), values)] }
    }

    fn split(name: &str, suffixes: [&str; 3], pixels: &[Vec3]) -> Layer {
        let channel = |i: usize| (suffixes[i].to_owned(), pixels.iter().map(|p| p[i]).collect());
        Layer { name: name.to_owned(), channels: (0..3).map(channel).collect() }
    }

    /// The full name of the channel with this suffix: `name.suffix`, or the one that is not empty.
    pub fn channel_name(&self, suffix: &str) -> String {
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
    fn pixels_are_stored_row_after_row() {
        let mut image = Image::new(3, 2);
        image.data[5] = Rgb::ONE;
        assert_eq!(image.pixel(2, 1), Rgb::ONE);
        assert_eq!(image.pixel(2, 0), Rgb::ZERO);
    }
}
