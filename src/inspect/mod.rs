//! Looking at a guide: what it knows of the place behind a pixel, held against what is traced there.

pub(crate) mod layers;
pub(crate) mod picture;
pub(crate) mod radiance;
pub(crate) mod sheet;

pub(crate) use layers::Layers;
pub(crate) use radiance::{Comparison, Radiance};

use crate::bsdf::Bsdf;
use crate::embree::{Coherence, HitBatch};
use crate::geometry::{Ray, SurfaceInteraction};
use crate::guiding::{Guide, RegionId};
use crate::math::rng::Rng;
use crate::scene::Scene;
use glam::Vec3;

/// Mirrors and panes through which a pixel is followed at most.
const MAX_SEGMENTS: u32 = 32;

/// The first surface behind a pixel's centre that a guide can help: one that does not only reflect like a mirror or
/// refract like glass.
pub struct PixelVertex<'s> {
    pub(crate) si: SurfaceInteraction,
    pub(crate) bsdf: Bsdf<'s>,
    /// Unit, in world space, to where the path came from.
    pub(crate) wo: Vec3,
}

impl<'s> PixelVertex<'s> {
    /// What the centre of pixel `(x, y)` shows, counted from the upper left; mirrors and glass are followed, which of the
    /// two ways at glass by fixed random numbers. `None` where there is nothing, or no such surface.
    pub fn through(scene: &'s Scene, x: u32, y: u32) -> Option<PixelVertex<'s>> {
        let mut rng = Rng::for_place(0, scene.camera.pixel(x, y), 0);
        let mut ray = scene.camera.ray(x, y, [0.5; 2]);
        for _ in 0..MAX_SEGMENTS {
            let mut rays: HitBatch = HitBatch::with_capacity(1);
            rays.push(&ray);
            rays.trace(scene.geometry(), Coherence::Coherent);
            let wo = -ray.dir;
            let hit = rays.hit(0)?;
            let si = scene.interaction(&hit, wo);
            let material = scene.choose_material(si.material, si.uv, || rng.f32());
            let plain = scene.bsdf(material, si.uv, || scene.vertex_color(&hit));
            let bsdf = material.relief().map_or(plain, |relief| scene.in_relief(plain, relief, Some(hit), &si));
            if bsdf.has_smooth() {
                return Some(PixelVertex { si, bsdf, wo });
            }
            let dir = si.frame.to_world(bsdf.sample(si.frame.to_local(wo), rng.f32(), rng.f32x2())?.wi);
            ray = Ray { org: si.spawn(dir), dir, tfar: f32::INFINITY };
        }
        None
    }

    /// Shading normal on the side of the path.
    pub(crate) fn normal(&self) -> Vec3 {
        self.si.facing(self.wo)
    }

    /// The guide's state there, without jitter; `None` while there are no states.
    pub fn state(&self, guide: &Guide) -> Option<RegionId> {
        guide.field().locate(self.si.p, self.normal(), [0.5; 3]).map(|place| place.drawn)
    }
}
