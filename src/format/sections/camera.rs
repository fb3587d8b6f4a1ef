//! `[camera]`, and what every section has in common.

use crate::document::{Bounds, COORDINATE, Fault, Key, NOT_NEGATIVE, Node, POSITIVE, Reader, key};
use crate::scene::description::{CameraDescription, CameraKey, Interpolation, Projection, Unsaid};
use glam::{DVec3, Vec3};

/// Degrees of a field of view.
pub(in crate::format) const VFOV: Bounds = Bounds::new(|x| x > 0.0 && x < 180.0, "greater than 0 and less than 180");
/// Numbers of frames.
const FRAME: Bounds = Bounds::new(|x| x.abs() <= 1e6, "between -1e6 and 1e6");
const ORIGIN: &str = "where the eye is; without it, a place is found from which most is seen";
const TARGET: &str =
    "what is in the middle of the picture; other than `origin`; without it, a direction is found in which most is seen";
const UP: &str =
    "what is up in the picture; not zero, and not along the view; without it +y, or what an OBJ file says of itself";
const FIELD: &str = "field of view from the lower to the upper edge; where the camera is found, that of a usual lens";
const HEIGHT: &str =
    "from the lower to the upper edge of the picture; where the camera is found, so much that the model fills it";

/// Reads over the camera there is. What nobody says is found when the scene is loaded.
pub(in crate::format) fn camera(t: &mut Reader, camera: &mut Option<CameraDescription>) -> Result<(), Fault> {
    let mut c = camera.clone().unwrap_or_else(CameraDescription::open);
    t.point(key("origin", ORIGIN).unit("length").optional(), COORDINATE, &mut c.origin)?;
    t.point(key("target", TARGET).unit("length").optional(), COORDINATE, &mut c.target)?;
    t.vector(key("up", UP).optional(), COORDINATE, &mut c.up)?;
    projection(t, &mut c)?;
    t.flag(key("mirrored", "flips the picture left to right"), &mut c.mirrored)?;
    let way = "from key to key: on curves without overshoot that begin and end at rest, or on straight lines at constant speed";
    t.choice(key("interpolation", way), INTERPOLATIONS, &mut c.interpolation)?;
    keys(t, &mut c)?;
    let Unsaid { origin, target, up, vfov, view_height } = &mut c.unsaid;
    let keys = [("origin", origin), ("target", target), ("up", up), ("vfov", vfov), ("view_height", view_height)];
    for (key, unsaid) in keys {
        *unsaid &= !t.has(key);
    }
    c.stand_at_first_keys();
    // Their defaults are for a camera that has a place.
    let open = c.unsaid.is_open();
    (c.unsaid.vfov, c.unsaid.view_height) = (c.unsaid.vfov && open, c.unsaid.view_height && open);
    check_camera(t, &c)?;
    *camera = Some(c);
    Ok(())
}

const INTERPOLATIONS: &[(&str, Interpolation)] =
    &[("smooth", Interpolation::Smooth), ("linear", Interpolation::Linear)];

/// Keys at frames. What the camera itself does not say is as in the first key that says it.
fn keys(t: &mut Reader, c: &mut CameraDescription) -> Result<(), Fault> {
    let meaning = "where the camera is at frames of an animation (`--frames`): any number of tables `[[camera.key]]`";
    let Some(node) = t.ask(key("key", meaning).optional(), "array of tables", "", "")? else { return Ok(()) };
    let mut keys: Vec<CameraKey> = Vec::new();
    for node in node.tables("camera.key")? {
        let at = node.at;
        let mut t = Reader::new("[[camera.key]]", node)?;
        let new = camera_key(&mut t, c.projection)?;
        t.finish()?;
        if keys.iter().any(|other| other.frame == new.frame) {
            return Err(Fault::new(at, format!("there are two keys at frame {}", new.frame)));
        }
        keys.push(new);
    }
    keys.sort_by(|a, b| a.frame.total_cmp(&b.frame));
    c.keys = keys;
    Ok(())
}

/// What is said at one frame of a camera with this projection.
pub(in crate::format) fn camera_key(t: &mut Reader, projection: Projection) -> Result<CameraKey, Fault> {
    const OF_KEYS: &str = "as of the camera; without it, as the keys about this one say";
    let of = |name| key(name, OF_KEYS).optional();
    let mut at = CameraKey::default();
    t.double(key("frame", "its number; two keys have different ones").required(), FRAME, &mut at.frame)?;
    let mut point = DVec3::ZERO;
    for (name, to) in [("origin", &mut at.origin), ("target", &mut at.target)] {
        t.point(of(name).unit("length"), COORDINATE, &mut point)?;
        *to = t.has(name).then_some(point);
    }
    let mut up = Vec3::ZERO;
    t.vector(of("up"), COORDINATE, &mut up)?;
    at.up = t.has("up").then_some(up);
    let perspective = |k: Key| k.only(projection == Projection::Perspective, "`projection = \"perspective\"`");
    let orthographic = |k: Key| k.only(projection == Projection::Orthographic, "`projection = \"orthographic\"`");
    let numbers = [
        (perspective(of("vfov").unit("degrees")), VFOV, &mut at.vfov),
        (orthographic(of("view_height").unit("length")), POSITIVE, &mut at.view_height),
        (perspective(of("aperture_radius").unit("length")), NOT_NEGATIVE, &mut at.aperture_radius),
        (perspective(of("focus_distance").unit("length")), POSITIVE, &mut at.focus_distance),
    ];
    for (key, bounds, to) in numbers {
        let mut number = 0.0;
        t.number(key, bounds, &mut number)?;
        *to = t.has(key.name).then_some(number);
    }
    Ok(at)
}

const PROJECTIONS: &[(&str, Projection)] = &[
    ("perspective", Projection::Perspective),
    ("orthographic", Projection::Orthographic),
    ("panorama", Projection::Panorama),
];

/// How the camera sees.
fn projection(t: &mut Reader, c: &mut CameraDescription) -> Result<(), Fault> {
    let projection = "a panorama has all directions by longitude and latitude, the target in the middle, and should be twice as wide \
        as high";
    t.choice(key("projection", projection), PROJECTIONS, &mut c.projection)?;
    let perspective = |k: Key| k.only(c.projection == Projection::Perspective, "`projection = \"perspective\"`");
    let orthographic = |k: Key| k.only(c.projection == Projection::Orthographic, "`projection = \"orthographic\"`");
    let vfov = key("vfov", FIELD).unit("degrees");
    t.number(perspective(vfov), VFOV, &mut c.vfov)?;
    let height = key("view_height", HEIGHT).unit("length");
    t.number(orthographic(height), POSITIVE, &mut c.view_height)?;
    let aperture =
        key("aperture_radius", "of the lens; what is not in focus is blurred. 0 is a pinhole").unit("length");
    t.number(perspective(aperture), NOT_NEGATIVE, &mut c.aperture_radius)?;
    let focus = "of the plane that is sharp, along the view; without it the target is in focus";
    let focus = perspective(key("focus_distance", focus).unit("length").optional());
    let mut distance = c.focus_distance.unwrap_or(1.0);
    t.number(focus, POSITIVE, &mut distance)?;
    c.focus_distance = if t.has("focus_distance") { Some(distance) } else { c.focus_distance };
    Ok(())
}

/// That all of `keys`, which were asked for, were there.
pub(in crate::format) fn needs(t: &Reader, keys: &[&str]) -> Result<(), Fault> {
    keys.iter().find(|k| !t.has(k)).map_or(Ok(()), |k| Err(t.missing(k)))
}

/// That the three vectors span a frame.
pub(in crate::format) fn check_camera(t: &Reader, c: &CameraDescription) -> Result<(), Fault> {
    let open = c.unsaid.is_open();
    let view = c.target - c.origin;
    if !open && view.length() == 0.0 {
        let at = t.place(&["target", "origin"]);
        return Err(Fault::new(at, "`target` must differ from `origin`"));
    }
    let up = c.up.as_dvec3();
    if up.length() == 0.0 {
        return Err(Fault::new(t.place(&["up"]), "`up` must not be zero or parallel to the view"));
    }
    // The sine of the angle between them; below about 1e-6, `f32` can no longer tell the camera's right.
    if !open && view.cross(up).length() <= 1e-6 * view.length() * up.length() {
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
