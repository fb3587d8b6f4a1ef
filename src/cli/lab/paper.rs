//! `phototaxis paper`: the pictures of Tan's paper on the project's own scenes, and a table of what they cost.

mod table;

use crate::cli::choices::Machine;
use crate::cli::inspect::pictures::Pictures;
use crate::cli::output::{Outputs, beauty};
use crate::cli::progress::say;
use crate::cli::render::{subject, watched};
use crate::cli::report::{Context, Report};
use crate::cli::signals::Signals;
use crate::format;
use crate::format::SceneFile;
use crate::image::exr::read_rgb;
use crate::image::{Exposure, Image, ViewTransform};
use crate::inspect::{Comparison, PixelVertex, Radiance};
use crate::lab::compare::reference::Growing;
use crate::lab::generate;
use crate::lab::paper::{Preset, View, presets};
use crate::render::{GuideIo, Rendering};
use crate::scene::Scene;
use anyhow::{Context as _, Result, bail};
use clap::Args;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use table::Row;

/// Paths that are traced for each direction of the truth that Q is drawn beside.
const TRUTH_SAMPLES: u32 = 256;

const NOTES: &str = "Writes NAME.png, NAME.exr and NAME.json for each preset, the scenes, and the references, and where Q is \
    shown NAME-latlong and NAME-hemisphere, learnt beside traced; a table of all goes to standard output and, as JSON, to paper.json. A reference-VIEW.exr that is there already, and of the right \
    size, is used as it is. The paper's number of samples is --spp 1024. What came of it: docs/paper.md.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct PaperArguments {
    /// Folder to write to; it is made if it is missing.
    #[arg(long, value_name = "DIR", default_value = "paper")]
    out: PathBuf,
    /// Renders this preset alone; may be repeated.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Lists the presets.
    #[arg(long)]
    list: bool,
    /// Width and height, 1 being 256 × 144 for the door.
    #[arg(long, value_name = "S", default_value_t = 0.5, value_parser = scale)]
    scale: f64,
    /// Samples per pixel of the door's pictures (the paper has 1024); wall and figure 3 have 32 as in the paper.
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Samples per pixel of the references.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
    reference_spp: u32,
    /// Seed of the random numbers; references have the next.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u64).range(..u64::MAX))]
    seed: u64,
    #[command(flatten)]
    machine: Machine,
    /// Prints the table and errors only.
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &PaperArguments) -> Result<ExitCode> {
    if arguments.list {
        presets().iter().try_for_each(|p| crate::cli::print(&format!("{:18} {}", p.name, p.about)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let chosen = choose(&arguments.only)?;
    let threads = arguments.machine.start(arguments.quiet)?;
    std::fs::create_dir_all(&arguments.out).with_context(|| arguments.out.display().to_string())?;
    let mut studio =
        PaperRun { arguments, threads, signals: Signals::catch(arguments.quiet)?, references: BTreeMap::new() };
    let mut rows = Vec::new();
    for preset in chosen {
        let Some(row) = studio.take(preset)? else { break };
        rows.push(row);
    }
    table::write(&rows, &arguments.out.join("paper.json"))?;
    table::print(&rows)?;
    Ok(studio.signals.exit_code())
}

fn choose(names: &[String]) -> Result<Vec<&'static Preset>> {
    if let Some(unknown) = names.iter().find(|name| presets().iter().all(|p| p.name != name.as_str())) {
        let known: Vec<&str> = presets().iter().map(|p| p.name).collect();
        bail!("no preset is called {unknown:?}; there are {}", known.join(", "));
    }
    Ok(presets().iter().filter(|p| names.is_empty() || names.iter().any(|name| name == p.name)).collect())
}

/// Renders presets, and what they are compared with.
struct PaperRun<'a> {
    arguments: &'a PaperArguments,
    /// For Embree.
    threads: usize,
    signals: Signals,
    references: BTreeMap<&'static str, Image>,
}

impl PaperRun<'_> {
    fn stopped(&self) -> bool {
        self.signals.came()
    }

    /// Renders and writes one preset; `None` where Ctrl-C came before it was done.
    fn take(&mut self, preset: &Preset) -> Result<Option<Row>> {
        let out = &self.arguments.out;
        let path = self.scene_file(preset.view)?;
        if !self.find_reference(preset.view, &path)? {
            return Ok(None);
        }
        let mut overrides = self.overrides(preset.view);
        overrides.push(format!("render.spp={}", preset.view.spp.unwrap_or(self.arguments.spp)));
        overrides.push(format!("render.seed={}", self.arguments.seed));
        overrides.extend(preset.overrides().map(String::from));
        let (mut description, _) = format::load(&path, &overrides)?;
        preset.place(&mut description.scene);
        let named = |extension: &str| out.join(format!("{}.{extension}", preset.name));
        let outputs = Outputs::new(&[named("png"), named("exr")], Some(&named("json")), None, &path, false)?;
        let keeping = GuideIo { from: None, keep: preset.shown.is_some() };
        let (scene, rendering) = self.render(preset.name, &description, keeping)?;
        let context = self.context(&scene, &path, &description, &rendering);
        let report = Report::new(&context, &rendering);
        outputs.write(&context, &rendering, &report)?;
        if let Some(found) = report.non_finite() {
            bail!("{}: {found}", named("exr").display());
        }
        if self.stopped() {
            return Ok(None);
        }
        let show = |at| self.show(preset, at, &scene, &description, &rendering);
        let q = preset.shown.map(show).transpose()?;
        Ok(Some(Row::new(preset, &rendering, &self.references[preset.view.name], q)?))
    }

    /// Draws what was learnt at a place of the picture beside what is traced there.
    fn show(
        &self,
        preset: &Preset,
        at: [f64; 2],
        scene: &Scene,
        description: &SceneFile,
        rendering: &Rendering,
    ) -> Result<Comparison> {
        let guide = rendering.guide.as_ref().context("there is no guide to look at")?;
        let sides = [scene.camera.width, scene.camera.height];
        let [x, y] = [0, 1].map(|axis| (at[axis] * f64::from(sides[axis])) as u32);
        let seen = PixelVertex::through(scene, x, y)
            .with_context(|| format!("behind pixel {x},{y} there is nothing to learn"))?;
        let seed = self.arguments.seed;
        let radiance = Radiance::new(scene, &description.integrator, guide, &seen, TRUTH_SAMPLES, seed);
        let prefix = format!("{}-", preset.name);
        let pictures = Pictures { folder: &self.arguments.out, prefix: &prefix, scene, seed, samples: TRUTH_SAMPLES };
        pictures.radiance(guide, &seen, &radiance)?;
        Ok(radiance.compare())
    }

    /// The scene's file in the folder of results, written if it is missing.
    fn scene_file(&self, view: &View) -> Result<PathBuf> {
        let path = self.arguments.out.join(view.scene).with_extension("toml");
        if !path.exists() {
            generate::generate(view.scene, &self.arguments.out)?;
        }
        Ok(path)
    }

    /// Size and camera of a view.
    fn overrides(&self, view: &View) -> Vec<String> {
        let [width, height] = self.size(view);
        let size = [format!("film.width={width}"), format!("film.height={height}")];
        size.into_iter().chain(view.camera.iter().map(|&s| s.into())).collect()
    }

    fn size(&self, view: &View) -> [u32; 2] {
        view.size.map(|side| (side as f64 * self.arguments.scale).round().max(1.0) as u32)
    }

    /// Reads a view's reference, or renders it with the scene's own settings; `false` where Ctrl-C came before it was
    /// done.
    fn find_reference(&mut self, view: &View, scene: &Path) -> Result<bool> {
        if self.references.contains_key(view.name) {
            return Ok(true);
        }
        let path = self.arguments.out.join(format!("reference-{}.exr", view.name));
        let [width, height] = self.size(view).map(|side| side as usize);
        if path.exists() {
            let found = read_rgb(&path)?;
            if (found.width, found.height) == (width, height) {
                self.references.insert(view.name, found);
                return Ok(true);
            }
        }
        let mut overrides = self.overrides(view);
        overrides.push(format!("render.spp={}", self.arguments.reference_spp));
        overrides.push(format!("render.seed={}", self.arguments.seed + 1));
        let (description, _) = format::load(scene, &overrides)?;
        let (scene, rendering) =
            self.render(&format!("the reference of {}", view.name), &description, GuideIo::default())?;
        if self.stopped() {
            return Ok(false);
        }
        let reference = Growing::from(rendering);
        reference.write(&path, &scene, self.arguments.seed + 1)?;
        self.references.insert(view.name, reference.into_reference().image);
        Ok(true)
    }

    fn render(&self, what: &str, description: &SceneFile, keeping: GuideIo) -> Result<(Scene, Rendering)> {
        if !self.arguments.quiet {
            say(&format!("rendering {what}"));
        }
        let (scene, _) = description.load_scene(self.threads)?;
        let rendering = watched(&scene, description, keeping, self.arguments.quiet, self.signals.stop());
        Ok((scene, rendering))
    }

    fn context<'s>(
        &'s self,
        scene: &'s Scene,
        path: &Path,
        description: &SceneFile,
        rendering: &Rendering,
    ) -> Context<'s> {
        let film = &description.scene.film;
        Context {
            scene,
            stop: self.signals.stop(),
            name: path.display().to_string(),
            seed: self.arguments.seed,
            interrupted: self.stopped(),
            load_seconds: 0.0,
            build_seconds: scene.build_seconds(),
            view: ViewTransform::of(film.exposure, film.tone, &beauty(&rendering.estimate)),
            exposure_auto: film.exposure == Exposure::Auto,
            subject: subject(scene, description),
            whole: [film.width, film.height],
            extra_layers: Vec::new(),
            guide_layers: None,
            denoised: None,
        }
    }
}

fn scale(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 64.0 => Ok(value),
        _ => Err("expected a number greater than 0 and at most 64".into()),
    }
}
