//! Where a render's pictures and figures go.

use super::report::{Context, Report};
use crate::film::accumulate::Estimate;
use crate::image::exr::{self, Attribute, Metadata, Window};
use crate::image::{Image, Layer, ViewTransform, png};
use crate::inspect::Layers;
use crate::io::atomic::{try_folder, write_atomically};
use crate::platform::Platform;
use crate::render::{Rendering, guide_file};
use anyhow::{Context as _, Result, bail};
use rayon::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Attributes of an EXR: stops and tone curve with which its picture was shown.
pub(super) const VIEW_EXPOSURE: &str = "viewExposure";
pub(super) const VIEW_TONE: &str = "viewTone";
/// Keyword of a PNG's text that names the scene, as the attribute `scene` of an EXR does.
const PNG_SCENE: &str = "Scene";

/// The files that a render will write.
pub struct Outputs {
    pictures: Vec<PathBuf>,
    json: Option<PathBuf>,
    guide: Option<PathBuf>,
}

impl Outputs {
    /// Decides on names, and refuses before hours are spent on a picture that could not be written.
    pub fn new(pictures: &[PathBuf], json: Option<&PathBuf>, guide: Option<&PathBuf>, scene: &Path) -> Result<Outputs> {
        let pictures = match pictures {
            [] => {
                let stem = PathBuf::from(scene.file_stem().context("the scene has no file name")?);
                vec![stem.with_extension("exr"), stem.with_extension("png")]
            }
            given => given.to_vec(),
        };
        for path in &pictures {
            match path.extension().and_then(|e| e.to_str()) {
                Some("exr" | "png") => check_writable(path)?,
                _ => bail!("{}: pictures are written as .exr or .png", path.display()),
            }
        }
        if let Some(path) = json.filter(|path| path.as_os_str() != "-") {
            check_writable(path)?;
        }
        if let Some(path) = guide {
            check_writable(path)?;
        }
        Ok(Outputs { pictures, json: json.cloned(), guide: guide.cloned() })
    }

    /// Pictures and the guide.
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.pictures.iter().chain(&self.guide)
    }

    pub fn any_exr(&self) -> bool {
        self.pictures.iter().any(|path| path.extension().is_some_and(|e| e == "exr"))
    }

    /// Writes them all. One that fails does not keep the others from being written.
    pub fn write(
        &self,
        context: &Context,
        rendering: &Rendering,
        report: &Report,
    ) -> Result<()> {
        let estimate = &rendering.estimate;
        // A PNG is packed by one thread: that of a large picture takes as long as an EXR, which all threads pack.
        let pictures = self.pictures.par_iter().map(|path| match path.extension().is_some_and(|e| e == "exr") {
            true => write_exr(path, context, rendering).map_err(anyhow::Error::from),
            false => write_png(path, context, &beauty(estimate)).map_err(anyhow::Error::from),
        });
        let pictures: Vec<Result<()>> = pictures.collect();
        let json = self.json.iter().map(|path| write_json(path, report));
        let guide = (self.guide.iter().zip(&rendering.guide)).map(|(path, guide)| {
            guide_file::write(path, guide, &context.subject, rendering.learnt_paths).map_err(anyhow::Error::from)
        });
        let failures: Vec<String> = pictures
            .into_iter()
            .chain(json)
            .chain(guide)
            .filter_map(|result| result.err().map(|e| format!("{e:#}")))
            .collect();
        if failures.is_empty() { Ok(()) } else { bail!(failures.join("\nerror: ")) }
    }
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

/// All that is known of a render, pixel by pixel; `guide` are the layers of the guide, where they are asked for.
pub(super) fn layers(rendering: &Rendering, guide: Option<&Layers>) -> Vec<Layer> {
    let e = &rendering.estimate;
    let features =
        |f: fn(&crate::film::tile::Aovs) -> crate::math::Rgb| -> Vec<_> { e.features.iter().map(f).collect() };
    let mut layers = vec![
        Layer::color("", &e.mean),
        Layer::color("variance", &e.variance),
        Layer::color("albedo", &features(|f| f.albedo)),
        Layer::vector("N", &features(|f| f.normal)),
        Layer::scalar("", "Z", e.features.iter().map(|f| f.depth).collect()),
        Layer::scalar("samples", "Y", (0..e.mean.len()).map(|i| e.count(i) as f32).collect()),
    ];
    layers.extend(guide.into_iter().flat_map(Layers::channels));
    layers
}

/// What a file's header says of how its picture is shown; its pixels are as they were.
pub(super) fn view_attributes(view: &ViewTransform) -> [(String, Attribute); 2] {
    let (exposure, tone) = (Attribute::Float(view.stops), Attribute::Text(view.tone.name().into()));
    [(VIEW_EXPOSURE.into(), exposure), (VIEW_TONE.into(), tone)]
}

fn write_png(path: &Path, context: &Context, image: &Image) -> crate::Result<()> {
    png::write(path, image, &context.view, &[(PNG_SCENE, &context.name)])
}

fn write_exr(path: &Path, context: &Context, rendering: &Rendering) -> crate::Result<()> {
    let e = &rendering.estimate;
    let mut extra = Platform::of(context.scene.geometry().device()).attributes();
    extra.insert("scene".into(), Attribute::Text(context.name.clone()));
    extra.extend(view_attributes(&context.view));
    let metadata = Metadata {
        scene_hash: context.scene.hash_text(),
        samples_per_pixel: e.samples,
        render_time_seconds: rendering.seconds as f32,
        seed: context.seed,
        extra,
    };
    let layers = layers(rendering, context.guide_layers.as_ref());
    exr::write(path, &Window::full(e.width as usize, e.height as usize), layers, &metadata)
}

pub(super) fn write_json(path: &Path, report: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(report)? + "\n";
    if path.as_os_str() == "-" {
        return std::io::stdout().write_all(text.as_bytes()).context("standard output");
    }
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}
