//! `[[mesh]]`, `[[instance]]` and `[[light]]`: what stands in the world, and where.

use super::fields::KeyReader;
use super::materials::light_group;
use crate::document::suggest::unknown;
use crate::document::{At, Bounds, COORDINATE, FINITE, Fault, Key, Node, Reader, Value, key};
use crate::fields::Fields;
use crate::light::{LightDescription, LightType};
use crate::scene::description::{InstanceDescription, MeshDescription, SceneDescription};
use crate::scene::model::MeshSource;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use std::collections::BTreeSet;
use std::path::Path;

const SCALE: Bounds = Bounds::new(|x| x != 0.0 && x.abs() <= 1e18, "other than 0 and between -1e18 and 1e18");

pub(in crate::format) fn mesh(t: &mut Reader, base: &Path) -> Result<MeshDescription, Fault> {
    let path = t.path(key("path", "an OBJ or PLY file").required(), base)?.unwrap_or_default();
    let transform = transform(t)?;
    let material = t.string(key("material", "replaces every material of the file").optional())?;
    let meaning = "makes the mesh part of this group: it is seen only where an `[[instance]]` of the group stands, and the \
                   keys above place it within the group";
    let group = t.string(key("group", meaning).optional())?;
    let source = MeshSource::File(path);
    Ok(MeshDescription { source, transform, material, material_location: None, group, location: None })
}

/// `meshes`: all of the scene, whose groups are the ones there are.
pub(in crate::format) fn instance(t: &mut Reader, meshes: &[MeshDescription]) -> Result<InstanceDescription, Fault> {
    let group = t.ask(key("group", "the `group` of a `[[mesh]]`").required(), "string", "", "")?;
    let transform = transform(t)?;
    let Some(group) = group else {
        return Ok(InstanceDescription { group: String::new(), transform, location: None });
    };
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
fn transform(t: &mut Reader) -> Result<DAffine3, Fault> {
    let steps = steps(t)?;
    let meaning =
        "row by row, for column vectors; the last row, 0, 0, 0, 1, may be left out; excludes the three before";
    let matrix = key("matrix", meaning).optional();
    let transform = match t.ask(matrix, "16 numbers or 4 rows of 4", "", "determinant not 0")? {
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

/// Where a table that was read says its material.
pub(in crate::format) fn material_at(t: &Reader) -> At {
    t.place(&["material"])
}

/// Where a table that was read says its transform, as far as it does.
pub(in crate::format) fn transform_at(t: &Reader) -> At {
    t.place(&["matrix", "scale", "translate", "rotate"])
}

/// Scale, then rotate, then translate.
fn steps(t: &mut Reader) -> Result<DAffine3, Fault> {
    let (mut translate, mut rotate, mut scale) = (DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE);
    let stretch =
        key("scale", "comes first; a negative one mirrors, and normals and the side that emits keep their meaning");
    t.factors(stretch, SCALE, &mut scale)?;
    if let Some(node) =
        t.ask(key("rotate", "comes second: a table of `axis` and `angle`").optional(), "table", "", "")?
    {
        let mut r = Reader::new(format!("`rotate` of {}", t.label()), node)?;
        rotate = rotation(&mut r)?;
        r.finish()?;
    }
    t.point(key("translate", "comes last").unit("length"), COORDINATE, &mut translate)?;
    Ok(DAffine3::from_scale_rotation_translation(scale, rotate, translate))
}

/// Degrees, counter-clockwise when the axis points at the viewer.
pub(in crate::format) fn rotation(t: &mut Reader) -> Result<DQuat, Fault> {
    let (mut axis, mut angle) = (DVec3::Y, 0.0);
    t.point(key("axis", "about which it turns; not zero").required(), COORDINATE, &mut axis)?;
    let meaning = "counter-clockwise when the axis points at the viewer";
    t.double(key("angle", meaning).unit("degrees").required(), FINITE, &mut angle)?;
    let axis = axis.try_normalize().ok_or_else(|| zero(t, "axis"))?;
    Ok(DQuat::from_axis_angle(axis, angle.to_radians()))
}

/// The unit vector along `v`, which was read from `key`.
pub(super) fn unit(t: &Reader, key: &str, v: Vec3) -> Result<Vec3, Fault> {
    v.as_dvec3().try_normalize().map(|v| v.as_vec3()).ok_or_else(|| zero(t, key))
}

fn zero(t: &Reader, key: &str) -> Fault {
    Fault::new(t.place(&[key]), format!("`{key}` must not be zero"))
}

/// 16 numbers row by row, flat or as four rows; the last row is 0 0 0 1 and may be left out.
pub(super) fn affine(node: &Node, key: &str) -> Result<DAffine3, Fault> {
    let mut m = [0.0; 16];
    m[15] = 1.0;
    match &node.value {
        Value::Array(rows) if matches!(rows.len(), 3 | 4) => {
            for (to, row) in m.chunks_exact_mut(4).zip(rows) {
                to.copy_from_slice(&row.doubles::<4>(key, COORDINATE)?);
            }
        }
        Value::Array(numbers) if numbers.len() == 12 => {
            m[..12].copy_from_slice(&node.doubles::<12>(key, COORDINATE)?);
        }
        _ => m = node.doubles::<16>(key, COORDINATE)?,
    }
    if m[12..] != [0.0, 0.0, 0.0, 1.0] {
        let message = format!("the last row of `{key}` must be 0, 0, 0, 1");
        return Err(Fault::new(node.at, message));
    }
    let column = |i: usize| DVec3::new(m[i], m[4 + i], m[8 + i]);
    let linear = DMat3::from_cols(column(0), column(1), column(2));
    Ok(DAffine3 { matrix3: linear, translation: column(3) })
}

/// That the transform does not flatten what it moves: normals need its inverse.
fn check_regular(t: &Reader, transform: &DAffine3) -> Result<(), Fault> {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = transform.matrix3.as_mat3().as_dmat3();
    let volume = x.cross(y).dot(z).abs();
    let longest = x.length() * y.length() * z.length();
    // Relative to a box with these edges; less than this is lost in `f32`.
    if volume > 1e-7 * longest {
        return Ok(());
    }
    let at = t.place(&["matrix", "scale"]);
    Err(Fault::new(at, "this transform flattens what it moves: its determinant is 0"))
}

/// Reads a light, and its group, into the scene.
pub(in crate::format) fn light(t: &mut Reader, base: &Path, scene: &mut SceneDescription) -> Result<(), Fault> {
    let (kind, group) = light_type(t)?;
    let kind = kind.ok_or_else(|| t.missing("type"))?;
    scene.lights.push(kind.read(t, base)?);
    scene.light_groups.push(group);
    Ok(())
}

/// The keys of every light.
pub(in crate::format) fn light_type(t: &mut Reader) -> Result<(Option<LightType>, Option<String>), Fault> {
    let key = Key { default: Some("required"), ..key("type", "what kind of light it is: one of the types below") };
    let (kind, mut group) = (t.chosen(key, LightType::NAMES)?, None);
    light_group(t, &mut group)?;
    Ok((kind, group))
}

impl LightType {
    /// Reads the type's own keys.
    pub(crate) fn read(self, table: &mut Reader, base: &Path) -> Result<LightDescription, Fault> {
        let mut light = self.light();
        light.fields(&mut KeyReader { table, base })?;
        Ok(light)
    }
}
