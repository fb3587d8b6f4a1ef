use super::*;
use crate::geometry::{Attribute, Indices};
use crate::math::{rng::Rng, warp};
use crate::simd::mask;
use glam::{Affine3A, Quat};

/// Triangles of all sizes, some without corner normals, some with normals that face either way.
pub(crate) fn mesh(rng: &mut Rng, normals: bool) -> Mesh {
    let triangles = 50;
    let mut point = |scale: f32| (Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5) * scale;
    let positions = (0..3 * triangles).map(|k| point(10f32.powi(k / 3 % 7 - 3)).into()).collect();
    let values = (0..3 * triangles).map(|_| point(1.0).normalize().into()).collect();
    let indices = |absent: bool| {
        (0..triangles as u32)
            .map(move |t| if absent && t % 3 == 0 { [u32::MAX; 3] } else { [3 * t, 3 * t + 1, 3 * t + 2] })
    };
    Mesh {
        positions,
        triangles: indices(false).collect(),
        normals: normals.then(|| Attribute { values, indices: Indices::Own(indices(true).collect()) }),
        uvs: None,
        colors: None,
        materials: (0..triangles as u32).collect(),
    }
}

/// A hit on a triangle of the mesh, and where it is seen from.
pub(crate) fn hit(mesh: &Mesh, rng: &mut Rng) -> (Hit, Vec3) {
    let primitive = rng.next_u32() % mesh.triangles.len() as u32;
    let [a, b, c] = mesh.corners(primitive as usize);
    let [u, v] = warp::square_to_triangle(rng.f32x2());
    let hit = Hit { t: 1.0, u, v, ng: (b - a).cross(c - a), primitive, geometry: 0, instance: u32::MAX };
    (hit, warp::square_to_uniform_sphere(rng.f32x2()))
}

/// Begins with these hits, each seen from its `wo`.
fn begin(surfaces: &mut Surfaces, hits: &[(Hit, Vec3)]) {
    let row = |of: fn(&(Hit, Vec3)) -> f32| std::array::from_fn(|k| hits.get(k).map_or(f32::NAN, of));
    let dir = [row(|(_, wo)| -wo.x), row(|(_, wo)| -wo.y), row(|(_, wo)| -wo.z)];
    let ng = [row(|(hit, _)| hit.ng.x), row(|(hit, _)| hit.ng.y), row(|(hit, _)| hit.ng.z)];
    let weights = [row(|(hit, _)| hit.u), row(|(hit, _)| hit.v)];
    let met = mask(|k| k < hits.len());
    let (dir, ng, weights) = (dir.each_ref(), ng.each_ref(), weights.each_ref());
    surfaces.begin(
        &HitRows { dir, ng, weights, geometry: &[0; LANES], primitive: &[0; LANES], instance: &[0; LANES] },
        met,
    );
}

/// A packet of hits on random triangles.
pub(crate) fn packet<'a>(mesh: &'a Mesh, rng: &mut Rng) -> Surfaces<'a> {
    let mut surfaces = Surfaces::new();
    let hits: Vec<_> = (0..LANES).map(|_| hit(mesh, rng)).collect();
    begin(&mut surfaces, &hits);
    hits.iter().enumerate().for_each(|(k, (hit, _))| surfaces.push(k, mesh, hit.primitive));
    surfaces.resolve();
    surfaces
}

#[test]
fn points_of_a_packet_are_those_of_single_hits() {
    let mut rng = Rng::new(1);
    let shear =
        Affine3A::from_scale_rotation_translation(Vec3::new(-1.0, 3.0, 0.2), Quat::from_rotation_y(0.4), Vec3::ONE);
    let place = Placement::new(shear);
    let meshes = [mesh(&mut rng, true), mesh(&mut rng, false)];
    let mut surfaces = Surfaces::new();
    for round in 0..400 {
        let mesh = &meshes[round % 2];
        let hits: Vec<_> = (0..1 + round % LANES).map(|_| hit(mesh, &mut rng)).collect();
        begin(&mut surfaces, &hits);
        let mut single = Vec::new();
        for (k, &(hit, wo)) in hits.iter().enumerate() {
            match k % 3 {
                0 => surfaces.push_placed(k, mesh, &place, &hit),
                _ => surfaces.push(k, mesh, hit.primitive),
            }
            let si = if k % 3 == 0 {
                SurfaceInteraction::placed(mesh, &place, &hit, wo)
            } else {
                SurfaceInteraction::new(mesh, &hit, wo)
            };
            single.push((si, wo));
        }
        surfaces.resolve();
        assert_eq!(each(surfaces.met()).collect::<Vec<_>>(), Vec::from_iter(0..single.len()));
        for (k, (si, wo)) in single.iter().enumerate() {
            // what is printed tells all floats apart
            assert_eq!(format!("{:?}", surfaces.get(k)), format!("{si:?}"));
            assert_eq!(surfaces.wo_local(k), si.frame.to_local(*wo));
            assert_eq!(surfaces.facing_normal(k), si.facing(*wo));
        }
    }
}

#[test]
fn directions_of_a_packet_are_those_of_single_points() {
    let mut rng = Rng::new(2);
    for _ in 0..100 {
        let mesh = mesh(&mut rng, true);
        let surfaces = packet(&mesh, &mut rng);
        let mut w = Vec3Lanes::ZERO;
        (0..LANES).for_each(|k| w.set(k, warp::square_to_uniform_sphere(rng.f32x2())));
        let [mut local, mut world, mut origin] = [Vec3Lanes::ZERO; 3];
        surfaces.to_local(&w, &mut local);
        surfaces.to_world(&local, &mut world);
        surfaces.spawn(&world, &mut origin);
        for k in 0..LANES {
            let si = surfaces.get(k);
            assert_eq!(local.get(k), si.frame.to_local(w.get(k)));
            assert_eq!(world.get(k), si.frame.to_world(local.get(k)));
            assert_eq!(origin.get(k), si.spawn(world.get(k)));
            assert_eq!(surfaces.consistent(k, w.get(k)), si.consistent(w.get(k)));
        }
    }
}
