//! Large scenes, of as many triangles as are asked for. Their files are streamed: the writer needs the same few megabytes
//! for any number of triangles, and the same version of this module writes the same bytes every time.

mod city;
mod forest;
mod noise;
mod stream;
mod terrain;
mod tree;

#[cfg(test)]
mod tests;

use super::obj_writer::{self, Material};
use crate::io::atomic::write_atomically;
use crate::{Error, Result};
use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use stream::ObjStream;

/// Name of each scene, and what it is in one line.
pub(crate) const SCENES: [(&str, &str); 3] = [
    ("city", "streets at dusk, thousands of small lights (--triangles)"),
    ("forest", "instanced trees and lanterns on rolling ground (--triangles)"),
    ("terrain", "a square kilometre of mountains, one smooth mesh (--triangles)"),
];

/// How many triangles can be asked for.
pub(crate) const TRIANGLES: RangeInclusive<u64> = 10_000..=30_000_000;

/// What is made where no number is given.
pub(crate) const DEFAULT_TRIANGLES: u64 = 1_000_000;

/// A scene before it is written.
struct LargeScene {
    toml: String,
    about: &'static str,
    materials: Vec<Material>,
    models: Vec<Model>,
}

type Draw = dyn Fn(&mut ObjStream) -> io::Result<()>;

/// An OBJ file and what writes it.
struct Model {
    file: &'static str,
    draw: Box<Draw>,
}

impl Model {
    fn new(file: &'static str, draw: impl Fn(&mut ObjStream) -> io::Result<()> + 'static) -> Model {
        Model { file, draw: Box::new(draw) }
    }
}

/// Writes the scene `name` of about `triangles` triangles (within 2 % from 60 000 on, those of
/// instances counted each time) into `dir`,
/// which is made if it is missing. Returns the paths written, the scene file first.
///
/// # Errors
/// [`Error::Scene`] for a name that [`SCENES`] does not list and a number outside of [`TRIANGLES`]; [`Error::Io`] where
/// a file cannot be written, as on a full disk: files of an earlier call are then left as they were, or complete.
pub(crate) fn generate(name: &str, triangles: u64, dir: &Path) -> Result<Vec<PathBuf>> {
    let scene = make(name, triangles)?;
    std::fs::create_dir_all(dir).map_err(Error::io(dir))?;
    let library = format!("{name}.mtl");
    let [settings, materials] = [format!("{name}.toml"), library.clone()].map(|file| dir.join(file));
    let mut paths = vec![settings.clone(), materials.clone()];
    for model in &scene.models {
        let path = dir.join(model.file);
        write_atomically(&path, |out| (model.draw)(&mut ObjStream::new(out, name, &library)?))?;
        paths.push(path);
    }
    let text = obj_writer::Model { about: scene.about, objects: Vec::new(), materials: scene.materials }.mtl(name);
    write_atomically(&materials, |out| out.write_all(text.as_bytes()))?;
    // Last, so that a scene file never names what is not there.
    write_atomically(&settings, |out| out.write_all(scene.toml.as_bytes()))?;
    Ok(paths)
}

fn make(name: &str, triangles: u64) -> Result<LargeScene> {
    if !TRIANGLES.contains(&triangles) {
        let (least, most) = (TRIANGLES.start(), TRIANGLES.end());
        return Err(Error::Scene(format!("a large scene has {least} to {most} triangles, not {triangles}")));
    }
    match name {
        "city" => Ok(city::scene(triangles)),
        "forest" => Ok(forest::scene(triangles)),
        "terrain" => Ok(terrain::scene(triangles)),
        _ => Err(Error::Scene(format!("no large scene is called {name:?}"))),
    }
}
