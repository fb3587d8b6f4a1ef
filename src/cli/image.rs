//! `phototaxis image`: another picture of what was rendered.

use super::amounts;
use super::output::{VIEW_EXPOSURE, VIEW_LAYER, VIEW_TONE, check_pictures};
use super::progress::say;
use crate::denoise::{Denoiser, Features};
use crate::image::exr::{self, Attribute, DENOISED, ExrFile, LAYER, Window, read_layers};
use crate::image::{Exposure, Image, Layer, Rectangle, Tone, ViewTransform, png, srgb};
use crate::math::Rgb;
use anyhow::{Context as _, Result, bail, ensure};
use clap::Args;
use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "Examples:
  phototaxis image a.exr --list
  phototaxis image a.exr -o a.png --exposure 1.5 --tone agx
  phototaxis image a.exr -o normals.png --layer N
  phototaxis image a.exr -o part.exr -o part.png --crop 100,50,640,360 --scale 50%";

/// What `--layer` calls the picture itself, which has no name in the file.
const BEAUTY: &str = "beauty";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ImageArguments {
    /// Picture to read (.exr).
    image: PathBuf,
    /// Picture to write, .png (as it is shown) or .exr (linear); may be repeated.
    #[arg(short, long, value_name = "FILE", required_unless_present = "list")]
    output: Vec<PathBuf>,
    /// Prints size, attributes and layers, and writes nothing.
    #[arg(long, conflicts_with_all = ["output", "layer", "exposure", "tone", "crop", "scale", "denoise"])]
    list: bool,
    /// Takes this layer; beauty is the picture itself. [default: for a PNG the one that its render showed, else the picture itself; for an EXR all]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Stops by which a PNG is brightened, or auto: by its log-average luminance, highlights kept. [default: as the render's
    /// PNG, else auto]
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true)]
    exposure: Option<Exposure>,
    /// Tone curve of a PNG: srgb (clamped), agx or aces (filmic). [default: as the render's PNG, else agx]
    #[arg(long, value_name = "CURVE")]
    tone: Option<Tone>,
    /// Takes only this part, in pixels from the upper left.
    #[arg(long, value_name = "X,Y,W,H", value_parser = amounts::rectangle)]
    crop: Option<Rectangle>,
    /// Makes it smaller, after cropping.
    #[arg(long, value_name = "PERCENT", value_parser = amounts::scale)]
    scale: Option<f64>,
    /// Removes the noise first, by Intel Open Image Denoise, which must be installed: adds the layer denoised, which a PNG
    /// then shows. Needs the layers albedo and N.
    #[arg(long, conflicts_with = "layer")]
    denoise: bool,
    /// Replaces the picture that is read.
    #[arg(long)]
    force: bool,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &ImageArguments) -> Result<ExitCode> {
    check(arguments)?;
    let denoiser = arguments.denoise.then(|| Denoiser::new(0)).transpose()?;
    let mut picture = Picture::of(read_layers(&arguments.image)?);
    if let Some(denoiser) = denoiser {
        picture.denoise(&denoiser).with_context(|| arguments.image.display().to_string())?;
    }
    if arguments.list {
        picture.list().iter().try_for_each(|line| super::print(line))?;
        return Ok(ExitCode::SUCCESS);
    }
    let picture = picture.changed(arguments).with_context(|| arguments.image.display().to_string())?;
    for path in &arguments.output {
        let what = match path.extension().is_some_and(|e| e == "exr") {
            true => picture.write_exr(path, arguments)?,
            false => picture.write_png(path, arguments)?,
        };
        if !arguments.quiet {
            say(&format!("wrote {}: {what}", path.display()));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Refuses what could do nothing or harm, before anything is read.
fn check(arguments: &ImageArguments) -> Result<()> {
    check_pictures(&arguments.output)?;
    let shown = arguments.exposure.is_some() || arguments.tone.is_some();
    let any_png = arguments.output.iter().any(|path| path.extension().is_some_and(|e| e == "png"));
    ensure!(any_png || !shown, "--exposure and --tone are for a PNG: an EXR stays linear and unexposed");
    ensure!(
        arguments.scale.is_none_or(|scale| scale <= 1.0),
        "--scale makes pictures smaller: more than 100% shows nothing more"
    );
    let own = arguments.output.iter().find(|path| is_same_file(path, &arguments.image));
    match own {
        Some(path) if !arguments.force => bail!("{}: that is the picture to read; --force replaces it", path.display()),
        _ => Ok(()),
    }
}

/// Whether both names, links or not, lead to one file.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let id = |path: &Path| path.metadata().ok().map(|m| (m.dev(), m.ino()));
    id(a).is_some_and(|own| id(b) == Some(own))
}

/// What a file holds.
struct Picture {
    width: usize,
    height: usize,
    layers: Vec<Layer>,
    attributes: BTreeMap<String, Attribute>,
}

/// A layer as a PNG shows it.
enum Shown {
    /// Light, which has an exposure.
    Light(Image),
    /// Numbers in [0, 1], which are stored as they are.
    Data(Image),
}

impl Picture {
    fn of(file: ExrFile) -> Picture {
        let (width, height, attributes) = (file.width, file.height, file.attributes.clone());
        Picture { width, height, layers: file.layers(), attributes }
    }

    /// What the picture says of itself.
    fn list(&self) -> Vec<String> {
        let mut lines = vec![format!("{} × {} pixels", self.width, self.height)];
        lines.extend(self.attributes.iter().map(|(name, value)| format!("{name}: {}", attribute_text(value))));
        lines.push(format!("{:20} {:12} {:>12} {:>12}", "layer", "channels", "least", "most"));
        lines.extend(self.layers.iter().map(|layer| {
            let suffixes: Vec<&str> = layer.channels.iter().map(|(suffix, _)| &**suffix).collect();
            let name = if layer.name.is_empty() { BEAUTY } else { &layer.name };
            let (least, most) = range(layer.channels.iter().flat_map(|(_, values)| values).copied());
            format!("{name:20} {:12} {least:>12.5} {most:>12.5}", suffixes.join(" "))
        }));
        lines
    }

    /// Adds the layer without noise, and shows that.
    fn denoise(&mut self, denoiser: &Denoiser) -> Result<()> {
        let vectors = |name: &str, suffixes: [&str; 3]| {
            let found = self.layers.iter().find(|layer| layer.name == name).and_then(|layer| layer.vectors(suffixes));
            found.with_context(|| {
                format!("--denoise needs the channels {}", suffixes.map(|s| format!("{name}.{s}")).join(", "))
            })
        };
        let data = vectors("", ["R", "G", "B"])?;
        let albedo = vectors("albedo", ["R", "G", "B"])?;
        // pictures of earlier versions have shading normals under the other name
        let normal = vectors("Ns", ["X", "Y", "Z"]).or_else(|_| vectors("N", ["X", "Y", "Z"]))?;
        let image = Image { width: self.width, height: self.height, data };
        let clean = denoiser.denoise(&image, &Features { albedo: &albedo, normal: &normal })?;
        self.layers.retain(|layer| layer.name != DENOISED);
        self.layers.push(Layer::color(DENOISED, &clean.data));
        self.attributes.insert(VIEW_LAYER.into(), Attribute::Text(DENOISED.into()));
        self.attributes.insert("denoiser".into(), Attribute::Text(denoiser.version().into()));
        Ok(())
    }

    /// The chosen layers, cropped and made smaller.
    fn changed(mut self, arguments: &ImageArguments) -> Result<Picture> {
        if let Some(name) = &arguments.layer {
            self.layers = vec![self.layer(name)?];
        }
        if let Some(part) = &arguments.crop {
            let fits = |from: usize, length: usize, all: usize| from.checked_add(length).is_some_and(|end| end <= all);
            ensure!(
                fits(part.x, part.width, self.width) && fits(part.y, part.height, self.height),
                "--crop reaches beyond the picture, which has {} × {} pixels",
                self.width,
                self.height
            );
            self.layers = self.layers.iter().map(|layer| layer.crop(self.width, part)).collect();
            (self.width, self.height) = (part.width, part.height);
        }
        if let Some(scale) = arguments.scale {
            let side = |side: usize| amounts::scaled(side as u64, scale) as usize;
            let (size, smaller) = ((self.width, self.height), (side(self.width), side(self.height)));
            self.layers = self.layers.iter().map(|layer| layer.shrink(size, smaller)).collect();
            (self.width, self.height) = smaller;
        }
        Ok(self)
    }

    /// A layer by its name, or a channel by its full name.
    fn layer(&self, name: &str) -> Result<Layer> {
        let name = if name == BEAUTY { "" } else { name };
        if let Some(layer) = self.layers.iter().find(|layer| layer.name == name) {
            return Ok(layer.clone());
        }
        for layer in &self.layers {
            if let Some(channel) = layer.channels.iter().find(|(suffix, _)| layer.channel_name(suffix) == name) {
                return Ok(Layer { name: layer.name.clone(), channels: vec![channel.clone()] });
            }
        }
        let names: Vec<&str> =
            self.layers.iter().map(|layer| if layer.name.is_empty() { BEAUTY } else { &*layer.name }).collect();
        bail!("there is no layer `{name}`: there are {}", crate::document::list(&names))
    }

    /// Writes all layers, or the chosen one, whose colours become those of the picture itself. Returns what was written.
    fn write_exr(&self, path: &Path, arguments: &ImageArguments) -> Result<String> {
        let (mut layers, mut attributes) = (self.layers.clone(), self.attributes.clone());
        if let Some(name) = arguments.layer.as_ref().filter(|name| *name != BEAUTY) {
            attributes.insert(LAYER.into(), Attribute::Text(name.clone()));
            attributes.remove(VIEW_LAYER);
            layers.iter_mut().filter(|layer| layer.colors().is_some()).for_each(|layer| layer.name.clear());
        }
        let what = arguments.layer.as_ref().map_or("all layers".into(), |name| format!("layer {name}"));
        exr::write_with(path, &Window::full(self.width, self.height), layers, &attributes)?;
        Ok(format!("{what}, {} × {} pixels", self.width, self.height))
    }

    fn write_png(&self, path: &Path, arguments: &ImageArguments) -> Result<String> {
        let name = match &arguments.layer {
            Some(name) => name.clone(),
            None => self.text(VIEW_LAYER).filter(|name| self.layer(name).is_ok()).unwrap_or_default(),
        };
        let layer = if arguments.layer.is_some() { self.layers[0].clone() } else { self.layer(&name)? };
        let size = format!("{} × {} pixels", self.width, self.height);
        let what = if name.is_empty() { String::new() } else { format!("layer {name}, ") };
        match self.shown(&layer)? {
            Shown::Light(image) => {
                let view = self.view(arguments, &name, &image);
                png::write(path, &image, &view, &[])?;
                Ok(format!("{what}{size}, exposure {:+} stops, tone {}", view.stops, view.tone.name()))
            }
            Shown::Data(image) => {
                let told = arguments.exposure.is_some() || arguments.tone.is_some();
                ensure!(!told, "layer {name} is no light: it has no exposure and no tone curve");
                png::write(path, &image, &ViewTransform::default(), &[])?;
                Ok(format!("{what}{size}"))
            }
        }
    }

    /// Colours are light; vectors in [−1, 1] become colours in [0, 1]; of single numbers the least are black and the largest
    /// white.
    fn shown(&self, layer: &Layer) -> Result<Shown> {
        let image = |data| Image { width: self.width, height: self.height, data };
        // What is stored is to be the number itself, so the transfer curve is undone.
        let stored = |x: f32| srgb::decode(x.clamp(0.0, 1.0));
        if let Some(colors) = layer.colors() {
            return Ok(Shown::Light(image(colors)));
        }
        if let Some(vectors) = layer.vectors(["X", "Y", "Z"]) {
            let color = |v: &glam::Vec3| Rgb::from((*v * 0.5 + 0.5).to_array().map(stored));
            return Ok(Shown::Data(image(vectors.iter().map(color).collect())));
        }
        let [(_, values)] = &*layer.channels else {
            let names: Vec<String> = layer.channels.iter().map(|(suffix, _)| layer.channel_name(suffix)).collect();
            let names: Vec<&str> = names.iter().map(|name| &**name).collect();
            bail!(
                "a PNG shows colours, vectors or one channel: choose by --layer among {}",
                crate::document::list(&names)
            );
        };
        let (least, most) = range(values.iter().copied());
        let extent = if most > least { most - least } else { 1.0 };
        Ok(Shown::Data(image(values.iter().map(|x| Rgb::splat(stored((x - least) / extent))).collect())))
    }

    /// As asked for, else as the render's own PNG. An albedo is no light of unknown strength.
    fn view(&self, arguments: &ImageArguments, name: &str, image: &Image) -> ViewTransform {
        let albedo = name == "albedo";
        let stops = match self.attributes.get(VIEW_EXPOSURE) {
            _ if albedo => Exposure::Stops(0.0),
            Some(Attribute::Float(stops)) => Exposure::Stops(*stops),
            _ => Exposure::Auto,
        };
        let tone = match self.text(VIEW_TONE).and_then(|name| name.parse().ok()) {
            _ if albedo => Tone::Srgb,
            own => own.unwrap_or(Tone::Agx),
        };
        ViewTransform::of(arguments.exposure.unwrap_or(stops), arguments.tone.unwrap_or(tone), image)
    }

    fn text(&self, attribute: &str) -> Option<String> {
        match self.attributes.get(attribute) {
            Some(Attribute::Text(text)) => Some(text.clone()),
            _ => None,
        }
    }
}

fn attribute_text(value: &Attribute) -> String {
    match value {
        Attribute::Text(text) => text.clone(),
        Attribute::Int(n) => n.to_string(),
        Attribute::Float(x) => x.to_string(),
    }
}

/// The least and the largest of the numbers that are finite; 0 where there are none.
fn range(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let finite = values.filter(|x| x.is_finite());
    let (least, most) = finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if least > most { (0.0, 0.0) } else { (least, most) }
}
