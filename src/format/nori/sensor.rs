//! Camera, samples and how paths are traced.

use crate::Result;
use crate::film::{FilmSettings, Filter, MAX_SIDE};
use crate::format::SceneFile;
use crate::format::xml::object::{Object, Objects};
use crate::format::xml::transform;
use crate::light::{ConstantLight, PointLightParameters};
use crate::math::Rgb;
use crate::scene::description::CameraDescription;
use glam::{DAffine3, DVec3};
use std::f32::consts::PI;

/// Reads the camera into the scene, and how many samples a pixel has.
pub(super) fn camera(objects: &Objects, file: &mut SceneFile) -> Result<()> {
    if let Some(sampler) = objects.child(&objects.root, "sampler")? {
        if let Some(count) = sampler.maybe_number("sample_count")? {
            file.render.spp = count.clamp(1.0, f64::from(u32::MAX)) as u32;
        }
        sampler.ignore(&["seed"]);
        objects.finish(&sampler);
    }
    let Some(camera) = objects.child(&objects.root, "sensor")? else { return Ok(()) };
    if !matches!(camera.kind.as_str(), "perspective" | "thinlens") {
        return Err(camera.error(format!("the camera `{}` has no counterpart", camera.kind)));
    }
    file.scene.film = film(objects, &camera)?;
    file.scene.camera = Some(view(&camera, &file.scene.film)?);
    camera.ignore(&["near_clip", "far_clip"]);
    objects.finish(&camera);
    Ok(())
}

fn film(objects: &Objects, camera: &Object) -> Result<FilmSettings> {
    let side = |name: &str, default: f64| -> Result<u32> {
        let side = camera.number(name, default)?;
        let fits = (1.0..=f64::from(MAX_SIDE)).contains(&side);
        fits.then_some(side as u32).ok_or_else(|| camera.error(format!("`{name}` must be between 1 and {MAX_SIDE}")))
    };
    let filter = match objects.child(camera, "rfilter")? {
        None => Filter::Gaussian,
        Some(filter) => match filter.kind.as_str() {
            "box" => Filter::Box,
            "tent" => Filter::Tent,
            "gaussian" => Filter::Gaussian,
            other => {
                objects.warn(&filter.at, format!("the filter `{other}` has no counterpart: a Gaussian is taken"));
                Filter::Gaussian
            }
        },
    };
    Ok(FilmSettings { width: side("width", 1280.0)?, height: side("height", 720.0)?, filter, ..Default::default() })
}

/// `fov` is the horizontal angle.
fn view(camera: &Object, film: &FilmSettings) -> Result<CameraDescription> {
    let to_world = camera.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    let placed = transform::camera(to_world).ok_or_else(|| camera.error("its transform flattens the view"))?;
    let fov = camera.number("fov", 30.0)?;
    if !(fov > 0.0 && fov < 180.0) {
        return Err(camera.error("`fov` must be between 0 and 180 degrees"));
    }
    let tangent = (0.5 * fov.to_radians()).tan() * f64::from(film.height) / f64::from(film.width);
    let placed = CameraDescription { vfov: (2.0 * tangent.atan().to_degrees()) as f32, ..placed };
    // courses have lenses under these names
    let either = |names: [&str; 2]| names.iter().find_map(|name| camera.maybe_number(name).transpose()).transpose();
    let radius = either(["lens_radius", "aperture_radius"])?.unwrap_or(0.0);
    let focus = either(["focal_distance", "focus_distance"])?;
    if radius < 0.0 || focus.is_some_and(|focus| focus <= 0.0) {
        return Err(camera.error("a lens has a radius of 0 or more and a focal distance greater than 0"));
    }
    Ok(match focus {
        Some(focus) if radius > 0.0 => CameraDescription {
            aperture_radius: radius as f32,
            focus_distance: Some(focus as f32),
            target: placed.origin + (placed.target - placed.origin) * focus,
            ..placed
        },
        _ => placed,
    })
}

/// How paths are traced, by the name of the integrator; those of the first exercises are lights.
pub(super) fn integrator(objects: &Objects, file: &mut SceneFile) -> Result<()> {
    let Some(integrator) = objects.child(&objects.root, "integrator")? else { return Ok(()) };
    let settings = &mut file.integrator;
    settings.max_depth = match integrator.maybe_number("max_depth")? {
        Some(depth) if depth > 0.0 => depth as u32,
        _ => u32::MAX,
    };
    let kind = integrator.kind.as_str();
    let (base, ways) = kind.rsplit_once('_').unwrap_or((kind, ""));
    match ways {
        "mats" => settings.next_event = false,
        "ems" => settings.mis = false,
        _ => (),
    }
    let taken =
        |what: &str| objects.warn(&integrator.at, format!("the integrator `{kind}` has no counterpart: {what}"));
    match base {
        "direct" => settings.max_depth = 2,
        "simple" => {
            taken("its light shines as a point light, and surfaces reflect as their materials do");
            settings.max_depth = 2;
            let position = integrator.vector("position")?.unwrap_or(DVec3::ZERO);
            let intensity = integrator.color("energy", Rgb::ZERO)? / (4.0 * PI);
            file.scene.lights.push(PointLightParameters { position, intensity }.into());
        }
        "ao" => {
            taken("even light from all around shines, and surfaces reflect as their materials do");
            settings.max_depth = 2;
            file.scene.lights.push(ConstantLight { radiance: Rgb::ONE }.into());
        }
        "normals" | "av" => {
            taken("a sky shines");
            file.scene.sky_where_dark = true;
        }
        _ if base.starts_with("path") => (),
        _ => taken("paths from the camera are traced"),
    }
    objects.children(&integrator, "guider")?;
    objects.finish(&integrator);
    Ok(())
}
