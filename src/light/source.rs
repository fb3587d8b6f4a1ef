//! What a light that is not a surface has to answer.

use super::LightSample;
use super::tree::{FarLight, LightBounds};
use crate::Result;
use crate::fields::Fields;
use crate::math::Rgb;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each};
use glam::{DVec3, Vec3};

/// A type of light as written.
pub(crate) trait LightParameters: Default + Fields {
    /// Stands for the type in a scene's hash: it never changes, and none is used twice.
    const NUMBER: u32;
    /// The light when its files are read.
    type Loaded: LightSource;

    /// Reads what files the light names.
    ///
    /// # Errors
    /// Those of the files.
    fn load(&self, findings: &mut Findings) -> Result<Self::Loaded>;

    /// Moves a light that is somewhere.
    fn translate(&mut self, _by: DVec3) {}
}

/// What loading lights brings beside them.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// For the user.
    pub warnings: Vec<String>,
    /// Hashes of the pictures that were read, in their order.
    pub pictures: Vec<u64>,
}

/// Where a light is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Extent {
    Near(LightBounds),
    Far(FarLight),
}

/// A light that is not a surface. Everything is in world space.
pub(crate) trait LightSource: Sized {
    /// The light with unit directions; an error where a number is unusable.
    fn checked(self) -> Result<Self>;

    /// Luminance of the power in W that reaches the scene. `section` is πR², where R is the radius of a sphere about it.
    fn power(&self, section: f64) -> f64;

    /// What a light tree chooses by.
    fn extent(&self) -> Extent;

    /// The largest component of the radiance that the light seems to have from the edge of the scene.
    fn brightness(&self, scene_radius: f64) -> f64;

    /// The light with all emission times `factor`, a power of two.
    fn scaled(self, factor: f64) -> Self;

    /// A direction from `p` to the light; `u_cell` chooses a part of it, `u` the point there, all uniform in [0, 1). Its
    /// density is given that this light is drawn from; 1 for a delta light. `None` where nothing arrives.
    fn sample(&self, p: Vec3, u_cell: f64, u: [f32; 2]) -> Option<LightSample>;

    /// [`Self::sample`] for the lanes of a packet, at the places `p`; others are left as they are.
    fn sample_lanes(
        &self,
        lanes: Mask,
        p: &Vec3Lanes,
        u_cell: &[f64; LANES],
        u: &[Lanes; 2],
        samples: &mut [Option<LightSample>; LANES],
    ) {
        for k in each(lanes) {
            samples[k] = self.sample(p.get(k), u_cell[k], [u[0][k], u[1][k]]);
        }
    }

    /// Radiance from the unit direction `wi`, in W/(sr·m²), for a ray that leaves the scene; 0 for delta lights, which no
    /// direction meets.
    fn radiance(&self, _wi: Vec3) -> Rgb {
        Rgb::ZERO
    }

    /// Whether rays that leave the scene see the light, as a background.
    fn surrounds(&self) -> bool {
        false
    }

    /// Density per steradian with which [`Self::sample`] draws the unit direction `wi`; 0 for delta lights.
    fn pdf(&self, _wi: Vec3) -> f32 {
        0.0
    }
}
