//! `phototaxis error`: how far pictures are from a reference.

use crate::image::exr::{read_layers, read_measured};
use crate::image::metrics::{Errors, compare};
use crate::image::{Image, Layer};
use crate::math::Rgb;
use crate::platform::Platform;
use crate::stats::Summary;
use anyhow::Result;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub(crate) struct ErrorArguments {
    /// Pictures (.exr), for example of independent seeds.
    #[arg(required = true)]
    images: Vec<PathBuf>,
    /// Picture of the same size to compare with.
    #[arg(long, value_name = "EXR")]
    reference: PathBuf,
    /// Layer of the pictures to measure. [default: the picture itself]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Measures denoised pictures too, whose error is not noise.
    #[arg(long)]
    allow_denoised: bool,
}

#[derive(Serialize)]
struct Report {
    platform: Platform,
    images: Vec<ImageReport>,
    /// Over the pictures, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    relmse: Option<Mean>,
    #[serde(skip_serializing_if = "Option::is_none")]
    relmse_trimmed: Option<Mean>,
    /// relMSE that the reference's own noise adds, by its variance layers.
    #[serde(skip_serializing_if = "Option::is_none")]
    relmse_of_reference: Option<f64>,
}

#[derive(Serialize)]
struct ImageReport {
    image: PathBuf,
    /// Pixels that are infinite or undefined. Errors that include one are `null`.
    non_finite_pixels: usize,
    #[serde(flatten)]
    errors: Errors,
}

/// Mean and 95 % interval (Student's t).
#[derive(Serialize)]
struct Mean {
    mean: f64,
    low: f64,
    high: f64,
}

pub(crate) fn run(arguments: &ErrorArguments) -> Result<ExitCode> {
    let reference = read(arguments, &arguments.reference, None)?;
    let mut images = Vec::new();
    let mut broken = name_non_finite(&arguments.reference, &reference);
    for path in &arguments.images {
        let image = read(arguments, path, arguments.layer.as_deref())?;
        let (errors, non_finite_pixels) = (compare(&image, &reference)?, name_non_finite(path, &image));
        broken += non_finite_pixels;
        images.push(ImageReport { image: path.clone(), non_finite_pixels, errors });
    }
    let report = Report {
        platform: Platform::here()?,
        relmse: mean(&images, |errors| errors.relmse),
        relmse_trimmed: mean(&images, |errors| errors.relmse_trimmed),
        relmse_of_reference: own_noise(&arguments.reference, &reference)?,
        images,
    };
    super::print(&serde_json::to_string_pretty(&report)?)?;
    Ok(if broken > 0 { ExitCode::from(super::NOT_FINITE) } else { ExitCode::SUCCESS })
}

fn read(arguments: &ErrorArguments, path: &Path, layer: Option<&str>) -> Result<Image> {
    Ok(read_measured(path, layer, arguments.allow_denoised)?)
}

/// How many pixels of a picture are not finite; says so where there are any.
fn name_non_finite(path: &Path, image: &Image) -> usize {
    let found = Layer::non_finite(&[Layer::color("", &image.data)], image.width);
    found.map_or(0, |found| {
        eprintln!("error: {}: {found}", path.display());
        found.pixels
    })
}

fn mean(images: &[ImageReport], measure: fn(&Errors) -> f64) -> Option<Mean> {
    let summary = Summary::of(&images.iter().map(|i| measure(&i.errors)).collect::<Vec<_>>())?;
    let interval = summary.confidence(0.95)?;
    Some(Mean { mean: summary.mean, low: interval.low, high: interval.high })
}

/// A picture off by its standard deviation in every value is off by its noise.
fn own_noise(path: &Path, reference: &Image) -> Result<Option<f64>> {
    let layers = read_layers(path)?;
    let channel = |suffix: &str| layers.channels.get(&format!("variance.{suffix}"));
    let (Some(r), Some(g), Some(b)) = (channel("R"), channel("G"), channel("B")) else { return Ok(None) };
    let mut noisy = Image::new(reference.width, reference.height);
    for (i, pixel) in noisy.data.iter_mut().enumerate() {
        let variance = Rgb::new(r[i], g[i], b[i]).max(Rgb::ZERO);
        *pixel = reference.data[i] + Rgb::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt());
    }
    Ok(Some(compare(&noisy, reference)?.relmse))
}
