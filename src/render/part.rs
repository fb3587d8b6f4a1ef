//! A range of the samples of a render, for machines that share it.
//!
//! All samples of such a render are drawn alike: without a guide, or with one that was learnt before and stays as it is. So a
//! sample depends on nothing but its number, and sums that do not depend on their order make the same picture of any parts.

use super::checkpoint::Header;
use super::guide_file::LoadedGuide;
use super::lesson::{Class, PartLesson};
use super::limits::Limits;
use super::onlooker::in_watts;
use super::schedule::Tiling;
use super::sealed::{Kind, SealedFile};
use super::state::new_guide;
use super::{IterationReport, Observer, Progress, Rendering, Settings, Stop};
use crate::Result;
use crate::film::accumulate::FEATURE_SAMPLES;
use crate::film::tile::Tile;
use crate::film::{ExactFilm, TileSums};
use crate::integrator::path::GuideUse;
use crate::integrator::{Batch, BatchResult, Counters, PathIntegrator, Task};
use crate::io::clock::CpuTime;
use crate::scene::Scene;
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

static KIND: Kind = Kind { magic: *b"PTXFILM\0", version: 2, name: "film" };

/// Camera paths between two reports of progress, at least.
const STRETCH: u64 = 1 << 18;

/// Which samples, by number, of how many per pixel in all.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Part {
    pub(crate) samples: Range<u32>,
    pub(crate) spp: u32,
}

impl Part {
    /// Part `number` of `parts`, counted from 1, which are as equal as can be; `None` where it would be empty.
    pub(crate) fn of(number: u32, parts: u32, spp: u32) -> Option<Part> {
        let bound = |n: u32| (u64::from(spp) * u64::from(n) / u64::from(parts)) as u32;
        let samples = bound(number.checked_sub(1)?)..bound(number);
        (number <= parts && !samples.is_empty()).then_some(Part { samples, spp })
    }
}

/// What took part in making samples, and how long that took.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Account {
    /// Tells guides apart.
    pub guide: Option<u64>,
    pub counters: Counters,
    wall_seconds: f64,
    cpu: CpuTime,
}

impl Account {
    fn add(&mut self, other: &Account) {
        self.counters.add(&other.counters);
        self.wall_seconds += other.wall_seconds;
        self.cpu += other.cpu;
    }
}

/// What is wanted of a part: its samples, or what they teach, or both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    pub(crate) film: bool,
    pub(crate) lesson: bool,
}

/// What was wanted of a part.
pub(crate) struct Done {
    part: Part,
    account: Account,
    film: Option<ExactFilm>,
    lesson: Option<PartLesson>,
}

/// Renders a part of a scene, with a guide that stays as it is or without one; `None` where it was stopped. What is to be learnt
/// where there is no guide yet is for one that knows nothing.
pub(crate) fn render_part(
    scene: &Scene,
    settings: &Settings,
    guide: Option<&LoadedGuide>,
    (part, wanted): (Part, Wanted),
    stop: &Stop,
    observer: Observer,
) -> Option<Done> {
    let limits = Limits::from_now(None, stop);
    let layers = settings.render.radiance_layers(scene.light_groups().names().len());
    let tiling = Tiling::of_single_samples(scene.camera.width, scene.camera.height);
    let tiles = tiling.tiles();
    let new = if wanted.lesson && guide.is_none() { new_guide(scene, &settings.guiding) } else { None };
    let used = guide.map(|loaded| &loaded.guide).or(new.as_ref());
    let view = guide.and_then(|loaded| loaded.view.as_ref());
    let efficiency = view.and_then(|view| view.of(&scene.hash_text(), &tiles, scene.camera.width));
    let work = Work {
        integrator: PathIntegrator {
            scene,
            camera: &scene.camera,
            settings: &settings.integrator,
            guide: used.map(|guide| GuideUse {
                field: guide.field(),
                settings: &settings.guiding,
                learn: wanted.lesson,
                efficiency: efficiency.as_ref(),
            }),
            seed: settings.render.seed ^ guide.map_or(0, |loaded| loaded.salt),
            sampler: settings.render.sampler,
            sequence: 0,
            features: false,
            ids: settings.render.wants_ids() && wanted.film,
            bounced: false,
            layers: &layers,
        },
        film: wanted.film.then(|| empty_film(scene, settings)),
        class: used.filter(|_| wanted.lesson).map(|guide| Class::new(guide, &tiles)),
        tiles,
        batches: Mutex::default(),
        stop,
    };
    let mut counters = Counters::default();
    let (pixels, all) = (scene.camera.width as u64 * scene.camera.height as u64, part.samples.len() as f64);
    let step = STRETCH.div_ceil(pixels) as usize;
    for first in part.samples.clone().step_by(step) {
        let samples = first..part.samples.end.min(first.saturating_add(step as u32));
        counters.add(&work.stretch(samples.clone())?);
        let (done, paths) = (samples.end - part.samples.start, counters.paths);
        let (share, wall_seconds) = (f64::from(done) / all, limits.elapsed());
        let progress = Progress { samples: done, share, wall_seconds, paths, training: false };
        if !observer(&progress) {
            return None;
        }
    }
    let guide = guide.map(|loaded| loaded.salt);
    let account = Account { guide, counters, wall_seconds: limits.elapsed(), cpu: limits.spent().cpu };
    Some(Done { part, account, film: work.film, lesson: work.class.map(Class::end) })
}

/// What threads work on.
struct Work<'a> {
    integrator: PathIntegrator<'a>,
    tiles: Vec<Tile>,
    film: Option<ExactFilm>,
    class: Option<Class<'a>>,
    batches: Mutex<Vec<Batch>>,
    stop: &'a Stop,
}

impl Work<'_> {
    /// Takes these samples of all pixels; `None` where that was stopped.
    fn stretch(&self, samples: Range<u32>) -> Option<Counters> {
        let tiles = &self.tiles;
        let task =
            |sample: u32| move |(k, tile): (usize, &Tile)| (k, Task { tile: *tile, first_sample: sample, samples: 1 });
        let tasks: Vec<(usize, Task)> = samples.flat_map(|sample| tiles.iter().enumerate().map(task(sample))).collect();
        let all = tasks.into_par_iter().map(|(k, task)| self.trace(k, &task));
        all.try_reduce(Counters::default, |mut all, counters| {
            all.add(&counters);
            Some(all)
        })
    }

    fn trace(&self, number: usize, task: &Task) -> Option<Counters> {
        let pool = || self.batches.lock().unwrap_or_else(PoisonError::into_inner);
        let mut batch = pool().pop().unwrap_or_default();
        let integrator = PathIntegrator { features: task.first_sample < FEATURE_SAMPLES, ..self.integrator };
        let result = match self.stop.is_due() {
            true => None,
            false => integrator.render_probed(task, &mut batch, &mut (), self.stop),
        };
        let result = result.inspect(|result| self.take(number, task, result));
        let (recorder, counters) = result.map_or((None, None), |result| (result.recorder, Some(result.counters)));
        recorder.into_iter().for_each(|recorder| batch.recorder = recorder.emptied());
        pool().push(batch);
        counters
    }

    /// Keeps what is wanted of a batch.
    fn take(&self, number: usize, task: &Task, result: &BatchResult) {
        self.film.iter().for_each(|film| film.add(number, &result.samples));
        if let Some((class, recorder)) = self.class.as_ref().zip(result.recorder.as_ref()) {
            class.learn(number, &task.tile, &result.samples, recorder);
        }
    }
}

fn empty_film(scene: &Scene, settings: &Settings) -> ExactFilm {
    let (width, height) = (scene.camera.width, scene.camera.height);
    let layers = settings.render.radiance_layers(scene.light_groups().names().len());
    ExactFilm::new(width, height, Tiling::of_single_samples(width, height).tiles(), &layers)
}

impl Done {
    /// Writes what was wanted, each file as a whole or not at all.
    ///
    /// # Errors
    /// All failures to write.
    pub(crate) fn write<R: Serialize>(
        self,
        header: &Header<R>,
        film_out: Option<&Path>,
        lesson_out: Option<&Path>,
    ) -> Result<()> {
        let Done { part, account, film, lesson } = self;
        if let Some((film, path)) = film.zip(film_out) {
            KIND.write(path, &(header, &part, &account, film.into_tiles()))?;
        }
        lesson.zip(lesson_out).map_or(Ok(()), |(lesson, path)| lesson.write(path, header, (&part, &account)))
    }
}

/// A film or lesson of a part, of which all but the sums is read.
pub(crate) struct PartFile<R> {
    path: PathBuf,
    pub(crate) header: Header<R>,
    pub(super) part: Part,
    pub(super) account: Account,
    pub(super) file: SealedFile,
}

impl<R: DeserializeOwned> PartFile<R> {
    pub(super) fn open(kind: &'static Kind, path: &Path) -> Result<PartFile<R>> {
        let mut file = kind.open(path)?;
        let (header, part, account) = (file.take()?, file.take()?, file.take()?);
        Ok(PartFile { path: path.to_path_buf(), header, part, account, file })
    }

    /// Processor time that the part took.
    pub(crate) fn cpu_seconds(&self) -> f64 {
        self.account.cpu.seconds()
    }
}

/// Whether a file is such a film, of whatever version.
pub(crate) fn is_film(path: &Path) -> bool {
    KIND.is_of(path)
}

/// Opens a film.
///
/// # Errors
/// [`crate::Error::Io`] where there is no such file; [`crate::Error::File`] for one that is no film, of another version, truncated
/// or damaged.
pub(crate) fn open<R: DeserializeOwned>(path: &Path) -> Result<PartFile<R>> {
    PartFile::open(&KIND, path)
}

/// Joins the films of all parts of a render, in any order; if `partial`, of those that there are.
///
/// # Errors
/// Films of another scene, of other settings, with another seed or guide; samples that two films hold, or, unless `partial`, none.
pub(crate) fn join<R>(
    scene: &Scene,
    settings: &Settings,
    mut files: Vec<PartFile<R>>,
    partial: bool,
) -> Result<Rendering> {
    check(scene, settings, &mut files, partial)?;
    let mut film = empty_film(scene, settings);
    let (mut counters, mut wall_seconds, mut cpu) = (Counters::default(), 0.0, CpuTime::default());
    // each film has as many samples of one pixel as of another
    let count = |below: u32| -> u32 {
        let of_file = |Range { start, end }: &Range<u32>| *end.min(&below) - *start.min(&below);
        files.iter().map(|file| of_file(&file.part.samples)).sum()
    };
    let (spp, averaged) = (count(u32::MAX), count(FEATURE_SAMPLES));
    for mut file in files {
        add_tiles(&mut film, &mut file.file)?;
        counters.add(&file.account.counters);
        wall_seconds += file.account.wall_seconds;
        cpu += file.account.cpu;
    }
    let iteration = IterationReport { samples: spp, wall_seconds, counters, ..IterationReport::default() };
    Ok(Rendering {
        estimate: in_watts(film.finish(spp, averaged), scene.light_unit()),
        iterations: vec![iteration],
        training: Vec::new(),
        samples: spp,
        wall_seconds,
        cpu,
        film_wall_seconds: 0.0,
        guide: None,
        verdict: None,
        learnt_paths: 0,
        relative_error: None,
        adaptive_tiles: None,
    })
}

/// Joins the films of neighbouring parts, in any order, into one of them all.
///
/// # Errors
/// As of [`join`]; and samples between two films that are in none.
pub(crate) fn join_films<R>(
    scene: &Scene,
    settings: &Settings,
    mut files: Vec<PartFile<R>>,
) -> Result<(Header<R>, Done)> {
    check(scene, settings, &mut files, true)?;
    for pair in files.windows(2) {
        let (end, start) = (pair[0].part.samples.end, pair[1].part.samples.start);
        if end < start {
            return Err(pair[1].file.error(&format!("samples {end} to {} before it are in no file", start - 1)));
        }
    }
    let mut film = empty_film(scene, settings);
    let mut joined: Option<(Header<R>, Part, Account)> = None;
    for mut file in files {
        add_tiles(&mut film, &mut file.file)?;
        let PartFile { header, part, account, .. } = file;
        joined = match joined {
            None => Some((header, part, account)),
            Some((header, mut all, mut sum)) => {
                all.samples.end = part.samples.end;
                sum.add(&account);
                Some((header, all, sum))
            }
        };
    }
    let (header, part, account) = joined.ok_or_else(|| crate::Error::Scene("there are no films to join".into()))?;
    Ok((header, Done { part, account, film: Some(film), lesson: None }))
}

/// Adds what a file holds, one tile after the other, so that there are never two films in memory.
fn add_tiles(film: &mut ExactFilm, file: &mut SealedFile) -> Result<()> {
    let malformed = |file: &SealedFile| file.error("it is malformed");
    // a sequence is its length and its elements
    if file.take::<usize>()? != film.tiles() {
        return Err(malformed(file));
    }
    for number in 0..film.tiles() {
        let sums: TileSums = file.take()?;
        if !film.add_sums(number, &sums) {
            return Err(malformed(file));
        }
    }
    if file.is_at_end() { Ok(()) } else { Err(malformed(file)) }
}

/// Puts parts in their order, if all are of the same render, and each sample is in one of them, or `partial`, in one at most.
pub(super) fn check<R>(scene: &Scene, settings: &Settings, files: &mut [PartFile<R>], partial: bool) -> Result<()> {
    files.sort_by_key(|file| file.part.samples.start);
    let Some(first) = files.first() else { return Ok(()) };
    let mut next = 0;
    for (k, file) in files.iter().enumerate() {
        file.header.conflict(scene, settings).map_or(Ok(()), |why| Err(file.file.error(why)))?;
        let bad = |what: &str| Err(file.file.error(&format!("{what} than {}", first.path.display())));
        if file.header.seed() != first.header.seed() {
            return bad("it has another seed");
        }
        if file.account.guide != first.account.guide {
            return bad("it was rendered with another guide");
        }
        if file.part.spp != first.part.spp {
            return bad("it is a part of more or fewer samples per pixel");
        }
        let Range { start, end } = file.part.samples;
        if start < next {
            let other = files[k - 1].path.display();
            return Err(file.file.error(&format!("its samples {start} to {} are in {other} too", next.min(end) - 1)));
        }
        if start > next && !partial {
            return Err(file.file.error(&format!("samples {next} to {} before it are in no file", start - 1)));
        }
        next = end;
    }
    if next < first.part.spp && !partial {
        let last = files.last().unwrap_or(first);
        return Err(last.file.error(&format!("samples {next} to {} after it are in no file", first.part.spp - 1)));
    }
    Ok(())
}

#[cfg(test)]
#[path = "part_tests.rs"]
mod tests;
