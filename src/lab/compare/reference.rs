//! What pictures are compared with: a long unguided render of our own, or a file.

use super::measure::{Reference, relative_noise};
use super::record::{ReferenceRecord, Source};
use crate::film::Combine;
use crate::film::accumulate::Estimate;
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::image::exr::{self, Attribute, Metadata, Window, read_layers, read_measured};
use crate::image::{Image, Layer};
use crate::integrator::SamplerKind;
use crate::math::Rgb;
use crate::platform::Platform;
use crate::render::{self, GuideIo, Order, Progress, Rendering, Stop};
use crate::scene::Scene;
use crate::{Error, Result};
use rustc_hash::FxHasher;
use std::hash::Hasher;
use std::path::Path;

/// Samples per pixel that a reference begins with.
const FIRST: u32 = 16;

/// Samples per pixel whose variance tells how many will be needed.
const TELLING: u32 = 64;

/// Seeds of references are far from those of runs.
pub(crate) const SEEDS: u64 = 1 << 60;

/// A render that is added to until it is good enough.
pub(crate) struct Growing {
    image: Image,
    /// Of the means.
    variance: Vec<Rgb>,
    samples: u32,
    seconds: f64,
}

/// How far a reference is to grow.
pub(crate) struct Growth<'a> {
    /// relMSE of its own that is good enough.
    pub(crate) wanted: f64,
    /// Seconds that it may take in all.
    pub(crate) time: f64,
    /// Seconds beyond which it is given up as soon as it seems to need them; `None`: never.
    pub(crate) patience: Option<f64>,
    /// What may end it early.
    pub(crate) stop: &'a Stop,
    /// Told in the middle of rendering how far it is.
    pub(crate) observer: &'a mut dyn FnMut(&Progress),
}

/// Of the reference of a scene: its name, and a hash of all that decides what it shows.
pub(crate) fn file_name(name: &str, scene: &Scene, description: &SceneFile) -> String {
    let mut hasher = FxHasher::default();
    hasher.write(format!("{} {:?}", scene.hash_text(), description.integrator).as_bytes());
    format!("{name}-{:016x}.exr", hasher.finish())
}

/// Reads a reference; its variance where the file has layers `variance.R`, `.G`, `.B`.
///
/// # Errors
/// As of [`read_measured`], which refuses denoised pictures; a picture of another size than the scene's, or with pixels that are not finite.
pub(crate) fn read(path: &Path, scene: &Scene) -> Result<Reference> {
    let image = read_measured(path, None, false)?;
    let (width, height) = (scene.camera.width as usize, scene.camera.height as usize);
    if (image.width, image.height) != (width, height) {
        let found = format!("{} × {}", image.width, image.height);
        return Err(Error::file(path, format!("the reference has {found} pixels, the scene {width} × {height}")));
    }
    if let Some(found) = Layer::non_finite(&[Layer::color("", &image.data)], width) {
        return Err(Error::file(path, format!("the reference cannot be compared with: {found}")));
    }
    let layers = read_layers(path)?;
    let channel = |suffix: &str| layers.channels.get(&format!("variance.{suffix}"));
    let variance = channel("R").zip(channel("G")).zip(channel("B")).map(|((r, g), b)| {
        let pixel = |i: usize| Rgb::new(r[i], g[i], b[i]).max(Rgb::ZERO);
        (0..image.data.len()).map(pixel).collect()
    });
    Ok(Reference { image, variance })
}

/// What is known of a reference that somebody else made.
pub(crate) fn record_of_file(path: &Path, reference: &Reference) -> ReferenceRecord {
    ReferenceRecord {
        source: Source::File,
        path: path.display().to_string(),
        samples: None,
        wall_seconds: None,
        relmse_noise: reference.noise(),
    }
}

impl Growing {
    /// What an earlier comparison left at `path`, or nothing yet.
    ///
    /// # Errors
    /// A file that is not what [`Growing::write`] writes.
    pub(crate) fn find(path: &Path, scene: &Scene) -> Result<Option<Growing>> {
        if !path.exists() {
            return Ok(None);
        }
        let Reference { image, variance } = read(path, scene)?;
        let attributes = read_layers(path)?.attributes;
        match (variance, attributes.get("samplesPerPixel"), attributes.get("renderTimeSeconds")) {
            (Some(variance), Some(&Attribute::Int(samples)), Some(&Attribute::Float(seconds))) if samples > 0 => {
                Ok(Some(Growing { image, variance, samples: samples as u32, seconds: f64::from(seconds) }))
            }
            _ => Err(Error::file(path, "this is no reference that was made here: remove it")),
        }
    }

    /// Renders until the noise is as wanted, the time is over, or it is stopped; `None` where that was
    /// before there was anything.
    pub(crate) fn grow(mut found: Option<Growing>, scene: &Scene, of: &SceneFile, growth: Growth) -> Option<Growing> {
        while let Some(samples) = found.as_ref().map_or(Some(FIRST), |f| f.next(growth.wanted, growth.time)) {
            if found.as_ref().is_some_and(|f| f.is_hopeless(&growth)) {
                break;
            }
            let taken = found.as_ref().map_or((0, 0.0), |f| (f.samples, f.seconds));
            let mut settings = super::scene_cache::settings(of);
            settings.guiding.method = GuidingMethod::None;
            settings.render.combine = Combine::All;
            settings.render.order = Order::Progressive;
            // their variance is taken off errors, so it must be no bound
            settings.render.sampler = SamplerKind::Independent;
            settings.render.spp = samples;
            settings.render.time = (taken.0 > 0).then_some(growth.time - taken.1);
            // As many as it has samples: never the same twice, however often it is added to.
            settings.render.seed = SEEDS + u64::from(taken.0);
            let keeping = GuideIo::default();
            let rendering = render::render_until(scene, &settings, keeping, growth.stop, &mut |progress| {
                (growth.observer)(progress);
                true
            });
            if growth.stop.is_asked() {
                break;
            }
            found = Some(Growing::merged(found, rendering.estimate, rendering.wall_seconds));
        }
        found
    }

    /// Samples to take next: what should do, but no more than there are; `None` where enough was done.
    fn next(&self, wanted: f64, time: f64) -> Option<u32> {
        let noise = self.noise();
        if noise <= wanted || self.seconds >= time || self.samples >= 1 << 29 {
            return None;
        }
        let missing = f64::from(self.samples) * (1.1 * noise / wanted - 1.0);
        Some(missing.clamp(f64::from(FIRST), f64::from(self.samples.max(FIRST))) as u32)
    }

    /// Whether the noise so far promises more time than anybody will wait for. Its estimate must rest on some samples.
    fn is_hopeless(&self, growth: &Growth) -> bool {
        let needed = self.seconds_for(growth.wanted);
        self.samples >= TELLING && growth.patience.is_some_and(|patience| needed > patience)
    }

    fn merged(before: Option<Growing>, new: Estimate, seconds: f64) -> Growing {
        let (width, height) = (new.width as usize, new.height as usize);
        let image = Image { width, height, data: new.mean };
        let Some(mut old) = before else {
            return Growing { image, variance: new.variance, samples: new.samples, seconds };
        };
        let share = new.samples as f32 / (old.samples + new.samples) as f32;
        for (i, new_mean) in image.data.iter().enumerate() {
            let mean = &mut old.image.data[i];
            *mean = *mean * (1.0 - share) + *new_mean * share;
            let variance = &mut old.variance[i];
            *variance = *variance * (1.0 - share).powi(2) + new.variance[i] * share.powi(2);
        }
        old.samples += new.samples;
        old.seconds += seconds;
        old
    }

    /// relMSE of its own.
    pub(crate) fn noise(&self) -> f64 {
        relative_noise(&self.image, &self.variance)
    }

    /// Seconds after which the noise would be as wanted.
    pub(crate) fn seconds_for(&self, wanted: f64) -> f64 {
        self.seconds * self.noise() / wanted
    }

    /// What is known of it; `file` is its place within the folder of the comparison.
    pub(crate) fn record(&self, file: &Path) -> ReferenceRecord {
        ReferenceRecord {
            source: Source::Made,
            path: file.display().to_string(),
            samples: Some(self.samples),
            wall_seconds: Some(self.seconds),
            relmse_noise: Some(self.noise()),
        }
    }

    /// Keeps it, with its variance, so that an error can be told from the reference's own noise. `seed` is the one that it
    /// was rendered with, or the first of several.
    ///
    /// # Errors
    /// All failures to write.
    pub(crate) fn write(&self, path: &Path, scene: &Scene, seed: u64) -> Result<()> {
        let image = &self.image;
        let layers = vec![Layer::color("", &image.data), Layer::color("variance", &self.variance)];
        let metadata = Metadata {
            scene_hash: scene.hash_text(),
            samples_per_pixel: self.samples,
            render_time_seconds: self.seconds as f32,
            seed,
            extra: Platform::of(scene.geometry().device()).attributes(),
        };
        exr::write(path, &Window::full(image.width, image.height), layers, &metadata)
    }

    /// The reference as it is.
    pub(crate) fn into_reference(self) -> Reference {
        Reference { image: self.image, variance: Some(self.variance) }
    }
}

/// What one render alone makes of it.
impl From<Rendering> for Growing {
    fn from(rendering: Rendering) -> Growing {
        Growing::merged(None, rendering.estimate, rendering.wall_seconds)
    }
}
