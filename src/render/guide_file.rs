//! Guides in files: what one render has learnt, another begins with.
//!
//! All numbers are little-endian: 8 bytes [`MAGIC`], the format's version (`u32`), the number of bytes of the body
//! (`u64`), the body, and the CRC-32 (IEEE 802.3) of all before it. The body is a [`Header`], then what was learnt, then the
//! [`View`] in which it was, where that is known; all in the wire format of the crate `postcard`. Radiance in it is in the scene's
//! own unit of light.

use super::view::View;
use crate::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings};
use crate::guiding::{Guide, Stored};
use crate::integrator::IntegratorSettings;
use crate::io::atomic::write_atomically;
use crate::math::rng::mix;
use crate::{Error, Result};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

const MAGIC: [u8; 8] = *b"PTXGUIDE";
/// Changes whenever older files would be read wrongly.
const VERSION: u32 = 9;
/// Bytes before the body, and after it.
const HEAD: usize = 20;
const TAIL: usize = 4;

/// What a guide was learnt for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GuideFingerprint {
    /// Hash of the scene, camera and film left out: views of one scene share guides.
    scene: String,
    /// The settings without which the table means something else, by their names in the scene file.
    settings: BTreeMap<String, String>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    subject: GuideFingerprint,
    paths: u64,
}

/// A guide that has learnt.
pub struct LoadedGuide {
    pub guide: Guide,
    /// Camera paths of the last iteration that it learnt from; the next one takes twice as many.
    pub paths: u64,
    /// Tells apart what was learnt. A render that begins with it must not draw the random numbers that it was learnt
    /// with: what is drawn from a guide must know nothing of it.
    pub salt: u64,
    /// What roulette goes by, where machines have learnt it together with the guide.
    pub(crate) view: Option<View>,
}

impl LoadedGuide {
    /// What a guide has learnt, as if it had gone through a file: for a render that follows at once. `paths` as there. The next
    /// render has to have another seed; the salt is 0.
    ///
    /// # Errors
    /// A guide that is larger than `guiding.memory`.
    pub(crate) fn carried(
        guide: &Guide,
        paths: u64,
        guiding: &GuidingSettings,
        bounds: (Vec3, Vec3),
    ) -> Result<LoadedGuide> {
        let fault = |message: String| Error::Scene(format!("the guide cannot go on to the next frame: {message}"));
        let new = Guide::new(guiding, bounds, std::iter::empty());
        let mut new = new.ok_or_else(|| fault("guiding.method is none".into()))?;
        new.restore(guide.stored()).map_err(fault)?;
        Ok(LoadedGuide { guide: new, paths, salt: 0, view: None })
    }
}

impl GuideFingerprint {
    /// `scene` is a hash of geometry, materials and lights.
    pub fn new(scene: String, guiding: &GuidingSettings, integrator: &IntegratorSettings) -> GuideFingerprint {
        GuideFingerprint { scene, settings: settings(guiding, integrator) }
    }

    /// What keeps a guide that was learnt for `self` from being used for `other`.
    fn conflict(&self, other: &GuideFingerprint) -> Option<String> {
        if self.scene != other.scene {
            return Some("the guide was learnt in another scene: its geometry, materials or lights differ".into());
        }
        let keys = self.settings.keys().chain(other.settings.keys().filter(|key| !self.settings.contains_key(*key)));
        let shown = |value: Option<&String>| value.map_or("not used", String::as_str).to_string();
        let differing: Vec<String> = keys
            .map(|key| (key, self.settings.get(key), other.settings.get(key)))
            .filter(|(_, learnt, now)| learnt != now)
            .map(|(key, learnt, now)| format!("{key} was {} and is {}", shown(learnt), shown(now)))
            .collect();
        let list = differing.join(", ");
        (!differing.is_empty()).then(|| format!("the guide was learnt with other settings: {list}"))
    }
}

/// The settings that give a table its shape, and what it holds its meaning.
fn settings(guiding: &GuidingSettings, integrator: &IntegratorSettings) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    let mut add = |key: &str, value: String| all.insert(key.to_string(), value);
    add("guiding.method", guiding.method.model().name().to_owned());
    match guiding.method.model() {
        GuidingMethod::Grid => add("guiding.normals", guiding.normals.to_string()),
        GuidingMethod::Adaptive => add("guiding.levels", guiding.levels.to_string()),
        GuidingMethod::Voronoi => add("guiding.sites", guiding.sites.to_string()),
        _ => None,
    };
    if matches!(guiding.method.model(), GuidingMethod::Grid | GuidingMethod::Adaptive) {
        add("guiding.resolution", guiding.resolution.to_string());
    }
    if guiding.method != GuidingMethod::SdTree {
        add("guiding.table", format!("{:?}", guiding.table).to_lowercase());
        if guiding.table != DirectionTable::Tree {
            add("guiding.strata", guiding.strata.to_string());
        }
    }
    // light that next-event estimation finds is left out of what is learnt
    add("integrator.next_event", integrator.next_event.to_string());
    add("integrator.mis", integrator.mis.to_string());
    all
}

/// Writes a guide, as a whole or not at all. `paths` as in [`LoadedGuide`].
///
/// # Errors
/// All failures to write.
pub fn write(path: &Path, guide: &Guide, subject: &GuideFingerprint, paths: u64) -> Result<()> {
    write_with_view(path, guide, subject, paths, None)
}

/// The same with the view in which it has learnt.
///
/// # Errors
/// All failures to write.
pub(crate) fn write_with_view(
    path: &Path,
    guide: &Guide,
    subject: &GuideFingerprint,
    paths: u64,
    view: Option<&View>,
) -> Result<()> {
    let header = Header { subject: subject.clone(), paths };
    let fail = |error: postcard::Error| Error::file(path, format!("the guide cannot be stored: {error}"));
    let body = postcard::to_stdvec(&(header, guide.stored(), view)).map_err(fail)?;
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&MAGIC);
    head[8..12].copy_from_slice(&VERSION.to_le_bytes());
    head[12..].copy_from_slice(&(body.len() as u64).to_le_bytes());
    let sum = checksum(&head, &body);
    write_atomically(path, |file| {
        [&head[..], &body, &sum.to_le_bytes()].iter().try_for_each(|part| file.write_all(part))
    })
}

/// Reads a guide for a scene with the bounds `bounds`, to be used with `guiding`.
///
/// # Errors
/// [`Error::Io`] where there is no such file; [`Error::File`] for one that is no guide, of another version, truncated
/// or damaged, of another subject, or larger than `guiding.memory`. No file makes it panic, or take more memory than a
/// few times the file's own size.
pub fn read(
    path: &Path,
    subject: &GuideFingerprint,
    guiding: &GuidingSettings,
    bounds: (Vec3, Vec3),
) -> Result<LoadedGuide> {
    let mut file = std::fs::File::open(path).map_err(Error::io(path))?;
    let bad = |message: &str| Error::file(path, message);
    let mut head = Vec::new();
    (&mut file).take(HEAD as u64).read_to_end(&mut head).map_err(Error::io(path))?;
    let length = body_length(&head).map_err(|message| bad(&message))?;
    let mut rest = Vec::new();
    file.take(length.saturating_add(TAIL as u64 + 1)).read_to_end(&mut rest).map_err(Error::io(path))?;
    if (rest.len() as u64).checked_sub(TAIL as u64) != Some(length) {
        return Err(bad("the guide is truncated, or something follows it"));
    }
    let (body, sum) = rest.split_at(rest.len() - TAIL);
    if checksum(&head, body).to_le_bytes() != sum {
        return Err(bad("the guide is damaged: its checksum does not match"));
    }
    let malformed = |_| bad("the guide is malformed");
    let (header, body): (Header, _) = postcard::take_from_bytes(body).map_err(malformed)?;
    if let Some(conflict) = header.subject.conflict(subject) {
        return Err(bad(&conflict));
    }
    let (stored, rest): (Stored, _) = postcard::take_from_bytes(body).map_err(malformed)?;
    let (view, left): (Option<View>, _) = postcard::take_from_bytes(rest).map_err(malformed)?;
    let guide = Guide::new(guiding, bounds, std::iter::empty());
    let mut guide = guide.ok_or_else(|| bad("guiding.method is none: no guide is used"))?;
    guide.restore(stored).map_err(|message| bad(&message))?;
    let salt = mix(u64::from(checksum(&head, body)));
    if left.is_empty() {
        Ok(LoadedGuide { guide, paths: header.paths, salt, view })
    } else {
        Err(bad("the guide is malformed"))
    }
}

/// Bytes of the body by the head of a file.
fn body_length(head: &[u8]) -> std::result::Result<u64, String> {
    let starts_like_a_guide = !head.is_empty() && head.iter().zip(&MAGIC).all(|(a, b)| a == b);
    if !starts_like_a_guide {
        return Err("this is not a guide's file".into());
    }
    let Ok(head) = <&[u8; HEAD]>::try_from(head) else {
        return Err("the guide is truncated, or something follows it".into());
    };
    let number =
        |range: std::ops::Range<usize>| head[range].iter().rev().fold(0u64, |sum, &byte| (sum << 8) | u64::from(byte));
    match number(8..12) {
        version if version == u64::from(VERSION) => Ok(number(12..20)),
        version => {
            Err(format!("the guide is of version {version} of the format; this program reads version {VERSION}"))
        }
    }
}

fn checksum(head: &[u8], body: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(head);
    hasher.update(body);
    hasher.finalize()
}
