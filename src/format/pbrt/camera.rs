//! Camera, film, samples and the length of paths.

use super::parameters::Parameters;
use super::world::World;
use crate::Result;
use crate::film::{FilmSettings, Filter, MAX_SIDE};
use crate::format::SceneFile;
use crate::format::xml::transform;
use crate::scene::description::{CameraDescription, Projection};
use glam::{DAffine3, DVec3};

/// Reads them all; also returns what the film makes of radiance: it is multiplied by this.
pub(super) fn read(world: &World, file: &mut SceneFile) -> Result<f32> {
    let get = |name: &str| world.settings.get(name);
    file.scene.film = FilmSettings { filter: filter(world), ..FilmSettings::default() };
    let mut exposure = 1.0;
    if let Some(film) = get("Film") {
        self::film(world, film, &mut file.scene.film)?;
        exposure = film.number("iso", 100.0)? / 100.0 * film.number("scale", 1.0)?;
        film.finish(&world.warnings);
    }
    if let Some(sampler) = get("Sampler") {
        file.render.spp = samples(sampler)?;
        sampler.ignore(&["seed", "randomization", "jitter", "dimensions"]);
        sampler.finish(&world.warnings);
    }
    integrator(world, file)?;
    if let Some(camera) = get("Camera") {
        file.scene.camera = Some(self::camera(world, camera, &file.scene.film)?);
        let [open, close] = [camera.number("shutteropen", 0.0)?, camera.number("shutterclose", 1.0)?];
        if close <= open {
            return Err(camera.error("the shutter does not open"));
        }
        exposure *= if world.old { 1.0 } else { close - open };
        camera.finish(&world.warnings);
    }
    Ok(exposure as f32)
}

fn filter(world: &World) -> Filter {
    let default = if world.old { "box" } else { "gaussian" };
    let (kind, parameters) = match world.settings.get("PixelFilter") {
        Some(parameters) => (parameters.plugin.as_str(), Some(parameters)),
        None => (default, None),
    };
    match kind {
        "box" => Filter::Box,
        "triangle" => Filter::Tent,
        "gaussian" => Filter::Gaussian,
        other => {
            if let Some(parameters) = parameters {
                let message = format!("the filter \"{other}\" has no counterpart: a Gaussian is taken");
                world.warnings.add(&parameters.at, message);
            }
            Filter::Gaussian
        }
    }
}

fn film(world: &World, film: &Parameters, settings: &mut FilmSettings) -> Result<()> {
    let side = |name: &str, default: f64| -> Result<u32> {
        let side = film.number(name, default)?;
        let fits = (1.0..=f64::from(MAX_SIDE)).contains(&side);
        fits.then_some(side as u32).ok_or_else(|| film.error(format!("`{name}` must be between 1 and {MAX_SIDE}")))
    };
    (settings.width, settings.height) = (side("xresolution", 1280.0)?, side("yresolution", 720.0)?);
    let (width, height) = (f64::from(settings.width), f64::from(settings.height));
    let bounds = match (film.numbers("pixelbounds")?, film.numbers("cropwindow")?) {
        (Some(&[x0, x1, y0, y1]), _) => Some([x0, x1, y0, y1]),
        (None, Some(&[x0, x1, y0, y1])) => Some([width * x0, width * x1, height * y0, height * y1].map(f64::ceil)),
        (None, None) => None,
        _ => return Err(film.error("`pixelbounds` and `cropwindow` are four numbers")),
    };
    if let Some([x0, x1, y0, y1]) = bounds {
        let crop = [x0, y0, x1 - x0, y1 - y0].map(|x| x.max(0.0) as u32);
        settings.crop = (crop != [0, 0, settings.width, settings.height]).then_some(crop);
        settings.check_crop().map_err(|message| film.error(message))?;
    }
    let sensor = film.text("sensor")?.unwrap_or("cie1931");
    if sensor != "cie1931" || film.number("whitebalance", 0.0)? != 0.0 {
        let message = "the film's sensor and white balance have no counterpart: colours are those of the light";
        world.warnings.add(&film.at, message);
    }
    film.ignore(&["filename", "diagonal", "savefp16", "maxsampleluminance", "maxcomponentvalue", "coordinatesystem"]);
    Ok(())
}

fn samples(sampler: &Parameters) -> Result<u32> {
    let product = match (sampler.maybe_number("xsamples")?, sampler.maybe_number("ysamples")?) {
        (None, None) => None,
        (x, y) => Some(x.unwrap_or(4.0) * y.unwrap_or(4.0)),
    };
    let count = sampler.maybe_number("pixelsamples")?.or(product).unwrap_or(16.0);
    Ok(count.clamp(1.0, f64::from(u32::MAX)) as u32)
}

/// `maxdepth` counts what scatters: a path has one segment more.
fn integrator(world: &World, file: &mut SceneFile) -> Result<()> {
    let settings = &mut file.integrator;
    settings.max_depth = 6;
    let Some(integrator) = world.settings.get("Integrator") else { return Ok(()) };
    let depth = integrator.number("maxdepth", 5.0)?.clamp(0.0, f64::from(u32::MAX - 1));
    settings.max_depth = depth as u32 + 1;
    match integrator.plugin.as_str() {
        "path" | "volpath" | "bdpt" | "mlt" | "sppm" => (),
        "simplepath" => settings.next_event = integrator.flag("samplelights", true)?,
        "randomwalk" => settings.next_event = false,
        kind => {
            let message = format!("the integrator \"{kind}\" has no counterpart: paths from the camera are traced");
            world.warnings.add(&integrator.at, message);
        }
    }
    integrator.ignore(&[
        "lightsampler",
        "lightsamplestrategy",
        "regularize",
        "rrthreshold",
        "samplebsdf",
        "pixelbounds",
    ]);
    integrator.finish(&world.warnings);
    Ok(())
}

fn camera(world: &World, camera: &Parameters, film: &FilmSettings) -> Result<CameraDescription> {
    // x is to the right there
    let to_world = world.camera_to_world * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let flat = || camera.error("the transform of the camera flattens the view");
    let placed = transform::camera(to_world).ok_or_else(flat)?;
    let axes = to_world.matrix3;
    let scale = axes.z_axis.length();
    if [axes.x_axis, axes.y_axis].iter().any(|axis| (axis.length() / scale - 1.0).abs() > 1e-3) {
        world.warnings.add(&camera.at, "the transform of the camera stretches the view, which has no counterpart");
    }
    let half = half_view(camera, film)?;
    match camera.plugin.as_str() {
        "perspective" => {
            let fov = camera.number("fov", 90.0)?;
            if !(fov > 0.0 && fov < 180.0) {
                return Err(camera.error("`fov` must be between 0 and 180 degrees"));
            }
            let tangent = (0.5 * fov.to_radians()).tan() * half;
            let vfov = (2.0 * tangent.atan().to_degrees()) as f32;
            let radius = camera.number("lensradius", 0.0)?;
            let focus = camera.number("focaldistance", 1e6)? * scale;
            if radius < 0.0 || focus <= 0.0 {
                return Err(camera.error("a lens has a radius of 0 or more and a focal distance greater than 0"));
            }
            let placed = CameraDescription { vfov, ..placed };
            if radius == 0.0 {
                return Ok(placed);
            }
            let target = placed.origin + (placed.target - placed.origin) * focus;
            let aperture_radius = (radius * scale) as f32;
            Ok(CameraDescription { aperture_radius, focus_distance: Some(focus as f32), target, ..placed })
        }
        "orthographic" => {
            let view_height = (2.0 * half * axes.y_axis.length()) as f32;
            camera.ignore(&["lensradius", "focaldistance"]);
            Ok(CameraDescription { projection: Projection::Orthographic, view_height, ..placed })
        }
        kind => Err(camera.error(format!("the camera \"{kind}\" has no counterpart"))),
    }
}

/// Half of the height of what is seen, in units of half of the shorter side of the film.
fn half_view(camera: &Parameters, film: &FilmSettings) -> Result<f64> {
    let aspect = f64::from(film.width) / f64::from(film.height);
    let frame = camera.number("frameaspectratio", aspect)?;
    let default = if frame > 1.0 { [-frame, frame, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / frame, 1.0 / frame] };
    let window = match camera.numbers("screenwindow")? {
        None => default,
        Some(&[x0, x1, y0, y1]) => [x0, x1, y0, y1],
        Some(_) => return Err(camera.error("`screenwindow` is four numbers")),
    };
    let [x0, x1, y0, y1] = window;
    let (wide, high) = (x1 - x0, y1 - y0);
    let middle = (x0 + x1).abs().max((y0 + y1).abs()) <= 1e-4 * high.abs();
    if !(wide > 0.0 && high > 0.0 && middle && (wide / high / aspect - 1.0).abs() < 1e-2) {
        let message = "a `screenwindow` or `frameaspectratio` that moves or stretches the view has no counterpart";
        return Err(camera.error(message));
    }
    Ok(0.5 * high)
}
