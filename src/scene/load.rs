//! Loading: a description becomes a scene.

use super::assets::LoadedAssets;
use super::build::Build;
use super::description::{CameraDescription, MaterialDescription, SceneDescription};
use super::emitters::{Lighting, Surfaces, lights, sky};
use super::hash;
use super::light_groups::LightGroups;
use super::material::Material;
use super::{Camera, FoundCamera, Scene, SceneNames, view};
use crate::bsdf::BsdfTables;
use crate::embree::{BuildOptions, Device};
use crate::film::FilmSettings;
use crate::film::accumulate::BYTES_PER_PIXEL;
use crate::geometry::Mesh;
use crate::io::clock::WallClock;
use crate::io::memory;
use crate::light::{Findings, Light, LightUnit};
use crate::texture::{Texture, TextureCache};
use crate::{Error, Result};
use std::sync::Arc;

/// What loading is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LoadStage {
    /// Reading models.
    Models,
    /// Reading textures and environments.
    Textures,
    /// Building the acceleration structure.
    Building,
}

/// How a scene is loaded.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LoadOptions {
    pub(crate) build: BuildOptions,
    /// A picture of a library that cannot be read is an error.
    pub(crate) strict: bool,
}

impl Scene {
    /// Loads all that the description names and builds the acceleration structure with `threads` threads (0: all).
    /// Also returns warnings for the user.
    ///
    /// # Errors
    /// As [`Device::new`] and [`Scene::load_on`].
    pub fn load(description: &SceneDescription, threads: usize, build: BuildOptions) -> Result<(Scene, Vec<String>)> {
        Scene::load_on(Device::new(threads)?, description, build)
    }

    /// The same on an Embree device of the caller's.
    ///
    /// # Errors
    /// Missing and malformed files, with file and line; a scene without triangles; a film or a scene for which there is not
    /// the memory.
    pub(crate) fn load_on(
        device: Arc<Device>,
        description: &SceneDescription,
        build: BuildOptions,
    ) -> Result<(Scene, Vec<String>)> {
        Scene::load_watched(device, description, LoadOptions { build, ..LoadOptions::default() }, &|_| ())
    }

    /// The same; `watch` is told what begins.
    ///
    /// # Errors
    /// As [`Scene::load_on`].
    pub(crate) fn load_watched(
        device: Arc<Device>,
        description: &SceneDescription,
        options: LoadOptions,
        watch: &dyn Fn(LoadStage),
    ) -> Result<(Scene, Vec<String>)> {
        check_memory(&description.film)?;
        watch(LoadStage::Models);
        let mut assets = LoadedAssets::of(description)?;
        let names = SceneNames::of(description, &assets);
        if assets.meshes.iter().all(|mesh| mesh.triangles.is_empty()) {
            return Err(Error::Scene("the scene has no triangles".into()));
        }
        watch(LoadStage::Textures);
        let mut cache = TextureCache::with(description.pictures.clone());
        assets.stand_in_for_pictures(&mut cache, options.strict)?;
        let LoadedAssets { meshes, hashes, materials, described, mut warnings, description, origin, .. } = assets;
        let description = &description;
        let mut tables = BsdfTables::default();
        let light_groups = LightGroups::of(description, materials.iter());
        let resolved = |m: &MaterialDescription| {
            let material = Material::new(m, &mut cache, &mut tables)?;
            Ok(material.in_light_group(light_groups.number(m.light_group.as_ref())))
        };
        let resolved = Arc::new(materials.iter().map(resolved).collect::<Result<Vec<_>>>()?);
        warnings.append(&mut cache.take_notes());
        let mut found = Findings::default();
        let far = description.lights.iter().map(|light| light.load(&mut found)).collect::<Result<Vec<_>>>()?;
        warnings.append(&mut found.warnings);
        let groups = light_groups.of_lights(description, &far)?;
        let content_hash = content_hash(description, &hashes, &materials, &mut cache, &found.pictures)?;
        let textures = Arc::new(cache.into_textures());
        let meshes = if textures.is_empty() { without_uvs(meshes) } else { meshes };
        watch(LoadStage::Building);
        let start = WallClock::start();
        let build = Build { device, options: options.build, materials: &resolved, textures: &textures };
        let (meshes, instances, geometry) = build.world(description, meshes)?;
        let build_seconds = start.elapsed().as_secs_f64();

        let bounds = geometry.bounds().ok_or_else(|| Error::Scene("the scene has no extent".into()))?;
        let surfaces = Surfaces { meshes: &meshes, instances: &instances, materials: &resolved, textures: &textures };
        let Lighting { lights, unit, sky_added } = lights(far.clone(), &surfaces, bounds)?;
        let lights = lights.with_groups(&groups);
        if sky_added {
            warnings.push(format!("nothing emits light in this scene: {SKY_IS_ADDED}"));
        }
        let film = &description.film;
        // what the scene took is no longer there
        check_memory(film)?;
        let camera = Camera::in_place(description.camera.as_ref(), bounds);
        let mut scene = Scene {
            camera: Camera::new(&camera, film)?,
            found_camera: None,
            geometry,
            hash: hash::view(description.camera.as_ref(), film, content_hash),
            content_hash,
            meshes,
            instances,
            materials: in_unit(&resolved, unit),
            described_materials: described,
            textures,
            lights,
            light_unit: unit,
            light_groups,
            names,
            bounds,
            origin,
            build_seconds,
        };
        scene.look(description)?;
        if description.sky_where_dark && !sky_added && !scene.is_lit() {
            warnings.push(format!("no light of this model reaches the camera: {SKY_IS_ADDED}"));
            scene.add_sky(far, &resolved)?;
            scene.look(description)?;
        }
        Ok((scene, warnings))
    }

    /// Finds what nobody has said of the camera.
    fn look(&mut self, description: &SceneDescription) -> Result<()> {
        let camera = view::said(description);
        let film = &description.film;
        self.found_camera = camera.unsaid.is_open().then(|| view::find(self, &camera, film));
        let placed = self.found_camera.as_ref().map_or(&camera, |found| &found.camera);
        self.camera = Camera::new(placed, film)?;
        if let Some(FoundCamera { camera, .. }) = &mut self.found_camera {
            (camera.origin, camera.target) = (camera.origin + self.origin, camera.target + self.origin);
        }
        Ok(())
    }

    /// Looks through another camera, in the coordinates of the scene's files, whose place is said.
    ///
    /// # Errors
    /// Where the view direction or the up vector is degenerate.
    pub(crate) fn look_through(&mut self, camera: &CameraDescription, film: &FilmSettings) -> Result<()> {
        let camera = self.moved(camera);
        self.camera = Camera::new(&camera, film)?;
        self.hash = hash::view(Some(&camera), film, self.content_hash);
        Ok(())
    }

    /// That it can be looked through.
    ///
    /// # Errors
    /// As [`Self::look_through`].
    pub(crate) fn check_camera(&self, camera: &CameraDescription, film: &FilmSettings) -> Result<()> {
        Camera::new(&self.moved(camera), film).map(drop)
    }

    /// A camera in the coordinates here.
    fn moved(&self, camera: &CameraDescription) -> CameraDescription {
        let [origin, target] = [camera.origin, camera.target].map(|p| p - self.origin);
        CameraDescription { origin, target, ..camera.clone() }
    }

    /// Whether any light reaches the camera.
    fn is_lit(&self) -> bool {
        self.found_camera.as_ref().is_some_and(|found| found.lit) || view::is_lit(self)
    }

    /// Adds a sky to the lights: those in `far`, and surfaces of these `materials`.
    fn add_sky(&mut self, mut far: Vec<Light>, materials: &Arc<Vec<Material>>) -> Result<()> {
        far.push(sky());
        let Scene { meshes, instances, textures, bounds, .. } = &*self;
        let surfaces = Surfaces { meshes, instances, materials, textures };
        let Lighting { lights, unit, .. } = lights(far, &surfaces, *bounds)?;
        (self.lights, self.light_unit, self.materials) = (lights, unit, in_unit(materials, unit));
        Ok(())
    }
}

const SKY_IS_ADDED: &str = "a constant sky of radiance 1 is added";

/// The meshes without texture coordinates, which nothing asks for where there are no pictures: in large scenes each of them would be
/// read from memory, at every vertex.
fn without_uvs(mut meshes: Vec<Mesh>) -> Vec<Mesh> {
    meshes.iter_mut().for_each(|mesh| mesh.uvs = None);
    meshes
}

/// The materials with their emission in this unit.
fn in_unit(materials: &[Material], unit: LightUnit) -> Arc<Vec<Material>> {
    Arc::new(materials.iter().map(|m| m.with_emission(|emission| unit.divide(emission))).collect())
}

/// That there is memory for the picture, before it is asked for.
fn check_memory(film: &FilmSettings) -> Result<()> {
    film.check_crop().map_err(|error| Error::Scene(format!("film.crop: {error}")))?;
    let [width, height] = film.rendered();
    memory::check(u64::from(width) * u64::from(height) * BYTES_PER_PIXEL)
        .map_err(|shortage| Error::Scene(format!("film.width × film.height: {width} × {height} pixels {shortage}")))
}

/// Over what light does in the scene. `hashes` are those of the meshes; `cache` holds all pictures of `materials`; `environments` are the hashes
/// of those of the lights.
fn content_hash(
    description: &SceneDescription,
    hashes: &[u64],
    materials: &[MaterialDescription],
    cache: &mut TextureCache,
    environments: &[u64],
) -> Result<u64> {
    let pictures: Vec<u64> = cache.textures().iter().map(Texture::content_hash).collect();
    let content =
        hash::Content { meshes: hashes, materials, picture: &mut |path| Ok(pictures[cache.get(path)?]), environments };
    hash::content(description, content)
}

#[cfg(test)]
#[path = "load_tests.rs"]
mod tests;
