//! What it costs to open a model: reading, building, the first pixel, and memory.

use super::{cpu, median, settings};
use crate::film::tile::Tile;
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::{Batch, PathIntegrator, Task};
use crate::io::clock::WallClock;
use crate::scene::{Scene, obj};
use crate::stats::Median;
use crate::{Error, Result};
use serde::Serialize;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;

/// Seconds and bytes. The file is in the system's cache: it was read once before.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LoadReport {
    pub(crate) file_bytes: u64,
    pub(crate) triangles: usize,
    /// The OBJ and its MTL read into a mesh.
    pub(crate) parse: Median,
    /// Embree's acceleration structure built.
    pub(crate) build: Median,
    /// From nothing to one sample of the middle pixel: reading, building, lights, and its path.
    pub(crate) first_pixel: Median,
    /// Of the mesh, and of what Embree holds beside it.
    pub(crate) mesh_bytes: usize,
    pub(crate) embree_bytes: u64,
    pub(crate) bytes_per_triangle: f64,
    /// The most memory the process had when the first pixel came the first time; `None` where the system does not tell.
    pub(crate) peak_bytes: Option<u64>,
    pub(crate) tobj: TobjFigure,
}

/// tobj alone on the same file.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct TobjFigure {
    pub(crate) triangles: Option<usize>,
    pub(crate) wall_seconds: Option<Median>,
    /// tobj's time over that of `parse`, turn by turn.
    pub(crate) ratio: Option<Median>,
    /// Why it has no figures.
    pub(crate) failure: Option<String>,
}

/// Loads the model that is all of the description's meshes, `turns` times, with `threads` for Embree (0: all).
///
/// # Errors
/// As [`Scene::load`]; where the description has not just one mesh.
pub(crate) fn load(description: &SceneFile, threads: usize, turns: usize) -> Result<LoadReport> {
    let [mesh] = &description.scene.meshes[..] else {
        return Err(Error::Scene("loading is measured of one model".into()));
    };
    let Some(path) = mesh.source.path() else {
        return Err(Error::Scene("loading is measured of a model in a file".into()));
    };
    let file_bytes = std::fs::metadata(path).map_err(Error::io(path))?.len();
    let (_, scene) = first_pixel(description, threads)?;
    let peak_bytes = cpu::peak_memory();
    let mesh_bytes: usize = scene.meshes().iter().map(|mesh| mesh.bytes()).sum();
    let (triangles, embree_bytes) = (scene.triangles(), scene.geometry().device().memory());
    drop(scene);
    let taken = (0..turns).map(|_| turn(description, path, threads)).collect::<Result<Vec<Turn>>>()?;
    let of = |figure: fn(&Turn) -> f64| median(&taken.iter().map(figure).collect::<Vec<_>>());
    Ok(LoadReport {
        file_bytes,
        triangles,
        parse: of(|turn| turn.parse)?,
        build: of(|turn| turn.build)?,
        first_pixel: of(|turn| turn.first_pixel)?,
        mesh_bytes,
        embree_bytes,
        bytes_per_triangle: (mesh_bytes as f64 + embree_bytes as f64) / triangles as f64,
        peak_bytes,
        tobj: tobj_figure(&taken),
    })
}

struct Turn {
    parse: f64,
    build: f64,
    first_pixel: f64,
    tobj: Result<Tobj, String>,
}

struct Tobj {
    seconds: f64,
    triangles: usize,
}

fn turn(description: &SceneFile, path: &Path, threads: usize) -> Result<Turn> {
    let start = WallClock::start();
    let parsed = obj::load(path)?;
    let parse = start.elapsed().as_secs_f64();
    drop(parsed);
    let tobj = tobj_alone(path);
    let (first_pixel, scene) = first_pixel(description, threads)?;
    Ok(Turn { parse, build: scene.build_seconds(), first_pixel, tobj })
}

fn first_pixel(description: &SceneFile, threads: usize) -> Result<(f64, Scene)> {
    let start = WallClock::start();
    let (scene, _) = description.load_scene(threads)?;
    let settings = settings(description, GuidingMethod::None);
    let integrator = PathIntegrator::plain(&scene, &settings.integrator, 0);
    let tile = Tile { x: scene.camera.width / 2, y: scene.camera.height / 2, width: 1, height: 1 };
    let result = integrator.render(&Task { tile, first_sample: 0, samples: 1 }, &mut Batch::new());
    std::hint::black_box(result.samples.sum[0]);
    Ok((start.elapsed().as_secs_f64(), scene))
}

/// Its fastest way: corners keep their own indices, nothing is merged. It panics on some legal files, of which the
/// message is kept from the terminal.
fn tobj_alone(path: &Path) -> Result<Tobj, String> {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let start = WallClock::start();
    let loaded = panic::catch_unwind(AssertUnwindSafe(|| tobj::load_obj(path, &options)));
    let seconds = start.elapsed().as_secs_f64();
    panic::set_hook(hook);
    let (models, _) = loaded.map_err(|_| "it panicked".to_owned())?.map_err(|error| error.to_string())?;
    Ok(Tobj { seconds, triangles: models.iter().map(|model| model.mesh.indices.len() / 3).sum() })
}

fn tobj_figure(turns: &[Turn]) -> TobjFigure {
    let all: Result<Vec<(&Turn, &Tobj)>, &String> =
        turns.iter().map(|turn| turn.tobj.as_ref().map(|tobj| (turn, tobj))).collect();
    match all {
        Err(failure) => TobjFigure { triangles: None, wall_seconds: None, ratio: None, failure: Some(failure.clone()) },
        Ok(all) => TobjFigure {
            triangles: all.first().map(|(_, tobj)| tobj.triangles),
            wall_seconds: Median::of(&all.iter().map(|(_, tobj)| tobj.seconds).collect::<Vec<_>>()),
            ratio: Median::of(&all.iter().map(|(turn, tobj)| tobj.seconds / turn.parse).collect::<Vec<_>>()),
            failure: None,
        },
    }
}
