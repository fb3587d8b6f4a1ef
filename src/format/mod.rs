//! Scenes in files: TOML (described in docs/scene-file.md), the interchange form `scene.json`, or a model alone. Each
//! format is one reader, in [`READERS`].

mod definitions;
mod gltf;
pub(crate) mod json;
pub(crate) mod mitsuba;
mod model;
mod nori;
mod pbrt;
pub(crate) mod reference;
mod sections;
mod tessellate;
#[cfg(test)]
pub(crate) mod tests;
mod toml;
pub(crate) mod write;
mod xml;

#[cfg(feature = "lab")]
pub(crate) use model::whole_file;

use crate::document::suggest::unknown;
use crate::document::{Node, Reader, Source, overrides_tree};
use crate::embree::Device;
use crate::film::Combine;
use crate::film::accumulate::BYTES_PER_LAYER;
use crate::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, Updates};
use crate::integrator::{IntegratorSettings, Roulette};
use crate::io::memory;
use crate::render::{Order, RenderSettings};
use crate::scene::description::{NamedCamera, SceneDescription};
use crate::scene::{LoadOptions, LoadStage, Scene};
use crate::{Error, Result};
use definitions::Definitions;
use std::path::Path;
use std::sync::Arc;
use xml::object::Dialect;

/// What a file says of a scene and of how it is to be rendered.
#[derive(Clone, Debug, Default)]
pub struct SceneFile {
    pub scene: SceneDescription,
    pub integrator: IntegratorSettings,
    pub guiding: GuidingSettings,
    pub render: RenderSettings,
}

impl SceneFile {
    /// Loads the scene, with all that its files name; `threads` threads build its acceleration structure (0: all). Also
    /// returns warnings for the user.
    ///
    /// # Errors
    /// As [`Scene::load`]; a guide for which there is not the memory.
    pub fn load_scene(&self, threads: usize) -> Result<(Scene, Vec<String>)> {
        self.load_scene_on(Device::new(threads)?)
    }

    /// The same on an Embree device of the caller's.
    ///
    /// # Errors
    /// As [`Self::load_scene`].
    pub fn load_scene_on(&self, device: Arc<Device>) -> Result<(Scene, Vec<String>)> {
        self.load_scene_watched(device, &|_| ())
    }

    /// The same; `watch` is told what begins.
    ///
    /// # Errors
    /// As [`Self::load_scene`].
    pub(crate) fn load_scene_watched(
        &self,
        device: Arc<Device>,
        watch: &dyn Fn(LoadStage),
    ) -> Result<(Scene, Vec<String>)> {
        self.check_memory()?;
        let options = LoadOptions { build: self.render.build, strict: self.render.strict };
        let loaded = Scene::load_watched(device, &self.scene, options, watch)?;
        // what the scene took is no longer there
        self.check_memory()?;
        Ok(loaded)
    }

    /// That there is memory for radiance layers and for what the guide may take, before it is asked for.
    fn check_memory(&self) -> Result<()> {
        let [width, height] = self.scene.film.rendered();
        let layers = self.render.radiance_layers(self.scene.light_group_count()).len() as u64;
        memory::check(layers * u64::from(width) * u64::from(height) * BYTES_PER_LAYER)
            .map_err(|shortage| Error::Scene(format!("render.layers: {layers} layers {shortage}")))?;
        if self.guiding.method == GuidingMethod::None {
            return Ok(());
        }
        memory::check(self.guiding.memory)
            .map_err(|shortage| Error::Scene(format!("guiding.memory: tables of the guide may {shortage}")))
    }
}

/// Reads a file of one format, which may ask for definitions; also returns warnings.
type Read = fn(&Path, &Definitions) -> Result<(SceneFile, Vec<String>)>;

/// The formats, by the end of a file's name.
const READERS: &[(&str, Read)] = &[
    ("toml", |path, _| toml::read(path)),
    ("json", |path, _| json::read(path)),
    ("obj", |path, _| model::read(path)),
    ("ply", |path, _| model::read(path)),
    ("xml", read_xml),
    ("gltf", |path, _| gltf::read(path)),
    ("glb", |path, _| gltf::read(path)),
    ("pbrt", |path, _| pbrt::read(path)),
];

/// Scenes of Mitsuba and of nori, which are told apart by what is in them.
fn read_xml(path: &Path, definitions: &Definitions) -> Result<(SceneFile, Vec<String>)> {
    let objects = xml::read(path, definitions)?;
    match objects.dialect {
        Dialect::Mitsuba(_) => mitsuba::read(objects),
        Dialect::Nori => nori::read(objects),
    }
}

/// The ends of names that there are readers for, as a sentence lists them.
fn ends(readers: &[(&str, Read)]) -> String {
    let ends: Vec<String> = readers.iter().map(|(end, _)| format!(".{end}")).collect();
    match &ends[..] {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => ends.concat(),
    }
}

/// Reads a scene, by a reader for the end of the file's name. `overrides` are `key=value` as of `--set`, over what the file
/// says; `default.NAME=VALUE` among them is what a scene of Mitsuba calls `$NAME`. Also returns warnings.
///
/// # Errors
/// [`Error::Parse`] with line and column for faults in the file, [`Error::Override`] for faults in
/// those, [`Error::Io`] and [`Error::File`] for a file that cannot be read or is of another kind.
pub fn load(path: &Path, overrides: &[String]) -> Result<(SceneFile, Vec<String>)> {
    load_layers(path, &[], overrides)
}

/// As [`load`], seen by the camera of this name; without one by that of `[camera]`, else by the first with a name.
///
/// # Errors
/// As [`load`]; a name that no camera has.
pub(crate) fn load_seen_by(
    path: &Path,
    camera: Option<&str>,
    overrides: &[String],
) -> Result<(SceneFile, Vec<String>)> {
    load_all(path, camera, &[], overrides)
}

/// As [`load`], where `common` overrides come first, which may be meant for other methods than the one that comes to hold: of
/// those, keys that mean nothing are no fault.
///
/// # Errors
/// As [`load`]; `overrides` are counted after those in `common`.
pub(crate) fn load_layers(path: &Path, common: &[String], overrides: &[String]) -> Result<(SceneFile, Vec<String>)> {
    load_all(path, None, common, overrides)
}

fn load_all(
    path: &Path,
    camera: Option<&str>,
    common: &[String],
    overrides: &[String],
) -> Result<(SceneFile, Vec<String>)> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let Some((_, read)) = READERS.iter().find(|(end, _)| *end == extension) else {
        return Err(Error::file(path, format!("not a scene: its name must end in {}", ends(READERS))));
    };
    let mut definitions = Definitions::default();
    let (before, before_at) = definitions.part(common, 0)?;
    let (rest, rest_at) = definitions.part(overrides, common.len())?;
    let (mut file, warnings) = read(path, &definitions)?;
    definitions.check_used(std::iter::empty())?;
    choose_camera(&mut file.scene, camera).map_err(|message| Error::file(path, message))?;
    let counted = |error, places: &[usize], first: usize| match error {
        Error::Override { index, text, message } => {
            let index = first + places.get(index).copied().unwrap_or(index);
            Error::Override { index, text, message }
        }
        other => other,
    };
    apply_overrides(&mut file, path, &before, true).map_err(|error| counted(error, &before_at, 0))?;
    apply_overrides(&mut file, path, &rest, false).map_err(|error| counted(error, &rest_at, common.len()))?;
    check_order(&file, path)?;
    Ok((file, warnings))
}

/// Makes the camera of this name the scene's.
fn choose_camera(scene: &mut SceneDescription, name: Option<&str>) -> Result<(), String> {
    let chosen = match name {
        None if scene.camera.is_some() => return Ok(()),
        None => scene.cameras.first(),
        Some(name) => Some(scene.cameras.iter().find(|camera| camera.name == name).ok_or_else(|| {
            let names = scene.cameras.iter().map(|camera| camera.name.as_str());
            match scene.cameras.is_empty() {
                true => format!("there is no camera `{name}`, for no camera of this scene has a name"),
                false => unknown(&format!("there is no camera `{name}`"), name, names),
            }
        })?),
    };
    if let Some(NamedCamera { camera, size, .. }) = chosen {
        scene.film.resize(*size);
        scene.camera = Some(camera.clone());
    }
    Ok(())
}

/// Parses the text of a TOML scene file. `path` names it in errors, and paths in it are relative to its folder.
///
/// # Errors
/// As [`load`].
#[cfg(test)]
pub(crate) fn parse(text: &str, path: &Path, overrides: &[String]) -> Result<(SceneFile, Vec<String>)> {
    let (mut file, warnings) = toml::parse(text, path)?;
    apply_overrides(&mut file, path, overrides, false)?;
    check_order(&file, path)?;
    Ok((file, warnings))
}

fn apply_overrides(file: &mut SceneFile, path: &Path, overrides: &[String], lenient: bool) -> Result<()> {
    let source = Source { path, text: "", overrides };
    let apply = |root: Node| {
        let mut root = Reader::new("--set", root)?.lenient(lenient);
        sections::read(&mut root, &source, file)?;
        root.finish()
    };
    overrides_tree(overrides).and_then(apply).map_err(|fault| source.error(fault))
}

/// What adaptive sampling needs and does not have.
fn check_adaptive(file: &SceneFile) -> std::result::Result<(), &'static str> {
    let (render, guided) = (&file.render, file.guiding.method != GuidingMethod::None);
    let wants = [
        (render.order == Order::Blocks, "render.order = \"progressive\": iterations decide on those after them"),
        (
            guided && file.guiding.updates == Updates::Online,
            "guiding.updates = \"frozen\": what is learnt within an iteration would come of the tiles that it gives most to",
        ),
        (
            render.combine != Combine::InverseVariance,
            "the usual render.combine: it weighs iterations by what was settled before they began",
        ),
    ];
    wants.into_iter().find(|(wanted, _)| render.adaptive && *wanted).map_or(Ok(()), |(_, needs)| Err(needs))
}

/// That settings of several sections go together, once all of them have been read.
fn check_order(file: &SceneFile, path: &Path) -> Result<()> {
    check_adaptive(file).map_err(|needs| Error::file(path, format!("render.adaptive needs {needs}")))?;
    if file.render.order != Order::Blocks {
        return Ok(());
    }
    let (guiding, guided) = (&file.guiding, file.guiding.method != GuidingMethod::None);
    let refined = guiding.method != GuidingMethod::Grid || guiding.table == DirectionTable::Tree;
    let wants = [
        (file.render.time.is_some(), "a number of samples and no time: a block has all of its samples before the next"),
        (
            file.render.noise.is_some(),
            "a number of samples and no noise: a block has all of its samples before the next",
        ),
        (guided && guiding.updates == Updates::Frozen, "guiding.updates = \"online\": it is one iteration"),
        (
            guided && refined,
            "guiding.method = \"grid\" with a table of strata: other states and trees are made between iterations",
        ),
        (
            guided && file.integrator.roulette == Roulette::Guided,
            "another integrator.roulette than \"guided\", which goes by the picture of an earlier iteration",
        ),
    ];
    match wants.into_iter().find(|(wanted, _)| *wanted) {
        Some((_, what)) => Err(Error::file(path, format!("render.order = \"blocks\" needs {what}"))),
        None => Ok(()),
    }
}
