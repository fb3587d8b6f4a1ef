//! Loading: a description becomes a scene.

use super::build::Build;
use super::far_lights::FarLights;
use super::instances::Instances;
use super::material::{Material, emitter_opacity};
use super::{Camera, Scene};
use super::{hash, obj};
use crate::bsdf::{BsdfDescription, CoatTables};
use crate::embree::{Device, LARGEST_COORDINATE};
use crate::film::FilmSettings;
use crate::film::accumulate::BYTES_PER_PIXEL;
use crate::geometry::{Indices, Mesh, Placement};
use crate::io::memory;
use crate::light::{EmissiveTriangle, Light, LightUnit, Lights};
use crate::math::Rgb;
use crate::scene::description::{MaterialDescription, MeshDescription, SceneDescription};
use crate::texture::{ColorTexture, ScalarTexture, Texture, TextureCache};
use crate::{Error, Result};
use glam::{Affine3A, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// What is gathered from the files before anything is built.
#[derive(Default)]
pub(crate) struct LoadedAssets {
    /// In the description's order and in place.
    pub meshes: Vec<Mesh>,
    /// Of each mesh, as its file has it.
    hashes: Vec<u64>,
    /// What the meshes' material numbers mean.
    pub materials: Vec<MaterialDescription>,
    /// Of the materials.
    pub names: Vec<String>,
    /// Index in `materials` by library and name: two models may use one name for two things.
    ids: FxHashMap<(Option<usize>, String), u32>,
    warnings: Vec<String>,
}

/// What loading is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadStage {
    /// Reading models.
    Models,
    /// Reading textures and environments.
    Textures,
    /// Building the acceleration structure.
    Building,
}

impl Scene {
    /// Loads all that the description names and builds the acceleration structure with `threads` threads (0: all);
    /// `robust` asks for watertight ray queries.
    /// Also returns warnings for the user.
    ///
    /// # Errors
    /// As [`Device::new`] and [`Scene::load_on`].
    pub fn load(description: &SceneDescription, threads: usize, robust: bool) -> Result<(Scene, Vec<String>)> {
        Scene::load_on(Device::new(threads)?, description, robust)
    }

    /// The same on an Embree device of the caller's.
    ///
    /// # Errors
    /// Missing and malformed files, with file and line; a scene without triangles; a film or a scene for which there is not
    /// the memory.
    pub fn load_on(device: Arc<Device>, description: &SceneDescription, robust: bool) -> Result<(Scene, Vec<String>)> {
        Scene::load_watched(device, description, robust, &|_| ())
    }

    /// The same; `watch` is told what begins.
    ///
    /// # Errors
    /// As [`Scene::load_on`].
    pub fn load_watched(
        device: Arc<Device>,
        description: &SceneDescription,
        robust: bool,
        watch: &dyn Fn(LoadStage),
    ) -> Result<(Scene, Vec<String>)> {
        check_memory(&description.film)?;
        watch(LoadStage::Models);
        let LoadedAssets { meshes, hashes, materials, mut warnings, .. } = LoadedAssets::of(description)?;
        if meshes.iter().all(|mesh| mesh.triangles.is_empty()) {
            return Err(Error::Scene("the scene has no triangles".into()));
        }
        watch(LoadStage::Textures);
        let mut cache = TextureCache::default();
        let mut coats = CoatTables::default();
        let resolved =
            materials.iter().map(|m| Material::new(m, &mut cache, &mut coats)).collect::<Result<Vec<_>>>()?;
        let resolved = Arc::new(resolved);
        let far = FarLights::of(description, &mut warnings)?;
        let content_hash = content_hash(description, &hashes, &materials, &mut cache, &far)?;
        let textures = Arc::new(cache.into_textures());
        watch(LoadStage::Building);
        let start = Instant::now();
        let build = Build { device, robust, materials: &resolved, textures: &textures };
        let (meshes, instances, geometry) = build.world(description, meshes)?;
        let build_seconds = start.elapsed().as_secs_f64();

        let bounds = geometry.bounds().ok_or_else(|| Error::Scene("the scene has no extent".into()))?;
        let surfaces = Surfaces { meshes: &meshes, instances: &instances, materials: &resolved, textures: &textures };
        let (lights, light_unit) = lights(far.lights, &surfaces, bounds, &mut warnings)?;
        let reckoned = resolved.iter().map(|m| m.with_emission(|emission| light_unit.divide(emission)));
        let camera = description.camera.clone().unwrap_or_else(|| Camera::for_bounds(bounds.0, bounds.1));
        let film = &description.film;
        // what the scene took is no longer there
        check_memory(film)?;
        let scene = Scene {
            camera: Camera::new(&camera, film.width, film.height, film.filter)?,
            geometry,
            hash: hash::view(description.camera.as_ref(), film, content_hash),
            content_hash,
            meshes,
            instances,
            materials: Arc::new(reckoned.collect()),
            textures,
            lights,
            light_unit,
            bounds,
            build_seconds,
        };
        Ok((scene, warnings))
    }
}

/// That there is memory for the picture, before it is asked for.
fn check_memory(film: &FilmSettings) -> Result<()> {
    let (width, height) = (film.width, film.height);
    memory::check(u64::from(width) * u64::from(height) * BYTES_PER_PIXEL)
        .map_err(|shortage| Error::Scene(format!("film.width × film.height: {width} × {height} pixels {shortage}")))
}

impl LoadedAssets {
    /// Reads all models that the description names.
    pub fn of(description: &SceneDescription) -> Result<LoadedAssets> {
        let mut gathered = LoadedAssets::default();
        for (k, mesh) in description.meshes.iter().enumerate() {
            gathered.add_mesh(k, mesh, description)?;
        }
        Ok(gathered)
    }

    /// Loads one model, moves it into place, and gives its materials their numbers in the scene.
    fn add_mesh(&mut self, model: usize, place: &MeshDescription, scene: &SceneDescription) -> Result<()> {
        let loaded = obj::load(&place.path)?;
        self.warnings.extend(loaded.warnings.iter().map(ToString::to_string));
        let numbers: Vec<u32> = loaded
            .material_names
            .iter()
            .map(|name| self.material(model, place.material.as_ref().unwrap_or(name), &loaded.materials, scene))
            .collect();
        let mut mesh = loaded.mesh;
        mesh.materials.iter_mut().for_each(|m| *m = numbers[*m as usize]);
        self.hashes.push(hash::mesh(&mesh, place.transform));
        transform(&mut mesh, &Placement::new(place.transform));
        check_positions(&mesh, place)?;
        // Embree reads a vertex with 16 bytes, four more than the last one has.
        mesh.positions.reserve_exact(1);
        self.meshes.push(mesh);
        Ok(())
    }

    /// A name means what the scene file says of it, else what the model's own library says, else grey.
    fn material(
        &mut self,
        model: usize,
        name: &str,
        library: &std::collections::BTreeMap<String, MaterialDescription>,
        scene: &SceneDescription,
    ) -> u32 {
        let named = scene.materials.get(name);
        let owner = if named.is_some() { None } else { Some(model) };
        if let Some(&id) = self.ids.get(&(owner, name.to_string())) {
            return id;
        }
        let own = || library.get(name).map(|own| without_missing_pictures(name, own.clone(), &mut self.warnings));
        self.materials.push(named.cloned().or_else(own).unwrap_or_default());
        self.names.push(name.to_string());
        let id = self.materials.len() as u32 - 1;
        self.ids.insert((owner, name.to_string()), id);
        id
    }
}

/// Libraries travel without their pictures: a material from one goes on in half of its own colour, and opaque, and says
/// so. A picture that a scene file names must be there.
fn without_missing_pictures(
    name: &str,
    mut material: MaterialDescription,
    warnings: &mut Vec<String>,
) -> MaterialDescription {
    let mut missing = |path: &Path| {
        let gone = !path.is_file();
        if gone {
            warnings.push(format!("{}: the picture of material `{name}` is missing", path.display()));
        }
        gone
    };
    if let BsdfDescription::Diffuse { reflectance: color }
    | BsdfDescription::Plastic { reflectance: color, .. }
    | BsdfDescription::Conductor { specular_reflectance: color, .. } = &mut material.bsdf
        && let ColorTexture::Image(image) = color
        && missing(&image.path)
    {
        *color = ColorTexture::Constant(image.tint * 0.5);
    }
    if let Some(ScalarTexture::Image(image)) = &material.opacity
        && missing(&image.path)
    {
        material.opacity = None;
    }
    material
}

/// That the transform has not carried the mesh beyond what can be traced; what its own file says is within it.
fn check_positions(mesh: &Mesh, place: &MeshDescription) -> Result<()> {
    let traced = |p: &[f32; 3]| p.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
    if mesh.positions.par_iter().all(traced) {
        return Ok(());
    }
    let message = "this transform carries the mesh beyond coordinates of 1e12";
    Err(match &place.location {
        Some(location) => location.error(message),
        None => Error::file(&place.path, message),
    })
}

/// Moves a mesh into place. A mirroring turns the corners' order round, so that the winding keeps its meaning.
fn transform(mesh: &mut Mesh, placement: &Placement) {
    if placement.to_world() == Affine3A::IDENTITY {
        return;
    }
    mesh.positions.par_iter_mut().for_each(|p| *p = placement.point(Vec3::from(*p)).into());
    if let Some(normals) = &mut mesh.normals {
        normals.values.par_iter_mut().for_each(|n| *n = placement.normal(Vec3::from(*n)).into());
    }
    if placement.mirrored() {
        let own = [mesh.normals.as_mut().map(|n| &mut n.indices), mesh.uvs.as_mut().map(|uvs| &mut uvs.indices)];
        for indices in own.into_iter().flatten() {
            if let Indices::Own(indices) = indices {
                indices.iter_mut().for_each(|t| t.swap(1, 2));
            }
        }
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}

/// All surfaces of a scene and what they are made of.
struct Surfaces<'a> {
    meshes: &'a [Arc<Mesh>],
    instances: &'a Instances,
    materials: &'a Arc<Vec<Material>>,
    textures: &'a Arc<Vec<Texture>>,
}

/// All lights, and the unit of their emission.
fn lights(
    mut others: Vec<Light>,
    surfaces: &Surfaces,
    bounds: (Vec3, Vec3),
    warnings: &mut Vec<String>,
) -> Result<(Lights, LightUnit)> {
    let own = (0..).zip(surfaces.meshes).flat_map(|(k, mesh)| surfaces.emitters(k, mesh, None));
    let placed = surfaces.instances.surfaces();
    let placed = placed.flat_map(|(k, mesh, place)| surfaces.emitters(k, mesh, Some(place)));
    let mut emissive = collected(own.chain(placed))?;
    if emissive.is_empty() && others.is_empty() {
        warnings.push("nothing emits light in this scene: a constant sky of radiance 1 is added".into());
        others.push(Light::Constant { radiance: Rgb::ONE });
    }
    let radius = 0.5 * (bounds.1 - bounds.0).length();
    let unit = LightUnit::of(&emissive, &others, radius);
    emissive.iter_mut().for_each(|triangle| triangle.radiance = unit.divide(triangle.radiance));
    let others = others.into_iter().map(|light| unit.divide_light(light)).collect();
    Ok((Lights::build(&emissive, others, radius)?, unit))
}

impl<'a> Surfaces<'a> {
    /// The triangles of surface `k` that emit, in world space; `place`: of an instance of the mesh.
    fn emitters(
        &self,
        k: u32,
        mesh: &'a Arc<Mesh>,
        place: Option<&'a Placement>,
    ) -> impl Iterator<Item = EmissiveTriangle> + use<'a> {
        let (materials, textures) = (self.materials, self.textures);
        let emits = materials.iter().any(|m| m.emits());
        let candidates = if emits { &mesh.materials[..] } else { &[] };
        let mirrored = place.is_some_and(|place| place.mirrored());
        let mut varying = None;
        candidates.iter().enumerate().filter(|(_, m)| materials[**m as usize].emits()).map(move |(triangle, m)| {
            let material = &materials[*m as usize];
            let constant = material.constant_opacity(textures);
            let mut map =
                || varying.get_or_insert_with(|| emitter_opacity(mesh, materials, textures, mirrored)).clone();
            EmissiveTriangle {
                mesh: k,
                triangle: triangle as u32,
                corners: place.map_or_else(|| mesh.corners(triangle), |place| place.facet(mesh, triangle)),
                radiance: material.emission(true) * constant.unwrap_or(1.0),
                two_sided: material.emission_two_sided(),
                opacity: constant.is_none().then(&mut map),
                slack: place.map_or(0.0, |place| place.slack_of(mesh, triangle)),
            }
        })
    }
}

/// In a vector that is held against the memory whenever it grows: instances make many lights of few.
fn collected(triangles: impl Iterator<Item = EmissiveTriangle>) -> Result<Vec<EmissiveTriangle>> {
    let mut all = Vec::new();
    for triangle in triangles {
        if all.len() == all.capacity() {
            let more = all.len().max(1024);
            check_lights(all.len() + more)?;
            all.reserve_exact(more);
        }
        all.push(triangle);
    }
    Ok(all)
}

fn check_lights(triangles: usize) -> Result<()> {
    let bytes = triangles as u64 * Lights::BYTES_PER_TRIANGLE;
    memory::check(bytes).map_err(|shortage| {
        Error::Scene(format!("triangles that emit light, of all instances, are too many: {triangles} {shortage}"))
    })
}

/// Over what light does in the scene. `hashes` are those of the meshes; `cache` holds all pictures of `materials`.
fn content_hash(
    description: &SceneDescription,
    hashes: &[u64],
    materials: &[MaterialDescription],
    cache: &mut TextureCache,
    far: &FarLights,
) -> Result<u64> {
    let pictures: Vec<u64> = cache.textures().iter().map(Texture::content_hash).collect();
    let content = hash::Content {
        meshes: hashes,
        materials,
        picture: &mut |path| Ok(pictures[cache.get(path)?]),
        environments: &far.pictures,
    };
    hash::content(description, content)
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn places_that_make_too_many_lights_are_an_error_and_not_an_abort() {
        let triangle = || EmissiveTriangle {
            mesh: 0,
            triangle: 0,
            corners: [Vec3::ZERO, Vec3::X, Vec3::Y],
            radiance: Rgb::ONE,
            two_sided: false,
            opacity: None,
            slack: 0.0,
        };
        assert_eq!(collected(std::iter::repeat_with(triangle).take(5000)).unwrap().len(), 5000);
        let message = check_lights(1 << 50).unwrap_err().to_string();
        assert!(message.contains("1125899906842624 take "), "{message}");
    }
}
