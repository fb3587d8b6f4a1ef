use super::*;
use crate::geometry::{Mesh, Ray, RayRows};
use crate::math::{rng::Rng, warp};
use crate::simd::Packing;
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// A bumpy closed surface: `n`² quads over the sphere, enough for hits at all angles.
pub(super) fn bumpy_ball(n: u32) -> Arc<Mesh> {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let (theta, phi) =
                (i as f32 / n as f32 * std::f32::consts::PI, j as f32 / n as f32 * std::f32::consts::TAU);
            let r = 1.0 + 0.1 * (7.0 * theta).sin() * (5.0 * phi).cos();
            mesh.positions.push([r * theta.sin() * phi.cos(), r * theta.cos(), r * theta.sin() * phi.sin()]);
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            mesh.triangles.push([a, a + 1, a + n + 1]);
            mesh.triangles.push([a + 1, a + n + 2, a + n + 1]);
        }
    }
    mesh.positions.reserve(1);
    Arc::new(mesh)
}

const ROBUST: BuildOptions = BuildOptions { robust: true, quality: BuildQuality::Medium };

fn buffers(mesh: &Mesh) -> Triangles<'_> {
    Triangles { positions: &mesh.positions, triangles: &mesh.triangles }
}

fn ball_scene() -> Scene {
    ball_scene_on(&Device::new(1).unwrap())
}

/// The ball with Embree at each instruction set that this processor has.
fn ball_scenes() -> impl Iterator<Item = (Isa, Scene)> {
    Isa::available().map(|isa| (isa, ball_scene_on(&Device::held_to(Some(isa), 1).unwrap())))
}

fn ball_scene_on(device: &Arc<Device>) -> Scene {
    built(device, bumpy_ball(64), BuildOptions::default())
}

pub(super) fn built(device: &Arc<Device>, mesh: Arc<Mesh>, options: BuildOptions) -> Scene {
    let mut builder = SceneBuilder::new(device, options).unwrap();
    builder.add_mesh(mesh, buffers, None).unwrap();
    builder.commit().unwrap()
}

pub(super) fn random_rays(n: usize) -> Vec<Ray> {
    let mut rng = Rng::new(7);
    let mut point = || warp::square_to_uniform_sphere(rng.f32x2());
    (0..n)
        .map(|_| {
            let (org, aim) = (point() * 3.0, point() * 1.2);
            Ray { org, dir: (aim - org).normalize(), tfar: f32::INFINITY }
        })
        .collect()
}

fn batch_agrees<P: HitPacket, S: ShadowPacket>(coherence: Coherence) {
    ball_scenes().for_each(|(isa, scene)| batch_agrees_on::<P, S>(&scene, coherence, isa));
}

fn batch_agrees_on<P: HitPacket, S: ShadowPacket>(scene: &Scene, coherence: Coherence, isa: Isa) {
    let rays = random_rays(1003);
    let (mut hits, mut shadows) = (HitBatch::<P>::with_capacity(8), ShadowBatch::<S>::with_capacity(8));
    // a first, longer wave leaves stale lanes behind
    rays.iter().chain(&rays).for_each(|ray| hits.push(ray));
    hits.trace(scene, coherence);
    hits.clear();
    for ray in &rays {
        hits.push(ray);
        shadows.push(ray);
    }
    hits.trace(scene, coherence);
    shadows.trace(scene, coherence);
    let found = (0..rays.len()).filter(|&i| hits.hit(i).is_some()).count();
    assert!((300..1000).contains(&found), "{found} hits: the rays do not test much");
    for (i, ray) in rays.iter().enumerate() {
        let (one, many) = (scene.intersect(ray), hits.hit(i));
        assert_eq!(one.map(|h| (h.primitive, h.geometry)), many.map(|h| (h.primitive, h.geometry)), "ray {i}, {isa:?}");
        assert_eq!(one.is_some(), shadows.occluded(i), "shadow ray {i}, {isa:?}");
        assert_eq!(one.is_some(), scene.occluded(ray));
    }
}

#[test]
fn every_packet_width_finds_what_single_rays_find() {
    batch_agrees::<Packet8, Shadow8>(Coherence::Incoherent);
    batch_agrees::<Packet16, Shadow16>(Coherence::Incoherent);
    batch_agrees::<Packet16, Shadow16>(Coherence::Coherent);
}

/// Waves of all lengths up to two packets, as the renderer packs them: lanes that were not chosen are no numbers, and end
/// up in lanes of the last packet that no ray is in. Before each there is a longer wave, which leaves its own rays there.
#[test]
fn lanes_without_a_ray_are_left_alone_at_every_instruction_set() {
    let rays = random_rays(64);
    for (isa, scene) in ball_scenes() {
        for coherence in [Coherence::Incoherent, Coherence::Coherent] {
            let (mut hits, mut shadows) = (<HitBatch>::with_capacity(0), <ShadowBatch>::with_capacity(0));
            for len in 1..=32 {
                for chosen in [vec![u16::MAX; 3], spread_over_packets(len)] {
                    hits.clear();
                    shadows.clear();
                    let expected = pack(&rays, &chosen, &mut hits, &mut shadows);
                    hits.trace(&scene, coherence);
                    shadows.trace(&scene, coherence);
                    check_wave(&scene, &expected, &hits, &shadows, &format!("{isa:?}, {coherence:?}, {len} rays"));
                }
            }
        }
    }
}

/// Lanes of four packets, `len` in all, every other one as far as that suffices.
fn spread_over_packets(len: usize) -> Vec<u16> {
    let order = (0..64).step_by(2).chain((1..64).step_by(2)).take(len);
    order.fold(vec![0; 4], |mut chosen, k| {
        chosen[k / 16] |= 1 << (k % 16);
        chosen
    })
}

/// Packs the chosen ones of `rays`, 16 by 16; in the rows' other lanes there are no numbers. Returns what was packed.
fn pack(rays: &[Ray], chosen: &[u16], hits: &mut HitBatch, shadows: &mut ShadowBatch) -> Vec<Ray> {
    let mut packed = Vec::new();
    for (rays, chosen) in rays.chunks(16).zip(chosen) {
        let is_chosen = |k: usize| chosen >> k & 1 == 1;
        let row = |part: fn(&Ray) -> f32| -> [f32; 16] {
            std::array::from_fn(|k| if is_chosen(k) { part(&rays[k]) } else { f32::NAN })
        };
        let (org, dir) = (
            [row(|r| r.org.x), row(|r| r.org.y), row(|r| r.org.z)],
            [row(|r| r.dir.x), row(|r| r.dir.y), row(|r| r.dir.z)],
        );
        // as the renderer leaves it: unused shadow rays have no direction, and end where they begin
        let tfar = std::array::from_fn(|k| if is_chosen(k) { rays[k].tfar } else { 0.0 });
        let rows = RayRows { org: org.each_ref(), dir: dir.each_ref(), tfar: &tfar };
        let packing = Packing::new(*chosen, hits.len());
        hits.pack(&packing, &rows);
        shadows.pack(&packing, &rows);
        packed.extend((0..16).filter(|k| is_chosen(*k)).map(|k| rays[k]));
    }
    packed
}

fn check_wave(scene: &Scene, expected: &[Ray], hits: &HitBatch, shadows: &ShadowBatch, what: &str) {
    assert_eq!((hits.len(), shadows.len()), (expected.len(), expected.len()));
    for (i, ray) in expected.iter().enumerate() {
        let one = scene.intersect(ray).map(|hit| (hit.geometry, hit.primitive));
        assert_eq!(hits.hit(i).map(|hit| (hit.geometry, hit.primitive)), one, "ray {i}; {what}");
        let open = shadows.open(i / 16 * 16).has(i % 16);
        assert_eq!((shadows.occluded(i), open), (one.is_some(), one.is_none()), "shadow ray {i}; {what}");
    }
    let open: u32 = (0..shadows.len()).step_by(16).map(|first| shadows.open(first).bits().count_ones()).sum();
    let missed = expected.iter().filter(|ray| !scene.occluded(ray)).count();
    assert_eq!(open as usize, missed, "lanes without a ray are not open; {what}");
}

#[test]
fn hits_lie_on_the_triangle_they_name() {
    let (scene, mesh) = (ball_scene(), bumpy_ball(64));
    for ray in random_rays(1000) {
        let Some(hit) = scene.intersect(&ray) else { continue };
        let [a, b, c] = mesh.triangles[hit.primitive as usize].map(|i| Vec3::from(mesh.positions[i as usize]));
        let on_triangle = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        assert!((on_triangle - (ray.org + ray.dir * hit.t)).length() < 1e-5);
        assert!(hit.ng.normalize().dot((b - a).cross(c - a).normalize()) > 0.999, "the normal follows the winding");
    }
}

#[test]
fn a_see_through_mesh_lets_rays_pass_where_its_test_says() {
    struct LeftHalf;
    impl OpacityTest for LeftHalf {
        fn passes(&self, _: u32, u: f32, _: f32) -> bool {
            u < 0.5
        }
    }
    let mut mesh = Mesh { positions: vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], ..Mesh::default() };
    mesh.triangles.push([0, 1, 2]);
    mesh.positions.reserve(1);
    let mut builder = SceneBuilder::new(&Device::new(1).unwrap(), BuildOptions::default()).unwrap();
    builder.add_mesh(Arc::new(mesh), buffers, Some(Box::new(LeftHalf))).unwrap();
    let scene = builder.commit().unwrap();
    let (mut hits, mut shadows) = (HitBatch::<Packet16>::with_capacity(16), ShadowBatch::<Shadow16>::with_capacity(16));
    let ray = |x: f32| Ray { org: Vec3::new(x, 0.1, 1.0), dir: Vec3::NEG_Z, tfar: 10.0 };
    for i in 0..16 {
        hits.push(&ray(i as f32 / 20.0 + 0.01));
        shadows.push(&ray(i as f32 / 20.0 + 0.01));
    }
    hits.trace(&scene, Coherence::Incoherent);
    shadows.trace(&scene, Coherence::Incoherent);
    for i in 0..16 {
        let solid = i as f32 / 20.0 + 0.01 >= 0.5;
        assert_eq!((hits.hit(i).is_some(), shadows.occluded(i)), (solid, solid), "ray {i}");
    }
    assert!(scene.intersect(&ray(0.2)).is_none() && scene.occluded(&ray(0.6)));
}

#[test]
fn instances_share_a_mesh_and_are_told_apart() {
    let device = Device::new(1).unwrap();
    let mut inner = SceneBuilder::new(&device, BuildOptions::default()).unwrap();
    inner.add_mesh(bumpy_ball(16), buffers, None).unwrap();
    let inner = Arc::new(inner.commit().unwrap());
    let mut outer = SceneBuilder::new(&device, BuildOptions::default()).unwrap();
    let place = |x: f32| Instance { scene: inner.clone(), to_world: Affine3A::from_translation(Vec3::X * x) };
    let ids = [-3.0, 3.0].map(|x| outer.add_instance(place(x)).unwrap());
    let scene = outer.commit().unwrap();
    for (x, id) in [-3.0, 3.0].into_iter().zip(ids) {
        let ray = Ray { org: Vec3::new(x, 0.1, 5.0), dir: Vec3::NEG_Z, tfar: f32::INFINITY };
        assert_eq!(scene.intersect(&ray).map(|hit| (hit.instance, hit.geometry)), Some((id, 0)));
    }
}

#[test]
fn all_memory_is_given_back() {
    let device = Device::new(1).unwrap();
    let mut builder = SceneBuilder::new(&device, BuildOptions::default()).unwrap();
    builder.add_mesh(bumpy_ball(64), buffers, None).unwrap();
    let scene = builder.commit().unwrap();
    assert!(device.memory() > 100_000, "{} bytes", device.memory());
    drop(scene);
    assert_eq!(device.memory(), 0);
}

#[test]
fn a_mesh_that_would_be_read_out_of_bounds_is_refused() {
    let mut mesh = Mesh { positions: Vec::with_capacity(4), triangles: vec![[0, 1, 3]], ..Mesh::default() };
    mesh.positions.extend([[0.0; 3]; 3]);
    let device = Device::new(1).unwrap();
    let mut builder = SceneBuilder::new(&device, BuildOptions::default()).unwrap();
    assert!(builder.add_mesh(Arc::new(mesh.clone()), buffers, None).is_err(), "index out of range");
    mesh.triangles[0][2] = 2;
    mesh.positions.shrink_to_fit();
    assert!(builder.add_mesh(Arc::new(mesh), buffers, None).is_err(), "no room behind the last vertex");
}

#[test]
fn an_empty_scene_has_no_bounds_and_no_hits() {
    let scene = SceneBuilder::new(&Device::new(1).unwrap(), ROBUST).unwrap().commit().unwrap();
    assert!(scene.bounds().is_none());
    assert!(scene.intersect(&Ray { org: Vec3::ZERO, dir: Vec3::X, tfar: f32::INFINITY }).is_none());
}

#[test]
fn packed_rays_are_those_that_are_pushed_one_by_one() {
    let ray = |x: f32| Ray { org: Vec3::splat(x), dir: Vec3::new(1.0, x, -x), tfar: 2.0 * x };
    let (mut hits, mut shadows) = (<HitBatch>::with_capacity(0), <ShadowBatch>::with_capacity(0));
    let mut expected = Vec::new();
    for (round, chosen) in [0xffff, 0, 0b1011, 0x8421, 0xfffe, 0x7fff, 1].into_iter().enumerate() {
        let rays: [Ray; 16] = std::array::from_fn(|k| ray((16 * round + k) as f32));
        let row = |part: fn(&Ray) -> f32| rays.each_ref().map(part);
        let (org, tfar) = (row(|r| r.org.x), row(|r| r.tfar));
        let dir = [row(|r| r.dir.x), row(|r| r.dir.y), row(|r| r.dir.z)];
        let rows = RayRows { org: [&org; 3], dir: dir.each_ref(), tfar: &tfar };
        let packing = Packing::new(chosen, hits.len());
        assert_eq!(packing.count(), u16::count_ones(chosen) as usize);
        hits.pack(&packing, &rows);
        shadows.pack(&packing, &rows);
        expected.extend((0..16).filter(|k| chosen >> k & 1 == 1).map(|k| rays[k]));
        // one by one among packed ones
        hits.push(&ray(-1.0));
        shadows.push(&ray(-1.0));
        expected.push(ray(-1.0));
    }
    assert_eq!((hits.len(), shadows.len()), (expected.len(), expected.len()));
    for (i, ray) in expected.iter().enumerate() {
        for found in [hits.ray(i), shadows.ray(i)] {
            assert_eq!((found.org, found.dir, found.tfar), (ray.org, ray.dir, ray.tfar));
        }
        assert!(hits.hit(i).is_none());
    }
    let open: u32 = (0..shadows.len()).step_by(16).map(|first| shadows.open(first).bits().count_ones()).sum();
    assert_eq!(
        open as usize,
        shadows.len(),
        "nothing lies on rays that were not traced, and what is beyond the last is none"
    );
}

#[test]
fn what_goes_beyond_the_memory_is_an_error_and_not_an_abort() {
    let build = |limit: i64| -> crate::Result<Scene> {
        let mut builder = SceneBuilder::new(&Device::within(limit, None, 2)?, BuildOptions::default())?;
        builder.add_mesh(bumpy_ball(256), buffers, None)?;
        builder.commit()
    };
    for limit in [10_000, 1 << 20, 4 << 20] {
        let error = build(limit).err().expect("131 072 triangles take more").to_string();
        assert!(error.contains("out of memory"), "{limit}: {error}");
    }
    assert!(build(1 << 30).is_ok());
}
