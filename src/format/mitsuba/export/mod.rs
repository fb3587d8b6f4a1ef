//! The scene as files of Mitsuba's: one XML and an OBJ for each material.

mod material;
mod meshes;
mod xml;

use crate::film::Filter;
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::Roulette;
use crate::io::atomic::write_atomically;
use crate::light::{ConstantLight, DirectionalLight, EnvironmentLight, LightDescription, PointLightParameters};
use crate::math::Rgb;
use crate::render::Order;
use crate::scene::description::{CameraDescription, Projection};
use crate::scene::{Camera, LoadedAssets};
use crate::texture::TextureCache;
use crate::{Error, Result};
use glam::{Affine3A, Vec3};
use std::path::{Path, PathBuf};
use xml::{Element, numbers};

/// What both renderers are told.
pub(crate) struct Translation {
    /// What Phototaxis renders.
    pub(crate) description: SceneFile,
    /// What Mitsuba does.
    pub(crate) file: PathBuf,
}

/// Near and far planes of the camera, as shares of the scene's size: nothing is to be cut off.
const NEAR: f32 = 1e-4;
const FAR: f32 = 100.0;

/// Depths from here on are none at all to Mitsuba.
const UNLIMITED: u32 = 1 << 20;

impl Translation {
    /// Writes the scene into `folder`, as `scene.xml` and its parts.
    ///
    /// # Errors
    /// As of [`Translation::write_as`].
    pub(crate) fn write(description: &SceneFile, spp: u32, folder: &Path) -> Result<Translation> {
        Translation::write_as(description, spp, &folder.join("scene.xml"), "")
    }

    /// Writes the scene as `file`; names of its parts, which go from that file's folder, begin with `prefix`.
    ///
    /// # Errors
    /// [`Error::Scene`] names what Mitsuba has no counterpart of.
    pub(crate) fn write_as(description: &SceneFile, spp: u32, file: &Path, prefix: &str) -> Result<Translation> {
        if !description.scene.pictures.is_empty() {
            return Err(unknown("pictures that are in no file (a scene file of this program's own can have them)"));
        }
        let mut gathered = LoadedAssets::of(&description.scene)?;
        gathered.stand_in_for_pictures(&mut TextureCache::with(description.scene.pictures.clone()), false)?;
        let counted = SceneFile { scene: gathered.description.clone(), ..description.clone() };
        let description = same_work(&counted, &gathered, spp)?;
        let mut root = Element::new("scene").attribute("version", "3.0.0").child(integrator(&description));
        root = root.child(sensor(&description, &gathered, spp)?);
        for light in &description.scene.lights {
            root = root.child(emitter(light)?);
        }
        root = surfaces(root, &gathered, (file, prefix))?;
        write_atomically(file, |out| out.write_all(root.to_string().as_bytes()))?;
        Ok(Translation { description, file: file.to_path_buf() })
    }
}

fn unknown(what: impl std::fmt::Display) -> Error {
    Error::Scene(format!("Mitsuba has no counterpart: {what}"))
}

/// The description as both can have it.
fn same_work(description: &SceneFile, gathered: &LoadedAssets, spp: u32) -> Result<SceneFile> {
    let mut d = description.clone();
    if !d.scene.instances.is_empty() || d.scene.meshes.iter().any(|mesh| mesh.group.is_some()) {
        return Err(unknown("instances (its own cannot emit, and copies would not be the same work)"));
    }
    if !d.integrator.next_event || !d.integrator.mis {
        return Err(unknown("a path tracer without integrator.next_event or integrator.mis"));
    }
    let pinhole = |c: &CameraDescription| c.projection == Projection::Perspective && c.aperture_radius == 0.0;
    if d.scene.film.crop.is_some() || !d.scene.camera.iter().all(pinhole) {
        return Err(unknown("a part of a picture, or a camera that is no pinhole"));
    }
    let far =
        |light: &&LightDescription| matches!(light, LightDescription::Environment(_) | LightDescription::Constant(_));
    if d.scene.lights.iter().filter(far).count() > 1 {
        return Err(unknown("two lights that surround the scene"));
    }
    if d.scene.lights.is_empty() && gathered.materials.iter().all(|m| m.emission == Rgb::ZERO) {
        // what a scene without lights gets when it is loaded
        d.scene.lights.push(ConstantLight { radiance: Rgb::ONE }.into());
    }
    d.scene.camera = Some(camera(description, gathered));
    d.scene.film.filter = Filter::Box;
    d.guiding.method = GuidingMethod::None;
    if d.integrator.roulette == Roulette::Guided {
        // what it is where there is no guide
        d.integrator.roulette = Roulette::Throughput;
    }
    (d.render.spp, d.render.time, d.render.order) = (spp, None, Order::Progressive);
    Ok(d)
}

fn camera(description: &SceneFile, gathered: &LoadedAssets) -> CameraDescription {
    Camera::in_place(description.scene.camera.as_ref(), bounds(gathered))
}

fn bounds(gathered: &LoadedAssets) -> (Vec3, Vec3) {
    let points = gathered.meshes.iter().flat_map(|mesh| &mesh.positions).map(|p| Vec3::from(*p));
    points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

fn integrator(description: &SceneFile) -> Element {
    let settings = &description.integrator;
    let limit = |depth: u32| if depth < UNLIMITED { i64::from(depth) } else { -1 };
    let start = match settings.roulette {
        Roulette::None => UNLIMITED,
        _ => settings.rr_depth.clamp(1, UNLIMITED),
    };
    let path = Element::new("integrator").kind("path").integer("max_depth", limit(settings.max_depth));
    path.integer("rr_depth", i64::from(start))
}

fn sensor(description: &SceneFile, gathered: &LoadedAssets, spp: u32) -> Result<Element> {
    let camera = camera(description, gathered);
    let (low, high) = bounds(gathered);
    let eye = camera.origin.as_vec3();
    let size = (high - low).length().max((high - eye).length()).max((low - eye).length());
    if !(size.is_finite() && size > 0.0) {
        return Err(Error::Scene("the scene has no extent".into()));
    }
    let film = Element::new("film").kind("hdrfilm").string("pixel_format", "rgb").string("component_format", "float32");
    let film = film
        .integer("width", i64::from(description.scene.film.width))
        .integer("height", i64::from(description.scene.film.height))
        .child(Element::new("rfilter").kind("box"));
    let look = Element::new("lookat")
        .attribute("origin", numbers(eye))
        .attribute("target", numbers(camera.target.as_vec3()))
        .attribute("up", numbers(camera.up));
    let mut placed = Element::new("transform").attribute("name", "to_world");
    if camera.mirrored {
        placed = placed.child(Element::new("scale").attribute("x", -1));
    }
    Ok(Element::new("sensor")
        .kind("perspective")
        .float("fov", camera.vfov)
        .string("fov_axis", "y")
        .float("near_clip", NEAR * size)
        .float("far_clip", FAR * size)
        .child(placed.child(look))
        .child(Element::new("sampler").kind("independent").integer("sample_count", i64::from(spp)))
        .child(film))
}

fn emitter(light: &LightDescription) -> Result<Element> {
    let plugin = |kind: &str| Element::new("emitter").kind(kind);
    Ok(match light {
        LightDescription::Constant(ConstantLight { radiance }) => plugin("constant").color("radiance", *radiance),
        LightDescription::Environment(EnvironmentLight { octahedral: true, .. }) => {
            return Err(unknown("an environment in the octahedral mapping"));
        }
        LightDescription::Environment(EnvironmentLight { path, scale, to_world, .. }) => {
            if scale.min_element() != scale.max_element() {
                return Err(unknown("an environment with a coloured scale"));
            }
            let path = std::path::absolute(path).map_err(Error::io(path))?;
            let envmap = plugin("envmap").string("filename", &path.to_string_lossy()).float("scale", scale.x);
            envmap.child(transform(to_world))
        }
        LightDescription::Point(PointLightParameters { position, intensity }) => {
            let point = Element::new("point").attribute("name", "position");
            let [x, y, z] = position.as_vec3().to_array();
            let point = point.attribute("x", x).attribute("y", y).attribute("z", z);
            plugin("point").child(point).color("intensity", *intensity)
        }
        LightDescription::Directional(DirectionalLight { direction, irradiance }) => {
            let vector = Element::new("vector").attribute("name", "direction");
            let [x, y, z] = direction.to_array();
            let vector = vector.attribute("x", x).attribute("y", y).attribute("z", z);
            plugin("directional").child(vector).color("irradiance", *irradiance)
        }
        // for types that come after this translation was written
        #[allow(unreachable_patterns)]
        other => return Err(unknown(format_args!("a light of the type `{}`", other.type_name()))),
    })
}

fn transform(to_world: &Affine3A) -> Element {
    let m = glam::Mat4::from(*to_world).transpose().to_cols_array();
    let matrix = Element::new("matrix").attribute("value", m.map(|x| x.to_string()).join(" "));
    Element::new("transform").attribute("name", "to_world").child(matrix)
}

/// Materials, and the meshes that have them. What emits has no normals at corners: Mitsuba would take them for the
/// triangles' own in light's density and cosine.
fn surfaces(mut root: Element, gathered: &LoadedAssets, (scene, prefix): (&Path, &str)) -> Result<Element> {
    let emission = |material: u32| gathered.materials[material as usize].emission;
    let parts = meshes::parts(&gathered.meshes, |material| emission(material) != Rgb::ZERO);
    let mut known = None;
    for (k, part) in parts.iter().enumerate() {
        let id = format!("material-{}", part.material);
        let description = &gathered.materials[part.material as usize];
        if known.replace(part.material) != Some(part.material) {
            let name = &gathered.names[part.material as usize];
            let bsdf = material::bsdf(description, &id);
            root = root.child(bsdf.map_err(|what| unknown(format!("material `{name}`: {what}")))?);
        }
        let file = format!("{prefix}part-{k}.obj");
        let textured = material::textured(description);
        write_atomically(&scene.with_file_name(&file), |out| meshes::write(out, &gathered.meshes, part, textured))?;
        let mut shape = Element::new("shape").kind("obj").string("filename", &file);
        shape = shape.value("boolean", "face_normals", !part.smooth);
        shape = shape.child(Element::new("ref").attribute("id", &id));
        if description.emission != Rgb::ZERO {
            shape = shape.child(Element::new("emitter").kind("area").color("radiance", description.emission));
        }
        root = root.child(shape);
    }
    Ok(root)
}
