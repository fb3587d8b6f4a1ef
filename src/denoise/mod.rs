//! Denoising by Intel Open Image Denoise 2, a library that is looked for when it is asked for, and not before.

mod library;
#[cfg(test)]
mod tests;

use crate::image::{Image, Tone, automatic_stops};
use crate::math::Rgb;
use crate::{Error, Result};
use library::{Device, Library};
use std::path::PathBuf;

/// Names the folder in which the library is, or the `lib` below which it is, where the system does not find it.
pub const FOLDER_VARIABLE: &str = "OIDN_DIR";
const FILE: &str = "libOpenImageDenoise.so.2";

const ADVICE: &str = "Get it as a package of the system where there is one, from https://github.com/RenderKit/oidn/releases, \
    or by `pip install pyoidn` (its folder pyoidn/oidn), and where the system does not find it, set OIDN_DIR to the folder \
    that holds its lib/";

/// What a denoiser looks at beside the picture: both noisy, of what the camera sees first.
pub struct Features<'a> {
    /// In [0, 1].
    pub albedo: &'a [Rgb],
    /// In any space, in [−1, 1].
    pub normal: &'a [Rgb],
}

/// The library, ready for use.
pub struct Denoiser {
    device: Device,
    version: String,
}

impl Denoiser {
    /// Loads the library, from the folder that [`FOLDER_VARIABLE`] names, else from where the system looks; it then works with
    /// `threads` threads (0: all), on the processor.
    ///
    /// # Errors
    /// [`Error::Denoise`] where the library is not there, which says how to get it, is of another major version, or refuses.
    pub fn new(threads: usize) -> Result<Denoiser> {
        let folder = std::env::var_os(FOLDER_VARIABLE).filter(|folder| !folder.is_empty()).map(PathBuf::from);
        let candidates = match &folder {
            Some(folder) => vec![folder.join(FILE), folder.join("lib").join(FILE)],
            None => vec![PathBuf::from(FILE)],
        };
        let mut failure = String::new();
        for path in candidates.iter().filter(|path| folder.is_none() || path.exists()) {
            match Library::load(path) {
                Ok(library) => return Denoiser::of(library, threads),
                Err(error) => failure = format!(" ({error})"),
            }
        }
        let place = folder.map_or(String::new(), |folder| format!(" in {FOLDER_VARIABLE}, {}", folder.display()));
        Err(Error::Denoise(format!("Open Image Denoise 2 ({FILE}) is not there{place}{failure}. {ADVICE}")))
    }

    fn of(library: Library, threads: usize) -> Result<Denoiser> {
        let device = Device::new(library, threads)?;
        let version = device.version();
        if version / 10_000 != 2 {
            return Err(Error::Denoise(format!("{FILE} has version number {version}, and 2.x is asked for")));
        }
        let version = format!("Open Image Denoise {}.{}.{}", version / 10_000, version / 100 % 100, version % 100);
        Ok(Denoiser { device, version })
    }

    /// Name and version of the library.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// The picture (linear radiance) without its noise. Albedo and normals are denoised on their own first, so that what is
    /// left of their noise is not taken for detail (`cleanAux` of the library's manual). Pixels that are not finite count as
    /// black.
    ///
    /// # Errors
    /// What the library refuses, such as a picture for which there is not the memory.
    ///
    /// # Panics
    /// Where features have another number of pixels than the picture.
    pub fn denoise(&self, image: &Image, features: &Features) -> Result<Image> {
        let size = (image.width, image.height);
        let albedo = self.prefiltered("albedo", features.albedo, size)?;
        let normal = self.prefiltered("normal", features.normal, size)?;
        // The library takes what is darker than 1e-8 for black: light of any strength is brought near to 1, exactly.
        let gain = automatic_stops(image, Tone::Aces).round().exp2();
        let color: Vec<Rgb> = image.data.iter().map(|pixel| finite(*pixel * gain)).collect();
        let inputs = [("color", &*color), ("albedo", &*albedo), ("normal", &*normal)];
        let clean = self.device.filter(&inputs, size, &[("hdr", true), ("cleanAux", true)])?;
        // A filter may fall below 0 beside bright edges, where there is no light.
        let data = clean.into_iter().map(|pixel| pixel.max(Rgb::ZERO) / gain).collect();
        Ok(Image { width: image.width, height: image.height, data })
    }

    fn prefiltered(&self, name: &'static str, values: &[Rgb], size: (usize, usize)) -> Result<Vec<Rgb>> {
        let values: Vec<Rgb> = values.iter().map(|value| finite(*value)).collect();
        self.device.filter(&[(name, &*values)], size, &[])
    }
}

fn finite(pixel: Rgb) -> Rgb {
    if pixel.is_finite() { pixel } else { Rgb::ZERO }
}
