//! Where a render's pictures and figures go.

use super::beside::Beside;
use super::layers::{layers, mattes};
use super::names;
use super::report::{Context, Report};
use crate::film::accumulate::Estimate;
use crate::image::exr::{self, Attribute, DENOISED, Metadata, Window};
use crate::image::packed::{Packed, Packing};
use crate::image::{Image, png};
use crate::io::atomic::{try_folder, write_atomically};
use crate::io::clock::WallClock;
use crate::platform::Platform;
use crate::render::{Rendering, Stop, guide_file};
use anyhow::{Context as _, Result, bail};
use rayon::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Attributes of an EXR: stops and tone curve with which its picture was shown.
pub(super) const VIEW_EXPOSURE: &str = "viewExposure";
/// Keyword of a PNG's text with the same stops.
pub(super) const PNG_EXPOSURE: &str = "Exposure";
pub(super) const VIEW_TONE: &str = "viewTone";
/// The layer that it showed, where that is not the picture itself.
pub(super) const VIEW_LAYER: &str = "viewLayer";
/// Keyword of a PNG's text that names the scene, as the attribute `scene` of an EXR does.
pub(super) const PNG_SCENE: &str = "Scene";

/// The attribute of an EXR and the keyword of a PNG's text by which a picture says that its render was stopped, and with how many
/// samples per pixel.
pub(super) const EXR_INCOMPLETE: &str = "incomplete";
pub(super) const PNG_INCOMPLETE: &str = "Incomplete";

/// What a denoiser made of a picture.
pub(crate) struct Denoised {
    pub(crate) image: Image,
    pub(crate) seconds: f64,
    /// Its name and version.
    pub(crate) by: String,
}

/// The files that a render will write.
#[derive(Default)]
pub(crate) struct Outputs {
    pictures: Vec<PathBuf>,
    json: Option<PathBuf>,
    guide: Option<PathBuf>,
    /// The names were chosen, and have a number since the plain ones are another scene's.
    numbered: bool,
}

impl Outputs {
    /// Decides on names, and refuses before hours are spent on a picture that could not be written. Where no names are given,
    /// another scene's pictures are replaced only with `force`.
    pub(crate) fn new(
        pictures: &[PathBuf],
        json: Option<&PathBuf>,
        guide: Option<&PathBuf>,
        scene: &Path,
        force: bool,
    ) -> Result<Outputs> {
        let (pictures, numbered) = match pictures {
            [] => names::pictures(scene, force).map(|(own, numbered)| (own.to_vec(), numbered))?,
            given => (given.to_vec(), false),
        };
        check_pictures(&pictures)?;
        if let Some(path) = json.filter(|path| path.as_os_str() != "-") {
            check_writable(path)?;
        }
        if let Some(path) = guide {
            check_writable(path)?;
        }
        Ok(Outputs { pictures, json: json.cloned(), guide: guide.cloned(), numbered })
    }

    pub(crate) fn pictures(&self) -> &[PathBuf] {
        &self.pictures
    }

    /// Pictures and the guide.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.pictures.iter().chain(&self.guide)
    }

    /// What is to be said of names that were chosen.
    pub(crate) fn note(&self) -> Option<String> {
        let name = self.pictures.first().filter(|_| self.numbered)?;
        Some(format!(
            "note: there are pictures of another scene of that name, so these are {} and so on (--force replaces those)",
            name.display()
        ))
    }

    /// Whether a picture is in the format of this extension.
    pub(crate) fn any(&self, extension: &str) -> bool {
        self.pictures.iter().any(|path| path.extension().is_some_and(|e| e == extension))
    }

    /// Writes them all. One that fails does not keep the others from being written.
    pub(crate) fn write(&self, context: &Context, rendering: &Rendering, report: &Report) -> Result<()> {
        let estimate = &rendering.estimate;
        // A PNG is packed by one thread: that of a large picture takes as long as an EXR, which all threads pack.
        let pictures = self.pictures.par_iter().map(|path| match path.extension().is_some_and(|e| e == "exr") {
            true => packed(context.stop, |packing| exr_packer(context, rendering, packing)).write(path),
            false => packed(context.stop, |packing| png_packer(context, estimate, packing)).write(path),
        });
        let pictures: Vec<crate::Result<()>> = pictures.collect();
        let json = self.json.iter().map(|path| write_json(path, report));
        let guide = (self.guide.iter().zip(&rendering.guide)).map(|(path, guide)| {
            guide_file::write(path, guide, &context.subject, rendering.learnt_paths).map_err(anyhow::Error::from)
        });
        let failures: Vec<String> = pictures
            .into_iter()
            .map(|written| written.map_err(anyhow::Error::from))
            .chain(json)
            .chain(guide)
            .filter_map(|result| result.err().map(|e| format!("{e:#}")))
            .collect();
        if failures.is_empty() { Ok(()) } else { bail!(failures.join("\nerror: ")) }
    }
}

/// That pictures can be written there, and in the formats that their names ask for.
pub(super) fn check_pictures(paths: &[PathBuf]) -> Result<()> {
    paths.iter().try_for_each(|path| match path.extension().and_then(|e| e.to_str()) {
        Some("exr" | "png") => check_writable(path),
        _ => bail!("{}: pictures are written as .exr or .png", path.display()),
    })
}

/// Makes and removes an empty file beside `path`, unless that is a device or a pipe, which are written directly.
pub(super) fn check_writable(path: &Path) -> Result<()> {
    // A link is followed, as it will be when the file is written.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let problem = match target.metadata() {
        Ok(existing) if existing.is_dir() => Some("it is a folder".to_string()),
        Ok(existing) if !existing.is_file() => None,
        _ if !folder.is_dir() => Some("its folder does not exist".to_string()),
        _ => try_folder(folder).err().map(|e| format!("its folder takes no files: {}", e.kind())),
    };
    problem.map_or(Ok(()), |problem| bail!("{}: {problem}", path.display()))
}

/// The picture itself, linear.
pub(super) fn beauty(estimate: &Estimate) -> Image {
    let mut image = Image::new(estimate.width as usize, estimate.height as usize);
    image.data.copy_from_slice(&estimate.mean);
    image
}

/// Packs a picture tightly, or loosely once `stop` is urgent, also where that comes while it is being packed.
fn packed<W: FnOnce() -> Packed + Send + 'static>(stop: &Stop, packer: impl Fn(Packing) -> W) -> Packed {
    let mut tightly = Beside::new("packing", 0.0);
    if !stop.is_urgent() {
        tightly.begin(WallClock::start(), packer(Packing::Tight));
    }
    tightly.settle_unless(stop).unwrap_or_else(|| packer(Packing::Loose)())
}

/// What packs the PNG.
fn png_packer(context: &Context, estimate: &Estimate, packing: Packing) -> impl FnOnce() -> Packed + Send + use<> {
    let denoised = context.denoised.as_ref();
    let said = [
        Some((PNG_SCENE, context.name.clone())),
        denoised.map(|denoised| ("Denoiser", denoised.by.clone())),
        context.interrupted.then(|| (PNG_INCOMPLETE, estimate.samples.to_string())),
    ];
    let (image, view) = (denoised.map_or_else(|| beauty(estimate), |denoised| denoised.image.clone()), context.view);
    move || {
        let said: Vec<_> = said.iter().flatten().map(|(keyword, text)| (*keyword, text.as_str())).collect();
        png::pack(&image, &view, &said, packing)
    }
}

/// What packs the EXR.
fn exr_packer(context: &Context, rendering: &Rendering, packing: Packing) -> impl FnOnce() -> Packed + Send + use<> {
    let (metadata, layers, e) = (metadata(context, rendering), layers(rendering, context), &rendering.estimate);
    let window = Window::part(context.whole, context.scene.camera.corner(), [e.width, e.height]);
    move || exr::pack(&window, layers, &metadata, packing)
}

/// What an EXR says beside its pixels.
fn metadata(context: &Context, rendering: &Rendering) -> Metadata {
    let e = &rendering.estimate;
    let mut extra = Platform::of(context.scene.geometry().device()).attributes();
    extra.insert("scene".into(), Attribute::Text(context.name.clone()));
    let (exposure, tone) = (Attribute::Float(context.view.stops), Attribute::Text(context.view.tone.name().into()));
    extra.extend([(VIEW_EXPOSURE.into(), exposure), (VIEW_TONE.into(), tone)]);
    mattes(context).iter().for_each(|matte| extra.extend(matte.attributes()));
    if let Some(denoised) = &context.denoised {
        extra.insert(VIEW_LAYER.into(), Attribute::Text(DENOISED.into()));
        extra.insert("denoiser".into(), Attribute::Text(denoised.by.clone()));
    }
    if context.interrupted {
        extra.insert(EXR_INCOMPLETE.into(), Attribute::Int(i32::try_from(e.samples).unwrap_or(i32::MAX)));
    }
    Metadata {
        scene_hash: context.scene.hash_text(),
        samples_per_pixel: e.samples,
        render_time_seconds: rendering.wall_seconds as f32,
        seed: context.seed,
        extra,
    }
}

pub(super) fn write_json(path: &Path, report: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(report)? + "\n";
    if path.as_os_str() == "-" {
        return std::io::stdout().write_all(text.as_bytes()).context("standard output");
    }
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ViewTransform;

    /// What packs one pixel, or never ends.
    fn packer(packing: Packing, ends: bool) -> impl FnOnce() -> Packed + Send {
        move || {
            if !ends && packing == Packing::Tight {
                loop {
                    std::thread::park();
                }
            }
            png::pack(&Image::new(1, 1), &ViewTransform::default(), &[], packing)
        }
    }

    #[test]
    fn who_has_no_time_gets_pictures_that_are_packed_loosely_also_in_the_middle_of_packing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let stop = Stop::new();
        stop.ask();
        packed(&stop, |packing| packer(packing, true)).write(&path).unwrap();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(std::time::Duration::from_millis(50));
                stop.insist();
            });
            packed(&stop, |packing| packer(packing, false)).write(&path).unwrap();
        });
        // it is not even tried tightly
        packed(&stop, |packing| packer(packing, false)).write(&path).unwrap();
        assert!(png::text(&path, "Tone").is_some());
    }
}
