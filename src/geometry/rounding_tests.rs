//! Rays start beyond what rounding may do, and no further. What the offset of 2⁻¹⁶ of the largest coordinate did, which
//! stood here once, is counted beside: it is the yardstick of the table in docs/performance.md.

use super::*;
use crate::embree::{BuildOptions, Device, Instance, Scene, SceneBuilder, Triangles};
use crate::geometry::{Hit, Mesh, Placement, Ray, SurfaceInteraction};
use crate::math::rng::Rng;
use crate::math::{Frame, warp};
use glam::{Affine3A, Quat};
use std::sync::Arc;

fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Arc<Mesh> {
    let materials = vec![0; triangles.len()];
    let mut positions: Vec<[f32; 3]> = positions.into_iter().map(Into::into).collect();
    positions.reserve(1);
    Arc::new(Mesh { positions, triangles, materials, ..Mesh::default() })
}

fn buffers(mesh: &Mesh) -> Triangles<'_> {
    Triangles { positions: &mesh.positions, triangles: &mesh.triangles }
}

/// A scene of these meshes, each by itself, or all in one group that stands once.
struct World {
    scene: Scene,
    meshes: Vec<Arc<Mesh>>,
    place: Option<Placement>,
}

impl World {
    fn new(robust: bool, meshes: Vec<Arc<Mesh>>, place: Option<Affine3A>) -> World {
        let device = Device::new(1).unwrap();
        let options = BuildOptions { robust, ..BuildOptions::default() };
        let mut builder = SceneBuilder::new(&device, options).unwrap();
        meshes.iter().for_each(|mesh| _ = builder.add_mesh(mesh.clone(), buffers, None).unwrap());
        let mut scene = builder.commit().unwrap();
        if let Some(to_world) = place {
            let mut outer = SceneBuilder::new(&device, options).unwrap();
            outer.add_instance(Instance { scene: Arc::new(scene), to_world }).unwrap();
            scene = outer.commit().unwrap();
        }
        World { scene, meshes, place: place.map(Placement::new) }
    }

    fn meet(&self, org: Vec3, dir: Vec3) -> Option<(Hit, SurfaceInteraction)> {
        let hit = self.scene.intersect(&Ray { org, dir, tfar: f32::INFINITY })?;
        let mesh = &self.meshes[hit.geometry as usize];
        let si = match &self.place {
            None => SurfaceInteraction::new(mesh, &hit, -dir),
            Some(place) => SurfaceInteraction::placed(mesh, place, &hit, -dir),
        };
        Some((hit, si))
    }

    /// The same point with the offset that there was before.
    fn as_before(&self, hit: &Hit, si: &SurfaceInteraction) -> SurfaceInteraction {
        let corners = self.meshes[hit.geometry as usize].corners(hit.primitive as usize);
        let largest = corners.iter().fold(Vec3::ZERO, |largest, c| largest.max(c.abs()));
        SurfaceInteraction { offset: largest.max_element() / (1 << 16) as f32, ..*si }
    }
}

/// Rays that left a triangle, and how many of them met it again: as they are, from a tenth of the offset, and from where
/// they started before.
#[derive(Default)]
struct Left {
    rays: u32,
    again: u32,
    from_a_tenth: u32,
    before: u32,
}

impl Left {
    fn count(&mut self, world: &World, hit: &Hit, si: &SurfaceInteraction, rng: &mut Rng) {
        for side in [si.ng, -si.ng] {
            let w = Frame::from_normal(side).to_world(warp::square_to_cosine_hemisphere(rng.f32x2()));
            let meets = |si: &SurfaceInteraction| {
                let again = world.scene.intersect(&Ray { org: si.spawn(w), dir: w, tfar: f32::INFINITY });
                again.is_some_and(|h| (h.geometry, h.primitive) == (hit.geometry, hit.primitive)) as u32
            };
            self.rays += 1;
            self.again += meets(si);
            self.from_a_tenth += meets(&SurfaceInteraction { offset: 0.1 * si.offset, ..*si });
            self.before += meets(&world.as_before(hit, si));
        }
    }
}

/// Triangles of the size `size`, turned at random, as many times longer than wide as 1/`thin`, `far` sizes away from the
/// origin; by themselves or as instances.
fn leave_triangles(size: f32, thin: f32, far: f32, robust: bool, placed: bool) -> Left {
    let (mut rng, mut left) = (Rng::new(3), Left::default());
    for _ in 0..60 {
        let turn = Quat::from_axis_angle(warp::square_to_uniform_sphere(rng.f32x2()), rng.f32() * 6.0);
        let centre = warp::square_to_uniform_sphere(rng.f32x2()) * far * size;
        let mut corner = || turn * Vec3::new(rng.f32() - 0.5, 0.0, (rng.f32() - 0.5) * thin) * size + centre;
        let corners = [corner(), corner(), corner()];
        let place = placed.then(|| {
            let scale = 0.2 + Vec3::new(rng.f32(), rng.f32(), -rng.f32());
            let turn = Quat::from_axis_angle(warp::square_to_uniform_sphere(rng.f32x2()), rng.f32() * 6.0);
            Affine3A::from_scale_rotation_translation(scale, turn, warp::square_to_uniform_sphere(rng.f32x2()) * size)
        });
        let world = World::new(robust, vec![mesh(corners.to_vec(), vec![[0, 1, 2]])], place);
        let [a, b, c] = corners.map(|p| place.map_or(p, |place| place.transform_point3(p)));
        for _ in 0..30 {
            let [u, v] = warp::square_to_triangle(rng.f32x2());
            let dir = warp::square_to_uniform_sphere(rng.f32x2());
            let org = a + (b - a) * u + (c - a) * v - dir * (size * 10f32.powf(rng.f32() * 3.0 - 1.0));
            let Some((hit, si)) = world.meet(org, dir) else { continue };
            (0..4).for_each(|_| left.count(&world, &hit, &si, &mut rng));
        }
    }
    left
}

/// The bound is one: no ray meets what it leaves, but for what first-order terms leave out. A tenth of it would not do.
#[test]
fn rays_do_not_meet_the_triangle_that_they_leave() {
    let mut all = Left::default();
    for (size, thin) in [(1e-8, 1.0), (1e-4, 0.1), (1.0, 1.0), (1.0, 1e-3), (1e4, 1e-2), (1e8, 1.0), (1e9, 1e-4)] {
        for (far, robust, placed) in [
            (0.0, false, false),
            (1.0, false, false),
            (1e3, false, false),
            (1.0, true, false),
            (1e3, true, false),
            (0.0, false, true),
            (30.0, false, true),
            (30.0, true, true),
        ] {
            let left = leave_triangles(size, thin, far, robust, placed);
            let Left { rays, again, from_a_tenth, before } = left;
            println!("{size:e} × {thin:e}, {far} away, robust {robust}, placed {placed}:");
            println!("    {again} of {rays} rays met their triangle, {from_a_tenth} from a tenth, {before} before");
            all.rays += rays;
            all.again += again;
            all.from_a_tenth += from_a_tenth;
        }
    }
    println!("{} of {} rays met their triangle, {} from a tenth of the offset", all.again, all.rays, all.from_a_tenth);
    assert!(all.rays > 400_000);
    assert!(all.again * 100_000 <= all.rays, "{} of {}", all.again, all.rays);
    assert!(all.from_a_tenth * 20 > all.rays, "a tenth would do as well: {}", all.from_a_tenth);
}

/// A floor 1000 sizes wide and a plate of one size that lies `gap` above it, tilted by `turn` and moved by `far`: how many
/// of 1000 rays that leave the floor straight up under the plate meet it, with the offset of today and of before.
fn under_the_plate(size: f32, gap: f32, far: f32, turn: Quat, robust: bool) -> [u32; 2] {
    let place = |p: Vec3| turn * p * size + far * size;
    let quad = |y: f32, low: [f32; 2], width: f32| {
        let at = |x: f32, z: f32| place(Vec3::new(low[0] + x * width, y, low[1] + z * width));
        mesh(vec![at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(1.0, 0.0)], vec![[0, 1, 2], [0, 2, 3]])
    };
    let world = World::new(robust, vec![quad(0.0, [-500.0; 2], 1000.0), quad(gap, [300.0, 200.0], 1.0)], None);
    let (mut rng, mut met, up) = (Rng::new(1), [0; 2], turn * Vec3::Y);
    for _ in 0..1000 {
        let start = place(Vec3::new(300.0 + rng.f32(), 0.8 * gap, 200.0 + rng.f32()));
        let Some((hit, si)) = world.meet(start, -up).filter(|(hit, _)| hit.geometry == 0) else { continue };
        for (met, si) in met.iter_mut().zip([si, world.as_before(&hit, &si)]) {
            *met += world.meet(si.spawn(up), up).is_some_and(|(hit, _)| hit.geometry == 1) as u32;
        }
    }
    met
}

#[test]
fn what_lies_closely_above_a_wide_floor_throws_its_shadow() {
    let tilted = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.3);
    for (size, gap, far, turn) in [
        (1e-4, 1e-3, 0.0, Quat::IDENTITY),
        // a millimetre above a kilometre
        (1.0, 1e-3, 0.0, Quat::IDENTITY),
        (1.0, 1.5e-3, 0.0, tilted),
        (1e8, 1e-3, 0.0, Quat::IDENTITY),
        // coordinates are a thousandth apart there
        (1.0, 8e-3, 1e4, Quat::IDENTITY),
    ] {
        for robust in [false, true] {
            let [now, before] = under_the_plate(size, gap, far, turn, robust);
            println!("{gap} × {size:e} above a floor {far} away, robust {robust}: {now} of 1000, {before} before");
            assert!(now >= 990 && before == 0, "{now}, {before} before");
        }
    }
}

/// A cube seen from inside, 1 wide, and how many of the paths that bounce about in it get out within 100 bounces.
fn escapes(size: f32, far: f32, robust: bool) -> [u32; 2] {
    let turn = Quat::from_axis_angle(Vec3::new(0.48, 0.6, 0.64), 1.0);
    let corner = |k: u32| turn * Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) * size + far * size;
    let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let world = World::new(robust, vec![mesh((0..8).map(corner).collect(), triangles)], None);
    let centre = turn * Vec3::splat(0.5 * size) + far * size;
    let mut out = [0; 2];
    for (k, out) in out.iter_mut().enumerate() {
        let mut rng = Rng::new(7);
        for _ in 0..500 {
            let mut ray = (centre, warp::square_to_uniform_sphere(rng.f32x2()));
            for _ in 0..100 {
                let Some((hit, si)) = world.meet(ray.0, ray.1) else {
                    *out += 1;
                    break;
                };
                let si = if k == 0 { si } else { world.as_before(&hit, &si) };
                let inwards = si.ng * si.ng.dot(-ray.1).signum();
                let w = Frame::from_normal(inwards).to_world(warp::square_to_cosine_hemisphere(rng.f32x2()));
                ray = (si.spawn(w), w);
            }
        }
    }
    out
}

/// Within a plane points are as wrong as coordinates are, and next to an edge that may put them beyond the neighbour.
#[test]
fn light_leaks_out_of_a_box_only_where_coordinates_are_too_coarse_for_its_edges() {
    for (size, far) in [(1e-4, 0.0), (1.0, 0.0), (1e8, 0.0), (1.0, 1e3), (1.0, 1e4)] {
        let ([plain, before], [robust, _]) = (escapes(size, far, false), escapes(size, far, true));
        println!("a box of {size:e}, {far} sizes away: {plain} of 500 paths get out, {robust} robust; {before} before");
        // 100 bounces, each with four edges that take a share of the side
        let allowed = if far == 0.0 { 0.0 } else { 500.0 * 100.0 * 4.0 * far * ROUNDING };
        assert!(plain as f32 <= allowed && robust as f32 <= allowed, "{plain}, {robust} robust, {allowed} allowed");
    }
}

/// A ball is convex: what leaves it by its front is gone from it.
#[test]
fn rays_that_leave_a_ball_do_not_meet_it_again() {
    const N: u32 = 48;
    for (size, far) in [(1e-4f32, 0.0f32), (1.0, 0.0), (1.0, 100.0), (1e8, 0.0), (1e8, 100.0)] {
        let at = |k: u32| {
            let (theta, phi) =
                ((k / N) as f64 / N as f64 * std::f64::consts::PI, (k % N) as f64 / N as f64 * std::f64::consts::TAU);
            let p = glam::DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()) + far as f64;
            (p * size as f64).as_vec3()
        };
        let rings = (0..N).flat_map(|i| {
            (0..N).map(move |j| [i * N + j, (i + 1) * N + j, (i + 1) * N + (j + 1) % N, i * N + (j + 1) % N])
        });
        let triangles = rings.flat_map(|[a, b, c, d]| [[a, c, b], [a, d, c]]).collect();
        let world = World::new(
            false,
            vec![mesh((0..=N).flat_map(|i| (0..N).map(move |j| i * N + j)).map(at).collect(), triangles)],
            None,
        );
        let (mut rng, mut rays, mut again) = (Rng::new(2), 0, 0);
        for _ in 0..4000 {
            let [n, aim] = [0; 2].map(|_| warp::square_to_uniform_sphere(rng.f32x2()));
            let centre = Vec3::splat(far * size);
            let Some((_, si)) = world.meet(centre + n * 3.0 * size, (aim * 0.9 - n * 3.0).normalize()) else {
                continue;
            };
            let outwards = si.ng * si.ng.dot(si.p - centre).signum();
            let w = Frame::from_normal(outwards).to_world(warp::square_to_cosine_hemisphere(rng.f32x2()));
            rays += 1;
            again += world.meet(si.spawn(w), w).is_some() as u32;
        }
        println!("a ball of {size:e}, {far} sizes away: {again} of {rays} rays met it again");
        assert!(rays > 3000 && again * 1000 <= rays, "{again} of {rays}");
    }
}

#[test]
fn directions_of_any_length_are_found() {
    for length in [1e-38, 1e-30, 1e-20, 1.0, 1e19, 1e30, 3e38] {
        let (unit, per_length) = unit(Vec3::new(0.6, 0.0, -0.8) * length);
        assert!((unit - Vec3::new(0.6, 0.0, -0.8)).length() < 1e-6, "{length:e}: {unit}");
        assert!((per_length * length - 1.0).abs() < 1e-6);
    }
    for none in [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::X * f32::INFINITY, Vec3::new(1.0, f32::NAN, 0.0)] {
        assert_eq!(unit(none), (Vec3::ZERO, 0.0), "{none}");
    }
}
