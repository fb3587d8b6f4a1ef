//! Why a picture is black.

use super::standpoints::sphere;
use super::{axes::Axes, light};
use crate::geometry::Ray;
use crate::scene::Scene;
use glam::Vec3;

/// The likely reason why a camera's picture is black.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Darkness {
    /// No light has any power.
    NoLight,
    /// There is no surface in the picture, and nothing shines behind.
    NothingSeen,
    /// There are surfaces in all directions about the camera, and no light was found there.
    Enclosed,
    /// No light was found that reaches what is seen.
    Unlit,
}

/// Why the picture of the scene's camera is black, which it is.
pub(crate) fn why_dark(scene: &Scene) -> Darkness {
    let rays: Vec<Ray> = light::grid(&scene.camera).collect();
    let meets = |ray: &Ray| scene.geometry().intersect(ray).is_some();
    if scene.lights().are_black() {
        Darkness::NoLight
    } else if !rays.iter().any(meets) {
        Darkness::NothingSeen
    } else if sphere(&Axes::new(Vec3::Y)).iter().all(|&dir| meets(&Ray { dir, ..rays[0] })) {
        Darkness::Enclosed
    } else {
        Darkness::Unlit
    }
}

impl Darkness {
    /// In words, for the user.
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Darkness::NoLight => "nothing emits light: all lights and all emission of materials are black",
            Darkness::NothingSeen => {
                "the camera sees no surface and no sky; without camera.origin and camera.target, a view is found"
            }
            Darkness::Enclosed => {
                "the camera is within a closed surface, a solid or a room without a lamp, where no light was found"
            }
            Darkness::Unlit => {
                "no light was found that reaches what the camera sees: lights face away or stand behind surfaces, \
                 materials are black, or so few samples do not find the light"
            }
        }
    }
}
