//! `[[mesh]]`, `[[instance]]` and `[[light]]`: what stands in the world, and where.

use super::settings::needs;
use crate::document::suggest::unknown;
use crate::document::{At, Bounds, COORDINATE, FINITE, Fault, NOT_NEGATIVE, Node, Reader, Value};
use crate::light::LightDescription;
use crate::math::Rgb;
use crate::scene::description::{InstanceDescription, MeshDescription};
use crate::scene::model::MeshSource;
use glam::{Affine3A, DMat3, DVec3, Mat3A, Quat, Vec3, Vec3A};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const SCALE: Bounds = Bounds::new(|x| x != 0.0 && x.abs() <= 1e18, "other than 0 and between -1e18 and 1e18");

pub(in crate::format) fn mesh(t: &mut Reader, base: &Path) -> Result<MeshDescription, Fault> {
    let path = t.take("path").map(|n| n.path("path", base)).transpose()?;
    let transform = transform(t)?;
    let material = t.take("material").map(|n| n.string("material").map(String::from)).transpose()?;
    let group = t.take("group").map(|n| n.string("group").map(String::from)).transpose()?;
    let source = MeshSource::File(path.ok_or_else(|| t.missing("path"))?);
    Ok(MeshDescription { source, transform, material, group, location: None })
}

/// `meshes`: all of the scene, whose groups are the ones there are.
pub(in crate::format) fn instance(t: &mut Reader, meshes: &[MeshDescription]) -> Result<InstanceDescription, Fault> {
    let group = t.take("group");
    let transform = transform(t)?;
    let group = group.ok_or_else(|| t.missing("group"))?;
    let name = group.string("group")?;
    let known: BTreeSet<&str> = meshes.iter().filter_map(|mesh| mesh.group.as_deref()).collect();
    if known.is_empty() {
        return Err(Fault::new(group.at, format!("unknown group `{name}`: no [[mesh]] has the key `group`")));
    }
    if !known.contains(name) {
        return Err(Fault::new(group.at, unknown(&format!("unknown group `{name}` in {}", t.label()), name, known)));
    }
    Ok(InstanceDescription { group: name.to_string(), transform, location: None })
}

/// `matrix`, or `scale`, `rotate` and `translate`.
fn transform(t: &mut Reader) -> Result<Affine3A, Fault> {
    let matrix = t.take("matrix");
    let steps = steps(t)?;
    let transform = match matrix {
        None => steps,
        Some(node) => {
            if ["translate", "rotate", "scale"].iter().any(|k| t.has(k)) {
                let message = "`matrix` stands alone: leave out `translate`, `rotate` and `scale`";
                return Err(Fault::new(node.at, message));
            }
            affine(&node, "matrix")?
        }
    };
    check_regular(t, &transform)?;
    Ok(transform)
}

/// Where a table that was read says its transform, as far as it does.
pub(in crate::format) fn transform_at(t: &Reader) -> At {
    t.place(&["matrix", "scale", "translate", "rotate"])
}

/// Scale, then rotate, then translate.
fn steps(t: &mut Reader) -> Result<Affine3A, Fault> {
    let (mut translate, mut rotate, mut scale) = (Vec3::ZERO, Quat::IDENTITY, Vec3::ONE);
    t.vector("translate", COORDINATE, &mut translate)?;
    if let Some(node) = t.take("rotate") {
        let mut r = Reader::new(format!("`rotate` of {}", t.label()), node)?;
        rotate = rotation(&mut r)?;
        r.finish()?;
    }
    t.color("scale", SCALE, &mut scale)?;
    Ok(Affine3A::from_scale_rotation_translation(scale, rotate, translate))
}

/// Degrees, counter-clockwise when the axis points at the viewer.
pub(in crate::format) fn rotation(t: &mut Reader) -> Result<Quat, Fault> {
    let (mut axis, mut angle) = (Vec3::ZERO, 0.0);
    t.vector("axis", COORDINATE, &mut axis)?;
    t.number("angle", FINITE, &mut angle)?;
    needs(t, &["axis", "angle"])?;
    Ok(Quat::from_axis_angle(unit(t, "axis", axis)?, angle.to_radians()))
}

/// The unit vector along `v`, which was read from `key`.
pub(super) fn unit(t: &Reader, key: &str, v: Vec3) -> Result<Vec3, Fault> {
    let zero = || Fault::new(t.place(&[key]), format!("`{key}` must not be zero"));
    v.as_dvec3().try_normalize().map(|v| v.as_vec3()).ok_or_else(zero)
}

/// 16 numbers row by row, flat or as four rows; the last row is 0 0 0 1 and may be left out.
pub(super) fn affine(node: &Node, key: &str) -> Result<Affine3A, Fault> {
    let mut m = [0.0; 16];
    m[15] = 1.0;
    match &node.value {
        Value::Array(rows) if matches!(rows.len(), 3 | 4) => {
            for (to, row) in m.chunks_exact_mut(4).zip(rows) {
                to.copy_from_slice(&row.numbers::<4>(key, COORDINATE)?);
            }
        }
        Value::Array(numbers) if numbers.len() == 12 => {
            m[..12].copy_from_slice(&node.numbers::<12>(key, COORDINATE)?);
        }
        _ => m = node.numbers::<16>(key, COORDINATE)?,
    }
    if m[12..] != [0.0, 0.0, 0.0, 1.0] {
        let message = format!("the last row of `{key}` must be 0, 0, 0, 1");
        return Err(Fault::new(node.at, message));
    }
    let column = |i: usize| Vec3A::new(m[i], m[4 + i], m[8 + i]);
    let linear = Mat3A::from_cols(column(0), column(1), column(2));
    Ok(Affine3A { matrix3: linear, translation: column(3) })
}

fn columns(transform: &Affine3A) -> [DVec3; 3] {
    let m = transform.matrix3;
    [m.x_axis, m.y_axis, m.z_axis].map(|c| Vec3::from(c).as_dvec3())
}

/// That the transform does not flatten what it moves: normals need its inverse.
fn check_regular(t: &Reader, transform: &Affine3A) -> Result<(), Fault> {
    let [x, y, z] = columns(transform);
    let volume = x.cross(y).dot(z).abs();
    let longest = x.length() * y.length() * z.length();
    // Relative to a box with these edges; less than this is lost in `f32`.
    if volume > 1e-7 * longest {
        return Ok(());
    }
    let at = t.place(&["matrix", "scale"]);
    Err(Fault::new(at, "this transform flattens what it moves: its determinant is 0"))
}

type ReadLight = fn(&mut Reader, &Path) -> Result<LightDescription, Fault>;

/// A light's `type` and what reads its other keys.
pub(in crate::format) const LIGHTS: &[(&str, ReadLight)] =
    &[("constant", constant), ("environment", environment), ("point", point), ("directional", directional)];

pub(in crate::format) fn light(t: &mut Reader, base: &Path) -> Result<LightDescription, Fault> {
    let read = t.chosen("type", LIGHTS)?.ok_or_else(|| t.missing("type"))?;
    read(t, base)
}

fn constant(t: &mut Reader, _: &Path) -> Result<LightDescription, Fault> {
    let mut radiance = Rgb::ZERO;
    t.color("radiance", NOT_NEGATIVE, &mut radiance)?;
    needs(t, &["radiance"])?;
    Ok(LightDescription::Constant { radiance })
}

fn environment(t: &mut Reader, base: &Path) -> Result<LightDescription, Fault> {
    let path: Option<PathBuf> = t.take("path").map(|n| n.path("path", base)).transpose()?;
    let mut scale = Rgb::ONE;
    t.color("scale", NOT_NEGATIVE, &mut scale)?;
    let mut degrees = 0.0;
    t.number("rotate_y", FINITE, &mut degrees)?;
    let to_world = match t.take("to_world") {
        None => Affine3A::from_rotation_y(degrees.to_radians()),
        Some(node) if t.has("rotate_y") => {
            return Err(Fault::new(node.at, "`to_world` and `rotate_y` exclude each other"));
        }
        Some(node) => orientation(&node, "to_world")?,
    };
    let path = path.ok_or_else(|| t.missing("path"))?;
    Ok(LightDescription::Environment { path, scale, to_world })
}

/// A matrix that keeps lengths and angles; translation means nothing infinitely far away and is dropped.
fn orientation(node: &Node, key: &str) -> Result<Affine3A, Fault> {
    let mut transform = affine(node, key)?;
    transform.translation = Vec3A::ZERO;
    let [x, y, z] = columns(&transform);
    let m = DMat3::from_cols(x, y, z);
    if (m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-4) {
        return Ok(transform);
    }
    Err(Fault::new(node.at, format!("`{key}` must be a rotation, with or without a reflection")))
}

fn point(t: &mut Reader, _: &Path) -> Result<LightDescription, Fault> {
    let (mut position, mut intensity) = (Vec3::ZERO, Rgb::ZERO);
    t.vector("position", COORDINATE, &mut position)?;
    t.color("intensity", NOT_NEGATIVE, &mut intensity)?;
    needs(t, &["position", "intensity"])?;
    Ok(LightDescription::Point { position, intensity })
}

fn directional(t: &mut Reader, _: &Path) -> Result<LightDescription, Fault> {
    let (mut direction, mut irradiance) = (Vec3::ZERO, Rgb::ZERO);
    t.vector("direction", COORDINATE, &mut direction)?;
    t.color("irradiance", NOT_NEGATIVE, &mut irradiance)?;
    needs(t, &["direction", "irradiance"])?;
    let direction = unit(t, "direction", direction)?;
    Ok(LightDescription::Directional { direction, irradiance })
}
