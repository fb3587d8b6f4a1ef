//! Steps of transforms.

use super::object::Object;
use crate::Result;
use crate::scene::description::CameraDescription;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// About an axis by an angle in degrees; `None` where the axis is zero.
pub(crate) fn rotation(axis: DVec3, angle: f64) -> Option<DAffine3> {
    Some(DAffine3::from_quat(DQuat::from_axis_angle(axis.try_normalize()?, angle.to_radians())))
}

/// The frame of a camera: x to the left of the view, y up, z along it. Without `up` any that goes. `None` where these span no view.
pub(crate) fn look_at(origin: DVec3, target: DVec3, up: Option<DVec3>) -> Option<DAffine3> {
    let forward = (target - origin).try_normalize()?;
    let up = up.filter(|up| *up != DVec3::ZERO).unwrap_or_else(|| forward.any_orthonormal_vector());
    let left = up.cross(forward).try_normalize()?;
    let linear = DMat3::from_cols(left, forward.cross(left), forward);
    Some(DAffine3 { matrix3: linear, translation: origin })
}

/// A camera that stands so in the world: z is along its view, y up and x to the left. `None` where that is flattened.
pub(crate) fn camera(to_world: DAffine3) -> Option<CameraDescription> {
    let axes = to_world.matrix3;
    let (forward, up) = (axes.z_axis.try_normalize()?, axes.y_axis.try_normalize()?);
    let origin = to_world.translation;
    let mirrored = axes.determinant() < 0.0;
    Some(CameraDescription { origin, target: origin + forward, up: up.as_vec3(), mirrored, ..Default::default() })
}

/// 16 numbers row by row, or 9 without a translation.
pub(crate) fn matrix(m: &[f64]) -> Option<DAffine3> {
    let (columns, translation) = match m.len() {
        16 if m[12..] == [0.0, 0.0, 0.0, 1.0] => (4, DVec3::new(m[3], m[7], m[11])),
        9 => (3, DVec3::ZERO),
        _ => return None,
    };
    let column = |k: usize| DVec3::new(m[k], m[columns + k], m[2 * columns + k]);
    Some(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation })
}

/// That the transform does not flatten what it moves.
pub(crate) fn check_regular(shape: &Object, transform: &DAffine3) -> Result<()> {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = transform.matrix3;
    if x.cross(y).dot(z).abs() > 1e-7 * x.length() * y.length() * z.length() {
        return Ok(());
    }
    Err(shape.error("its transform flattens it"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_looks_along_z_with_x_to_its_left() {
        let frame = look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, Some(DVec3::Y)).unwrap();
        assert_eq!(frame.transform_point3(DVec3::Z), DVec3::new(0.0, 0.0, 4.0));
        assert_eq!(frame.transform_vector3(DVec3::X), -DVec3::X);
        assert_eq!(frame.transform_vector3(DVec3::Y), DVec3::Y);
        assert!(look_at(DVec3::ZERO, DVec3::Y, Some(DVec3::Y)).is_none());
        assert!(look_at(DVec3::ZERO, DVec3::Y, None).is_some());
    }

    #[test]
    fn matrices_are_row_by_row() {
        let m: Vec<f64> = vec![1.0, 2.0, 3.0, 4.0, 0.0, 1.0, 0.0, 5.0, 0.0, 0.0, 1.0, 6.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(matrix(&m).unwrap().transform_point3(DVec3::Y), DVec3::new(6.0, 6.0, 6.0));
        assert!(matrix(&m[..12]).is_none());
    }
}
