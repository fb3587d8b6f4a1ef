//! What `phototaxis render` is asked for, and a render that goes on or is merged was.

use super::address::{self, Address};
use super::amounts;
use super::choices::Choices;
use super::frames::{self, FrameArguments};
use super::output::{Outputs, check_pictures, check_writable};
use super::progress::Show;
use crate::film::{FilmSettings, MAX_SIDE};
use crate::format;
use crate::format::SceneFile;
use crate::format::reference::help;
use crate::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, Updates};
use crate::image::{Exposure, Rectangle, Tone};
use crate::render::{Order, RenderSettings};
use anyhow::{Result, anyhow, bail, ensure};
use clap::{ArgGroup, Args};
use std::path::PathBuf;

const EXAMPLES: &str = "Examples:
  phototaxis render model.obj
  phototaxis render scene.toml --size 1920x1080 --time 1m30s -o out/scene.exr -o out/scene.png
  phototaxis render scene.toml --guide none --scale 50% --json -
  phototaxis render scene.toml --spp 256 --guide-out scene.guide
  phototaxis render scene.toml --time 8h -o scene.exr --checkpoint scene.checkpoint --preview scene.png
  phototaxis render scene.toml --time 8h -o scene.exr --serve
  phototaxis render model.obj --turntable 120 --time 30s -o turn/####.png
  phototaxis render scene.toml --spp 64 --guide-in scene.guide --set 'camera.origin=[0, 1, 4]'";

#[derive(Args, Clone, serde::Serialize, serde::Deserialize)]
#[command(after_help = EXAMPLES, group = ArgGroup::new("of_part").multiple(true))]
pub(crate) struct RenderArguments {
    /// Scene (.toml, .json, .xml, .gltf, .glb, .pbrt) or model (.obj, .ply).
    pub(super) scene: PathBuf,
    /// Picture to write, .exr (linear, all layers) or .png (sRGB); may be repeated. [default: both, named like the
    /// scene, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    /// Replaces what is there and would be kept: pictures of another scene that has the same name, frames, and a checkpoint.
    /// A single picture that --output names is replaced in any case.
    #[arg(long)]
    pub(super) force: bool,
    /// Size of the picture in pixels, for example 1920x1080. [default: the scene file's, else 1280x720]
    #[arg(long, value_name = "WxH", value_parser = amounts::size)]
    size: Option<(u32, u32)>,
    /// Scales the picture's size, for example 50%.
    #[arg(long, value_name = "PERCENT", value_parser = amounts::scale)]
    scale: Option<f64>,
    /// Renders a part of the picture alone, in pixels from the upper left of the whole as --size and --scale leave it.
    #[arg(long, value_name = "X,Y,W,H", value_parser = amounts::rectangle)]
    crop: Option<Rectangle>,
    #[arg(long, value_name = "N|1k", value_parser = amounts::count_u32, help = help("render.spp"))]
    spp: Option<u32>,
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds, help = help("render.time"))]
    time: Option<f64>,
    #[arg(long, value_name = "ERROR", value_parser = amounts::error, help = help("render.noise"))]
    noise: Option<f64>,
    #[arg(long, help = help("render.adaptive"))]
    #[serde(default)]
    adaptive: bool,
    /// Begins with what an earlier render of this scene learnt, whatever its camera.
    #[arg(long, value_name = "FILE")]
    pub(super) guide_in: Option<PathBuf>,
    /// Writes what was learnt, also when a signal stops the render; the last iteration then learns too.
    #[arg(long, value_name = "FILE")]
    pub(super) guide_out: Option<PathBuf>,
    /// Rewrites this picture, .png or .exr (colours, alpha, numbers of samples), again and again while it renders.
    #[arg(long, value_name = "FILE")]
    pub(super) preview: Option<PathBuf>,
    #[command(flatten)]
    #[serde(skip)]
    pub(super) displays: DisplayArguments,
    /// Rewrites this file again and again, and when a signal stops the render, with all that it takes to go on:
    /// phototaxis resume FILE.
    #[arg(long, value_name = "FILE")]
    pub(super) checkpoint: Option<PathBuf>,
    /// Time between two previews and between two checkpoints; more where writing one takes more than a twentieth of it.
    /// [default: 10s for previews, 5m for checkpoints]
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds)]
    pub(super) every: Option<f64>,
    /// Renders part K of N of the samples alone, into --film-out or --learn-out; merge makes a picture of all parts, the same
    /// however many they are, and guide merge a guide. Without a guide (--guide none), or with one from --guide-in, which then
    /// stays as it is.
    #[arg(long, value_name = "K/N", value_parser = amounts::part, requires = "of_part",
          conflicts_with_all = ["output", "time", "noise", "preview", "serve", "tev", "checkpoint", "guide_out", "guide_layers", "denoise", "json"])]
    pub(super) part: Option<(u32, u32)>,
    /// Where the samples of a part go.
    #[arg(long, value_name = "FILE", requires = "part", group = "of_part")]
    pub(super) film_out: Option<PathBuf>,
    /// Where what a part teaches the guide goes, that of --guide-in or one that knows nothing yet: guide merge has it learn from
    /// all parts.
    #[arg(long, value_name = "FILE", requires = "part", group = "of_part")]
    #[serde(skip)]
    pub(super) learn_out: Option<PathBuf>,
    #[command(flatten)]
    #[serde(skip)]
    pub(super) animation: FrameArguments,
    /// Adds layers to the EXR: guide.fraction, guide.visits, guide.state.
    #[arg(long)]
    pub(super) guide_layers: bool,
    #[arg(long, value_name = "LAYERS", value_delimiter = ',', help = help("render.layers"))]
    layers: Vec<String>,
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true, help = help("film.exposure"))]
    exposure: Option<Exposure>,
    /// Tone curve of the PNG: srgb (clamped), agx or aces (filmic). [default: the scene file's, else srgb;
    /// agx for a model]
    #[arg(long, value_name = "CURVE")]
    tone: Option<Tone>,
    #[command(flatten)]
    pub(super) choices: Choices,
    /// Removes the noise by Intel Open Image Denoise, which must be installed: the PNG shows the result, the EXR has it as
    /// denoised.{R,G,B} beside the picture as it was rendered.
    #[arg(long)]
    pub(super) denoise: bool,
    /// Makes errors of pictures of a material library that are missing or cannot be read, which else are warnings.
    #[arg(long)]
    strict: bool,
    /// How progress is shown on standard error.
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    pub(super) progress: Show,
    /// Writes the figures as JSON; "-" is standard output.
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Prints errors only.
    #[arg(short, long)]
    pub(super) quiet: bool,
    /// How the scene was named, where its path is another by now.
    #[arg(skip)]
    name: Option<String>,
    /// What holds whatever the scene file and the other arguments say.
    #[arg(skip)]
    pub(super) budget: Option<Budget>,
}

/// Where the picture is shown while it grows.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct DisplayArguments {
    /// Serves a page that shows the picture as it grows, its error, the speed and the guide, until the render ends; on this
    /// machine alone unless another host is named. [default: 127.0.0.1 and a port that is free, which is printed]
    #[arg(long, value_name = "HOST:PORT", value_parser = address::serve, num_args = 0..=1, require_equals = true,
          default_missing_value = "")]
    pub(super) serve: Option<Address>,
    /// Shows the picture as it grows in the viewer tev, which must be running, and all layers at the end.
    /// [default: 127.0.0.1:14158]
    #[arg(long, value_name = "HOST:PORT", value_parser = address::tev, num_args = 0..=1, require_equals = true,
          default_missing_value = "")]
    pub(super) tev: Option<Address>,
}

/// When a render ends.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Budget {
    /// Samples per pixel, seconds, and relative error.
    pub(super) spp: u32,
    pub(super) time: Option<f64>,
    pub(super) noise: Option<f64>,
}

impl Budget {
    fn of(render: &RenderSettings) -> Budget {
        Budget { spp: render.spp, time: render.time, noise: render.noise }
    }

    pub(super) fn set(self, render: &mut RenderSettings) {
        (render.spp, render.time, render.noise) = (self.spp, self.time, self.noise);
    }
}

impl RenderArguments {
    /// The scene as they describe it, with warnings.
    pub(super) fn load(&self) -> Result<(SceneFile, Vec<String>)> {
        let (mut description, warnings) =
            format::load_seen_by(&self.scene, self.choices.camera.as_deref(), &overrides(self))?;
        let film = &mut description.scene.film;
        self.scale.map_or(Ok(()), |scale| rescale(film, scale))?;
        self.crop.map_or(Ok(()), |part| crop(film, &part))?;
        self.budget.iter().for_each(|budget| budget.set(&mut description.render));
        Ok((description, warnings))
    }

    /// The files that will be written.
    pub(super) fn outputs(&self) -> Result<Outputs> {
        if self.part.is_some() {
            self.film_out.iter().chain(&self.learn_out).try_for_each(|path| check_writable(path))?;
            return Ok(Outputs::default());
        }
        if let Some(range) = self.animation.range()? {
            return frames::outputs(self, range.first(), true);
        }
        let (json, guide) = (self.json.as_ref(), self.guide_out.as_ref());
        Outputs::new(&self.output, json, guide, &self.scene, self.force)
    }

    /// How progress is shown.
    pub(super) fn show(&self) -> Show {
        if self.quiet { Show::None } else { self.progress }
    }

    /// The same render, of which nothing but pictures is to be written.
    pub(super) fn of_picture_alone(&self) -> RenderArguments {
        let (guide_in, guide_out, preview, checkpoint) = Default::default();
        RenderArguments {
            guide_in,
            guide_out,
            guide_layers: false,
            preview,
            displays: DisplayArguments::default(),
            animation: FrameArguments::default(),
            checkpoint,
            every: None,
            part: None,
            film_out: None,
            learn_out: None,
            ..self.clone()
        }
    }

    pub(super) fn name(&self) -> String {
        self.name.clone().unwrap_or_else(|| self.scene.display().to_string())
    }

    /// The same render, asked for from any folder, with the names and the budget that it has got.
    pub(super) fn settled(&self, outputs: &Outputs, render: &RenderSettings) -> Result<RenderArguments> {
        let output = match self.animation.range()? {
            Some(_) => frames::patterns(self)?,
            None => outputs.pictures().to_vec(),
        };
        let mut settled =
            RenderArguments { output, name: Some(self.name()), budget: Some(Budget::of(render)), ..self.clone() };
        let optional = [&mut settled.guide_in, &mut settled.guide_out, &mut settled.preview, &mut settled.checkpoint];
        let json = settled.json.iter_mut().filter(|path| path.as_os_str() != "-");
        let all = optional.into_iter().flatten().chain(json).chain(&mut settled.output);
        for path in all.chain([&mut settled.scene]) {
            *path = std::path::absolute(&path)?;
        }
        Ok(settled)
    }
}

/// Samples per pixel of a render that ends by time alone.
pub(super) const OPEN_ENDED: u32 = i32::MAX as u32;

/// The flags that stand for keys of the scene file, then `--set`, which has the last word.
fn overrides(arguments: &RenderArguments) -> Vec<String> {
    let open_ended = (arguments.time.is_some() || arguments.noise.is_some()) && arguments.spp.is_none();
    let spp = arguments.spp.or(open_ended.then_some(OPEN_ENDED));
    let budget = [spp.map(|n| format!("render.spp={n}")), arguments.time.map(|t| format!("render.time={t:?}"))];
    let noise = arguments.noise.map(|noise| format!("render.noise={noise:?}"));
    let layers = (!arguments.layers.is_empty()).then(|| format!("render.layers={:?}", arguments.layers));
    let adaptive = arguments.adaptive.then(|| "render.adaptive=true".to_string());
    let strict = arguments.strict.then(|| "render.strict=true".to_string());
    let size = arguments.size.map(|(width, height)| [format!("film.width={width}"), format!("film.height={height}")]);
    let view = [
        arguments.exposure.map(|exposure| format!("film.exposure={exposure}")),
        arguments.tone.map(|tone| format!("film.tone={}", tone.name())),
    ];
    arguments.choices.overrides(
        budget
            .into_iter()
            .chain([noise, adaptive])
            .chain(view)
            .flatten()
            .chain(layers)
            .chain(strict)
            .chain(size.into_iter().flatten()),
    )
}

/// The film in another size, of the same shape as far as whole pixels allow.
fn rescale(film: &mut FilmSettings, scale: f64) -> Result<()> {
    ensure!(film.crop.is_none(), "--scale and film.crop: give the part of the smaller picture by --crop");
    for side in [&mut film.width, &mut film.height] {
        let scaled = amounts::scaled(u64::from(*side), scale);
        ensure!(scaled <= MAX_SIDE.into(), "--scale makes a side of {scaled} pixels, and {MAX_SIDE} are the most");
        *side = scaled as u32;
    }
    Ok(())
}

fn crop(film: &mut FilmSettings, part: &Rectangle) -> Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(|_| anyhow!("--crop: {n} pixels are more than a picture has"));
    film.crop = Some([side(part.x)?, side(part.y)?, side(part.width)?, side(part.height)?]);
    film.check_crop().map_err(|error| anyhow!("--crop: {error}"))
}

const LEARNS_TOGETHER: &str = "--learn-out needs guiding.method auto, adaptive or grid, with guiding.normals, and guiding.table tree or \
    hemisphere: what other guides learn depends on the order of samples";

/// Refuses a part of a render whose samples depend on each other.
fn check_part(arguments: &RenderArguments, scene: &SceneFile) -> Result<()> {
    let (guiding, render) = (&scene.guiding, &scene.render);
    let (guided, teaches) = (guiding.method != GuidingMethod::None, arguments.learn_out.is_some());
    ensure!(
        !guided || arguments.guide_in.is_some() || teaches,
        "--part needs --guide none, or --guide-in with what was learnt before, or --learn-out: parts learn nothing of each other"
    );
    ensure!(guided || !teaches, "--learn-out needs a guide, and guiding.method is none");
    ensure!(!teaches || learns_from_sums(guiding), LEARNS_TOGETHER);
    ensure!(guiding.updates == Updates::Frozen, "--part needs guiding.updates = \"frozen\": its guide stays as it is");
    let ends_by_samples = render.time.is_none() && render.noise.is_none();
    ensure!(ends_by_samples, "--part needs a number of samples, and render.time or render.noise is given");
    ensure!(render.order == Order::Progressive, "--part needs render.order = \"progressive\"");
    ensure!(
        !render.adaptive,
        "--part cannot render adaptively: each part has as many samples of one pixel as of another"
    );
    Ok(())
}

/// Whether machines can teach such a guide together.
fn learns_from_sums(guiding: &GuidingSettings) -> bool {
    let space = match guiding.method {
        GuidingMethod::Auto | GuidingMethod::Adaptive => true,
        GuidingMethod::Grid => guiding.normals,
        GuidingMethod::None | GuidingMethod::Voronoi | GuidingMethod::SdTree => false,
    };
    space && guiding.table != DirectionTable::Sphere
}

/// Refuses options that could do nothing.
pub(super) fn check_options(arguments: &RenderArguments, scene: &SceneFile, outputs: &Outputs) -> Result<()> {
    let RenderArguments { guide_in, guide_out, guide_layers, preview, checkpoint, .. } = arguments;
    check_pictures(preview.as_slice())?;
    checkpoint.as_deref().map_or(Ok(()), check_writable)?;
    let blocks = scene.render.order == Order::Blocks;
    if arguments.part.is_some() {
        check_part(arguments, scene)?;
    }
    ensure!(checkpoint.is_none() || !blocks, "--checkpoint needs render.order = \"progressive\"");
    let rewrites = preview.is_some() || checkpoint.is_some();
    ensure!(arguments.every.is_none() || rewrites, "--every needs --preview or --checkpoint");
    let given =
        [("--guide-in", guide_in.is_some()), ("--guide-out", guide_out.is_some()), ("--guide-layers", *guide_layers)];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given)
        && scene.guiding.method == GuidingMethod::None
    {
        bail!("{option} needs a guide, and guiding.method is none");
    }
    if arguments.budget.is_some() || arguments.part.is_some() {
        // they were of use for what was to be written first
        return Ok(());
    }
    for (option, given) in [("--guide-layers", *guide_layers), ("--layers", !arguments.layers.is_empty())] {
        ensure!(!given || outputs.any("exr"), "{option} needs a picture in EXR");
    }
    let shown =
        outputs.any("png") || arguments.preview.as_ref().is_some_and(|p| p.extension().is_some_and(|e| e == "png"));
    for (option, given) in [("--exposure", arguments.exposure.is_some()), ("--tone", arguments.tone.is_some())] {
        ensure!(!given || shown, "{option} needs a picture in PNG: an EXR stays linear and unexposed");
    }
    Ok(())
}
