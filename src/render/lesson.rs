//! What a guide learns from an iteration that machines share: each writes what its part of the samples taught, and the guide takes in
//! all of it at once.

use super::Settings;
use super::checkpoint::Header;
use super::guide_file::LoadedGuide;
use super::part::{Account, Part, PartFile, check};
use super::schedule::Tiling;
use super::sealed::{Kind, SealedFile};
use super::state::new_guide;
use super::view::{View, ViewSums};
use crate::Result;
use crate::film::tile::{Tile, TileSamples};
use crate::guiding::{Guide, Lesson, Recorder, RegionId, RegionSums};
use crate::integrator::Counters;
use crate::scene::Scene;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

pub(super) static KIND: Kind = Kind { magic: *b"PTXLESSN", version: 2, name: "lesson" };

/// A guide, and what is to be told to it.
pub(super) struct Class<'a> {
    pub guide: &'a Guide,
    lesson: Lesson,
    view: ViewSums,
}

impl<'a> Class<'a> {
    pub fn new(guide: &'a Guide, tiles: &[Tile]) -> Class<'a> {
        Class { guide, lesson: Lesson::new(), view: ViewSums::new(tiles) }
    }

    /// Takes one sample of each pixel of tile `number`.
    pub fn learn(&self, number: usize, tile: &Tile, samples: &TileSamples, recorder: &Recorder) {
        self.view.add(number, tile, samples);
        self.lesson.learn(self.guide, recorder, number);
    }

    pub fn end(self) -> PartLesson {
        PartLesson { lesson: self.lesson, view: self.view }
    }
}

/// What a part of an iteration taught.
pub(crate) struct PartLesson {
    lesson: Lesson,
    view: ViewSums,
}

impl PartLesson {
    /// Writes it, as a whole or not at all.
    ///
    /// # Errors
    /// All failures to write.
    pub(super) fn write<R: Serialize>(
        self,
        path: &Path,
        header: &Header<R>,
        (part, account): (&Part, &Account),
    ) -> Result<()> {
        KIND.write(path, &(header, part, account, self.view, self.lesson.into_shards()))
    }
}

/// Opens a lesson.
///
/// # Errors
/// [`crate::Error::Io`] where there is no such file; [`crate::Error::File`] for one that is no lesson, of another version, truncated
/// or damaged.
pub(crate) fn open<R: DeserializeOwned>(path: &Path) -> Result<PartFile<R>> {
    PartFile::open(&KIND, path)
}

/// A guide that has learnt, as it is written.
pub(crate) struct Taught {
    pub(crate) guide: Guide,
    /// Camera paths of the iteration.
    pub(crate) paths: u64,
    pub(crate) view: Option<View>,
}

/// Tells a guide, or one that knows nothing yet, all lessons of an iteration, in any order.
///
/// # Errors
/// Lessons of another scene, of other settings, with another seed or another guide; samples that two lessons hold, or none; lessons
/// that no paths can have taught.
pub(crate) fn teach<R>(
    scene: &Scene,
    settings: &Settings,
    guide: Option<LoadedGuide>,
    mut files: Vec<PartFile<R>>,
) -> Result<Taught> {
    let salt = guide.as_ref().map(|guide| guide.salt);
    if let Some(file) = files.iter().find(|file| file.account.guide != salt) {
        let text = match (salt, file.account.guide) {
            (Some(_), None) => "it was learnt without a guide, and --guide-in gives one",
            (None, _) => "it was learnt with a guide: --guide-in has to give that",
            _ => "it was learnt with another guide than that of --guide-in",
        };
        return Err(file.file.error(text));
    }
    check(scene, settings, &mut files, false)?;
    let guide = guide.map(|guide| guide.guide).or_else(|| new_guide(scene, &settings.guiding));
    let (Some(mut guide), Some(first)) = (guide, files.first()) else {
        unreachable!("lessons are of scenes with a guide, and there is one at least");
    };
    let (samples, width) = (first.part.spp, scene.camera.width);
    let tiles = Tiling::of_single_samples(width, scene.camera.height).tiles();
    let (mut lesson, mut view, mut counters) = (Lesson::new(), ViewSums::new(&tiles), Counters::default());
    for file in &mut files {
        add(&mut lesson, &mut view, &mut file.file)?;
        counters.add(&file.account.counters);
    }
    let paths = u64::from(samples) * u64::from(width) * u64::from(scene.camera.height);
    guide.take_in(lesson, paths).map_err(|why| files[0].file.error(&format!("{why}, or in one of the others")))?;
    let learnt = (guide.learnt_paths() * u64::from(samples) / paths) as u32;
    let view = view.finish(&tiles, samples, learnt, &counters).map(|roulette| View::new(scene.hash_text(), roulette));
    Ok(Taught { guide, paths, view })
}

/// Adds what a file holds, one shard after the other.
fn add(lesson: &mut Lesson, view: &mut ViewSums, file: &mut SealedFile) -> Result<()> {
    let malformed = |file: &SealedFile| file.error("it is malformed");
    let sums: ViewSums = file.take()?;
    // a sequence is its length and its elements
    if !view.add_sums(sums) || file.take::<usize>()? != Lesson::SHARDS {
        return Err(malformed(file));
    }
    for number in 0..Lesson::SHARDS {
        let shard: Vec<(RegionId, RegionSums)> = file.take()?;
        if !lesson.add(number, shard) {
            return Err(malformed(file));
        }
    }
    if file.is_at_end() { Ok(()) } else { Err(malformed(file)) }
}

#[cfg(test)]
#[path = "lesson_tests.rs"]
mod tests;
