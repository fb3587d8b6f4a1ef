//! The project's own scenes, made from a few shapes: no scene file needs to be fetched to see the guide at work.
//!
//! A scene is three files: `NAME.toml` (camera, what MTL cannot say of materials, settings), `NAME.obj` and
//! `NAME.mtl`. The same version of this module writes the same bytes every time.

mod blocks;
mod cornell;
mod door;
mod furnace;
pub(crate) mod gallery;
mod head;
pub(crate) mod large;
mod obj_writer;
mod shape;
mod shapes;
mod still_life;
mod wall;

#[cfg(test)]
mod tests;

use crate::{Error, Result};
use obj_writer::Model;
use std::path::{Path, PathBuf};

const SCENES: [(&str, &str); 4] = [
    ("door", "two rooms and a door ajar: all that is seen is lit through the gap"),
    ("wall", "a room cut in two: one half lit directly, the other only by what comes round the wall"),
    ("cornell", "a small box under a large light, where guiding can gain little"),
    ("furnace", "a closed glowing sphere whose radiance is known: 2 everywhere"),
];

/// A scene before it is written.
struct SceneFiles {
    toml: String,
    model: Model,
}

/// Name of each scene of a fixed size, and what it tests in one line; [`large`] has those of any size.
pub(crate) fn scenes() -> &'static [(&'static str, &'static str)] {
    &SCENES
}

/// Writes `NAME.toml`, `NAME.obj` and `NAME.mtl` into `dir`, which is made if it is missing; files of these names are
/// replaced. Returns the paths written, the scene file first. A scene of the gallery may have no mesh of its own.
///
/// # Errors
/// [`Error::Scene`] for a name that neither [`scenes`] nor the gallery has, [`Error::Io`] where a file cannot be written.
pub(crate) fn generate(name: &str, dir: &Path) -> Result<Vec<PathBuf>> {
    let files = make(name)?;
    std::fs::create_dir_all(dir).map_err(Error::io(dir))?;
    write_scene(name, &files, dir)
}

fn write_scene(name: &str, files: &SceneFiles, dir: &Path) -> Result<Vec<PathBuf>> {
    let mut texts = vec![("toml", files.toml.clone())];
    if !files.model.objects.is_empty() {
        texts.extend([("obj", files.model.obj(name)), ("mtl", files.model.mtl(name))]);
    }
    texts
        .into_iter()
        .map(|(extension, text)| {
            let path = dir.join(format!("{name}.{extension}"));
            replace_file(&path, &text)?;
            Ok(path)
        })
        .collect()
}

fn make(name: &str) -> Result<SceneFiles> {
    match name {
        "door" => Ok(door::scene()),
        "wall" => Ok(wall::scene()),
        "cornell" => Ok(cornell::scene()),
        "furnace" => Ok(furnace::scene()),
        _ => gallery::make(name).ok_or_else(|| unknown(name)),
    }
}

fn unknown(name: &str) -> Error {
    let known: Vec<&str> = SCENES.iter().chain(&large::SCENES).map(|scene| scene.0).collect();
    let gallery: Vec<&str> = gallery::names().collect();
    let (known, gallery) = (known.join(", "), gallery.join(", "));
    Error::Scene(format!("no scene is called {name:?}; there are {known}, and in the gallery {gallery}"))
}

/// A reader never meets half a file: the text is written beside it and takes its place when complete.
fn replace_file(path: &Path, text: &str) -> Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".tmp");
    let beside = PathBuf::from(beside);
    std::fs::write(&beside, text).map_err(Error::io(&beside))?;
    std::fs::rename(&beside, path).map_err(Error::io(path))
}
