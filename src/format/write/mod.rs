//! Scenes as scene files of this program's own: a TOML, and meshes and pictures beside it.

mod meshes;
mod pictures;
mod values;

use super::SceneFile;
use crate::embree::BuildQuality;
use crate::film::{FilmSettings, Filter};
use crate::guiding::settings::GuidingSettings;
use crate::image::Exposure;
use crate::integrator::{IntegratorSettings, Roulette, SamplerKind};
use crate::io::atomic::write_atomically;
use crate::light::LightSampler;
use crate::scene::LoadedAssets;
use crate::scene::description::{CameraDescription, CameraKey, Interpolation, NamedCamera, Projection};
use crate::texture::TextureCache;
use crate::{Error, Result};
use ::toml::{Table, Value};
use glam::DAffine3;
use pictures::Pictures;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use values::{Materials, double, doubles, insert_group, light, number, numbers};

/// Writes the scene to `path`, and what it consists of into the folder beside it of the same name. Returns warnings: what a scene file
/// cannot say but does not change the picture, and those of loading.
///
/// # Errors
/// Those of loading what the scene names, and of writing; [`Error::Scene`] names what a scene file cannot say.
pub(crate) fn write(file: &SceneFile, path: &Path) -> Result<Vec<String>> {
    let mut gathered = LoadedAssets::of(&file.scene)?;
    gathered.stand_in_for_pictures(&mut TextureCache::with(file.scene.pictures.clone()), file.render.strict)?;
    let beside = folder_beside(path)?;
    let mut warnings = std::mem::take(&mut gathered.warnings);
    let mut root = Table::new();
    settings(file, &mut root, &mut warnings);
    let names = meshes::names(&gathered);
    let mut pictures = Pictures::new(path, &beside, &file.scene.pictures);
    root.insert("mesh".into(), Value::Array(meshes::write(&gathered, &names, &beside)?));
    instances(&gathered, &mut root);
    let mut materials = Materials { written: Table::new(), names: names.iter().cloned().collect() };
    for (name, described) in names.iter().zip(&gathered.materials) {
        let written = materials.add(name, described, &mut pictures);
        written.map_err(|what| Error::Scene(format!("a scene file cannot say of material `{name}`: {what}")))?;
    }
    root.insert("material".into(), Value::Table(materials.written));
    let groups = file.scene.light_groups.iter().map(Option::as_ref).chain(std::iter::repeat(None));
    let lights = file.scene.lights.iter().zip(groups).map(|(described, group)| {
        let mut table = light(described, &mut pictures);
        insert_group(&mut table, group);
        Value::Table(table)
    });
    root.insert("light".into(), Value::Array(lights.collect()));
    pictures.write()?;
    root.retain(|_, value| !matches!(value, Value::Array(array) if array.is_empty()));
    let text = ::toml::to_string(&root).map_err(|error| Error::file(path, error.to_string()))?;
    write_atomically(path, |out| out.write_all(text.as_bytes()))?;
    Ok(warnings)
}

/// Makes the folder of a scene's meshes and pictures beside it, where it is not there yet.
///
/// # Errors
/// Where the scene's own folder does not exist or takes no files.
pub(crate) fn folder_beside(path: &Path) -> Result<PathBuf> {
    let stem = path.file_stem().ok_or_else(|| Error::file(path, "not a file's name"))?;
    let beside = path.with_file_name(format!("{} files", stem.to_string_lossy()));
    match std::fs::create_dir(&beside) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => Err(Error::io(&beside)(error)),
        _ => Ok(beside),
    }
}

fn settings(file: &SceneFile, root: &mut Table, warnings: &mut Vec<String>) {
    let scene = &file.scene;
    if let Some(described) = &scene.camera {
        root.insert("camera".into(), Value::Table(camera(described)));
    }
    let mut cameras = Table::new();
    for NamedCamera { name, camera: described, size } in &scene.cameras {
        if size.iter().any(Option::is_some) {
            warnings.push(format!("the size of the picture of camera `{name}` is not written"));
        }
        cameras.insert(name.clone(), Value::Table(camera(described)));
    }
    if !cameras.is_empty() {
        root.insert("cameras".into(), Value::Table(cameras));
    }
    root.insert("film".into(), Value::Table(film(&scene.film)));
    root.insert("integrator".into(), Value::Table(integrator(&file.integrator)));
    let mut render = Table::new();
    render.insert("spp".into(), Value::Integer(file.render.spp.into()));
    render.insert("sampler".into(), named(&SamplerKind::NAMES, file.render.sampler));
    render.insert("robust".into(), Value::Boolean(file.render.build.robust));
    render.insert("build_quality".into(), named(&BuildQuality::NAMES, file.render.build.quality));
    root.insert("render".into(), Value::Table(render));
    if file.guiding != GuidingSettings::default() {
        warnings.push("settings of the guide are not written".into());
    }
}

/// Only what has been said.
fn camera(c: &CameraDescription) -> Table {
    let mut t = Table::new();
    let projection = match c.projection {
        Projection::Perspective => "perspective",
        Projection::Orthographic => "orthographic",
        Projection::Panorama => "panorama",
    };
    t.insert("projection".into(), Value::String(projection.into()));
    let mut say = |unsaid: bool, key: &str, value: Value| {
        if !unsaid {
            t.insert(key.into(), value);
        }
    };
    say(c.unsaid.origin, "origin", doubles(&c.origin.to_array()));
    say(c.unsaid.target, "target", doubles(&c.target.to_array()));
    say(c.unsaid.up, "up", numbers(&c.up.to_array()));
    say(!c.mirrored, "mirrored", Value::Boolean(true));
    match c.projection {
        Projection::Perspective => {
            say(c.unsaid.vfov, "vfov", number(c.vfov));
            say(c.aperture_radius == 0.0, "aperture_radius", number(c.aperture_radius));
            say(c.focus_distance.is_none(), "focus_distance", number(c.focus_distance.unwrap_or(1.0)));
        }
        Projection::Orthographic => say(c.unsaid.view_height, "view_height", number(c.view_height)),
        Projection::Panorama => (),
    }
    if c.interpolation == Interpolation::Linear {
        t.insert("interpolation".into(), Value::String("linear".into()));
    }
    if !c.keys.is_empty() {
        t.insert("key".into(), Value::Array(c.keys.iter().map(|key| Value::Table(camera_key(key))).collect()));
    }
    t
}

fn camera_key(key: &CameraKey) -> Table {
    let mut t = Table::new();
    t.insert("frame".into(), doubles(&[key.frame])[0].clone());
    let points = [("origin", key.origin), ("target", key.target), ("up", key.up.map(|up| up.as_dvec3()))];
    points.into_iter().for_each(|(name, p)| t.extend(p.map(|p| (name.into(), doubles(&p.to_array())))));
    let CameraKey { vfov, view_height, aperture_radius, focus_distance, .. } = *key;
    let names = ["vfov", "view_height", "aperture_radius", "focus_distance"];
    let values = names.into_iter().zip([vfov, view_height, aperture_radius, focus_distance]);
    t.extend(values.filter_map(|(name, value)| Some((name.into(), number(value?)))));
    t
}

fn film(film: &FilmSettings) -> Table {
    let mut t = Table::new();
    t.insert("width".into(), Value::Integer(film.width.into()));
    t.insert("height".into(), Value::Integer(film.height.into()));
    let filter = match film.filter {
        Filter::Box => "box",
        Filter::Tent => "tent",
        Filter::Gaussian => "gaussian",
    };
    t.insert("filter".into(), Value::String(filter.into()));
    if let Some(crop) = film.crop {
        t.insert("crop".into(), Value::Array(crop.map(|side| Value::Integer(side.into())).into()));
    }
    let exposure = match film.exposure {
        Exposure::Auto => Value::String("auto".into()),
        Exposure::Stops(stops) => number(stops),
    };
    t.insert("exposure".into(), exposure);
    t.insert("tone".into(), Value::String(film.tone.name().into()));
    t
}

fn integrator(settings: &IntegratorSettings) -> Table {
    let mut t = Table::new();
    t.insert("max_depth".into(), Value::Integer(settings.max_depth.into()));
    t.insert("next_event".into(), Value::Boolean(settings.next_event));
    t.insert("mis".into(), Value::Boolean(settings.mis));
    let roulette = match settings.roulette {
        Roulette::None => "none",
        Roulette::Throughput => "throughput",
        Roulette::Guided => "guided",
    };
    t.insert("light_sampler".into(), named(LightSampler::NAMES, settings.light_sampler));
    t.insert("roulette".into(), Value::String(roulette.into()));
    t.insert("rr_depth".into(), Value::Integer(settings.rr_depth.into()));
    t.insert("max_split".into(), number(settings.max_split));
    t
}

/// The name of a value in a list.
fn named<T: PartialEq>(names: &[(&str, T)], value: T) -> Value {
    let name = names.iter().find(|(_, other)| *other == value).map_or("", |(name, _)| name);
    Value::String(name.into())
}

fn instances(gathered: &LoadedAssets, root: &mut Table) {
    let place = |transform: DAffine3| DAffine3 { translation: transform.translation + gathered.origin, ..transform };
    let written = gathered.description.instances.iter().map(|instance| {
        let mut t = Table::new();
        t.insert("group".into(), Value::String(instance.group.clone()));
        t.insert("matrix".into(), matrix(&place(instance.transform)));
        Value::Table(t)
    });
    root.insert("instance".into(), Value::Array(written.collect()));
}

/// Row by row, without the last one.
fn matrix(transform: &DAffine3) -> Value {
    let rows = transform.matrix3.transpose();
    let columns = [rows.x_axis, rows.y_axis, rows.z_axis];
    let row = |k: usize| columns[k].to_array().into_iter().chain([transform.translation[k]]).map(double);
    Value::Array((0..3).map(|k| Value::Array(row(k).collect())).collect())
}

#[cfg(test)]
mod tests;
