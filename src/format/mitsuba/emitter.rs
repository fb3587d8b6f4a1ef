//! Lights that are no surfaces.

use super::sun;
use crate::Result;
use crate::format::xml::object::{Object, Objects};
use crate::light::{
    ConstantLight, DirectionalLight, EnvironmentLight, LightDescription, PointLightParameters, SkyLight,
    SpotLightParameters,
};
use crate::math::Rgb;
use glam::{DAffine3, DMat3, DVec3};

/// The light of an emitter that belongs to no shape.
///
/// # Errors
/// A type that is not known or has no counterpart, and what is wrong with its properties.
pub(crate) fn light(objects: &Objects, emitter: &Object) -> Result<LightDescription> {
    emitter.ignore(&["sampling_weight"]);
    let light = match emitter.kind.as_str() {
        "constant" => ConstantLight { radiance: emitter.color("radiance", Rgb::ONE)? }.into(),
        "envmap" => environment(objects, emitter)?.into(),
        "point" => {
            let placed = emitter.transform("to_world")?.map(|to_world| to_world.translation);
            let position = emitter.vector("position")?.or(placed).unwrap_or(DVec3::ZERO);
            PointLightParameters { position, intensity: emitter.color("intensity", Rgb::ONE)? }.into()
        }
        "directional" => {
            let to_world = emitter.transform("to_world")?;
            let turned = to_world.map(|to_world| to_world.transform_vector3(DVec3::Z));
            let direction = emitter.vector("direction")?.or(turned).unwrap_or(DVec3::Z);
            let direction = unit(emitter, direction)?.as_vec3();
            DirectionalLight { direction, irradiance: emitter.color("irradiance", Rgb::ONE)? }.into()
        }
        "spot" => spot(emitter)?.into(),
        "sky" | "sunsky" | "sun" => sky(objects, emitter)?,
        "area" => return Err(emitter.error("an area light belongs into a shape, and no shape refers to this one")),
        kind => {
            return Err(emitter.error(format!("the emitter `{kind}` has no counterpart, and no other looks like it")));
        }
    };
    objects.finish(emitter);
    Ok(light)
}

fn spot(emitter: &Object) -> Result<SpotLightParameters> {
    let to_world = emitter.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    let direction = unit(emitter, to_world.transform_vector3(DVec3::Z))?;
    let cutoff = emitter.number("cutoff_angle", 20.0)?;
    let beam = emitter.number("beam_width", 0.75 * cutoff)?;
    if !(cutoff > 0.0 && cutoff <= 180.0 && (0.0..=cutoff).contains(&beam)) {
        return Err(emitter.error("`beam_width` must be between 0 and `cutoff_angle`, and that at most 180"));
    }
    if emitter.find("texture").is_some() {
        return Err(emitter.error("a spot light with a picture has no counterpart"));
    }
    Ok(SpotLightParameters {
        position: to_world.translation,
        direction: direction.as_vec3(),
        intensity: emitter.color("intensity", Rgb::ONE)?,
        cutoff_angle: cutoff as f32,
        beam_angle: beam as f32,
    })
}

fn unit(emitter: &Object, direction: DVec3) -> Result<DVec3> {
    direction.try_normalize().ok_or_else(|| emitter.error("its direction must not be zero"))
}

fn environment(objects: &Objects, emitter: &Object) -> Result<EnvironmentLight> {
    let path = emitter.file()?.to_path_buf();
    let scale = emitter.color("scale", Rgb::ONE)?;
    let to_world = turn(objects, emitter)?;
    Ok(EnvironmentLight { path, scale, to_world: to_world.as_affine3a(), octahedral: false })
}

/// The rotation of `to_world`, with or without a mirroring.
fn turn(objects: &Objects, emitter: &Object) -> Result<DAffine3> {
    let to_world = emitter.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = to_world.matrix3;
    let flat = || emitter.error("its transform flattens the surroundings");
    let [x, y, z] = [x.try_normalize(), y.try_normalize(), z.try_normalize()];
    let turned = DMat3::from_cols(x.ok_or_else(flat)?, y.ok_or_else(flat)?, z.ok_or_else(flat)?);
    if turned.determinant().abs() < 0.999_99 {
        let message = "its transform is no rotation: surroundings are only turned";
        objects.warn(&emitter.at, message);
        let (x, z) = (turned.x_axis, turned.x_axis.cross(turned.y_axis).normalize_or(DVec3::Z));
        return Ok(DAffine3::from_mat3(DMat3::from_cols(x, z.cross(x), z)));
    }
    Ok(DAffine3::from_mat3(turned))
}

/// What Mitsuba's sky is over ours, which is watts weighed by the eye's sensitivity: Mitsuba takes the mean over wavelengths, and the integral
/// of that sensitivity is 106.857 nm.
const SKY_MEAN: f64 = 1.0 / 106.856_895;

/// A sky, with its sun or without, or the sun alone.
fn sky(objects: &Objects, emitter: &Object) -> Result<LightDescription> {
    let up = if objects.is_old() { DVec3::Y } else { DVec3::Z };
    let turned = turn(objects, emitter)?;
    let up = turned.transform_vector3(up);
    let sun = match emitter.vector("sun_direction")? {
        Some(direction) => unit(emitter, direction)?,
        None => turned.transform_vector3(sun::direction(emitter, objects.is_old())?),
    };
    if sun.dot(up) < 0.0 {
        return Err(emitter.error("the sun is below the horizon"));
    }
    let scale = emitter.number("scale", 1.0)?;
    let (sky_scale, sun_scale) = match emitter.kind.as_str() {
        "sunsky" => (emitter.number("sky_scale", 1.0)?, emitter.number("sun_scale", 1.0)?),
        "sun" => (0.0, 1.0),
        _ => (1.0, 0.0),
    };
    let alone = sky_scale == 0.0 && sun_scale > 0.0;
    if !alone && sun_scale != 0.0 && sun_scale != sky_scale {
        objects.warn(&emitter.at, "`sun_scale` other than `sky_scale` has no counterpart: `sky_scale` counts for both");
    }
    let albedo = if objects.is_old() { 0.15 } else { 0.3 };
    objects
        .warn(&emitter.at, "its light is the same model by another table: colours and strength differ by some percent");
    let sky = SkyLight {
        sun_direction: sun.as_vec3(),
        up: up.as_vec3(),
        turbidity: emitter.number("turbidity", 3.0)?.clamp(1.0, 10.0) as f32,
        ground_albedo: emitter.color("albedo", Rgb::splat(albedo))?.min(Rgb::ONE),
        sun: sun_scale != 0.0,
        scale: (scale * if alone { sun_scale } else { sky_scale } * SKY_MEAN).max(0.0) as f32,
    };
    Ok(if alone { sky.sun_alone().map_err(|error| emitter.error(error.to_string()))?.into() } else { sky.into() })
}
