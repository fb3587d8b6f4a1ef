//! The light that arrives along a ray: a small path tracer, one ray at a time.

use crate::geometry::{Ray, SurfaceInteraction};
use crate::light::{LightSampleContext, LightSampler};
use crate::math::rng::Rng;
use crate::math::{Rgb, luminance};
use crate::scene::{Camera, Scene};
use rayon::prelude::*;

/// Segments of a path at most. Light that reaches a room through another one needs several.
const LONGEST: usize = 12;

/// An estimate of the luminance that comes in along the ray, in the scene's unit of light. It errs at most towards dark:
/// paths are short, and emission that glossy lobes would meet is left to next-event estimation.
pub(super) fn arriving(scene: &Scene, mut ray: Ray, rng: &mut Rng) -> f32 {
    let (mut throughput, mut found, mut unasked) = (Rgb::ONE, Rgb::ZERO, true);
    for _ in 0..LONGEST {
        let Some(hit) = scene.geometry().intersect(&ray) else {
            if unasked {
                found += throughput * scene.lights().environment_radiance(ray.dir);
            }
            break;
        };
        let si = scene.interaction(&hit, -ray.dir);
        if unasked {
            found += throughput * scene.emission(&si);
        }
        let bsdf =
            scene.bsdf(scene.choose_material(si.material, si.uv, || rng.f32()), si.uv, || scene.vertex_color(&hit));
        let wo = si.frame.to_local(-ray.dir);
        if bsdf.has_smooth() {
            found += throughput * asked(scene, &si, |wi| bsdf.eval(wo, si.frame.to_local(wi)), rng);
        }
        let Some(next) = bsdf.sample(wo, rng.f32(), rng.f32x2()) else { break };
        let dir = si.frame.to_world(next.wi);
        throughput *= next.weight;
        unasked = next.delta;
        if !si.consistent(dir) || throughput == Rgb::ZERO {
            break;
        }
        ray = Ray { org: si.spawn(dir), dir, tfar: f32::INFINITY };
    }
    if found.is_finite() { luminance(found) } else { 0.0 }
}

/// What one light sends to the point and on, where nothing is between.
fn asked(scene: &Scene, si: &SurfaceInteraction, scattered: impl Fn(glam::Vec3) -> Rgb, rng: &mut Rng) -> Rgb {
    let ctx = LightSampleContext::unoriented(si.p);
    let Some(light) = scene.lights().sample(LightSampler::Tree, &ctx, rng.f64(), rng.f32x2()) else { return Rgb::ZERO };
    let brought = scattered(light.wi) * light.radiance / light.pdf;
    if brought == Rgb::ZERO || !si.consistent(light.wi) {
        return Rgb::ZERO;
    }
    let ray = light.shadow_ray(si.spawn(light.wi));
    if ray.tfar > 0.0 && !scene.geometry().occluded(&ray) { brought } else { Rgb::ZERO }
}

/// Share of the paths from a picture from which on light arrives. By rounding, one path in very many gets through where
/// surfaces touch.
pub(super) const LEAST: f32 = 1.0 / 256.0;

/// Rows and columns of the rays through the picture of a camera whose light is looked for.
const GRID: u32 = 48;

/// Rays through the whole picture of a camera.
pub(super) fn grid(camera: &Camera) -> impl ExactSizeIterator<Item = Ray> + '_ {
    let at = |k: u32, side: u32| (u64::from(2 * k + 1) * u64::from(side) / u64::from(2 * GRID)) as u32;
    (0..GRID * GRID).map(move |k| camera.ray(at(k % GRID, camera.width), at(k / GRID, camera.height), [0.5; 2]))
}

/// Whether light is found along rays through the picture of the scene's camera.
pub(super) fn reaches(scene: &Scene) -> bool {
    let rays: Vec<Ray> = grid(&scene.camera).collect();
    let lit = |(k, ray): &(usize, Ray)| arriving(scene, *ray, &mut Rng::for_place(0, *k as u32, 0)) > 0.0;
    let found = rays.into_par_iter().enumerate().filter(lit).count();
    found as f32 >= LEAST * (GRID * GRID) as f32
}
