//! Lights that are no surfaces.

use super::parameters::Parameters;
use super::spectrum::Role;
use super::world::{Light, World};
use crate::Result;
use crate::image::picture;
use crate::light::{
    ConstantLight, DirectionalLight, EnvironmentLight, LightDescription, PointLightParameters, SpotLightParameters,
};
use crate::math::{Rgb, luminance};
use crate::scene::description::SceneDescription;
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::PI;
use std::path::Path;

pub(super) fn light(world: &World, light: &Light) -> Result<LightDescription> {
    let Light { parameters, to_world } = light;
    let described: LightDescription = match parameters.plugin.as_str() {
        "point" => point(world, parameters, to_world)?.into(),
        "goniometric" => {
            let message = "the light \"goniometric\" has no counterpart: a point light is taken";
            world.warnings.add(&parameters.at, message);
            parameters.ignore(&["filename", "mapname"]);
            point(world, parameters, to_world)?.into()
        }
        "distant" => {
            let (_, towards) = ends(parameters, to_world)?;
            let irradiance = emitted(world, parameters, "L")? * positive(parameters, "illuminance")?.unwrap_or(1.0);
            DirectionalLight { direction: towards.as_vec3(), irradiance }.into()
        }
        "spot" => spot(world, parameters, to_world)?.into(),
        "infinite" => infinite(world, parameters, to_world)?,
        kind => {
            return Err(
                parameters.error(format!("the light \"{kind}\" has no counterpart, and no other looks like it"))
            );
        }
    };
    parameters.finish(&world.warnings);
    Ok(described)
}

/// The light of a parameter, times `scale`.
pub(super) fn emitted(world: &World, parameters: &Parameters, name: &str) -> Result<Rgb> {
    let light = world.color(parameters, name, Role::Light)?.unwrap_or(Rgb::ONE);
    let scale = world.color(parameters, "scale", Role::Reflectance)?.unwrap_or(Rgb::ONE);
    parameters.ignore(&["samples", "nsamples"]);
    Ok(light * scale)
}

/// A number that counts where it is greater than 0.
fn positive(parameters: &Parameters, name: &str) -> Result<Option<f32>> {
    Ok(parameters.maybe_number(name)?.filter(|&number| number > 0.0).map(|number| number as f32))
}

fn point(world: &World, parameters: &Parameters, to_world: &DAffine3) -> Result<PointLightParameters> {
    let from = parameters.vector("from")?.unwrap_or(DVec3::ZERO);
    let power = positive(parameters, "power")?.map_or(1.0, |power| power / (4.0 * PI) as f32);
    let intensity = emitted(world, parameters, "I")? * power;
    Ok(PointLightParameters { position: to_world.transform_point3(from), intensity })
}

/// Where a light is and the direction in which it shines.
fn ends(parameters: &Parameters, to_world: &DAffine3) -> Result<(DVec3, DVec3)> {
    let from = parameters.vector("from")?.unwrap_or(DVec3::ZERO);
    let to = parameters.vector("to")?.unwrap_or(DVec3::Z);
    let towards = to_world.transform_vector3(to - from).try_normalize();
    let towards = towards.ok_or_else(|| parameters.error("`from` and `to` are at one place"))?;
    Ok((to_world.transform_point3(from), towards))
}

fn spot(world: &World, parameters: &Parameters, to_world: &DAffine3) -> Result<SpotLightParameters> {
    let (position, towards) = ends(parameters, to_world)?;
    let cone = parameters.number("coneangle", 30.0)?;
    let beam = cone - parameters.number("conedeltaangle", 5.0)?;
    if !(cone > 0.0 && cone <= 180.0 && (0.0..=cone).contains(&beam)) {
        return Err(parameters.error("`conedeltaangle` must be between 0 and `coneangle`, and that at most 180"));
    }
    let [outer, inner] = [cone, beam].map(|angle| angle.to_radians().cos());
    let power =
        positive(parameters, "power")?.map_or(1.0, |power| power / (2.0 * PI * (1.0 - 0.5 * (inner + outer))) as f32);
    Ok(SpotLightParameters {
        position,
        direction: towards.as_vec3(),
        intensity: emitted(world, parameters, "I")? * power,
        cutoff_angle: cone as f32,
        beam_angle: beam as f32,
    })
}

/// Light from all around: even, or a picture.
fn infinite(world: &World, parameters: &Parameters, to_world: &DAffine3) -> Result<LightDescription> {
    if parameters.numbers("portal")?.is_some() {
        world.warnings.add(&parameters.at, "`portal` means nothing here: light comes from all around");
    }
    let illuminance = positive(parameters, "illuminance")?;
    let scale = emitted(world, parameters, "L")?;
    let name = match parameters.text("filename")? {
        Some(name) => Some(name),
        None => parameters.text("mapname")?,
    };
    let Some(name) = name else {
        let radiance = scale * illuminance.map_or(1.0, |illuminance| illuminance / PI as f32);
        return Ok(ConstantLight { radiance }.into());
    };
    let path = world.file(name);
    // the frames of longitude and latitude have z up there, and y here
    let upright = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::NEG_X);
    let turned = turn(world, parameters, to_world)?;
    let linear = if world.old { turned * upright } else { turned };
    let scale = match illuminance.filter(|_| !world.old) {
        Some(wanted) => scale * (wanted / from_above(&path)?.max(f32::MIN_POSITIVE)),
        None => scale,
    };
    let to_world = DAffine3::from_mat3(linear).as_affine3a();
    Ok(EnvironmentLight { path, scale, to_world, octahedral: !world.old }.into())
}

/// The rotation of a transform, with or without a mirroring.
fn turn(world: &World, parameters: &Parameters, to_world: &DAffine3) -> Result<DMat3> {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = to_world.matrix3;
    let flat = || parameters.error("its transform flattens the surroundings");
    let [x, y, z] = [x.try_normalize(), y.try_normalize(), z.try_normalize()];
    let turned = DMat3::from_cols(x.ok_or_else(flat)?, y.ok_or_else(flat)?, z.ok_or_else(flat)?);
    if turned.determinant().abs() > 0.999_99 {
        return Ok(turned);
    }
    world.warnings.add(&parameters.at, "its transform is no rotation: surroundings are only turned");
    let (z, x) = (turned.z_axis, turned.y_axis.cross(turned.z_axis).try_normalize().ok_or_else(flat)?);
    Ok(DMat3::from_cols(x, z.cross(x), z))
}

/// The luminance that an octahedral picture sends onto a patch that looks along +z.
fn from_above(path: &Path) -> Result<f32> {
    let picture = picture::load(path)?;
    let (width, height) = (picture.width, picture.height);
    let cosine = |k: usize| {
        let [u, v] = [(k % width, width), (k / width, height)].map(|(i, n)| 2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
        // of the equal-area mapping
        let r = u.abs() + v.abs();
        if r < 1.0 { 1.0 - r * r } else { 0.0 }
    };
    let colors = picture.colors();
    let sum: f64 = colors.iter().enumerate().map(|(k, color)| f64::from(luminance(*color)) * cosine(k)).sum();
    Ok((sum * 4.0 * PI / colors.len() as f64) as f32)
}

/// Multiplies all light, as a film does that is more or less sensitive, or longer open.
pub(super) fn expose(scene: &mut SceneDescription, exposure: f32) {
    if exposure == 1.0 {
        return;
    }
    for light in &mut scene.lights {
        match light {
            LightDescription::Constant(light) => light.radiance *= exposure,
            LightDescription::Environment(light) => light.scale *= exposure,
            LightDescription::Point(light) => light.intensity *= exposure,
            LightDescription::Directional(light) => light.irradiance *= exposure,
            LightDescription::Spot(light) => light.intensity *= exposure,
            _ => (),
        }
    }
    scene.materials.values_mut().for_each(|material| material.emission *= exposure);
}
