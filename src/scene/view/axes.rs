//! Directions by what is up, and the frame of a picture.

use glam::{Vec3, vec3};

/// Half the longer side of the film of a small camera, 36 mm wide, for which focal lengths are commonly said.
const HALF_FILM: f32 = 18.0;

/// A frame of the world by what is up in it. All are unit vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    pub(super) up: Vec3,
    /// From the model's front to its viewer, as modellers have it: +z where y is up, −y where z is.
    pub(super) front: Vec3,
    /// To the right of that viewer.
    pub(super) side: Vec3,
}

impl Axes {
    /// `up` has any length but zero.
    pub(super) fn new(up: Vec3) -> Axes {
        let up = up.normalize_or(Vec3::Y);
        let z_is_up = up.z.abs() > up.x.abs().max(up.y.abs());
        let front = if z_is_up { vec3(0.0, -1.0, 0.0) } else { Vec3::Z };
        let side = up.cross(front).normalize();
        Axes { up, front: side.cross(up), side }
    }

    /// The unit vector with this azimuth, from the front on towards the side, and this elevation; in radians.
    pub(super) fn direction(&self, azimuth: f32, elevation: f32) -> Vec3 {
        let level = self.front * azimuth.cos() + self.side * azimuth.sin();
        level * elevation.cos() + self.up * elevation.sin()
    }
}

/// What is seen from some place: the frame of a picture. The horizon is level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaze {
    pub(super) forward: Vec3,
    pub(super) right: Vec3,
    pub(super) up: Vec3,
    /// Tangents of half the fields of view, across and upwards.
    pub(super) half: [f32; 2],
}

impl Gaze {
    /// Along the unit vector `forward`. Straight up or down, the model's front is at the lower edge of the picture.
    pub(super) fn new(forward: Vec3, axes: &Axes, half: [f32; 2]) -> Gaze {
        let level = forward.cross(axes.up);
        // Below this sine a single-precision cross product has no digits left.
        let right = if level.length() > 1e-5 { level.normalize() } else { axes.side };
        Gaze { forward, right, up: right.cross(forward), half }
    }

    /// The unit direction through a place of the picture: (−1, −1) is its lower left corner, (1, 1) its upper right one.
    pub(super) fn through(&self, [x, y]: [f32; 2]) -> Vec3 {
        (self.forward + self.right * (x * self.half[0]) + self.up * (y * self.half[1])).normalize()
    }

    /// Whether a direction is in the picture.
    pub(super) fn sees(&self, d: Vec3) -> bool {
        let depth = d.dot(self.forward);
        d.dot(self.right).abs() <= depth * self.half[0] && d.dot(self.up).abs() <= depth * self.half[1]
    }

    /// Vertical field of view, in degrees.
    pub(super) fn vfov(&self) -> f32 {
        2.0 * self.half[1].atan().to_degrees()
    }
}

/// Tangents of half the fields of view of a lens with this focal length, in mm, on a picture of this aspect.
pub(super) fn lens(focal_length: f32, aspect: f32) -> [f32; 2] {
    let long = HALF_FILM / focal_length;
    if aspect >= 1.0 { [long, long / aspect] } else { [long * aspect, long] }
}
