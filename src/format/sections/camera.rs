//! `[camera]`, and what every section has in common.

use crate::document::{Bounds, COORDINATE, Fault, Key, Node, Reader, key};
use crate::scene::description::CameraDescription;
use glam::{DVec3, Vec3};

/// Degrees of a field of view.
pub(in crate::format) const VFOV: Bounds = Bounds::new(|x| x > 0.0 && x < 180.0, "greater than 0 and less than 180");
/// `None` before means that the section places a camera, else it changes the one there is.
pub(in crate::format) fn camera(t: &mut Reader, camera: &mut Option<CameraDescription>) -> Result<(), Fault> {
    let mut c = camera.clone().unwrap_or_else(camera_facing_up);
    let new = camera.is_none();
    let placed = |k: Key| if new { k.required() } else { k };
    t.point(placed(key("origin", "where the eye is").unit("length")), COORDINATE, &mut c.origin)?;
    let target = key("target", "what is in the middle of the picture; other than `origin`").unit("length");
    t.point(placed(target), COORDINATE, &mut c.target)?;
    let up = "what is up in the picture; not zero, and not along the view";
    t.vector(key("up", up), COORDINATE, &mut c.up)?;
    let vfov = key("vfov", "field of view from the lower to the upper edge").unit("degrees");
    t.number(vfov, VFOV, &mut c.vfov)?;
    t.flag(key("mirrored", "flips the picture left to right"), &mut c.mirrored)?;
    t.complete()?;
    check_camera(t, &c)?;
    *camera = Some(c);
    Ok(())
}

/// What a camera has before its keys are read; that `origin` and `target` are given is checked after.
pub(in crate::format) fn camera_facing_up() -> CameraDescription {
    let (origin, target, up) = (DVec3::ZERO, DVec3::ZERO, Vec3::Y);
    CameraDescription { origin, target, up, vfov: 45.0, mirrored: false }
}

/// That all of `keys`, which were asked for, were there.
pub(in crate::format) fn needs(t: &Reader, keys: &[&str]) -> Result<(), Fault> {
    keys.iter().find(|k| !t.has(k)).map_or(Ok(()), |k| Err(t.missing(k)))
}

/// That the three vectors span a frame.
pub(in crate::format) fn check_camera(t: &Reader, c: &CameraDescription) -> Result<(), Fault> {
    let view = c.target - c.origin;
    if view.length() == 0.0 {
        let at = t.place(&["target", "origin"]);
        return Err(Fault::new(at, "`target` must differ from `origin`"));
    }
    let up = c.up.as_dvec3();
    // The sine of the angle between them; below about 1e-6, `f32` can no longer tell the camera's right.
    if view.cross(up).length() <= 1e-6 * view.length() * up.length() {
        let at = t.place(&["up", "target", "origin"]);
        return Err(Fault::new(at, "`up` must not be zero or parallel to the view"));
    }
    Ok(())
}

/// Reads the section `key` of `root`, if it is there, and refuses what `read` has not asked for.
pub(in crate::format) fn section(
    root: &mut Reader,
    key: &'static str,
    read: impl FnOnce(&mut Reader) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let lenient = root.is_lenient();
    root.take(key).map_or(Ok(()), |node: Node| {
        let mut t = Reader::new(format!("[{key}]"), node)?.lenient(lenient);
        read(&mut t)?;
        t.finish()
    })
}
