//! How far back a camera has to stand.

use super::axes::Gaze;
use glam::{Vec2, Vec3};

/// What is left free between a model and each edge of the picture, as a share of half the picture.
const MARGIN: f32 = 0.05;

/// The nearest place from which a camera with this gaze has all points in its picture, and in the middle of it. `about` is any
/// point near them, of which the place is reckoned.
pub(super) fn standing_back(points: impl Iterator<Item = Vec3>, gaze: &Gaze, about: Vec3) -> Vec3 {
    let [across, upwards] = edges(points, gaze, about);
    let aside = [0.5 * (across.0 - across.1), 0.5 * (upwards.0 - upwards.1)];
    let [h, v] = gaze.half.map(framed);
    let back = (0.5 * (across.0 + across.1) / h).max(0.5 * (upwards.0 + upwards.1) / v);
    about + gaze.right * aside[0] + gaze.up * aside[1] - gaze.forward * back
}

/// The same with `target` in the middle of the picture.
pub(super) fn looking_at(points: impl Iterator<Item = Vec3>, gaze: &Gaze, target: Vec3) -> Vec3 {
    let [across, upwards] = edges(points, gaze, target);
    let [h, v] = gaze.half.map(framed);
    let back = (across.0.max(across.1) / h).max(upwards.0.max(upwards.1) / v);
    target - gaze.forward * back
}

/// For parallel rays: where the middle of the points is in the picture, seen from `about`, and how high the picture has to be for all
/// of them; where `fixed`, with `about` in its middle.
pub(super) fn parallel(
    points: impl Iterator<Item = Vec3>,
    gaze: &Gaze,
    about: Vec3,
    (aspect, fixed): (f32, bool),
) -> ([f32; 2], f32) {
    let none = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    let (low, high) = points.fold(none, |(low, high), point| {
        let q = point - about;
        let at = Vec2::new(q.dot(gaze.right), q.dot(gaze.up));
        (low.min(at), high.max(at))
    });
    let middle = if fixed { Vec2::ZERO } else { low + 0.5 * (high - low) };
    let half = (high - middle).max(middle - low);
    (middle.to_array(), 2.0 * half.y.max(half.x / aspect) / (1.0 - MARGIN))
}

fn framed(half: f32) -> f32 {
    half * (1.0 - MARGIN)
}

/// A point at (x, y, z) of the gaze's frame is in the picture where |x − a| ≤ h·(z + d), a being how far the camera is moved
/// aside and d how far back: of each edge, the point furthest out counts, max(x − h·z) on the right and max(−x − h·z) on the
/// left. The pairs are (right, left) and (above, below).
fn edges(points: impl Iterator<Item = Vec3>, gaze: &Gaze, about: Vec3) -> [(f32, f32); 2] {
    let [h, v] = gaze.half.map(framed);
    let none = (f32::NEG_INFINITY, f32::NEG_INFINITY);
    points.fold([none; 2], |[across, upwards], point| {
        let q = point - about;
        let (x, y, z) = (q.dot(gaze.right), q.dot(gaze.up), q.dot(gaze.forward));
        [(across.0.max(x - h * z), across.1.max(-x - h * z)), (upwards.0.max(y - v * z), upwards.1.max(-y - v * z))]
    })
}

/// Tangents of half the fields of view, of this aspect (width over height), with which all points are in the picture of a
/// camera at `origin`; `None` where some are behind it, or in its plane.
pub(super) fn zoomed(points: impl Iterator<Item = Vec3>, gaze: &Gaze, origin: Vec3, aspect: f32) -> Option<[f32; 2]> {
    let mut half: f32 = 0.0;
    for point in points {
        let q = point - origin;
        let depth = q.dot(gaze.forward);
        if depth <= 0.0 {
            return None;
        }
        half = half.max(q.dot(gaze.up).abs() / depth).max(q.dot(gaze.right).abs() / (depth * aspect));
    }
    let half = half / (1.0 - MARGIN);
    (half > 0.0 && half.is_finite()).then_some([half * aspect, half])
}
