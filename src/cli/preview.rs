//! The picture so far, in a file that is written again and again.

use super::beside::Beside;
use super::output::{PNG_SCENE, beauty};
use super::progress::say;
use crate::film::FilmSettings;
use crate::film::accumulate::Estimate;
use crate::format::SceneFile;
use crate::image::exr::{self, Metadata, Window};
use crate::image::{Image, Layer, ViewTransform, png};
use crate::io::clock::WallClock;
use crate::render::{Moment, Occasion, Onlooker, Stop};
use crate::scene::Scene;
use std::path::{Path, PathBuf};

/// Seconds between two previews, where nothing else is asked for.
pub(super) const EVERY: f64 = 10.0;

/// What a preview says of itself.
#[derive(Clone)]
struct Subject {
    path: PathBuf,
    scene: String,
    film: FilmSettings,
    /// Where the picture stands in the whole that its camera sees.
    corner: [u32; 2],
    has_background: bool,
    seed: u64,
    scene_hash: String,
}

/// Writes previews, beside a render that goes on meanwhile.
pub(super) struct Preview {
    subject: Subject,
    writer: Beside<crate::Result<()>>,
    /// Whether one that could not be written has been told of, or nothing is to be told.
    told: bool,
}

impl Preview {
    /// In the file `path`, each `every` seconds and for the first time at the end of the first pass.
    pub(super) fn new(path: &Path, every: f64, name: &str, scene: &Scene, description: &SceneFile) -> Preview {
        let subject = Subject {
            path: path.to_path_buf(),
            scene: name.to_owned(),
            film: description.scene.film.clone(),
            corner: scene.camera.corner(),
            has_background: scene.lights().has_surroundings(),
            seed: description.render.seed,
            scene_hash: scene.hash_text(),
        };
        Preview { subject, writer: Beside::new("preview", every), told: false }
    }

    /// The same; `quiet`, it says nothing.
    pub(super) fn quietly(mut self, quiet: bool) -> Preview {
        self.told = quiet;
        self
    }

    /// Waits for the newest, unless `stop` is urgent. That one cannot be written is said once, and no reason to end the render.
    pub(super) fn settle(&mut self, stop: &Stop) {
        if let Some(Err(error)) = self.writer.settle_unless(stop)
            && !std::mem::replace(&mut self.told, true)
        {
            say(&format!("warning: {error}; there is no new preview, and the render goes on"));
        }
    }
}

impl Onlooker for Preview {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        self.writer.is_due(occasion)
    }

    fn look(&mut self, moment: &Moment) {
        let clock = WallClock::start();
        self.settle(moment.stop());
        let (subject, picture) = (self.subject.clone(), moment.picture());
        let coverage = if subject.is_exr() { moment.coverage() } else { Vec::new() };
        self.writer.begin(clock, move || subject.write(picture, coverage));
    }
}

impl Subject {
    fn is_exr(&self) -> bool {
        self.path.extension().is_some_and(|extension| extension == "exr")
    }

    fn write(&self, picture: Estimate, coverage: Vec<f32>) -> crate::Result<()> {
        match self.is_exr() {
            true => self.write_exr(&picture, coverage),
            false => self.write_png(&beauty(&picture)),
        }
    }

    fn write_png(&self, image: &Image) -> crate::Result<()> {
        let view = ViewTransform::of(self.film.exposure, self.film.tone, image);
        png::write(&self.path, image, &view, &[(PNG_SCENE, &self.scene)])
    }

    /// Colour, alpha and numbers of samples.
    fn write_exr(&self, picture: &Estimate, coverage: Vec<f32>) -> crate::Result<()> {
        let alpha = if self.has_background { vec![1.0; coverage.len()] } else { coverage };
        let samples = (0..picture.mean.len()).map(|i| picture.count(i) as f32).collect();
        let layers = vec![
            Layer::color("", &picture.mean),
            Layer::scalar("", "A", alpha),
            Layer::scalar("samples", "Y", samples),
        ];
        let metadata = Metadata {
            scene_hash: self.scene_hash.clone(),
            samples_per_pixel: picture.samples,
            seed: self.seed,
            ..Metadata::default()
        };
        let whole = [self.film.width, self.film.height];
        exr::write(&self.path, &Window::part(whole, self.corner, [picture.width, picture.height]), layers, &metadata)
    }
}
