//! Names of pictures where none are given: like the scene, and never those of another scene's pictures.

use super::output::{EXR_INCOMPLETE, PNG_EXPOSURE, PNG_INCOMPLETE, PNG_SCENE, VIEW_EXPOSURE};
use crate::image::exr::{Attribute, read_attributes};
use crate::image::png;
use anyhow::{Context as _, Result, bail};
use std::path::{Path, PathBuf};

/// A file of this name is called as its folder is, since every scene's is.
const NAMELESS: &str = "scene";
/// Numbers that are tried before a name is given up.
const MOST: u32 = 9999;

/// An EXR and a PNG in the current folder, and whether their names have a number because the plain ones are taken by pictures
/// of other scenes; `force` takes the plain ones all the same. Pictures of this scene are replaced.
pub(crate) fn pictures(scene: &Path, force: bool) -> Result<([PathBuf; 2], bool)> {
    let stem = stem(scene)?;
    let named = |stem: &str| ["exr", "png"].map(|end| PathBuf::from(format!("{stem}.{end}")));
    let free = |paths: &[PathBuf; 2]| paths.iter().all(|path| may_replace(path, scene));
    if force || free(&named(&stem)) {
        return Ok((named(&stem), false));
    }
    match (2..=MOST).map(|number| named(&format!("{stem}-{number}"))).find(free) {
        Some(paths) => Ok((paths, true)),
        None => bail!("{stem}.exr and all names with a number are taken: name the pictures with -o"),
    }
}

/// The same of frames, whatever is there; `####` stands for their numbers.
pub(super) fn of_frames(scene: &Path) -> Result<[PathBuf; 2]> {
    let stem = stem(scene)?;
    Ok(["exr", "png"].map(|end| PathBuf::from(format!("{stem}.####.{end}"))))
}

/// Whether a picture is there, and does not say that its render was stopped.
pub(super) fn is_whole(path: &Path) -> bool {
    let marked = match path.extension().is_some_and(|e| e == "exr") {
        true => read_attributes(path).is_ok_and(|attributes| attributes.contains_key(EXR_INCOMPLETE)),
        false => png::text(path, PNG_INCOMPLETE).is_some(),
    };
    path.is_file() && !marked
}

/// Stops by which a picture, or the PNG beside an EXR, is brightened, where it says so.
pub(super) fn exposure(path: &Path) -> Option<f32> {
    match path.extension().is_some_and(|e| e == "exr") {
        true => match read_attributes(path).ok()?.get(VIEW_EXPOSURE) {
            Some(Attribute::Float(stops)) => Some(*stops),
            _ => None,
        },
        false => png::text(path, PNG_EXPOSURE)?.parse().ok(),
    }
}

/// What the scene is called.
fn stem(scene: &Path) -> Result<String> {
    let own = scene.file_stem().context("the scene has no file name")?.to_string_lossy().into_owned();
    let folder = || Some(scene.canonicalize().ok()?.parent()?.file_name()?.to_string_lossy().into_owned());
    Ok(if own == NAMELESS { folder().unwrap_or(own) } else { own })
}

/// Whether nothing stands there, or a picture that says that it is of this scene.
fn may_replace(path: &Path, scene: &Path) -> bool {
    if path.symlink_metadata().is_err() {
        return true;
    }
    let named = match path.extension().is_some_and(|e| e == "exr") {
        true => read_attributes(path).ok().and_then(|attributes| match attributes.get("scene") {
            Some(Attribute::Text(name)) => Some(name.clone()),
            _ => None,
        }),
        false => png::text(path, PNG_SCENE),
    };
    named.is_some_and(|named| named == scene.display().to_string())
}
