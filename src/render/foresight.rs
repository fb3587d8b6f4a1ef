//! Where paths will go, roughly: a few are traced before the first sample, so that the guide's cells suit what is looked at.

use crate::geometry::Ray;
use crate::math::rng::Rng;
use crate::scene::Scene;
use glam::Vec3;

/// Paths along each side of the picture.
const SIDE: u32 = 32;

/// Segments of a path at most.
const LONGEST: usize = 4;

/// Vertices of paths from the camera (world space), with unit normals on the side of the path. The same for the same scene
/// and camera.
pub(super) fn vertices(scene: &Scene) -> Vec<(Vec3, Vec3)> {
    let (camera, mut met) = (&scene.camera, Vec::new());
    for k in 0..SIDE * SIDE {
        let mut rng = Rng::for_place(0, k, 0);
        let at = |k: u32, side: u32| (u64::from(2 * k + 1) * u64::from(side) / u64::from(2 * SIDE)) as u32;
        let mut ray = camera.ray(at(k % SIDE, camera.width), at(k / SIDE, camera.height), [0.5; 2]);
        for _ in 0..LONGEST {
            let Some(next) = follow(scene, &ray, &mut rng, &mut met) else { break };
            ray = next;
        }
    }
    met
}

/// Notes the surface that a ray meets, and draws the next ray there.
fn follow(scene: &Scene, ray: &Ray, rng: &mut Rng, met: &mut Vec<(Vec3, Vec3)>) -> Option<Ray> {
    let hit = scene.geometry().intersect(ray)?;
    let si = scene.interaction(&hit, -ray.dir);
    let n = si.frame.n;
    met.push((si.p, if n.dot(ray.dir) > 0.0 { -n } else { n }));
    let bsdf = scene.bsdf(scene.choose_material(si.material, si.uv, || rng.f32()), si.uv, || scene.vertex_color(&hit));
    let next = bsdf.sample(si.frame.to_local(-ray.dir), rng.f32(), rng.f32x2())?;
    let dir = si.frame.to_world(next.wi);
    si.consistent(dir).then(|| Ray { org: si.spawn(dir), dir, tfar: f32::INFINITY })
}
