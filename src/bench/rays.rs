//! Single rays against packets, coherent and not, in tile order, sorted and shuffled.
//!
//! Every figure counts what the renderer pays: rays written into packets, traced, and their hits read back. Variants
//! take turns, so that a machine that changes its pace slows them all alike; the median over the turns is kept.

use crate::embree::{
    Coherence, HitBatch, HitPacket, Packet8, Packet16, Ray, Shadow8, Shadow16, ShadowBatch, ShadowPacket,
};
use crate::geometry::Frame;
use crate::math::{rng::Rng, warp};
use crate::scene::Scene;
use glam::Vec3;
use serde::Serialize;
use std::time::Instant;

/// Rays of one set.
const RAYS: u32 = 1 << 16;
/// Rays of a batch, as in the renderer.
const BATCH: usize = 4096;

/// One kind of ray, as a path tracer meets it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RaySet {
    Camera,
    Bounce1,
    Bounce2,
    Shadow,
}

/// Speed of one way to trace one set.
#[derive(Clone, Debug, Serialize)]
pub struct RayFigure {
    pub set: RaySet,
    pub order: &'static str,
    /// Rays at a time: 1, 8 or 16.
    pub width: usize,
    pub coherent: bool,
    /// Median over the turns, in millions of rays per second on one thread.
    pub mrays_per_second: f64,
    /// Against single rays in tile order.
    pub ratio: f64,
}

/// Measures every variant on the scene's own rays, `turns` times each.
pub fn measure(scene: &Scene, turns: usize) -> Vec<RayFigure> {
    let sets = ray_sets(scene);
    sets.iter()
        .filter(|(_, rays)| !rays.is_empty())
        .flat_map(|(set, rays)| measure_set(scene, *set, rays, turns))
        .collect()
}

fn measure_set(scene: &Scene, set: RaySet, rays: &[Ray], turns: usize) -> Vec<RayFigure> {
    let orders = [("tile", rays.to_vec()), ("octant", by_octant(rays)), ("shuffled", shuffled(rays))];
    let modes = [(1, false), (8, false), (16, false), (8, true), (16, true)];
    let variants: Vec<_> = orders.iter().flat_map(|order| modes.map(|mode| (order, mode))).collect();
    let mut seconds = vec![Vec::new(); variants.len()];
    for _ in 0..turns {
        for (((_, rays), (width, coherent)), seconds) in variants.iter().zip(&mut seconds) {
            seconds.push(time(scene, set, rays, *width, *coherent));
        }
    }
    let rates: Vec<f64> = seconds.iter_mut().map(|s| rays.len() as f64 / median(s) * 1e-6).collect();
    let figures = variants.iter().zip(&rates).map(|(((order, _), (width, coherent)), &rate)| RayFigure {
        set,
        order,
        width: *width,
        coherent: *coherent,
        mrays_per_second: rate,
        ratio: rate / rates[0],
    });
    figures.collect()
}

fn time(scene: &Scene, set: RaySet, rays: &[Ray], width: usize, coherent: bool) -> f64 {
    let coherence = if coherent { Coherence::Coherent } else { Coherence::Incoherent };
    let start = Instant::now();
    let found = match (set, width) {
        (RaySet::Shadow, 1) => rays.iter().filter(|ray| scene.geometry().occluded(ray)).count(),
        (RaySet::Shadow, 8) => shadows::<Shadow8>(scene, rays, coherence),
        (RaySet::Shadow, _) => shadows::<Shadow16>(scene, rays, coherence),
        (_, 1) => rays.iter().filter(|ray| scene.geometry().intersect(ray).is_some()).count(),
        (_, 8) => hits::<Packet8>(scene, rays, coherence),
        _ => hits::<Packet16>(scene, rays, coherence),
    };
    std::hint::black_box(found);
    start.elapsed().as_secs_f64()
}

fn hits<P: HitPacket>(scene: &Scene, rays: &[Ray], coherence: Coherence) -> usize {
    let mut batch = HitBatch::<P>::with_capacity(BATCH);
    let mut found = 0;
    for rays in rays.chunks(BATCH) {
        batch.clear();
        rays.iter().for_each(|ray| batch.push(ray));
        batch.trace(scene.geometry(), coherence);
        found += (0..batch.len()).filter(|&i| batch.hit(i).is_some()).count();
    }
    found
}

fn shadows<P: ShadowPacket>(scene: &Scene, rays: &[Ray], coherence: Coherence) -> usize {
    let mut batch = ShadowBatch::<P>::with_capacity(BATCH);
    let mut found = 0;
    for rays in rays.chunks(BATCH) {
        batch.clear();
        rays.iter().for_each(|ray| batch.push(ray));
        batch.trace(scene.geometry(), coherence);
        found += (0..batch.len()).filter(|&i| batch.occluded(i)).count();
    }
    found
}

/// Camera rays in blocks of 4×4 pixels, cosine-distributed bounces from their hits, and shadow rays from these.
fn ray_sets(scene: &Scene) -> [(RaySet, Vec<Ray>); 4] {
    let mut rng = Rng::new(11);
    let camera = &scene.camera;
    let blocks_across = camera.width.div_ceil(4);
    let blocks = blocks_across * camera.height.div_ceil(4);
    let pixel = |i: u32| {
        let block = (i / 16) % blocks;
        (block % blocks_across * 4 + i % 4, block / blocks_across * 4 + i % 16 / 4)
    };
    let first: Vec<Ray> = (0..RAYS).map(pixel).map(|(x, y)| camera.ray(x, y, rng.f32x2())).collect();
    let (bounce1, shadow) = bounce(scene, &first, &mut rng);
    let (bounce2, _) = bounce(scene, &bounce1, &mut rng);
    [(RaySet::Camera, first), (RaySet::Bounce1, bounce1), (RaySet::Bounce2, bounce2), (RaySet::Shadow, shadow)]
}

fn bounce(scene: &Scene, rays: &[Ray], rng: &mut Rng) -> (Vec<Ray>, Vec<Ray>) {
    let (mut next, mut shadow) = (Vec::new(), Vec::new());
    for ray in rays {
        let Some(hit) = scene.geometry().intersect(ray) else { continue };
        let si = scene.interaction(&hit, -ray.dir);
        let facing = if si.ng.dot(ray.dir) > 0.0 { -si.ng } else { si.ng };
        let dir = Frame::from_normal(facing).to_world(warp::square_to_cosine_hemisphere(rng.f32x2()));
        next.push(Ray { org: si.spawn(dir), dir, tfar: f32::INFINITY });
        let light = scene.lights().sample(si.p, rng.f64(), rng.f32x2()).filter(|light| light.wi.dot(facing) > 0.0);
        shadow.extend(light.map(|light| light.shadow_ray(si.spawn(light.wi))));
    }
    (next, shadow)
}

/// Sorted by the signs of the direction, batch by batch: the cheapest order that could help.
fn by_octant(rays: &[Ray]) -> Vec<Ray> {
    let octant = |d: Vec3| (d.x < 0.0) as u8 | ((d.y < 0.0) as u8) << 1 | ((d.z < 0.0) as u8) << 2;
    let mut sorted = rays.to_vec();
    sorted.chunks_mut(BATCH).for_each(|batch| batch.sort_by_key(|ray| octant(ray.dir)));
    sorted
}

fn shuffled(rays: &[Ray]) -> Vec<Ray> {
    let mut rng = Rng::new(13);
    let mut all = rays.to_vec();
    for i in (1..all.len()).rev() {
        all.swap(i, rng.next_u32() as usize % (i + 1));
    }
    all
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
