//! Checkpoints: all of a render in a file, from which it goes on to the same picture.
//!
//! A file holds a [`Header`] and a [`Kept`]: [`RenderState`] with the iteration under way and the guide. Nothing else of a render is
//! needed but its scene and its settings, which are loaded again and compared by the header. Radiance is in the scene's own unit
//! of light.

use super::limits::Spent;
use super::onlooker::Moment;
use super::sealed::{Kind, SealedFile};
use super::state::{Record, RenderState};
use super::{RenderSettings, Settings};
use crate::Result;
use crate::guiding::{Guide, GuideState};
use crate::scene::Scene;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;

static KIND: Kind = Kind { magic: *b"PTXCHECK", version: 5, name: "checkpoint" };

/// What a file is of. `R` says how the render was asked for.
#[derive(Serialize, Deserialize)]
pub(crate) struct Header<R> {
    /// Hash of the scene, camera and film included.
    scene: String,
    /// All settings but budget and seed.
    settings: String,
    seed: u64,
    pub(crate) request: R,
}

/// Settings that may not change from one part of a render to the next.
fn fixed(settings: &Settings) -> String {
    let RenderSettings { spp, time, noise, seed, .. } = RenderSettings::default();
    let render = RenderSettings { spp, time, noise, seed, ..settings.render.clone() };
    format!("{:?}", (&settings.integrator, &settings.guiding, render))
}

impl<R> Header<R> {
    pub(crate) fn new(scene: &Scene, settings: &Settings, request: R) -> Header<R> {
        Header { scene: scene.hash_text(), settings: fixed(settings), seed: settings.render.seed, request }
    }

    /// What keeps it from being of this scene and these settings, whatever the seed.
    pub(super) fn conflict(&self, scene: &Scene, settings: &Settings) -> Option<&'static str> {
        if self.scene != scene.hash_text() {
            return Some("it is of another scene: geometry, materials, lights, camera or film differ");
        }
        (self.settings != fixed(settings))
            .then_some("it is of other settings: [integrator], [guiding] or [render] differ")
    }

    pub(super) fn seed(&self) -> u64 {
        self.seed
    }
}

/// What is written of a moment, by reference, or read.
#[derive(Serialize, Deserialize)]
#[serde(bound(deserialize = "S: Deserialize<'de>, I: Deserialize<'de>"))]
struct Kept<'g, S, I> {
    state: S,
    record: I,
    guide: Option<GuideState<'g>>,
    spent: Spent,
    keeps_guide: bool,
}

/// A render as it was, which can go on.
pub struct Checkpoint {
    pub(super) state: RenderState,
    pub(super) record: Record,
    pub(super) spent: Spent,
    pub(super) keeps_guide: bool,
}

impl Checkpoint {
    /// Samples per pixel that were taken.
    pub(crate) fn samples(&self) -> u32 {
        self.state.samples()
    }

    /// Wall time that they took.
    pub(crate) fn seconds(&self) -> f64 {
        self.spent.wall.elapsed().as_secs_f64()
    }
}

impl Moment<'_> {
    /// Whether a render that goes on from here ends with the same picture.
    pub(crate) fn can_go_on(&self) -> bool {
        !self.record.is_broken
    }

    /// Writes a checkpoint, as a whole or not at all: it is given up where somebody waits impatiently for the end.
    ///
    /// # Errors
    /// All failures to write, and that it was given up.
    pub(crate) fn write_checkpoint<R: Serialize>(&self, path: &Path, header: &Header<R>) -> Result<()> {
        let guide = self.state.guide.as_ref().map(Guide::state);
        let Moment { state, record, spent, keeps_guide, .. } = *self;
        let kept = Kept { state, record, guide, spent, keeps_guide };
        KIND.write_unless(path, &(header, kept), &|| self.stop.gives_up_files())
    }
}

/// A checkpoint whose header is read.
pub(crate) struct CheckpointFile<R> {
    pub(crate) header: Header<R>,
    file: SealedFile,
}

/// Opens a checkpoint.
///
/// # Errors
/// [`crate::Error::Io`] where there is no such file; [`crate::Error::File`] for one that is no checkpoint, of another version,
/// truncated or damaged. No file makes it take more memory than a few times its own size.
pub(crate) fn open<R: DeserializeOwned>(path: &Path) -> Result<CheckpointFile<R>> {
    let mut file = KIND.open(path)?;
    Ok(CheckpointFile { header: file.take()?, file })
}

impl<R> CheckpointFile<R> {
    /// The render, of the scene and the settings that it was begun with. Only the budget may be another.
    ///
    /// # Errors
    /// Another scene, other settings, and a state that is none of theirs.
    pub(crate) fn read(self, scene: &Scene, settings: &Settings) -> Result<Checkpoint> {
        match self.header.seed == settings.render.seed {
            true => self.read_of_any_seed(scene, settings),
            false => Err(self.file.error("it is of other settings: render.seed differs")),
        }
    }

    /// As [`Self::read`], whatever the seed.
    pub(crate) fn read_of_any_seed(mut self, scene: &Scene, settings: &Settings) -> Result<Checkpoint> {
        self.header.conflict(scene, settings).map_or(Ok(()), |why| Err(self.file.error(why)))?;
        let kept: Kept<RenderState, Record> = self.file.take()?;
        let Kept { mut state, record, guide, spent, keeps_guide } = kept;
        let new = Guide::new(&settings.guiding, scene.bounds(), scene.facets());
        if !state.fits(scene, settings) || new.is_some() != guide.is_some() || !self.file.is_at_end() {
            return Err(self.file.error("it is malformed"));
        }
        state.guide = new;
        if let Some((new, guide)) = state.guide.as_mut().zip(guide) {
            new.resume(guide).map_err(|message| self.file.error(&format!("its guide: {message}")))?;
        }
        Ok(Checkpoint { state, record, spent, keeps_guide })
    }
}

#[cfg(test)]
#[path = "checkpoint_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "checkpoint_points_tests.rs"]
mod points_tests;
