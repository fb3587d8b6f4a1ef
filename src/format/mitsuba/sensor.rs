//! Camera, film, samples and the length of paths.

use crate::Result;
use crate::film::{FilmSettings, Filter, MAX_SIDE};
use crate::format::SceneFile;
use crate::format::xml::object::{Object, Objects};
use crate::format::xml::transform;
use crate::scene::description::{CameraDescription, Projection};
use glam::DAffine3;

/// Reads the first sensor into the scene, and what it says of the film and of samples.
pub(super) fn sensors(objects: &Objects, file: &mut SceneFile) -> Result<()> {
    let found = objects.children(&objects.root, "sensor")?;
    let Some((_, first)) = found.first() else { return Ok(()) };
    if let Some((_, second)) = found.get(1) {
        objects.warn(&second.at, "only the first sensor counts");
    }
    let film = objects.child(first, "film")?;
    file.scene.film = match &film {
        Some(film) => self::film(objects, film)?,
        None => FilmSettings { width: 768, height: 576, filter: Filter::Gaussian, ..FilmSettings::default() },
    };
    if let Some(sampler) = objects.child(first, "sampler")? {
        if let Some(count) = sampler.maybe_number("sample_count")? {
            file.render.spp = count.clamp(1.0, f64::from(u32::MAX)) as u32;
        }
        sampler.ignore(&["seed", "jitter"]);
    }
    file.scene.camera = Some(camera(objects, first, &file.scene.film)?);
    first.ignore(&["near_clip", "far_clip", "shutter_open", "shutter_close"]);
    objects.finish(first);
    Ok(())
}

fn film(objects: &Objects, film: &Object) -> Result<FilmSettings> {
    let side = |name: &str, default: f64| -> Result<u32> {
        let side = film.number(name, default)?;
        if (1.0..=f64::from(MAX_SIDE)).contains(&side) {
            Ok(side as u32)
        } else {
            Err(film.error(format!("`{name}` must be between 1 and {MAX_SIDE}")))
        }
    };
    let (width, height) = (side("width", 768.0)?, side("height", 576.0)?);
    let offset = |name: &str| film.number(name, 0.0).map(|x| x.max(0.0) as u32);
    let [x, y] = [offset("crop_offset_x")?, offset("crop_offset_y")?];
    let (crop_width, crop_height) = (side("crop_width", f64::from(width))?, side("crop_height", f64::from(height))?);
    let crop = [x, y, crop_width, crop_height];
    let filter = match objects.child(film, "rfilter")? {
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
    film.ignore(&[
        "file_format",
        "pixel_format",
        "component_format",
        "banner",
        "high_quality_edges",
        "sample_border",
        "attach_log",
        "compensate",
        "gamma",
        "exposure",
        "tonemap_method",
        "fov",
        "variable",
        "digits",
    ]);
    objects.finish(film);
    let crop = (crop != [0, 0, width, height]).then_some(crop);
    let settings = FilmSettings { width, height, filter, crop, ..FilmSettings::default() };
    settings.check_crop().map_err(|message| film.error(message))?;
    Ok(settings)
}

fn camera(objects: &Objects, sensor: &Object, film: &FilmSettings) -> Result<CameraDescription> {
    let to_world = sensor.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    let axes = to_world.matrix3;
    let flat = || sensor.error("the transform of the sensor flattens the view");
    let common = transform::camera(to_world).ok_or_else(flat)?;
    let (origin, forward) = (common.origin, common.target - common.origin);
    let lens = sensor.kind == "thinlens";
    let focus = sensor.number("focus_distance", 1.0)?;
    match sensor.kind.as_str() {
        "perspective" | "thinlens" => {
            for name in ["principal_point_offset_x", "principal_point_offset_y"] {
                if sensor.number(name, 0.0)? != 0.0 {
                    objects.warn(
                        &sensor.at,
                        format!("`{name}` has no counterpart: the view is in the middle of the film"),
                    );
                }
            }
            let aperture_radius = if lens { sensor.number("aperture_radius", 0.0)? } else { 0.0 };
            if aperture_radius < 0.0 || lens && focus <= 0.0 {
                return Err(sensor.error("`aperture_radius` and `focus_distance` must not be negative"));
            }
            Ok(CameraDescription {
                vfov: vertical_view(sensor, film)? as f32,
                aperture_radius: aperture_radius as f32,
                focus_distance: lens.then_some(focus as f32),
                target: if lens { origin + forward * focus } else { common.target },
                ..common
            })
        }
        // the film is as wide as 2 units of the sensor's own space
        "orthographic" => {
            let width = 2.0 * axes.x_axis.length();
            let view_height = width * f64::from(film.height) / f64::from(film.width);
            let projection = Projection::Orthographic;
            Ok(CameraDescription { projection, view_height: view_height as f32, ..common })
        }
        kind => Err(sensor.error(format!("the sensor `{kind}` has no counterpart"))),
    }
}

/// The vertical field of view in degrees.
fn vertical_view(sensor: &Object, film: &FilmSettings) -> Result<f64> {
    let aspect = f64::from(film.width) / f64::from(film.height);
    // tangents of half the angles, of which the height's is wanted
    let from_diagonal = |tangent: f64| tangent / (1.0 + aspect * aspect).sqrt();
    let tangent = match sensor.text("focal_length")? {
        Some(text) => {
            let millimetres = text.trim().trim_end_matches("mm").trim().parse().ok().filter(|x: &f64| *x > 0.0);
            let focal = millimetres.ok_or_else(|| sensor.error("`focal_length` must be a number of mm"))?;
            // of a film of 36 mm by 24 mm
            from_diagonal(0.5 * (36f64 * 36.0 + 24.0 * 24.0).sqrt() / focal)
        }
        None => {
            let default = if sensor.find("fov").is_none() {
                from_diagonal(0.5 * (36f64 * 36.0 + 24.0 * 24.0).sqrt() / 50.0)
            } else {
                0.0
            };
            let Some(fov) = sensor.maybe_number("fov")? else { return Ok(2.0 * default.atan().to_degrees()) };
            if !(fov > 0.0 && fov < 180.0) {
                return Err(sensor.error("`fov` must be between 0 and 180 degrees"));
            }
            let tangent = (0.5 * fov.to_radians()).tan();
            match sensor.text("fov_axis")?.unwrap_or("x") {
                "x" => tangent / aspect,
                "y" => tangent,
                "diagonal" => from_diagonal(tangent),
                "smaller" => {
                    if aspect > 1.0 {
                        tangent
                    } else {
                        tangent / aspect
                    }
                }
                "larger" => {
                    if aspect > 1.0 {
                        tangent / aspect
                    } else {
                        tangent
                    }
                }
                other => {
                    return Err(sensor.error(format!("unknown `fov_axis` {other}: x, y, diagonal, smaller or larger")));
                }
            }
        }
    };
    Ok(2.0 * tangent.atan().to_degrees())
}

/// How long paths are. Paths without an end are as long as a number goes.
pub(super) fn integrator(objects: &Objects, file: &mut SceneFile) -> Result<()> {
    let Some(mut integrator) = objects.child(&objects.root, "integrator")? else { return Ok(()) };
    // `moment`, `aov` and their like add layers to what the integrator within them finds
    while let Some(inner) = objects.child(&integrator, "integrator")? {
        if integrator.kind != "moment" {
            let message = format!("the integrator `{}` has no counterpart: the one within it counts", integrator.kind);
            objects.warn(&integrator.at, message);
        }
        integrator = inner;
    }
    let path = ["path", "volpath", "volpath_simple", "volpathmis", "guided_path"];
    match integrator.kind.as_str() {
        "direct" => file.integrator.max_depth = 2,
        kind => {
            if !path.contains(&kind) {
                objects.warn(
                    &integrator.at,
                    format!("the integrator `{kind}` has no counterpart: paths from the camera are traced"),
                );
            }
            file.integrator.max_depth = match integrator.number("max_depth", -1.0)? {
                depth if depth < 0.0 => u32::MAX,
                depth => (depth as u32).max(1),
            };
        }
    }
    if integrator.flag("hide_emitters", false)? {
        objects.warn(&integrator.at, "`hide_emitters` has no counterpart: lights are seen");
    }
    Ok(())
}
