//! What there is to say of a scene, for programs.

use super::material::{Parameter, parameters, pictures, place, source, values};
use crate::format::SceneFile;
use crate::math::luminance;
use crate::scene::description::{CameraDescription, Projection};
use crate::scene::{DescribedMaterial, Inventory, MaterialUse, Scene};
use crate::texture::Texture;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Version of the JSON's shape; a change that breaks readers raises it.
const SCHEMA: u32 = 1;

/// A scene that has been loaded.
pub(super) struct Loaded<'a> {
    pub(super) name: &'a Path,
    pub(super) file: &'a SceneFile,
    pub(super) scene: &'a Scene,
    pub(super) warnings: Vec<String>,
    /// All that it took.
    pub(super) seconds: Duration,
}

/// What `--json` prints.
#[derive(Serialize)]
pub(super) struct Report {
    schema: u32,
    phototaxis: &'static str,
    pub(super) scene: String,
    scene_hash: String,
    pub(super) load_wall_seconds: f64,
    pub(super) build_wall_seconds: f64,
    /// Those of a group count in each of its places.
    pub(super) triangles: usize,
    pub(super) meshes: usize,
    pub(super) instances: usize,
    pub(super) bounds: Bounds,
    pub(super) memory: Memory,
    pub(super) camera: Camera,
    /// Those with a name.
    pub(super) cameras: Vec<String>,
    pub(super) lights: Vec<Light>,
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Picture>,
    pub(super) warnings: Vec<String>,
}

#[derive(Serialize)]
pub(super) struct Bounds {
    pub(super) low: Value,
    pub(super) high: Value,
}

/// Bytes.
#[derive(Serialize)]
pub(super) struct Memory {
    pub(super) meshes: usize,
    pub(super) textures: usize,
    pub(super) embree: u64,
}

#[derive(Serialize)]
pub(super) struct Camera {
    /// Whether it was found by what can be seen, and not said by the file in full.
    pub(super) found: bool,
    pub(super) projection: &'static str,
    pub(super) origin: Value,
    pub(super) target: Value,
    pub(super) up: Value,
    /// In degrees, of a perspective camera.
    pub(super) vfov: Option<f32>,
    /// Of an orthographic one.
    pub(super) view_height: Option<f32>,
    pub(super) width: u32,
    pub(super) height: u32,
}

#[derive(Serialize)]
pub(super) struct Light {
    /// `surface`, or its type in a scene file.
    pub(super) kind: &'static str,
    /// Of a surface.
    pub(super) material: Option<String>,
    pub(super) triangles: Option<usize>,
    pub(super) area: Option<f64>,
    /// Of any other light.
    pub(super) parameters: BTreeMap<&'static str, Value>,
    /// Luminance of the power that it sends into the scene, in W where lengths are metres.
    pub(super) power: f64,
    /// Nobody asked for it: there was no light.
    pub(super) added: bool,
}

#[derive(Serialize)]
pub(super) struct Material {
    pub(super) name: String,
    #[serde(rename = "type")]
    pub(super) kind: &'static str,
    /// Who describes it: `scene file`, `library`, or `default` for nobody.
    pub(super) source: &'static str,
    pub(super) triangles: usize,
    pub(super) area: f64,
    pub(super) parameters: Vec<Parameter>,
}

#[derive(Serialize)]
pub(super) struct Picture {
    pub(super) path: PathBuf,
    pub(super) width: Option<usize>,
    pub(super) height: Option<usize>,
    pub(super) bytes: Option<usize>,
    /// Why it cannot be used.
    pub(super) error: Option<String>,
    pub(super) materials: Vec<String>,
}

impl Report {
    pub(super) fn new(loaded: Loaded) -> Report {
        let Loaded { name, file, scene, warnings, seconds } = loaded;
        let inventory = scene.inventory();
        let (low, high) = scene.bounds();
        Report {
            schema: SCHEMA,
            phototaxis: env!("CARGO_PKG_VERSION"),
            scene: name.display().to_string(),
            scene_hash: scene.content_hash_text(),
            load_wall_seconds: seconds.as_secs_f64() - scene.build_seconds(),
            build_wall_seconds: scene.build_seconds(),
            triangles: scene.triangles(),
            meshes: inventory.meshes,
            instances: inventory.instances,
            bounds: Bounds {
                low: place(low.as_dvec3() + scene.origin()),
                high: place(high.as_dvec3() + scene.origin()),
            },
            memory: Memory {
                meshes: inventory.mesh_bytes,
                textures: inventory.texture_bytes,
                embree: scene.geometry().device().memory(),
            },
            camera: camera(file, scene),
            cameras: file.scene.cameras.iter().map(|camera| camera.name.clone()).collect(),
            lights: lights(file, scene, &inventory),
            materials: materials(scene, &inventory),
            textures: textures(scene.described_materials()),
            warnings,
        }
    }
}

fn camera(file: &SceneFile, scene: &Scene) -> Camera {
    let found = scene.found_camera().map(|found| found.camera.clone());
    let whole = found.is_none();
    let c: CameraDescription = found.or_else(|| file.scene.camera.clone()).unwrap_or_default();
    let (width, height) = (file.scene.film.width, file.scene.film.height);
    let (projection, vfov, view_height) = match c.projection {
        Projection::Perspective => ("perspective", Some(c.vfov), None),
        Projection::Orthographic => ("orthographic", None, Some(c.view_height)),
        Projection::Panorama => ("panorama", None, None),
    };
    let [origin, target, up] = [c.origin, c.target, c.up.as_dvec3()].map(place);
    Camera { found: !whole, projection, origin, target, up, vfov, view_height, width, height }
}

fn materials(scene: &Scene, inventory: &Inventory) -> Vec<Material> {
    let described = scene.described_materials().iter().zip(&inventory.materials);
    let material = |(material, used): (&DescribedMaterial, &MaterialUse)| Material {
        name: material.name.clone(),
        kind: material.description.type_name(),
        source: source(material.source),
        triangles: used.triangles,
        area: used.area,
        parameters: parameters(material),
    };
    described.map(material).collect()
}

/// Surfaces by their materials, then the others in the order of the file.
fn lights(file: &SceneFile, scene: &Scene, inventory: &Inventory) -> Vec<Light> {
    let described = scene.described_materials().iter().zip(&inventory.materials);
    let emitting =
        described.filter(|(material, used)| luminance(material.description.emission) > 0.0 && used.area > 0.0);
    let surfaces = emitting.map(|(material, used)| surface_light(material, used));
    let far = inventory.far_power.iter().enumerate().map(|(k, &power)| far_light(file, k, power));
    surfaces.chain(far).collect()
}

fn surface_light(material: &DescribedMaterial, used: &MaterialUse) -> Light {
    let sides = if material.description.emission_two_sided { 2.0 } else { 1.0 };
    Light {
        kind: "surface",
        material: Some(material.name.clone()),
        triangles: Some(used.triangles),
        area: Some(used.area),
        parameters: BTreeMap::new(),
        power: f64::from(luminance(material.description.emission)) * PI * used.area * sides,
        added: false,
    }
}

/// Light `k` of those that are no surfaces. One that the file does not say is the sky that was added.
fn far_light(file: &SceneFile, k: usize, power: f64) -> Light {
    let said = file.scene.lights.get(k);
    Light {
        kind: said.map_or("constant", |light| light.type_name()),
        material: None,
        triangles: None,
        area: None,
        parameters: said.map_or_else(BTreeMap::new, |light| values(&mut light.clone()).into_iter().collect()),
        power,
        added: said.is_none(),
    }
}

/// All pictures of materials, each once, in the order of their names.
fn textures(materials: &[DescribedMaterial]) -> Vec<Picture> {
    let mut users: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    for material in materials {
        for path in pictures(&material.description) {
            let names = users.entry(path).or_default();
            if names.last() != Some(&material.name) {
                names.push(material.name.clone());
            }
        }
    }
    let users: Vec<(PathBuf, Vec<String>)> = users.into_iter().collect();
    users.into_par_iter().map(|(path, materials)| picture(path, materials)).collect()
}

fn picture(path: PathBuf, materials: Vec<String>) -> Picture {
    let loaded = match path.is_file() {
        true => Texture::load(&path).map_err(|error| error.to_string()),
        false => Err("missing".to_string()),
    };
    let known = loaded.as_ref().ok();
    Picture {
        width: known.map(|texture| texture.size()[0]),
        height: known.map(|texture| texture.size()[1]),
        bytes: known.map(Texture::bytes),
        error: loaded.err(),
        path,
        materials,
    }
}
