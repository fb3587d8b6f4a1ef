//! Where shadow rays end: before the light that they are sent to, and behind what stands just before that.

use super::draw;
use crate::embree::{BuildOptions, Device, Instance, Scene, SceneBuilder, Triangles};
use crate::geometry::{Mesh, Placement};
use crate::light::{EmissiveTriangle, Lights, PointLight};
use crate::math::{Rgb, rng::Rng, warp};
use glam::{Affine3A, Quat, Vec3};
use std::sync::Arc;

fn mesh(triangles: &[[Vec3; 3]]) -> Arc<Mesh> {
    let mut positions: Vec<[f32; 3]> = triangles.iter().flatten().map(|&p| p.into()).collect();
    positions.reserve(1);
    let triangles: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Arc::new(Mesh { positions, materials: vec![0; triangles.len()], triangles, ..Mesh::default() })
}

fn buffers(mesh: &Mesh) -> Triangles<'_> {
    Triangles { positions: &mesh.positions, triangles: &mesh.triangles }
}

fn scene(mesh: Arc<Mesh>, place: Option<Affine3A>) -> Scene {
    let device = Device::new(1).unwrap();
    let mut builder = SceneBuilder::new(&device, BuildOptions::default()).unwrap();
    builder.add_mesh(mesh, buffers, None).unwrap();
    let inner = builder.commit().unwrap();
    let Some(to_world) = place else { return inner };
    let mut outer = SceneBuilder::new(&device, BuildOptions::default()).unwrap();
    outer.add_instance(Instance { scene: Arc::new(inner), to_world }).unwrap();
    outer.commit().unwrap()
}

fn turn(rng: &mut Rng) -> Quat {
    Quat::from_axis_angle(warp::square_to_uniform_sphere(rng.f32x2()), rng.f32() * 6.0)
}

/// Shadow rays from points up to `reach` sizes away from lamps of the size `size`, `far` sizes from the origin, and how
/// many of them meet the lamp itself.
fn shadowed(size: f32, far: f32, reach: f32, placed: bool) -> [u32; 2] {
    let (mut rng, mut counts) = (Rng::new(5), [0; 2]);
    for _ in 0..100 {
        let centre = warp::square_to_uniform_sphere(rng.f32x2()) * far * size;
        let mut corner = || centre + (Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5) * size;
        let mesh = mesh(&[[corner(), corner(), corner()]]);
        let scale = Vec3::new(0.5 + rng.f32(), 0.3, 0.5 + rng.f32());
        let place = placed.then(|| Affine3A::from_scale_rotation_translation(scale, turn(&mut rng), -centre));
        let placement = Placement::new(place.unwrap_or(Affine3A::IDENTITY));
        let (corners, slack) = (placement.facet(&mesh, 0), placement.slack_of(&mesh, 0));
        let (radiance, slack) = (Rgb::ONE, if placed { slack } else { 0.0 });
        let lamp = EmissiveTriangle {
            mesh: 0,
            triangle: 0,
            corners,
            radiance,
            two_sided: true,
            group: 0,
            pattern: None,
            slack,
        };
        let (lights, scene) = (Lights::build(&[lamp], vec![], size).unwrap(), scene(mesh, place));
        for _ in 0..100 {
            let away = warp::square_to_uniform_sphere(rng.f32x2()) * size * 10f32.powf(reach.log10() * rng.f32());
            let p = corners[0] + away;
            let Some(sample) = draw(&lights, p, rng.f64(), rng.f32x2()) else { continue };
            let ray = sample.shadow_ray(p);
            counts[0] += (ray.tfar > 0.0) as u32;
            counts[1] += (ray.tfar > 0.0 && scene.occluded(&ray)) as u32;
        }
    }
    counts
}

#[test]
fn lamps_do_not_shadow_themselves() {
    for (size, far, reach, placed) in [
        (1.0, 0.0, 10.0, false),
        (1.0, 0.0, 1e5, false),
        (1.0, 1e3, 100.0, false),
        (1e-6, 10.0, 1e3, false),
        (1e8, 10.0, 1e3, false),
        (1.0, 0.0, 100.0, true),
        (1.0, 1e3, 100.0, true),
    ] {
        let [rays, met] = shadowed(size, far, reach, placed);
        println!("lamps of {size:e}, {far} sizes away, placed {placed}: {met} of {rays} shadow rays meet the lamp");
        assert!(rays > 9000 && met * 10_000 <= rays, "{met} of {rays}");
    }
}

/// A plate 5 cm before a lamp that is 1 km away, and 1 mm before one that is 10 m away; the same of a point light.
#[test]
fn what_stands_just_before_a_lamp_throws_a_shadow() {
    let mut rng = Rng::new(8);
    for (distance, gap) in [(1000.0, 0.05), (10.0, 0.001), (1.0, 1e-5)] {
        let turn = turn(&mut rng);
        let at = |x: f32, y: f32, z: f32| turn * Vec3::new(x, y, z);
        let lamp = [at(-1.0, distance, -1.0), at(1.0, distance, -1.0), at(0.0, distance, 1.0)];
        let plate = lamp.map(|p| p - at(0.0, gap, 0.0));
        let scene = scene(mesh(&[lamp, plate]), None);
        let radiance = Rgb::ONE;
        let emitter = EmissiveTriangle {
            mesh: 0,
            triangle: 0,
            corners: lamp,
            radiance,
            two_sided: true,
            group: 0,
            pattern: None,
            slack: 0.0,
        };
        let position = at(0.0, distance, 0.0);
        for lights in [
            Lights::build(&[emitter], vec![], 1.0).unwrap(),
            Lights::build(&[], vec![PointLight { position, intensity: radiance }.into()], 1.0).unwrap(),
        ] {
            for _ in 0..100 {
                let p = at(0.2 * rng.f32(), 0.0, 0.2 * rng.f32());
                let sample = draw(&lights, p, rng.f64(), rng.f32x2().map(|u| 0.2 + 0.6 * u)).unwrap();
                assert!(scene.occluded(&sample.shadow_ray(p)), "{distance} away, {gap} before it");
            }
        }
    }
}
