//! Parts of pictures beside each other.

use crate::image::exr::read_rgb;
use crate::image::{Exposure, Image, Tone, ViewTransform, png};
use crate::inspect::sheet::{Panel, sheet};
use anyhow::Result;
use std::path::Path;

/// A part of a picture: its corner and its size, as shares of the picture's width and height.
pub(super) struct Part {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// Writes the same part of some pictures under their names, each pixel `enlarged` times; all at the exposure of the last.
pub(super) fn write(
    to: &Path,
    title: &str,
    note: &str,
    pictures: &[(&str, &Path)],
    part: &Part,
    enlarged: usize,
    stamp: &str,
) -> Result<()> {
    let images = pictures.iter().map(|(_, path)| read_rgb(path)).collect::<crate::Result<Vec<Image>>>()?;
    let stops = images.last().map_or(0.0, |last| Exposure::default().stops(last, Tone::Srgb));
    let cut: Vec<Image> = images.iter().map(|image| scaled(&crop(image, part), enlarged, 2f32.powf(stops))).collect();
    let panels: Vec<Panel> =
        pictures.iter().zip(&cut).map(|((name, _), image)| Panel { name, image, x: &[], y: &[] }).collect();
    let sheet = sheet(title, note, &panels, None)?;
    Ok(png::write(to, &sheet, &ViewTransform::default(), &[("Comment", stamp)])?)
}

fn crop(image: &Image, part: &Part) -> Image {
    let along = |share: f64, size: usize| ((share * size as f64) as usize).min(size - 1);
    let (x, y) = (along(part.x, image.width), along(part.y, image.height));
    let width = along(part.width, image.width).clamp(1, image.width - x);
    let height = along(part.height, image.height).clamp(1, image.height - y);
    let data = (0..width * height).map(|i| image.data[(y + i / width) * image.width + x + i % width]).collect();
    Image { width, height, data }
}

fn scaled(image: &Image, by: usize, factor: f32) -> Image {
    let (width, height) = (by * image.width, by * image.height);
    let at = |i: usize| image.data[i / width / by * image.width + i % width / by] * factor;
    Image { width, height, data: (0..width * height).map(at).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    #[test]
    fn parts_are_cut_where_they_are_said_to_be_and_enlarged() {
        let image = Image { width: 8, height: 4, data: (0..32).map(|i| Rgb::splat(i as f32)).collect() };
        let cut = crop(&image, &Part { x: 0.5, y: 0.25, width: 0.25, height: 0.5 });
        assert_eq!((cut.width, cut.height), (2, 2));
        assert_eq!(cut.data.iter().map(|c| c.x).collect::<Vec<_>>(), [12.0, 13.0, 20.0, 21.0]);
        let twice = scaled(&cut, 2, 10.0);
        assert_eq!((twice.width, twice.data[0].x, twice.data[5].x, twice.data[15].x), (4, 120.0, 120.0, 210.0));
    }
}
