//! Lights that are no surfaces. Nori has none of its own: these are what courses add.

use crate::Result;
use crate::format::mitsuba::emitter;
use crate::format::xml::object::{Object, Objects};
use crate::light::{DirectionalLight, LightDescription, PointLightParameters, SpotLightParameters};
use crate::math::Rgb;
use glam::DVec3;
use std::f32::consts::PI;

pub(super) fn light(objects: &Objects, emitter: &Object) -> Result<LightDescription> {
    let light: LightDescription = match emitter.kind.as_str() {
        "point" | "pointlight" => {
            PointLightParameters { position: position(emitter)?, intensity: intensity(objects, emitter)? }.into()
        }
        "directional" | "distant" => {
            let direction = direction(emitter)?;
            let name = if emitter.find("radiance").is_some() { "radiance" } else { "irradiance" };
            DirectionalLight { direction, irradiance: emitter.color(name, Rgb::ONE)? }.into()
        }
        "spot" | "spotlight" => spot(objects, emitter)?.into(),
        "envmap" | "constant" => return emitter::light(objects, emitter),
        "area" => return Err(emitter.error("an area light belongs into a mesh")),
        kind => {
            return Err(emitter.error(format!("the emitter `{kind}` has no counterpart, and no other looks like it")));
        }
    };
    objects.finish(emitter);
    Ok(light)
}

fn position(emitter: &Object) -> Result<DVec3> {
    let placed = emitter.transform("to_world")?.map(|to_world| to_world.translation);
    Ok(emitter.vector("position")?.or(placed).unwrap_or(DVec3::ZERO))
}

fn direction(emitter: &Object) -> Result<glam::Vec3> {
    let turned = emitter.transform("to_world")?.map(|to_world| to_world.transform_vector3(DVec3::Z));
    let direction = emitter.vector("direction")?.or(turned).unwrap_or(DVec3::Z);
    let unit = direction.try_normalize().ok_or_else(|| emitter.error("its direction must not be zero"))?;
    Ok(unit.as_vec3())
}

/// `power` is that of the whole sphere; `intensity` is per steradian.
fn intensity(objects: &Objects, emitter: &Object) -> Result<Rgb> {
    if emitter.find("power").is_some() {
        return Ok(emitter.color("power", Rgb::ONE)? / (4.0 * PI));
    }
    if emitter.find("intensity").is_none() {
        objects
            .warn(&emitter.at, format!("the {} has neither `power` nor `intensity`: 1 W/sr is taken", emitter.label()));
    }
    emitter.color("intensity", Rgb::ONE)
}

fn spot(objects: &Objects, emitter: &Object) -> Result<SpotLightParameters> {
    let cutoff = emitter.number("cutoff_angle", 20.0)?;
    let beam = emitter.number("beam_width", 0.75 * cutoff)?;
    if !(cutoff > 0.0 && cutoff <= 180.0 && (0.0..=cutoff).contains(&beam)) {
        return Err(emitter.error("`beamWidth` must be between 0 and `cutoffAngle`, and that at most 180"));
    }
    Ok(SpotLightParameters {
        position: position(emitter)?,
        direction: direction(emitter)?,
        intensity: intensity(objects, emitter)?,
        cutoff_angle: cutoff as f32,
        beam_angle: beam as f32,
    })
}
