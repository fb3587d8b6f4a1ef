//! What the integration tests share: scenes, renders, and statistics of renders that are independent of each other.

#![allow(dead_code, reason = "every test binary is compiled with all of this and needs a part of it")]

pub mod browser;
pub mod hall;
pub mod masked_lamp;
pub mod square;
pub mod still_life;

use phototaxis::embree::{Device, Isa};
use phototaxis::film::accumulate::Estimate;
use phototaxis::format;
use phototaxis::format::SceneFile;
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::math::{Rgb, luminance};
use phototaxis::render::{Rendering, Settings, render};
use phototaxis::scene::Scene;
use phototaxis::scene::description::MaterialDescription;
use phototaxis::stats::Summary;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A loaded scene and what its file says beside it.
pub struct Loaded {
    pub scene: Scene,
    pub settings: Settings,
}

/// One of the project's own scenes, with `--set` overrides.
pub fn own(name: &str, overrides: &[&str]) -> Loaded {
    load(&own_path(name), overrides)
}

pub fn own_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("toml")
}

pub fn load(path: &Path, overrides: &[&str]) -> Loaded {
    build(&describe(path, overrides))
}

pub fn describe(path: &Path, overrides: &[&str]) -> SceneFile {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    format::load(path, &overrides).unwrap_or_else(|error| panic!("{error}")).0
}

/// Threads of Embree's build: all.
const ALL: usize = 0;

pub fn build(description: &SceneFile) -> Loaded {
    build_on(Device::new(ALL), description)
}

/// The same with Embree held to an instruction set.
pub fn build_with(isa: Isa, description: &SceneFile) -> Loaded {
    build_on(Device::held_to(Some(isa), ALL), description)
}

fn build_on(device: phototaxis::Result<Arc<Device>>, description: &SceneFile) -> Loaded {
    let loaded = device.and_then(|device| description.load_scene_on(device));
    let (scene, _) = loaded.unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings {
        integrator: description.integrator.clone(),
        guiding: description.guiding.clone(),
        render: description.render.clone(),
    };
    Loaded { scene, settings }
}

/// Text files of a scene in a folder of their own, the scene file being `scene.toml`.
pub fn written(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    folder
}

/// Loads `scene.toml` of a [`written`] folder.
pub fn load_written(files: &[(&str, &str)], overrides: &[&str]) -> Loaded {
    load(&written(files).path().join("scene.toml"), overrides)
}

/// The folder of scenes with references; `None`, after saying so, where there is none.
pub fn shared_scenes() -> Option<PathBuf> {
    let root = std::env::var_os("PHOTOTAXIS_SCENES")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"), PathBuf::from);
    if root.is_dir() {
        return Some(root);
    }
    eprintln!("SKIPPED: no folder of scenes at {}", root.display());
    None
}

/// Scales the emission of the materials named; everything else of a scene stays as it is.
pub fn scale_emission(description: &mut SceneFile, scale: f32, emitters: &[(&str, MaterialDescription)]) {
    for (name, material) in emitters {
        let scaled = MaterialDescription { emission: material.emission * scale, ..material.clone() };
        description.scene.materials.insert((*name).into(), scaled);
    }
}

impl Loaded {
    pub fn render(&self, settings: &Settings) -> Rendering {
        let rendering = render(&self.scene, settings, &mut |_| true);
        for iteration in &rendering.iterations {
            assert_eq!(iteration.counters.non_finite, 0, "a sample is not finite");
        }
        rendering
    }

    pub fn estimate(&self, settings: &Settings) -> Estimate {
        self.render(settings).estimate
    }

    /// The scene's settings without a guide.
    pub fn unguided(&self) -> Settings {
        let mut settings = self.settings.clone();
        settings.guiding.method = GuidingMethod::None;
        settings
    }

    /// The luminance of the whole picture and of its blocks, run by run. Runs are independent: each has a seed of
    /// its own, counted from `first_seed`.
    pub fn runs(&self, settings: &Settings, runs: usize, first_seed: u64) -> Runs {
        let one = |k: usize| {
            let mut settings = settings.clone();
            settings.render.seed = first_seed + k as u64;
            blocks(&self.estimate(&settings))
        };
        // One small picture keeps one core busy; many keep all.
        let values: Vec<Vec<f64>> = (0..runs).into_par_iter().map(one).collect();
        Runs { values }
    }
}

/// Blocks along each side of a picture.
const BLOCKS: usize = 4;

/// Mean luminance of the picture, then of its 4 × 4 blocks row by row.
pub fn blocks(picture: &Estimate) -> Vec<f64> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let mut sums = vec![(0.0, 0.0); 1 + BLOCKS * BLOCKS];
    for (i, value) in picture.mean.iter().enumerate() {
        let block = (i / width * BLOCKS / height) * BLOCKS + i % width * BLOCKS / width;
        for k in [0, 1 + block] {
            sums[k].0 += luminance(*value) as f64;
            sums[k].1 += 1.0;
        }
    }
    sums.into_iter().map(|(sum, pixels)| sum / pixels).collect()
}

/// Values of independent runs: the picture's mean, then its blocks.
pub struct Runs {
    values: Vec<Vec<f64>>,
}

impl Runs {
    /// Mean and spread of value `k` over the runs.
    pub fn summary(&self, k: usize) -> Summary {
        let column: Vec<f64> = self.values.iter().map(|run| run[k]).collect();
        Summary::of(&column).expect("at least two runs, all finite")
    }

    /// The same runs, a planted `factor` brighter.
    pub fn scaled(&self, factor: f64) -> Runs {
        let values = self.values.iter().map(|run| run.iter().map(|v| v * factor).collect()).collect();
        Runs { values }
    }

    /// Runs of several kinds as one set.
    pub fn together(kinds: Vec<Runs>) -> Runs {
        Runs { values: kinds.into_iter().flat_map(|kind| kind.values).collect() }
    }
}

/// Welch's t of some runs against many `plain` ones, and its two-sided p-value. A run's variance counts as no smaller
/// than a plain run's: a few runs that all missed what is rare and bright have both a low mean and little spread, and
/// would be called significantly too dark.
pub fn welch(some: &Summary, plain: &Summary) -> (f64, f64) {
    let (va, vb) = (some.variance.max(plain.variance) / some.runs as f64, plain.variance / plain.runs as f64);
    if va + vb == 0.0 {
        return if some.mean == plain.mean { (0.0, 1.0) } else { (f64::INFINITY, 0.0) };
    }
    let t = (some.mean - plain.mean) / (va + vb).sqrt();
    let freedom = (va + vb).powi(2) / (va * va / (some.runs - 1) as f64 + vb * vb / (plain.runs - 1) as f64);
    let law = StudentsT::new(0.0, 1.0, freedom).expect("positive degrees of freedom");
    (t, 2.0 * law.cdf(-t.abs()))
}

/// Mean colour of a picture in double precision.
pub fn mean_color(pixels: &[Rgb]) -> [f64; 3] {
    let sum = pixels.iter().fold([0.0; 3], |sum, p| [0, 1, 2].map(|c| sum[c] + p[c] as f64));
    sum.map(|s: f64| s / pixels.len() as f64)
}

/// Mean of the red channel over the picture, with its standard error.
pub fn mean_and_error(picture: &Estimate) -> (f64, f64) {
    let variance: f64 = picture.variance.iter().map(|v| v.x as f64).sum();
    (mean_color(&picture.mean)[0], variance.sqrt() / picture.variance.len() as f64)
}
