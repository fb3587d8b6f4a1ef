//! Checkpoints: all of a render in a file, from which it goes on to the same picture.
//!
//! All numbers are little-endian: 8 bytes [`MAGIC`], the format's version (`u32`), a [`Header`], the state, both in the wire format
//! of the crate `postcard`, and the CRC-32 (IEEE 802.3) of all before it. The state is a [`Kept`]: [`RenderState`] with the
//! iteration under way and the guide. Nothing else of a render is needed but its scene and its settings, which are loaded again
//! and compared by the header. Radiance is in the scene's own unit of light.

use super::limits::Spent;
use super::onlooker::Moment;
use super::state::{Record, RenderState};
use super::{RenderSettings, Settings};
use crate::guiding::{Guide, GuideState};
use crate::io::atomic::write_atomically;
use crate::scene::Scene;
use crate::{Error, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"PTXCHECK";
/// Changes whenever older files would be read wrongly.
const VERSION: u32 = 1;
/// Bytes before the header, and after the state.
const HEAD: u64 = 12;
const TAIL: u64 = 4;

/// Bytes that all texts of a file take together at most.
const TEXTS: usize = 1 << 20;

/// What a checkpoint is of. `R` says how the render was asked for.
#[derive(Serialize, Deserialize)]
pub(crate) struct Header<R> {
    /// Hash of the scene, camera and film included.
    scene: String,
    /// All settings but the budget.
    settings: String,
    pub(crate) request: R,
}

/// Settings that may not change from one part of a render to the next.
fn fixed(settings: &Settings) -> String {
    let budget = RenderSettings::default();
    let render = RenderSettings { spp: budget.spp, time: budget.time, ..settings.render.clone() };
    format!("{:?}", (&settings.integrator, &settings.guiding, render))
}

impl<R> Header<R> {
    pub(crate) fn new(scene: &Scene, settings: &Settings, request: R) -> Header<R> {
        Header { scene: scene.hash_text(), settings: fixed(settings), request }
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

    /// Writes a checkpoint, as a whole or not at all.
    ///
    /// # Errors
    /// All failures to write.
    pub(crate) fn write_checkpoint<R: Serialize>(&self, path: &Path, header: &Header<R>) -> Result<()> {
        let guide = self.state.guide.as_ref().map(Guide::state);
        let Moment { state, record, spent, keeps_guide, .. } = *self;
        let kept = Kept { state, record, guide, spent, keeps_guide };
        write_atomically(path, |file| {
            let mut out = BufWriter::with_capacity(1 << 18, Summed::new(file));
            out.write_all(&MAGIC)?;
            out.write_all(&VERSION.to_le_bytes())?;
            let written = postcard::to_io(&(header, &kept), &mut out).map(drop);
            out.get_mut().error.take().map_or(Ok(()), Err)?;
            written.map_err(io::Error::other)?;
            let Summed { to, sum, .. } = out.into_inner().map_err(io::IntoInnerError::into_error)?;
            to.write_all(&sum.finalize().to_le_bytes())
        })
    }
}

/// Counts the checksum of what is written. Postcard forgets why it could not write, so it is kept.
struct Summed<T> {
    to: T,
    sum: crc32fast::Hasher,
    error: Option<io::Error>,
}

impl<T> Summed<T> {
    fn new(to: T) -> Summed<T> {
        Summed { to, sum: crc32fast::Hasher::new(), error: None }
    }
}

impl<T: Write> Write for Summed<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes).inspect_err(|error| {
            self.error = Some(error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error));
        })?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// A checkpoint whose header is read.
pub(crate) struct CheckpointFile<R> {
    path: PathBuf,
    pub(crate) header: Header<R>,
    rest: io::Take<BufReader<File>>,
}

/// Opens a checkpoint.
///
/// # Errors
/// [`Error::Io`] where there is no such file; [`Error::File`] for one that is no checkpoint, of another version, truncated or
/// damaged. No file makes it take more memory than its own size.
pub(crate) fn open<R: DeserializeOwned>(path: &Path) -> Result<CheckpointFile<R>> {
    let mut file = File::open(path).map_err(Error::io(path))?;
    let length = check(path, &mut file)?;
    file.seek(SeekFrom::Start(HEAD)).map_err(Error::io(path))?;
    let mut rest = BufReader::with_capacity(1 << 18, file).take(length - HEAD - TAIL);
    let header = take(path, &mut rest)?;
    Ok(CheckpointFile { path: path.to_path_buf(), header, rest })
}

/// Reads the next value.
fn take<T: DeserializeOwned>(path: &Path, from: &mut impl Read) -> Result<T> {
    let read = postcard::from_io((from, &mut vec![0; TEXTS][..])).map(|(value, _)| value);
    read.map_err(|_| Error::file(path, "the checkpoint is malformed"))
}

/// That the file is a checkpoint of this version and whole; returns its length.
fn check(path: &Path, file: &mut File) -> Result<u64> {
    let bad = |message: String| Error::file(path, message);
    let length = file.metadata().map_err(Error::io(path))?.len();
    let mut head = Vec::new();
    file.take(HEAD).read_to_end(&mut head).map_err(Error::io(path))?;
    if head.is_empty() || !head.iter().zip(&MAGIC).all(|(a, b)| a == b) {
        return Err(bad("this is not a checkpoint".into()));
    }
    let truncated = || bad("the checkpoint is truncated".into());
    let version = head.get(8..12).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes);
    let version = version.ok_or_else(truncated)?;
    if version != VERSION {
        let message =
            format!("the checkpoint is of version {version} of the format; this program reads version {VERSION}");
        return Err(bad(message));
    }
    let body = length.checked_sub(HEAD + TAIL).ok_or_else(truncated)?;
    let mut sum = crc32fast::Hasher::new();
    sum.update(&head);
    let (mut left, mut buffer) = (body, vec![0; 1 << 18]);
    while left > 0 {
        let some = &mut buffer[..left.min(1 << 18) as usize];
        file.read_exact(some).map_err(Error::io(path))?;
        sum.update(some);
        left -= some.len() as u64;
    }
    let mut tail = [0; TAIL as usize];
    file.read_exact(&mut tail).map_err(Error::io(path))?;
    if sum.finalize().to_le_bytes() != tail {
        return Err(bad("the checkpoint is truncated or damaged: its checksum does not match".into()));
    }
    Ok(length)
}

impl<R> CheckpointFile<R> {
    /// The render, of the scene and the settings that it was begun with. Only the budget may be another.
    ///
    /// # Errors
    /// Another scene, other settings, and a state that is none of theirs.
    pub(crate) fn read(mut self, scene: &Scene, settings: &Settings) -> Result<Checkpoint> {
        let bad = |message: &str| Error::file(&self.path, message);
        if self.header.scene != scene.hash_text() {
            return Err(bad("the checkpoint is of another scene: geometry, materials, lights, camera or film differ"));
        }
        if self.header.settings != fixed(settings) {
            return Err(bad("the checkpoint is of other settings: [integrator], [guiding] or [render] differ"));
        }
        let kept: Kept<RenderState, Record> = take(&self.path, &mut self.rest)?;
        let Kept { mut state, record, guide, spent, keeps_guide } = kept;
        let new = Guide::new(&settings.guiding, scene.bounds(), scene.facets());
        if !state.fits(scene, settings) || new.is_some() != guide.is_some() || self.rest.limit() > 0 {
            return Err(bad("the checkpoint is malformed"));
        }
        state.guide = new;
        if let Some((new, guide)) = state.guide.as_mut().zip(guide) {
            new.resume(guide).map_err(|message| bad(&format!("the guide in the checkpoint: {message}")))?;
        }
        Ok(Checkpoint { state, record, spent, keeps_guide })
    }
}

#[cfg(test)]
#[path = "checkpoint_tests.rs"]
mod tests;
